# SPDX-License-Identifier: GPL-3.0-or-later
"""Nodes that compute colours: Mix and its blend modes, Hue Saturation Value, Separate and Combine Color, and others."""

from __future__ import annotations

import numpy as np

from isophote.values import Number, call1, clamp, divide, maximum, minimum, mix, select

from ..values import as_number, call3, each, not_negative, saturate, triple
from .arithmetic import fraction


def soft_light(a: Number, b: Number, t: Number) -> Number:
    screen = 1.0 - (1.0 - b) * (1.0 - a)
    return mix(a, (1.0 - a) * b * a + a * screen, t)


# Blend modes of each part: the first with the second by a factor; as in Cycles (src/kernel/svm/color_util.h).
BLENDS = {
    "MIX": mix,
    "ADD": lambda a, b, t: a + t * b,
    "SUBTRACT": lambda a, b, t: a - t * b,
    "MULTIPLY": lambda a, b, t: mix(a, a * b, t),
    "DIVIDE": lambda a, b, t: select(b, mix(a, divide(a, b), t), a),
    "SCREEN": lambda a, b, t: 1.0 - (1.0 - t * b) * (1.0 - a),
    "OVERLAY": lambda a, b, t: call1("overlay", a, b, t),
    "DODGE": lambda a, b, t: call1("dodge", a, b, t),
    "BURN": lambda a, b, t: call1("burn", a, b, t),
    "DARKEN": lambda a, b, t: mix(a, minimum(a, b), t),
    "LIGHTEN": lambda a, b, t: mix(a, maximum(a, b), t),
    "DIFFERENCE": lambda a, b, t: mix(a, call1("absolute", a - b), t),
    "EXCLUSION": lambda a, b, t: maximum(mix(a, a + b - 2.0 * a * b, t), 0.0),
    "SOFT_LIGHT": soft_light,
    "LINEAR_LIGHT": lambda a, b, t: a + t * (2.0 * b - 1.0),
}


def to_hsv(color) -> np.ndarray:
    return call3("rgb_to_hsv", *color)


def from_hsv(hue: Number, saturation: Number, value: Number) -> np.ndarray:
    return call3("hsv_to_rgb", hue, saturation, value)


def blend_hue(a, b, t: Number):
    (_, saturation, value), (hue, any_hue, _) = to_hsv(a), to_hsv(b)
    return mix_where(any_hue, a, from_hsv(hue, saturation, value), t)


def blend_color(a, b, t: Number):
    value, (hue, saturation, _) = to_hsv(a)[2], to_hsv(b)
    return mix_where(saturation, a, from_hsv(hue, saturation, value), t)


def mix_where(which: Number, a, b, t: Number):
    """The mixture where `which` is not 0, else a."""
    return each(lambda x, y: select(which, mix(x, y, t), x), a, b)


def blend_saturation(a, b, t: Number):
    hue, saturation, value = to_hsv(a)
    blended = from_hsv(hue, mix(saturation, to_hsv(b)[1], t), value)
    return each(lambda x, y: select(saturation, y, x), a, blended)


def blend_value(a, b, t: Number):
    hue, saturation, value = to_hsv(a)
    return from_hsv(hue, saturation, mix(value, to_hsv(b)[2], t))


BLENDS_OF_HSV = {"HUE": blend_hue, "SATURATION": blend_saturation, "COLOR": blend_color, "VALUE": blend_value}


def blend(mode: str, a, b, t: Number):
    """Two colours by a factor; None for a mode that is not known."""
    if mode in BLENDS:
        return each(lambda x, y: BLENDS[mode](x, y, t), a, b)
    return BLENDS_OF_HSV[mode](a, b, t) if mode in BLENDS_OF_HSV else None


def mix_rgb(values, node, socket, stack):
    a, b = values.color(node, stack, "Color1"), values.color(node, stack, "Color2")
    blended = blend(node.blend_type, a, b, clamp(values.number(node, stack, "Fac")))
    return saturate(blended) if node.use_clamp and blended is not None else blended


