# SPDX-License-Identifier: GPL-3.0-or-later
"""Sky Texture: analytic skies, and those of scattered light with the sun's disc (isophote/skies.py)."""

from __future__ import annotations

import math

import numpy as np

from isophote import skies
from isophote.values import maximum

from ... import compat
from ..images import Picture
from ..values import Sun, each, outputs, triple
from .images import EXTENSIONS, INTERPOLATIONS
from .inputs import generated
from .vectors import texture_mapped

LINEAR_TO_THE_END = INTERPOLATIONS["Linear"] | EXTENSIONS["EXTEND"] << 2


def sky_texture(values, node, socket, stack):
    if values.lookups is None:
        return None
    linked = values.is_linked(node, stack, "Vector")
    co = values.vector(node, stack, "Vector") if linked else generated(values)
    co = texture_mapped(co, node.texture_mapping)
    if node.sky_type in ("PREETHAM", "HOSEK_WILKIE"):
        return analytic(values, node, co)
    if node.sky_type in ("NISHITA", "SINGLE_SCATTERING", "MULTIPLE_SCATTERING"):
        return scattered(values, node, co)
    return None


def analytic(values, node, co):
    sun = np.array(node.sun_direction, np.float64)
    sun /= np.linalg.norm(sun) or 1.0
    if node.sky_type == "PREETHAM":
        constants, of_chroma = skies.preetham(sun, node.turbidity), 1.0
    else:
        constants, of_chroma = skies.hosek_wilkie(sun, node.turbidity, node.ground_albedo), 0.0
    xyz = outputs("daylight", *co, data=values.lookups.table(constants), number=of_chroma)
    return triple(*(maximum(sum(m * part for m, part in zip(row, xyz, strict=True)), 0.0) for row in compat.RGB_OF_XYZ))


def scattered(values, node, co):
    """In Blender 5 the disc is added to the sky, before it stands in its place."""
    old = node.sky_type == "NISHITA"
    elevation, rotation = wrapped(node.sun_elevation, node.sun_rotation)
    air = skies.Air(node.sky_type == "MULTIPLE_SCATTERING", elevation, node.altitude, node.air_density,
                    compat.dust_density(node), node.ozone_density)
    make, operation = (skies.dome, "dome_place") if old else (skies.globe, "globe_place")
    u, v, *left = outputs(operation, *co, number=rotation)
    number, _ = values.lookups.image((operation, air), LINEAR_TO_THE_END, lambda: Picture(to_rgb(make(air)), False))
    color = triple(*outputs("image", u, v, data=number, repeat=4)[:3])
    if old:
        color = color * left[0]
    size = max(node.sun_size, skies.SMALLEST_SUN)
    disc = (skies.setting_disc if old else skies.disc)(air, size) if node.sun_disc else None
    if disc is None:
        return color
    across = math.cos(elevation)
    towards = (-across * math.sin(rotation), across * math.cos(rotation), math.sin(elevation))
    radiances = np.array([disc.low, disc.high]) @ compat.RGB_OF_XYZ.T * node.sun_intensity
    constants = [*towards, size / 2.0, disc.lowest, disc.factor, disc.summand, *radiances.ravel()]
    *glow, there = outputs("sun_disc", *co, data=values.lookups.table(constants))
    values.suns.append(Sun(np.array(towards), size / 2.0, co))
    return each(lambda sky, sun: (sky * (1.0 - there) if old else sky) + sun, color, triple(*glow))


def to_rgb(xyz: np.ndarray) -> np.ndarray:
    """Not below 0, as Cycles has it once it has interpolated."""
    return np.maximum(xyz @ compat.RGB_OF_XYZ.T.astype(np.float32), 0.0)


def wrapped(elevation: float, rotation: float) -> tuple[float, float]:
    """The sun's elevation, brought into -90 to 90 degrees, and its longitude, against its rotation, from 0 on."""
    turn = 2.0 * math.pi
    elevation = math.remainder(elevation, turn)
    if abs(elevation) >= math.pi / 2.0:
        elevation, rotation = math.copysign(math.pi, elevation) - elevation, rotation + math.pi
    return elevation, turn - math.fmod(math.fmod(rotation, turn) + turn, turn)


NODES = {"ShaderNodeTexSky": sky_texture}
