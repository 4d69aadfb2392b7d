"""The grid: the settings that a report tries. Each differs from the scene's own in one thing, so its effect has a name.

A full product of all axes would be thousands of renders and say less: what one setting does shows best where
nothing else changes. One choice at the end takes all savings at once, because people do.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, replace

from isophote.settings import Settings

NO_LIMIT = 128  # bounces of the truth: roulette ends paths long before
BASE, TRUTH, ADAPTIVE = "base", "truth", "adaptive"
FIELDS = {field.name for field in fields(Settings)}
BOUNCES = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces",
           "transparent_bounces")


@dataclass(frozen=True)
class Choice:
    """One entry of the grid: `key` names its files, `axis` groups it, `label` is for people.

    `can_be_idle`: whether it is left out where a pilot finds that it changes no bit of the picture.
    """

    key: str
    axis: str
    label: str
    settings: Settings
    can_be_idle: bool = False


def plain_settings(settings: Settings) -> Settings:
    """The settings as a report renders with them: no limit but samples, and one device at a time is timed."""
    return replace(settings, samples=1, time_limit=0.0, error_target=0.0, seed=0, wait_for_kernels=True,
                   passes=("combined",), region=None)


def truth_of(base: Settings, precision: str) -> Settings:
    """What the others are measured against: no limit on bounces, no clamping, every pixel its samples."""
    also = {"adaptive": False} if "adaptive" in FIELDS else {}
    return replace(base, **dict.fromkeys(BOUNCES, NO_LIMIT), clamp_direct=0.0, clamp_indirect=0.0, precision=precision,
                   **also)


def make_grid(base: Settings, devices: Iterable[str] = ()) -> list[Choice]:
    """The choices to try beside the truth, the scene's own settings first; none twice."""
    choices = [Choice(BASE, "Your settings", "Your settings", base), *bounce_choices(base), *clamp_choices(base),
               *other_choices(base)]
    for device in devices:
        choices.append(Choice(f"device={device}", "Device", f"Device {device}", replace(base, device=device)))
    quick = {"max_bounces": min(2, base.max_bounces), "clamp_indirect": 1.0, "precision": "fast"}
    choices.append(Choice("quick", "All savings", "All at once: 2 bounces, indirect light clamped at 1, fast precision",
                          replace(base, **quick)))
    seen, kept = set(), []
    for choice in choices:
        if choice.settings not in seen:
            seen.add(choice.settings)
            kept.append(choice)
    return kept


def bounce_choices(base: Settings) -> list[Choice]:
    made = []
    for count in (1, 2, 4, 8):
        if count < base.max_bounces:
            label = "1 bounce" if count == 1 else f"{count} bounces"
            made.append(Choice(f"max_bounces={count}", "Bounces", label, replace(base, max_bounces=count), True))
    for name in BOUNCES[1:]:
        kind, limit = name.removesuffix("_bounces"), 1 if name in BOUNCES[1:3] else 2
        if limit < min(getattr(base, name), base.max_bounces):
            label = f"{limit} {kind} bounce{'s' if limit > 1 else ''}"
            made.append(Choice(f"{name}={limit}", "Bounces", label, replace(base, **{name: limit}), True))
    more = {name: 32 if name == "max_bounces" else max(32, getattr(base, name)) for name in BOUNCES}
    if any(getattr(base, name) < 32 for name in BOUNCES):
        made.append(Choice("bounces=32", "Bounces", "32 bounces of every kind", replace(base, **more), True))
    return made


def clamp_choices(base: Settings) -> list[Choice]:
    """Clamps are never idle: what they cut may come once in a million paths, and is then all that one sees."""
    made = []
    if base.clamp_direct or base.clamp_indirect:
        off = replace(base, clamp_direct=0.0, clamp_indirect=0.0)
        made.append(Choice("clamp=off", "Clamping", "No clamping", off))
    for value in (10.0, 3.0, 1.0):
        made.append(Choice(f"clamp_indirect={value:g}", "Clamping", f"Clamping indirect light at {value:g}",
                           replace(base, clamp_indirect=value)))
    made.append(Choice("clamp_direct=10", "Clamping", "Clamping direct light at 10", replace(base, clamp_direct=10.0)))
    return made


def other_choices(base: Settings) -> list[Choice]:
    """Filter and precision, and the size of textures where this version has such a setting."""
    made = [Choice(f"filter_width={width:g}", "Filter", f"Filter {width:g} pixels wide",
                   replace(base, filter_width=width)) for width in (1.0, 2.5) if width != base.filter_width]
    names = {"strict": "Strict precision", "fast": "Fast precision", "reference": "64-bit precision"}
    for precision, label in names.items():
        if precision != base.precision and (precision != "reference" or base.device == "openmp"):
            made.append(Choice(f"precision={precision}", "Precision", label, replace(base, precision=precision)))
    if "texture_scale" in FIELDS:
        for scale in (0.5, 0.25):
            if scale < base.texture_scale:
                label = f"Textures at {100 * scale:g} % of their size"
                smaller = replace(base, texture_scale=scale)
                made.append(Choice(f"texture_scale={scale:g}", "Textures", label, smaller, True))
    return made


def adaptive_choice(base: Settings, target: float) -> Choice:
    """Adaptive sampling until `target` is reached, the error (confidence.error_95) of a run of the others."""
    settings = replace(base, adaptive=True, error_target=target)
    return Choice(ADAPTIVE, "Adaptive sampling", f"Adaptive sampling to {100 * target:.3g} % error", settings)
