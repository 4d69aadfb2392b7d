# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes whose functions are tabulated: Color Ramp, the three kinds of curves, Wavelength.

A constant input is evaluated by Blender itself. One that varies is looked up in 256 entries, as Cycles does it
(intern/cycles/blender/util.h), so that the same steps and corners show.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from isophote.values import Number, call1, divide, mix, varies

from ... import compat
from ..values import each, not_negative, triple

ENTRIES = 256


def tabulated(values, evaluate: Callable[[float], float], x: Number, low: float, high: float, kind: str):
    """A function of x, of which [low, high] is looked up by the operation `kind`; None where nothing may vary."""
    if not varies(x):
        return evaluate(x)
    return look_up(values, [evaluate(t) for t in np.linspace(low, high, ENTRIES).tolist()], divide(x - low, high - low),
                   kind)


def look_up(values, entries, place: Number, kind: str = "table"):
    if values.lookups is None:
        return None
    return call1(kind, place, data=values.lookups.table(entries), number=float(len(entries)))


def ramp(values, node, socket, stack):
    factor, evaluate = values.number(node, stack, "Fac"), node.color_ramp.evaluate
    kind = "table_stepped" if node.color_ramp.interpolation == "CONSTANT" else "table"
    parts = (3,) if socket.name == "Alpha" else (0, 1, 2)
    found = [tabulated(values, lambda x, part=part: evaluate(x)[part], factor, 0.0, 1.0, kind) for part in parts]
    if any(each is None for each in found):
        return None
    return found[0] if len(found) == 1 else triple(*found)


# ------------------------------------------------------------------ curves


class Curves:
    """A node's curves, ready to be evaluated."""

    def __init__(self, values, mapping):
        mapping.update()
        self.values, self.mapping = values, mapping
        ends = [curve.points[end].location[0] for curve in mapping.curves for end in (0, len(curve.points) - 1)]
        self.low, self.high = min(ends), max(ends)  # of all curves, as in Cycles
        self.kind = "table_extended" if mapping.extend == "EXTRAPOLATED" else "table"

    def __call__(self, x: Number, *curves: int):
        """x through curves, one after the other."""
        def evaluate(t: float) -> float:
            for curve in curves:
                t = self.mapping.evaluate(self.mapping.curves[curve], t)
            return t

        return tabulated(self.values, evaluate, x, self.low, self.high, self.kind)


def float_curve(values, node, socket, stack):
    x, factor = values.number(node, stack, "Value"), values.number(node, stack, "Factor")
    y = Curves(values, node.mapping)(x, 0)
    return y if y is None else mix(x, y, factor)


def vector_curves(values, node, socket, stack):
    return three_curves(values, node, stack, "Vector", (0,), (1,), (2,))


def rgb_curves(values, node, socket, stack):
    """The curve of all three first."""
    return three_curves(values, node, stack, "Color", (3, 0), (3, 1), (3, 2))


def three_curves(values, node, stack, name: str, *orders):
    given, factor = values.vector(node, stack, name), values.number(node, stack, "Fac")
    curves = Curves(values, node.mapping)
    found = [curves(x, *order) for x, order in zip(given, orders, strict=True)]
    if any(each is None for each in found):
        return None
    return each(lambda x, y: mix(x, y, factor), given, triple(*found))


# ------------------------------------------------------------------ wavelengths

# CIE 1931 2 degree observer, XYZ, in steps of 5 nm from 380 nm.
OBSERVER = np.array([float(x) for x in """
    .0014 0 .0065 .0022 .0001 .0105 .0042 .0001 .0201 .0076 .0002 .0362 .0143 .0004 .0679 .0232 .0006 .1102
    .0435 .0012 .2074 .0776 .0022 .3713 .1344 .0040 .6456 .2148 .0073 1.0391 .2839 .0116 1.3856 .3285 .0168 1.6230
    .3483 .0230 1.7471 .3481 .0298 1.7826 .3362 .0380 1.7721 .3187 .0480 1.7441 .2908 .0600 1.6692 .2511 .0739 1.5281
    .1954 .0910 1.2876 .1421 .1126 1.0419 .0956 .1390 .8130 .0580 .1693 .6162 .0320 .2080 .4652 .0147 .2586 .3533
    .0049 .3230 .2720 .0024 .4073 .2123 .0093 .5030 .1582 .0291 .6082 .1117 .0633 .7100 .0782 .1096 .7932 .0573
    .1655 .8620 .0422 .2257 .9149 .0298 .2904 .9540 .0203 .3597 .9803 .0134 .4334 .9950 .0087 .5121 1 .0057
    .5945 .9950 .0039 .6784 .9786 .0027 .7621 .9520 .0021 .8425 .9154 .0018 .9163 .8700 .0017 .9786 .8163 .0014
    1.0263 .7570 .0011 1.0567 .6949 .0010 1.0622 .6310 .0008 1.0456 .5668 .0006 1.0026 .5030 .0003 .9384 .4412 .0002
    .8544 .3810 .0002 .7514 .3210 .0001 .6424 .2650 0 .5419 .2170 0 .4479 .1750 0 .3608 .1382 0
    .2835 .1070 0 .2187 .0816 0 .1649 .0610 0 .1212 .0446 0 .0874 .0320 0 .0636 .0232 0
    .0468 .0170 0 .0329 .0119 0 .0227 .0082 0 .0158 .0057 0 .0114 .0041 0 .0081 .0029 0
    .0058 .0021 0 .0041 .0015 0 .0029 .0010 0 .0020 .0007 0 .0014 .0005 0 .0010 .0004 0
    .0007 .0002 0 .0005 .0002 0 .0003 .0001 0 .0002 .0001 0 .0002 .0001 0 .0001 0 0
    .0001 0 0 .0001 0 0 0 0 0""".split()]).reshape(81, 3)
BRIGHTEST = 2.52  # what Cycles divides by
FIRST, LAST = 375.0, 780.0  # nm


def wavelength(values, node, socket, stack):
    """The first 5 nm are those of Cycles: its table's first two entries, straight on."""
    x = values.number(node, stack, "Wavelength")
    entries = np.concatenate([2.0 * OBSERVER[:1] - OBSERVER[1:2], OBSERVER]) @ compat.RGB_OF_XYZ.T / BRIGHTEST
    if not varies(x):
        grid = np.linspace(FIRST, LAST, len(entries))
        return not_negative(triple(*(np.interp(x, grid, part, left=0.0, right=0.0) for part in entries.T)))
    if values.lookups is None:
        return None
    parts = triple(*(look_up(values, part, (x - FIRST) * (1.0 / (LAST - FIRST))) for part in entries.T))
    return not_negative(parts * call1("less_than", FIRST, x))


NODES = {
    "ShaderNodeValToRGB": ramp,
    "ShaderNodeFloatCurve": float_curve,
    "ShaderNodeVectorCurve": vector_curves,
    "ShaderNodeRGBCurve": rgb_curves,
    "ShaderNodeWavelength": wavelength,
}
