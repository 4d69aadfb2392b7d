"""Pictures in and out: multilayer EXR with Blender's channel names, and PNG. OpenImageIO does the work.

In memory a picture is a dict "Pass" -> float32 (h, w, c) with rows from the bottom, scene-linear
Rec. 709, alpha premultiplied; in files rows run from the top.
"""

from __future__ import annotations

import os
import tempfile
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from isophote.files import replacing
from isophote.passes import PASSES, channels_of
from isophote.settings import MOST_LEVELS

SUFFIXES = (".exr", ".png")
LAYER = "ViewLayer"
CHANNELS = channels_of(PASSES, MOST_LEVELS)
CHANNEL_ORDER = "RGBAXYZWUV"


class ImageError(OSError):
    """A picture that cannot be read or written; the message names the file."""


@dataclass
class Image:
    """A picture read from a file: planes as above, and the metadata of its first part."""

    planes: dict[str, np.ndarray]
    metadata: dict[str, object] = field(default_factory=dict)

    @property
    def partial(self) -> bool:
        """Whether the render that wrote it was stopped before its end."""
        return bool(int(self.metadata.get("isophote:partial", 0)))


def openimageio():
    try:
        import OpenImageIO
    except ImportError as error:
        raise ImageError(f"OpenImageIO cannot be loaded, pictures need it: {error}") from error
    return OpenImageIO


def check_writable(path: str | Path) -> None:
    """See before a render that its picture can be written after it. Raises ImageError naming what is in the way."""
    path = Path(path)
    if path.suffix.lower() not in SUFFIXES:
        raise ImageError(f"{path}: pictures end in {' or '.join(SUFFIXES)}")
    openimageio()
    check_place(path)


def check_place(path: str | Path) -> None:
    """See that a file of any kind can be written at `path`. Raises ImageError."""
    path = Path(path)
    if path.is_dir():
        raise ImageError(f"{path}: is a folder")
    if not path.parent.is_dir():
        raise ImageError(f"{path}: there is no folder {path.parent}")
    if path.exists() and not os.access(path, os.W_OK):
        raise ImageError(f"{path}: exists and may not be written")
    try:  # the only sure test: read-only mounts and rights of groups show no other way
        with tempfile.TemporaryFile(dir=path.parent):
            pass
    except OSError as error:
        raise ImageError(f"{path}: cannot write to {path.parent}: {error.strerror}") from error


def write_image(path: str | Path, planes: dict[str, np.ndarray], metadata: dict | None = None, exposure: float = 0.0):
    """Write `planes`, name -> (h, w, c), as 32-bit multilayer EXR (all of them) or 8-bit sRGB PNG ("Combined").

    `metadata` goes into the header ("isophote:partial": 1 marks an unfinished render). `exposure`, in
    stops, is for PNG only; its transform is plain sRGB (Blender's "Standard"). The file appears whole
    or not at all. Raises ImageError naming the file.
    """
    path = Path(path)
    try:
        with replacing(path) as temporary:
            if path.suffix.lower() == ".exr":
                write_exr(temporary, planes, metadata or {})
            elif path.suffix.lower() == ".png":
                write_png(temporary, planes, metadata or {}, exposure)
            else:
                raise ImageError(f"pictures end in {' or '.join(SUFFIXES)}")
    except (OSError, KeyError) as error:
        raise ImageError(f"{path}: {error}") from error


def write_exr(path: Path, planes: dict[str, np.ndarray], metadata: dict) -> None:
    oiio = openimageio()
    if not planes:
        raise ImageError("no passes to write")
    names, arrays = [], []
    for name, array in planes.items():
        ids = CHANNELS.get(name, CHANNEL_ORDER[:array.shape[2]] if array.shape[2] > 1 else "X")
        if array.shape[2] != len(ids):
            raise ImageError(f"pass {name} has {array.shape[2]} channels, wanted {ids}")
        names += [f"{LAYER}.{name}.{channel}" for channel in ids]
        arrays.append(np.asarray(array, np.float32))
    pixels = np.ascontiguousarray(np.concatenate(arrays, axis=2)[::-1])
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], pixels.shape[2], oiio.FLOAT)
    spec.channelnames = names
    spec.attribute("compression", "zip")
    write_pixels(oiio, path, spec, pixels, metadata)


def write_png(path: Path, planes: dict[str, np.ndarray], metadata: dict, exposure: float) -> None:
    oiio = openimageio()
    if "Combined" not in planes:
        raise ImageError("a PNG holds the pass Combined, which was not rendered")
    pixels = np.ascontiguousarray(to_srgb8(planes["Combined"], exposure)[::-1])
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 4, oiio.UINT8)
    spec.attribute("oiio:UnassociatedAlpha", 1)
    spec.attribute("oiio:ColorSpace", "sRGB")
    write_pixels(oiio, path, spec, pixels, {name: str(value) for name, value in metadata.items()})


