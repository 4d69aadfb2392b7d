"""Cryptomatte: ids of names, and what a file says of them (Psyop, Cryptomatte specification 1.2).

An id is a name's MurmurHash3 as the bits of a float32; names that a file's manifest tells are those of things that can
be seen.
"""

from __future__ import annotations

import json
from collections.abc import Iterable

import numpy as np

from isophote.scene import Scene

KINDS = {"object": "CryptoObject", "material": "CryptoMaterial", "asset": "CryptoAsset"}  # what files call them


def murmur3(text: str) -> int:
    """MurmurHash3_x86_32 of the text's UTF-8, with seed 0 (A. Appleby, smhasher)."""
    data, mask = text.encode(), 0xFFFFFFFF
    state, whole = 0, len(data) & ~3
    for at in range(0, len(data), 4):
        k = int.from_bytes(data[at:at + 4], "little") * 0xCC9E2D51 & mask
        k = (k << 15 | k >> 17) * 0x1B873593 & mask
        state ^= k
        if at < whole:
            state = ((state << 13 | state >> 19) * 5 + 0xE6546B64) & mask
    state ^= len(data)
    for shift, factor in ((16, 0x85EBCA6B), (13, 0xC2B2AE35), (16, 1)):
        state = (state ^ state >> shift) * factor & mask
    return state


def id_bits(name: str) -> int:
    """Bits of the float32 that stands for a name: its hash, with an exponent that numbers have, neither 0 nor 255."""
    bits = murmur3(name)
    return bits ^ 1 << 23 if bits >> 23 & 255 in (0, 255) else bits


def ids_of(names: Iterable[str]) -> np.ndarray:
    """uint32 (n) of names, many of which may be the same."""
    names = list(names)
    bits = {name: id_bits(name) for name in set(names)}
    return np.array([bits[name] for name in names], np.uint32)


def names_of(scene: Scene, kind: str) -> list[str]:
    """Of the things of a kind that have an id."""
    if kind == "asset":
        return list(scene.names.get("assets", ()))
    groups = {"object": ("instance", "sphere"), "material": ("material",)}[kind]
    return [name for group in groups
            for name, ids in zip(scene.names.get(f"{group}s", ()), scene.arrays[f"{group}_matte"], strict=False)
            if np.any(ids)]


def metadata(layer: str, kind: str, names: Iterable[str]) -> dict[str, str]:
    """What a file's header says of a layer's mattes of a kind, whose things have these names."""
    name = f"{layer}.{KINDS[kind]}"
    manifest = {name: f"{id_bits(name):08x}" for name in sorted(set(names))}
    prefix = f"cryptomatte/{murmur3(name):08x}"[:-1] + "/"  # seven digits
    return {f"{prefix}name": name, f"{prefix}hash": "MurmurHash3_32", f"{prefix}conversion": "uint32_to_float32",
            f"{prefix}manifest": json.dumps(manifest, ensure_ascii=False, separators=(",", ":"))}
