# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels of Blender's images, in the smallest type that loses none of them, as kernels/values/image.h reads them.

Kinds of alpha and the curve that stays in the texels are Cycles' (src/blender/image.cpp, src/scene/image_oiio.cpp):
colours are stored times alpha, in the numbers of the file, unless they are data or alpha has a meaning of its own.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from isophote.images import ImageError, openimageio

from .. import compat

MISSING = (1.0, 0.0, 1.0)  # radiance of what cannot be read, as in Cycles
KINDS = {"u1": 2, "u2": 1, "f2": 5, "f4": 4}  # TEXEL_ numbers of kernels/scene_records.h
LINEAR_SPACES = {"Linear", "Linear Rec.709", "Raw"}  # of the scene, by the names that Blender 3.4 to 5.0 give it
OF_16_BITS = {"PNG", "JPEG2000"}  # formats of files that Blender turns into floating-point numbers
LEFT_ALONE = {"NONE", "CHANNEL_PACKED"}  # kinds of alpha by which colours are not multiplied


class Unreadable(ValueError):
    """An image without pixels; the message says why."""


@dataclass(frozen=True)
class Picture:
    """Texels (h, w, c), rows from the bottom up: u1 and u2 are fractions, f2 and f4 numbers; c is 1, 3 or 4.

    `srgb`: stored by sRGB's curve.
    """

    texels: np.ndarray
    srgb: bool

    @property
    def kind(self) -> int:
        """A TEXEL_ number."""
        return KINDS[self.texels.dtype.str[1:]]


def multiplied(image) -> bool:
    """Whether an image's colours are stored times alpha."""
    return not image.colorspace_settings.is_data and image.alpha_mode not in LEFT_ALONE


def read_picture(image, frame: int, tile: int | None = None) -> Picture:
    """The picture of an image, at a frame (number in its sequence) or of one of its tiles.

    Raises Unreadable.
    """
    if image.source == "MOVIE":
        raise Unreadable("movies are not supported")
    if image.source in ("SEQUENCE", "TILED"):
        texels = read_file(tile_path(image, tile) if tile else frame_path(image, frame), multiplied(image))
        in_scene_space = False
    else:
        texels, in_scene_space = read_blender(image), image.is_float
    if image.alpha_mode == "NONE" and texels.shape[2] == 4:
        texels[:, :, 3] = 1.0 if texels.dtype.kind == "f" else np.iinfo(texels.dtype).max
    if texels.dtype.kind == "f":
        texels[~np.isfinite(texels).all(axis=2)] = 0.0
    space = image.colorspace_settings
    srgb = space.name == "sRGB" and not space.is_data
    if in_scene_space and srgb and image.source == "FILE" and image.file_format in OF_16_BITS:
        texels = np.rint(encode_srgb(texels) * np.float32(65535.0)).astype(np.uint16)  # what the file holds
    elif in_scene_space:
        srgb = False
    elif not (space.is_data or srgb or space.name in LINEAR_SPACES):
        texels = to_scene_linear(texels, space.name)
    return Picture(smallest(needed_channels(texels)), srgb)


def smallest(texels: np.ndarray) -> np.ndarray:
    """The same numbers in fewer bytes where they fit."""
    if texels.dtype != np.float32:
        return texels
    with np.errstate(over="ignore"):
        halves = texels.astype(np.float16)
    if np.array_equal(halves, texels):
        return halves
    shorts = as_shorts(texels)
    return texels if shorts is None else shorts


def as_shorts(texels: np.ndarray) -> np.ndarray | None:
    """Fractions of 65535, u2, where all texels are that but for rounding."""
    if texels.min(initial=0.0) < 0.0 or texels.max(initial=0.0) > 1.0:
        return None
    whole = np.rint(texels * np.float32(65535.0))
    return whole.astype(np.uint16) if np.abs(texels * np.float32(65535.0) - whole).max(initial=0.0) < 0.05 else None


def encode_srgb(texels: np.ndarray) -> np.ndarray:
    """By sRGB's curve, alpha as it is; colours that are stored times alpha keep to that."""
    colors = np.maximum(texels[:, :, :3], 0.0).astype(np.float64)
    alpha = texels[:, :, 3:4] if texels.shape[2] == 4 else np.ones_like(texels[:, :, :1])
    colors /= np.where(alpha > 0.0, alpha, 1.0)
    coded = np.where(colors <= 0.0031308, 12.92 * colors, 1.055 * colors ** (1 / 2.4) - 0.055).clip(0.0, 1.0) * alpha
    return np.concatenate([coded, texels[:, :, 3:]], axis=2).astype(np.float32)


