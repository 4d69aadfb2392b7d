"""numpy's view of the records, lists and numbers that kernels define, read from their headers.

Each list exists once, in kernels/: record structs and #defines in scene_records.h, the list of the
scene's arrays in scene_buffers.h, that of a work item's settings in params.h. Structs hold 4-byte
scalars only (a ushort is an element of an array), so a dtype follows from the text; a test compares
sizes with the compiler's.
"""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np

SCALARS = {"float": "<f4", "int": "<i4", "uint": "<u4", "ushort": "<u2"}


def header_path(name: str) -> Path:
    """A kernel source's file: inside an installed package, or beside the package in the source tree."""
    inside = Path(__file__).parent / "kernels"
    return (inside if inside.is_dir() else Path(__file__).parent.parent / "kernels") / name


@cache
def header(name: str) -> str:
    """The text of a kernel header without comments."""
    return re.sub(r"/\*.*?\*/|//[^\n]*", " ", header_path(name).read_text(), flags=re.S)


@cache
def numbers() -> dict[str, int]:
    """Whole numbers that scene_records.h and params.h #define, by name."""
    found = re.findall(r"#define (\w+) (0x[0-9a-fA-F]+|\d+)u?\b", header("scene_records.h") + header("params.h"))
    return {name: int(value, 0) for name, value in found}


def feature_names(mask: int) -> dict[str, bool]:
    """Each FEATURE_ that kernels can be compiled for, in small letters, and whether it is in the mask."""
    return {name.removeprefix("FEATURE_").lower(): bool(mask & bit) for name, bit in numbers().items()
            if name.startswith("FEATURE_")}


@cache
def records() -> dict[str, np.dtype]:
    """The dtype of each record struct, by its C name; scalars too."""
    made = {name: np.dtype(code) for name, code in SCALARS.items()}
    made["packed3"] = np.dtype((np.float32, 3))
    for body, name in re.findall(r"typedef struct \{(.*?)\} (\w+);", header("scene_records.h"), re.S):
        made[name] = np.dtype([field for line in body.split(";") for field in fields_of(line, made)])
    return made


def fields_of(declaration: str, known: dict[str, np.dtype]):
    """(name, dtype) or (name, dtype, shape) of each name that a C declaration declares."""
    words = declaration.split(None, 1)
    if len(words) < 2:
        return
    for declared in words[1].split(","):
        name, _, count = declared.strip().partition("[")
        if count:
            size = count.rstrip("]").strip()
            yield name, known[words[0]], (int(size) if size.isdigit() else numbers()[size],)
        elif known[words[0]].subdtype:
            yield name, *known[words[0]].subdtype
        else:
            yield name, known[words[0]]


@cache
def scene_buffers() -> dict[str, np.dtype]:
    """Element type of each of the scene's arrays, in the order in which kernels take them."""
    return {name: records()[kind] for kind, name in re.findall(r"X\((\w+), (\w+), \"", header("scene_buffers.h"))}


@cache
def plane_groups() -> dict[str, tuple[int, int]]:
    """Number and planes of each group of a film's planes beside Combined's, in their order."""
    found = re.findall(r"X\((\d+), (\w+), (\d+)\)", header("params.h"))
    return {name: (int(number), int(planes)) for number, name, planes in found}


@cache
def params_dtype() -> np.dtype:
    """The record Params of a work item."""
    declared = re.findall(r"X\((float|int|uint), (\w+)\)", header("params.h"))
    return np.dtype([(name, SCALARS[kind]) for kind, name in declared])


def make_records(name: str, count: int, **columns) -> np.ndarray:
    """`count` records of a struct, with the given fields filled and the others zero."""
    made = np.zeros(count, records()[name])
    for field, values in columns.items():
        made[field] = values
    return made
