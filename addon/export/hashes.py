# SPDX-License-Identifier: GPL-3.0-or-later
"""The hashes by which Blender and Cycles make random numbers of names and numbers: Jenkins 2006, "lookup3"."""

from __future__ import annotations

import numpy as np

MASK = 0xFFFFFFFF
START = 0xDEADBEEF + 13  # and four for each word


def hash_pair(x, y):
    """Of two words: numbers or arrays of i8."""
    start = START + 8 & MASK
    return finished(start + x & MASK, start + y & MASK, start)


def hash_words(words: np.ndarray) -> np.ndarray:
    """Of each word alone, i8 (n)."""
    start = START + 4 & MASK
    return finished(words.astype(np.int64) + start & MASK, start, start)


def finished(a, b, c):
    """The last mixing of three words: numbers or arrays of i8."""
    for turn in (14, 11, 25, 16, 4, 14, 24):
        c = (c ^ b) - turned(b, turn) & MASK
        a, b, c = b, c, a  # the next word to change comes last
    return b


def turned(x, bits: int):
    return (x << bits | x >> 32 - bits) & MASK


def hash_text(text: str) -> int:
    """Of a name, byte by byte as signed numbers."""
    made = 0
    for byte in text.encode():
        made = made * 37 + (byte - 256 if byte > 127 else byte) & MASK
    return made


def to_unit(word):
    """From 0 to 1, in float32."""
    return np.float32(word) * np.float32(1.0 / MASK)
