# SPDX-License-Identifier: GPL-3.0-or-later
"""Photometric files (IES LM-63-2002) as the tables that kernels/values/photometry.h reads.

Symmetries and units are taken as Cycles takes them (src/util/ies.cpp): candelas are those of daylight D65, 177.83
lumens a watt, and times 4 pi, since a lamp's strength is that of its whole sphere.
"""

from __future__ import annotations

import re

import numpy as np

from isophote.records import header

WATTS_OF_CANDELA = 4.0 * np.pi / 177.83
TYPE_C = 1  # vertical angles from straight down, horizontal ones around the vertical axis


class NotPhotometric(ValueError):
    """A text that is no photometric file, or not one of a kind that is supported; the message says why."""


def parse_photometry(text: str) -> np.ndarray:
    """The table of a file's text, f4: numbers of horizontal and vertical angles, both kinds of angles in radians, and
    watts, those of one horizontal angle together.

    Raises NotPhotometric.
    """
    found = re.search(r"^[ \t]*TILT=(.*)$", text, re.MULTILINE)
    if not found:
        raise NotPhotometric("it is no photometric (IES) file")
    numbers = read_numbers(text[found.end():])
    if found.group(1).strip() == "INCLUDE":  # of how the lamp burns when it is tilted, which is left out
        numbers = numbers[2 + 2 * int(numbers[1]):] if len(numbers) > 1 else numbers
    if len(numbers) < 13:
        raise NotPhotometric("its photometric file ends too soon")
    multiplier, down, around, kind = numbers[2], int(numbers[3]), int(numbers[4]), int(numbers[5])
    if kind != TYPE_C:
        raise NotPhotometric(f"photometry of type {kind} is not supported, only C (1)")
    most = int(re.search(r"MOST_PHOTOMETRY_ANGLES (\d+)", header("values/photometry.h")).group(1))
    if not (2 <= down <= most and 1 <= around <= most // 4 and len(numbers) >= 13 + down + around + down * around):
        raise NotPhotometric(f"its photometric file has {down} x {around} angles and {len(numbers)} numbers")
    vertical, horizontal, watts = np.split(numbers[13:13 + down + around + down * around], (down, down + around))
    watts = watts.reshape(around, down) * (multiplier * numbers[10] * numbers[11] * WATTS_OF_CANDELA)
    horizontal, watts = all_around(horizontal, watts)
    if (np.diff(vertical) <= 0.0).any() or (np.diff(horizontal) <= 0.0).any():
        raise NotPhotometric("the angles of its photometric file do not ascend")
    angles = np.radians(np.concatenate([horizontal, vertical]).astype(np.float32))
    return np.concatenate([[len(horizontal), len(vertical)], angles, watts.ravel()]).astype(np.float32)


def read_numbers(text: str) -> np.ndarray:
    """All numbers up to the first thing that is none, f8."""
    made = []
    for word in text.replace(",", " ").split():
        try:
            made.append(float(word))
        except ValueError:
            break
    return np.array(made)


def all_around(horizontal: np.ndarray, watts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Horizontal angles from 0 to 360 degrees and the rows of watts for them: files leave out what is the same on
    another side. Raises NotPhotometric."""
    if horizontal[0] == 90.0:  # some go from 90 to 270
        horizontal = horizontal - 90.0
    if horizontal[0] != 0.0:
        raise NotPhotometric(f"horizontal angles of its photometric file begin at {horizontal[0]:g} degrees")
    if len(horizontal) == 1:
        return np.array([0.0, 360.0]), np.repeat(watts, 2, axis=0)
    for turn in (90.0, 180.0):
        if horizontal[-1] == turn:
            horizontal = np.concatenate([horizontal, 2.0 * turn - horizontal[-2::-1]])
            watts = np.concatenate([watts, watts[-2::-1]])
    if horizontal[-1] != 360.0:
        if 360.0 - horizontal[-1] not in (horizontal[1] - horizontal[0], horizontal[-1] - horizontal[-2]):
            raise NotPhotometric(f"horizontal angles of its photometric file end at {horizontal[-1]:g} degrees")
        horizontal, watts = np.append(horizontal, 360.0), np.concatenate([watts, watts[:1]])
    return horizontal, watts
