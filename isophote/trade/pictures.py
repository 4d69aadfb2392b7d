"""The report's pictures: sRGB at one exposure, and differences in a colour scale that is the same for all.

PNG is written here, in ten lines over zlib: Blender before 3.5 brings no OpenImageIO, and a report must come out of its
Python too. JPEG, for reports that are to be small, is OpenImageIO's.
"""

from __future__ import annotations

import struct
import zlib
from pathlib import Path

import numpy as np

from isophote.images import ImageError, encode_srgb, openimageio
from isophote.statistics import LUMINANCE

FORMATS = ("png", "jpg")
DARKER, EQUAL, BRIGHTER = (0.03, 0.32, 0.67), (0.97, 0.97, 0.96), (0.75, 0.29, 0.0)  # blue to orange: no red-green
LIFT = 0.1  # of the mean brightness: darker places are compared with this


def exposure_of(reference: np.ndarray) -> float:
    """The factor at which linear pictures (h, w, 3) are shown: 1, as Blender's Standard view shows them, unless that
    would be nearly black or white throughout; then the 90th percentile becomes 0.5."""
    bright = float(np.percentile(reference @ LUMINANCE, 90.0))
    return 1.0 if 0.05 <= bright <= 2.0 or bright <= 0.0 else 0.5 / bright


def shown(picture: np.ndarray, exposure: float) -> np.ndarray:
    """sRGB, uint8 (h, w, 3), of linear RGB."""
    return np.floor(encode_srgb(picture * exposure) * 255.0 + 0.5).astype(np.uint8)


def difference(change: np.ndarray, reference: np.ndarray, full: float) -> np.ndarray:
    """`change` (h, w, 3) relative to the reference's brightness in blue (darker) and orange, saturated at `full`."""
    brightness = reference @ LUMINANCE
    below = np.maximum(brightness, LIFT * brightness.mean())
    share = np.clip((change @ LUMINANCE) / np.where(below > 0.0, below, 1.0) / full, -1.0, 1.0)[..., None]
    darker, equal, brighter = (np.array(colour) for colour in (DARKER, EQUAL, BRIGHTER))
    mixed = np.where(share < 0.0, equal + (darker - equal) * -share, equal + (brighter - equal) * share)
    return np.floor(mixed * 255.0 + 0.5).astype(np.uint8)


def encode_png(pixels: np.ndarray) -> bytes:
    """PNG of uint8 (h, w, 3), rows from the top (RFC 2083): 8 bits RGB, each row filtered by its left neighbour."""
    height, width = pixels.shape[:2]
    left = np.concatenate([np.zeros((height, 1, 3), np.uint8), pixels[:, :-1]], axis=1)
    rows = (pixels - left).reshape(height, -1)
    data = np.concatenate([np.ones((height, 1), np.uint8), rows], axis=1).tobytes()

    def chunk(name: bytes, body: bytes) -> bytes:
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    return (b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(data, 9))
            + chunk(b"IEND", b""))


def write_picture(path: Path, pixels: np.ndarray) -> None:
    """Write uint8 (h, w, 3), rows from the bottom, as .png or .jpg. Raises ImageError naming the file."""
    pixels = np.ascontiguousarray(pixels[::-1])
    if path.suffix == ".png":
        try:
            path.write_bytes(encode_png(pixels))
        except OSError as error:
            raise ImageError(f"{path}: {error.strerror}") from error
        return
    oiio = openimageio()
    spec = oiio.ImageSpec(pixels.shape[1], pixels.shape[0], 3, oiio.UINT8)
    spec.attribute("Compression", "jpeg:85")
    output = oiio.ImageOutput.create(str(path))
    if output is None or not output.open(str(path), spec) or not output.write_image(pixels) or not output.close():
        raise ImageError(f"{path}: {oiio.geterror() if output is None else output.geterror()}")