def needed_channels(texels: np.ndarray) -> np.ndarray:
    """Without an alpha of 1, and one channel for grey."""
    one = 1.0 if texels.dtype.kind == "f" else np.iinfo(texels.dtype).max
    if texels.shape[2] == 4 and (texels[:, :, 3] == one).all():
        texels = texels[:, :, :3]
    if texels.shape[2] == 3 and (texels == texels[:, :, :1]).all():
        texels = texels[:, :, :1]
    return np.ascontiguousarray(texels)


# ------------------------------------------------------------------ where pixels come from


def read_blender(image) -> np.ndarray:
    """Texels as Blender has them in memory, of files, packed and generated images alike: u1 in the file's numbers or
    f4 in scene-linear ones."""
    loaded = image.has_data
    width, height = image.size
    if width == 0 or height == 0:
        raise Unreadable(f"'{image.filepath}' cannot be read" if image.source == "FILE" else "it has no pixels")
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    pixels = with_channels(pixels.reshape(height, width, image.channels))
    if not image.is_float:
        pixels = np.rint(pixels * np.float32(255.0)).astype(np.uint8)
        if multiplied(image):
            pixels = times_alpha(pixels)
    if not loaded and not image.is_dirty:
        image.buffers_free()
    return pixels


def read_file(path: str, multiply: bool) -> np.ndarray:
    """Texels of a file in its own numbers: u1, u2, f2 as f4, or f4."""
    try:
        oiio = openimageio()
    except ImageError as error:
        raise Unreadable(f"sequences and tiles need OpenImageIO: {error}") from None
    hints = oiio.ImageSpec()
    hints.attribute("oiio:UnassociatedAlpha", 1)
    file = oiio.ImageInput.open(path, hints)
    if file is None:
        raise Unreadable(f"'{path}' cannot be read")
    spec = file.spec()
    kind = {"uint8": "uint8", "uint16": "uint16"}.get(str(spec.format), "float")
    texels = np.array(file.read_image(kind)).reshape(spec.height, spec.width, spec.nchannels)[::-1]
    file.close()
    texels = with_channels(texels[:, :, :4])
    straight = spec.get_int_attribute("oiio:UnassociatedAlpha", 0)
    return times_alpha(texels) if multiply and straight else texels


def with_channels(texels: np.ndarray) -> np.ndarray:
    """Grey with alpha as four channels; one, three and four stay."""
    return np.ascontiguousarray(texels[:, :, [0, 0, 0, 1]]) if texels.shape[2] == 2 else texels


def times_alpha(texels: np.ndarray) -> np.ndarray:
    """Colours times alpha; whole numbers are rounded down."""
    if texels.shape[2] < 4:
        return texels
    alpha = texels[:, :, 3:].astype(np.uint32 if texels.dtype.kind == "u" else np.float32)
    product = texels[:, :, :3] * alpha
    if texels.dtype.kind == "u":
        product //= np.iinfo(texels.dtype).max
    return np.concatenate([product.astype(texels.dtype), texels[:, :, 3:]], axis=2)


def to_scene_linear(texels: np.ndarray, space: str) -> np.ndarray:
    """f4 of what another colour space holds. Raises Unreadable where nothing here can tell."""
    convert = compat.scene_linear_converter(space)
    if convert is None:
        raise Unreadable(f"colour space {space} needs OpenColorIO, which this Blender has no module for")
    if texels.dtype.kind == "u":
        texels = texels * np.float32(1.0 / np.iinfo(texels.dtype).max)
    colors = np.broadcast_to(texels[:, :, :3], (*texels.shape[:2], 3))
    alpha = texels[:, :, 3:] if texels.shape[2] == 4 else np.ones_like(texels[:, :, :1])
    divisor = np.where(alpha != 0.0, alpha, 1.0)
    made = convert(np.ascontiguousarray(colors / divisor, np.float32)) * divisor
    return np.concatenate([made, texels[:, :, 3:]], axis=2)


def sequence_frame(user, frame: int) -> int:
    """Number of the picture that an ImageUser shows at a frame (Blender's BKE_image_user_frame_get)."""
    at, length = frame - user.frame_start + 1, user.frame_duration
    if user.use_cyclic and length:
        at = (at - 1) % length + 1
    return min(max(at, 0), length) + user.frame_offset


def frame_path(image, frame: int) -> str:
    """The file of a sequence for a frame: the last digits of the name are its number."""
    path = compat.absolute_path(image)
    digits = list(re.finditer(r"\d+", path.rpartition("/")[2]))
    if not digits:
        return path
    start = len(path) - len(path.rpartition("/")[2])
    first, end = start + digits[-1].start(), start + digits[-1].end()
    return f"{path[:first]}{frame:0{end - first}d}{path[end:]}"


def tile_path(image, tile: int) -> str:
    """The file of a tile (1001 and up)."""
    path, place = compat.absolute_path(image), tile - 1001
    return path.replace("<UDIM>", str(tile)).replace("<UVTILE>", f"u{place % 10 + 1}_v{place // 10 + 1}")
