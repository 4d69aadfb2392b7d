# SPDX-License-Identifier: GPL-3.0-or-later
"""What the values of materials read beside the shaded point: attributes of meshes, pictures, tables of curves."""

from __future__ import annotations

import numpy as np

from .images import MISSING, Picture

IMAGE_SRGB, IMAGE_DIVIDE_ALPHA = 1, 2  # of kernels/scene_records.h
# Of the keys (kind, name) by which attributes are asked for.
ATTRIBUTE_KINDS = ("uv", "named", "generated", "color", "tangent", "island", "pointiness", "place", "box_low",
                   "box_sizes", "strand")


class Lookups:
    """Numbers what materials ask for; collected while they are exported.

    `frame` is the scene's; `view_layer_value(name)` is the value of a property of the view layer, the scene or the
    world, four numbers.
    """

    def __init__(self, frame: int, view_layer_value):
        self.frame, self.view_layer_value = frame, view_layer_value
        self.instance_columns: dict[tuple[str, str, int], int] = {}
        self.attributes: dict[tuple[str, str], int] = {}
        self._images: dict[tuple, int] = {}  # by key and flags
        self._rows: list[tuple] = []
        self._pictures: dict[object, tuple[tuple, int]] = {}  # by key: the start of their rows, how they are stored
        self._texels: list[np.ndarray] = []
        self._words = 0
        self._tables: dict[bytes, int] = {}
        self._entries: list[np.ndarray] = []
        self._length = 0

    def attribute(self, kind: str, name: str = "") -> int:
        """The number of an attribute: kind "uv" with a map's name ("": the active one), "tangent" with that of the map
        along which it runs, "color" likewise, "named" with an attribute's, "strand" with what strands.py calls it, or
        another of ATTRIBUTE_KINDS."""
        assert kind in ATTRIBUTE_KINDS
        return self.attributes.setdefault((kind, name), len(self.attributes))

    def instance(self, kind: str, name: str = "", part: int = 0) -> int:
        """The column of what is known of each instance (instance_values.py has the kinds)."""
        return self.instance_columns.setdefault((kind, name, part), len(self.instance_columns))

    def table(self, entries) -> int:
        """Where a row of numbers begins in value_tables; equal rows are kept once."""
        entries = np.ascontiguousarray(entries, np.float32).ravel()
        key = entries.tobytes()
        if key not in self._tables:
            self._tables[key] = self._length
            self._entries.append(entries)
            self._length += len(entries)
        return self._tables[key]

    def image(self, key, flags: int, read) -> tuple[int, int]:
        """The number of an image, and how its colours are stored: IMAGE_SRGB, IMAGE_DIVIDE_ALPHA where it has an alpha.

        It is the picture that `read` gives (images.Picture), kept once for each key, with IMAGE_ modes of interpolation
        and extension. What `read` raises goes through.
        """
        if key not in self._pictures:
            self._pictures[key] = self.add_picture(read())
        row, stored = self._pictures[key]
        if (key, flags) not in self._images:
            self._images[key, flags] = len(self._rows)
            self._rows.append((*row, flags))
        return self._images[key, flags], stored

    def add_picture(self, picture) -> tuple[tuple, int]:
        """Where its texels are: first word, width, height, channels, TEXEL_ kind; and how they are stored."""
        height, width, channels = picture.texels.shape
        plain = np.ascontiguousarray(picture.texels).reshape(-1).view(np.uint8)
        words = -(-len(plain) // 4)
        first, self._words = self._words, self._words + words
        self._texels += [plain, np.zeros(4 * words - len(plain), np.uint8)]
        stored = IMAGE_SRGB * picture.srgb | IMAGE_DIVIDE_ALPHA * (channels == 4)
        return (first, width, height, channels, picture.kind), stored

    def missing_image(self) -> int:
        """Stands for pictures that there are not."""
        return self.image("missing", 0, lambda: Picture(np.array([[MISSING]], np.float16), False))[0]

    def arrays(self) -> dict[str, np.ndarray]:
        """The scene's arrays."""
        made = {"value_tables": np.concatenate(self._entries)} if self._entries else {}
        if self._rows:
            made |= {"images": np.array(self._rows, np.int32), "image_texels": np.concatenate(self._texels)}
        return made