def mix_node(values, node, socket, stack):
    if node.data_type == "VECTOR":
        return mix_vectors(values, node, stack)
    t = limited(values.number(node, stack, "Factor_Float"), node)
    if node.data_type == "FLOAT":
        return mix(values.number(node, stack, "A_Float"), values.number(node, stack, "B_Float"), t)
    if node.data_type != "RGBA":
        return None
    blended = blend(node.blend_type, values.color(node, stack, "A_Color"), values.color(node, stack, "B_Color"), t)
    return saturate(blended) if node.clamp_result and blended is not None else blended


def mix_vectors(values, node, stack):
    a, b = values.vector(node, stack, "A_Vector"), values.vector(node, stack, "B_Vector")
    if node.factor_mode == "UNIFORM":
        t = values.number(node, stack, "Factor_Float")
    else:
        t = values.vector(node, stack, "Factor_Vector")
    return each(lambda x, y, part: mix(x, y, limited(part, node)), a, b, t)


def limited(factor: Number, node) -> Number:
    return clamp(factor) if node.clamp_factor else factor


# ------------------------------------------------------------------ one colour


def hue_saturation(values, node, socket, stack):
    color, factor = values.color(node, stack, "Color"), values.number(node, stack, "Fac")
    turn, strength, brightness = (values.number(node, stack, name) for name in ("Hue", "Saturation", "Value"))
    hue, saturation, value = to_hsv(color)
    changed = from_hsv(fraction(hue + turn + 0.5), clamp(saturation * strength), value * brightness)
    return not_negative(each(lambda x, y: mix(x, y, factor), color, changed))


def bright_contrast(values, node, socket, stack):
    color = values.color(node, stack, "Color")
    bright, contrast = values.number(node, stack, "Bright"), values.number(node, stack, "Contrast")
    return not_negative(color * (contrast + 1.0) + (bright - contrast * 0.5))


def gamma(values, node, socket, stack):
    exponent = values.number(node, stack, "Gamma")
    return each(lambda x: call1("gamma", x, exponent), values.color(node, stack, "Color"))


def invert(values, node, socket, stack):
    t, color = values.number(node, stack, "Fac"), values.color(node, stack, "Color")
    return each(lambda x: mix(x, 1.0 - x, t), color)


def to_grey(values, node, socket, stack):
    return as_number(values.color(node, stack, "Color"), "RGBA")


def blackbody(values, node, socket, stack):
    return call3("blackbody", values.number(node, stack, "Temperature"))


# ------------------------------------------------------------------ parts

CONVERSIONS = {"HSV": ("rgb_to_hsv", "hsv_to_rgb"), "HSL": ("rgb_to_hsl", "hsl_to_rgb")}


def mode_of(node) -> str:
    return getattr(node, "mode", "HSV" if node.bl_idname.endswith("HSV") else "RGB")


def separate(values, node, socket, stack):
    color = values.color(node, stack, node.inputs[0].identifier)
    if mode_of(node) != "RGB":
        color = call3(CONVERSIONS[mode_of(node)][0], *color)
    return color[list(node.outputs).index(socket)]


def combine(values, node, socket, stack):
    parts = [values.number(node, stack, s.identifier) for s in list(node.inputs)[:3]]
    return triple(*parts) if mode_of(node) == "RGB" else call3(CONVERSIONS[mode_of(node)][1], *parts)


NODES = {
    "ShaderNodeMixRGB": mix_rgb,
    "ShaderNodeMix": mix_node,
    "ShaderNodeHueSaturation": hue_saturation,
    "ShaderNodeBrightContrast": bright_contrast,
    "ShaderNodeGamma": gamma,
    "ShaderNodeInvert": invert,
    "ShaderNodeRGBToBW": to_grey,
    "ShaderNodeBlackbody": blackbody,
    "ShaderNodeSeparateColor": separate,
    "ShaderNodeSeparateRGB": separate,
    "ShaderNodeSeparateHSV": separate,
    "ShaderNodeCombineColor": combine,
    "ShaderNodeCombineRGB": combine,
    "ShaderNodeCombineHSV": combine,
}