def write_pixels(oiio, path: Path, spec, pixels: np.ndarray, metadata: dict) -> None:
    for name, value in metadata.items():
        spec.attribute(name, value)
    output = oiio.ImageOutput.create(str(path))
    if output is None:
        raise ImageError(oiio.geterror())
    if not output.open(str(path), spec) or not output.write_image(pixels):
        message = output.geterror()
        output.close()
        raise ImageError(message)
    if not output.close():
        raise ImageError(output.geterror())


def encode_srgb(linear: np.ndarray) -> np.ndarray:
    """IEC 61966-2-1 encoding of linear values, clipped to 0..1; NaN becomes 0."""
    x = np.clip(np.nan_to_num(linear, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.power(x, 1 / 2.4) - 0.055)


def decode_srgb(encoded: np.ndarray) -> np.ndarray:
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def to_srgb8(combined: np.ndarray, exposure: float = 0.0) -> np.ndarray:
    """uint8 (h, w, 4) with straight alpha from linear premultiplied RGBA (h, w, 4); exposure in stops."""
    alpha = np.clip(combined[..., 3:4].astype(np.float64), 0.0, 1.0)
    # Light on clear pixels (alpha 0, as of fire) has no straight form; it is kept as it is.
    straight = combined[..., :3] / np.where(alpha > 0.0, alpha, 1.0)
    encoded = np.concatenate([encode_srgb(straight * 2.0 ** exposure), alpha], axis=2)
    return np.floor(np.nan_to_num(encoded) * 255.0 + 0.5).astype(np.uint8)


def read_image(path: str | Path) -> Image:
    """Read an EXR (one part or, as Blender 5 writes, one part a pass) or PNG (decoded to linear, "Combined").

    Raises ImageError naming the file.
    """
    path = Path(path)
    if not path.is_file():
        raise ImageError(f"{path}: no such file")
    oiio = openimageio()
    config = oiio.ImageSpec()
    config.attribute("oiio:UnassociatedAlpha", 1)  # PNG: leave the values as they lie in the file
    source = oiio.ImageInput.open(str(path), config)
    if source is None:
        raise ImageError(f"{path}: not a readable picture ({oiio.geterror()})")
    try:
        channels, metadata = read_channels(path, oiio, source)
    finally:
        source.close()
    planes = gathered(channels)
    if path.suffix.lower() != ".exr":
        planes = {"Combined": from_encoded(path, planes)}
    return Image(planes, metadata)


def read_channels(path: Path, oiio, source) -> tuple[dict[str, np.ndarray], dict]:
    """All channels of all parts by name, each (h, w) with rows from the bottom, and the first part's metadata."""
    channels: dict[str, np.ndarray] = {}
    metadata: dict = {}
    part = 0
    while source.seek_subimage(part, 0):
        spec = source.spec()
        pixels = source.read_image(part, 0, 0, spec.nchannels, oiio.FLOAT)
        if pixels is None:
            raise ImageError(f"{path}: damaged ({source.geterror()})")
        if part == 0:
            metadata = {attribute.name: attribute.value for attribute in spec.extra_attribs}
        for index, name in enumerate(spec.channelnames):
            channels[name] = np.asarray(pixels, np.float32).reshape(spec.height, spec.width, -1)[::-1, :, index]
        part += 1
    return channels, metadata


def gathered(channels: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """"Layer.Pass.R" -> passes; the layer's name stays only where there are several. Bare "R" belongs to Combined."""
    parted: dict[tuple[str, str], dict[str, np.ndarray]] = {}
    for name, values in channels.items():
        head, _, channel = name.rpartition(".")
        layer, _, pass_name = head.rpartition(".")
        parted.setdefault((layer, pass_name or "Combined"), {})[channel] = values
    several = len({layer for layer, _ in parted if layer}) > 1
    planes = {}
    for (layer, pass_name), found in parted.items():
        order = sorted(found, key=lambda c: CHANNELS.get(pass_name, CHANNEL_ORDER).upper().find(c.upper()))
        planes[f"{layer}.{pass_name}" if several and layer else pass_name] = np.stack([found[c] for c in order], axis=2)
    return planes


def from_encoded(path: Path, planes: dict[str, np.ndarray]) -> np.ndarray:
    """Premultiplied linear RGBA from the encoded values of an 8- or 16-bit picture."""
    found = planes.get("Combined")
    if found is None or found.shape[2] not in (3, 4):
        raise ImageError(f"{path}: neither RGB nor RGBA")
    alpha = found[..., 3:4] if found.shape[2] == 4 else np.ones_like(found[..., :1])
    return np.concatenate([decode_srgb(found[..., :3]) * alpha, alpha], axis=2).astype(np.float32)
