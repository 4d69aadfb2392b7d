"""Which planes a film has: those of Combined, groups that passes ask for, and those of what clamping cuts off.

Planes of Combined, rows from the bottom: 0-3 RGBA of replicate 0, 4-7 RGBA of replicate 1, 8 how many samples were no
numbers and count as 0. Behind them lie the film's groups, in the order of PLANE_GROUPS in kernels/params.h, and where
light is clamped four more: luminance cut off from direct and from indirect light of replicate 0, and of replicate 1.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from isophote.records import numbers, plane_groups

INVALID = 8  # the plane's number
COMBINED = 9  # so many
CUT = 4
SHARES = 12  # numbers of a path where light is told apart by the closures of its first bounce (kernels/passes.h)
GUIDES = 4  # and where denoisers are guided
DENOISING = ("denoising_normal", "denoising_albedo", "denoising_depth")
SPLIT = tuple(f"{kind}_{light}" for kind in ("diffuse", "glossy", "transmission") for light in ("direct", "indirect"))


@dataclass(frozen=True)
class Planes:
    """The planes of a film; as an index it is their number. `groups` are in the kernels' order (make_planes), `aovs`
    AOV outputs in the scene's: color:NAME (RGBA) or value:NAME."""

    groups: tuple[str, ...] = ()
    clamps: bool = False
    aovs: tuple[str, ...] = ()

    def __index__(self) -> int:
        return COMBINED + sum(plane_groups()[name][1] for name in self.groups) + self.aov_planes + CUT * self.clamps

    __int__ = __index__

    def __str__(self) -> str:
        return f"{int(self)} planes" + (f" ({', '.join(self.groups + self.aovs)})" if self.groups + self.aovs else "")

    @cached_property
    def first(self) -> dict[str, int]:
        """The first plane of each group and AOV."""
        made, at = {}, COMBINED
        for name in self.groups:
            made[name], at = at, at + plane_groups()[name][1]
        for name in self.aovs:
            made[name], at = at, at + aov_width(name)
        return made

    @property
    def aov_planes(self) -> int:
        return sum(aov_width(name) for name in self.aovs)

    @property
    def mask(self) -> int:
        """As Params has it."""
        return sum(1 << plane_groups()[name][0] for name in self.groups) | numbers()["GROUPS_AOVS"] * bool(self.aovs)

    @property
    def cut(self) -> int:
        """The first plane of what clamping cuts off; 0 where nothing is clamped."""
        return int(self) - CUT if self.clamps else 0

    @property
    def columns(self) -> int:
        """Numbers of a path beside its light."""
        split, guided = (any(name in of for name in self.groups) for of in (SPLIT, DENOISING))
        return int(self) - COMBINED - CUT * self.clamps + SHARES * split + GUIDES * guided

    @property
    def needs_sample_0(self) -> bool:
        """Whether some plane is made of sample 0 alone."""
        return any(plane_groups()[name][0] < numbers()["GROUPS_OF_SAMPLE_0"] for name in self.groups)


def aov_width(name: str) -> int:
    """Planes of an AOV: a colour has an alpha of 1."""
    return 4 if name.startswith("color:") else 1


def make_planes(groups: Iterable[str] = (), clamps: bool = False, aovs: Iterable[str] = ()) -> Planes:
    """Planes with these groups, in any order, and AOVs. Raises ValueError naming one that does not exist."""
    groups = set(groups)
    if unknown := groups - set(plane_groups()):
        raise ValueError(f"no planes {', '.join(sorted(unknown))}; there are {', '.join(plane_groups())}")
    return Planes(tuple(name for name in plane_groups() if name in groups), bool(clamps), tuple(aovs))
