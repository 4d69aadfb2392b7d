"""What a user can choose about a render. Immutable; the defaults stand here and nowhere else."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

PRECISIONS = ("strict", "fast", "reference")
MOST_LEVELS = 16  # of Cryptomatte, as in Blender

# What may change between two parts of one film: how far and how fast, not what each sample is.
NOT_OF_THE_SAMPLES = ("samples", "time_limit", "error_target", "adaptive", "device", "wait_for_kernels", "threads",
                      "passes", "named", "matte_levels", "shadow_catchers")


@dataclass(frozen=True)
class Settings:
    """Settings of one render. Bounce limits count as Cycles counts them (0: direct light only)."""

    samples: int = 128
    time_limit: float = 0.0  # seconds, 0: none
    error_target: float = 0.0  # relative, 95 % of the pixels shall be within it (confidence.py); 0: none
    adaptive: bool = True  # with an error_target: samples go where they are needed (adaptive.py)
    seed: int = 0
    precision: str = "strict"
    device: str = "openmp"  # openmp, opencl or opencl:N
    wait_for_kernels: bool = False  # else the CPU renders while an OpenCL device compiles, where bits are equal
    threads: int = 0  # 0: all cores
    max_bounces: int = 12
    diffuse_bounces: int = 4
    glossy_bounces: int = 4
    transmission_bounces: int = 12
    volume_bounces: int = 0
    transparent_bounces: int = 8
    clamp_direct: float = 0.0  # 0: off
    clamp_indirect: float = 0.0
    filter_width: float = 1.5  # pixels, Blackman-Harris
    film_transparent: bool = False
    passes: tuple[str, ...] = ("combined", "error")
    named: tuple[str, ...] = ()  # all AOV outputs and light groups of the scene (Scene.named), or none
    matte_levels: int = 6  # ids of a pixel that Cryptomatte's passes show
    shadow_catchers: bool = False  # films keep what it takes to show the shadows on catchers (Scene.catches)
    region: tuple[int, int, int, int] | None = None  # x0, y0, x1, y1 in pixels from the lower left

    def __post_init__(self):
        if self.precision not in PRECISIONS:
            raise ValueError(f"precision {self.precision!r}: one of {', '.join(PRECISIONS)}")
        for name in ("samples", "max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces",
                     "volume_bounces", "transparent_bounces", "threads", "seed"):
            if getattr(self, name) < 0:
                raise ValueError(f"{name} is {getattr(self, name)}: it cannot be negative")
        if not 0.0 <= self.error_target < math.inf:
            raise ValueError(f"error_target is {self.error_target}: it must be 0 (none) or more")
        if not 1 <= self.matte_levels <= MOST_LEVELS:
            raise ValueError(f"matte_levels is {self.matte_levels}: there are 1 to {MOST_LEVELS}")
        if self.samples < 1:
            raise ValueError("samples is 0: at least 1 is needed")

    @property
    def clamps(self) -> bool:
        """Whether light is clamped: the film then has planes of what was cut off."""
        return self.clamp_direct > 0.0 or self.clamp_indirect > 0.0

    def fingerprint(self) -> dict:
        """The settings on which the value of a sample depends, by name: films that differ here do not merge."""
        return {name: value for name, value in asdict(self).items() if name not in NOT_OF_THE_SAMPLES}
