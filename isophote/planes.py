"""Which planes a film has: those of Combined, groups that passes ask for, and those of what clamping cuts off.

Planes of Combined, rows from the bottom: 0-3 RGBA of replicate 0, 4-7 RGBA of replicate 1, 8 how many samples were no
numbers and count as 0. Behind them lie the film's groups, in the order of PLANE_GROUPS in kernels/params.h, then AOV
outputs and light groups, where light is clamped four more: luminance cut off from direct and from indirect light of
replicate 0, and of replicate 1; and where there are mattes those of their table, which are no sums (mattes.py).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from isophote.records import numbers, plane_groups

INVALID = numbers()["PLANE_INVALID"]
COMBINED = numbers()["PLANES_COMBINED"]  # so many
CUT = numbers()["PLANES_CUT"]
SHARES = numbers()["SHARE_COLUMNS"]  # numbers of a path where light is told apart by the closures of its first bounce
GUIDES = numbers()["GUIDE_COLUMNS"]  # and where denoisers are guided
RECORDS = numbers()["MATTE_RECORDS"]  # rows of a path's table of mattes
SPARE_ROWS = 6  # of a pixel's, beside those that are shown
MATTES = {kind: numbers()[f"GROUPS_MATTE_{kind.upper()}"] for kind in ("object", "material", "asset")}
DENOISING = ("denoising_normal", "denoising_albedo", "denoising_depth")
SPLIT = tuple(f"{kind}_{light}" for kind in ("diffuse", "glossy", "transmission") for light in ("direct", "indirect"))


@dataclass(frozen=True)
class Planes:
    """The planes of a film; as an index it is their number. `groups` are in the kernels' order (make_planes), `named`
    in the scene's: AOV outputs, color:NAME (RGBA) or value:NAME, then light groups, light:NAME. `mattes` are kinds of
    MATTES in their order, of which the `levels` ids are shown that cover most of a pixel."""

    groups: tuple[str, ...] = ()
    clamps: bool = False
    named: tuple[str, ...] = ()
    mattes: tuple[str, ...] = ()
    levels: int = 0

    def __index__(self) -> int:
        return self.sums + self.matte_planes(self.matte_rows)

    __int__ = __index__

    def __str__(self) -> str:
        names = (*self.groups, *self.named, *(f"mattes of {kind}s" for kind in self.mattes))
        return f"{int(self)} planes" + (f" ({', '.join(names)})" if names else "")

    @property
    def sums(self) -> int:
        """So many are sums, the first ones."""
        return COMBINED + sum(plane_groups()[name][1] for name in self.groups) + self.named_planes + CUT * self.clamps

    @property
    def matte_rows(self) -> int:
        """Of a pixel's table: so many ids are told apart in a block of its samples."""
        return self.levels + SPARE_ROWS if self.mattes else 0

    def matte_planes(self, rows: int) -> int:
        return rows * (1 + len(self.mattes)) + 1 if self.mattes else 0

    @cached_property
    def first(self) -> dict[str, int]:
        """The first plane of each group, by name."""
        made, at = {}, COMBINED
        for name in self.groups:
            made[name], at = at, at + plane_groups()[name][1]
        for name in self.named:
            made[name], at = at, at + named_width(name)
        return made

    @property
    def named_planes(self) -> int:
        return sum(named_width(name) for name in self.named)

    @property
    def light_plane(self) -> int:
        """The first one of light groups, counted from that of the first that is named."""
        return sum(named_width(name) for name in self.named if not name.startswith("light:"))

    @property
    def mask(self) -> int:
        """As Params has it."""
        lit = [name.startswith("light:") for name in self.named]
        named = numbers()["GROUPS_AOVS"] * (not all(lit)) | numbers()["GROUPS_LIGHT_GROUPS"] * any(lit)
        mattes = sum(MATTES[kind] for kind in self.mattes)
        return sum(1 << plane_groups()[name][0] for name in self.groups) | named | mattes

    @property
    def cut(self) -> int:
        """The first plane of what clamping cuts off; 0 where nothing is clamped."""
        return self.sums - CUT if self.clamps else 0

    @property
    def columns(self) -> int:
        """Numbers of a path beside its light."""
        split, guided = (any(name in of for name in self.groups) for of in (SPLIT, DENOISING))
        lit = any(name.startswith("light:") for name in self.named)
        return (self.sums - COMBINED - CUT * self.clamps + SHARES * split + GUIDES * guided + lit
                + self.matte_planes(RECORDS))


def named_width(name: str) -> int:
    """Planes of an AOV or a light group. An AOV's colour has an alpha of 1."""
    return {"color": 4, "light": 3, "value": 1}[name.partition(":")[0]]


def make_planes(groups: Iterable[str] = (), clamps: bool = False, named: Iterable[str] = (), mattes: Iterable[str] = (),
                levels: int = 0) -> Planes:
    """Planes with these groups and mattes, in any order, and those that are named. Raises ValueError naming an unknown
    group."""
    groups, mattes = set(groups), set(mattes)
    if unknown := groups - set(plane_groups()):
        raise ValueError(f"no planes {', '.join(sorted(unknown))}; there are {', '.join(plane_groups())}")
    return Planes(tuple(name for name in plane_groups() if name in groups), bool(clamps), tuple(named),
                  tuple(kind for kind in MATTES if kind in mattes), levels if mattes else 0)
