"""THE table of passes: what each is called, what it needs and how it comes from a film."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

import numpy as np

from isophote.cryptomatte import KINDS
from isophote.film import Film, FilmError
from isophote.mattes import UNITS
from isophote.planes import INVALID, Planes, make_planes, named_width
from isophote.records import plane_groups
from isophote.scene import Scene
from isophote.settings import Settings
from isophote.statistics import pixel_error

CATCHER = "shadow_catcher"  # pass and group of planes


def combined(film: Film) -> np.ndarray:
    """Mean of all samples, both replicates; alpha is premultiplied. Where catchers show their shadows, these lie black
    behind the matte."""
    if CATCHER not in film.planes.groups:
        return all_light(film)
    made, shadow = matte(film), shadow_catcher(film)
    made[..., 3] += (1.0 - made[..., 3]) * (1.0 - np.clip(shadow.mean(-1), 0.0, 1.0))
    return made


def all_light(film: Film) -> np.ndarray:
    return np.stack([mean_of(film, film.sum(c) + film.sum(4 + c)) for c in range(4)], axis=-1)


def matte(film: Film) -> np.ndarray:
    """What the camera sees before it meets a catcher, RGBA."""
    made = mean_planes(CATCHER)(film)
    met = made[..., 7:] > 0.0
    made[..., 3] = np.clip(1.0 - made[..., 3], 0.0, 1.0)
    return np.where(met, made[..., :4], all_light(film))  # the same, but rounded alike with and without these planes


def shadow_catcher(film: Film) -> np.ndarray:
    """By how much others darken or brighten what catchers show: a factor for the picture that lies behind.

    Light from catchers with all objects there over that with catchers alone; 1 where the camera meets none. As Cycles,
    film_calculate_shadow_catcher.
    """
    sums = sums_of(film, CATCHER)
    lit = np.stack([film.sum(c) + film.sum(4 + c) for c in range(3)], axis=-1) - sums[..., :3]
    alone = sums[..., 4:7]
    factor = np.divide(lit, alone, out=np.ones_like(lit), where=(alone != 0.0) & (sums[..., 7:] > 0.0))
    alpha = np.clip(all_light(film)[..., 3:].astype(np.float64), 0.0, 1.0)
    return (1.0 - alpha + alpha * factor).astype(np.float32)


def mean_of(film: Film, sums: np.ndarray) -> np.ndarray:
    return (sums / np.maximum(film.counts, 1)).astype(np.float32)


def sums_of(film: Film, group: str) -> np.ndarray:
    """Sums of a group's planes over all samples, float64 (h, w, planes)."""
    first, count = film.planes.first[group], plane_groups()[group][1]
    return np.stack([film.sum(first + c) for c in range(count)], axis=-1)


def mean_planes(group: str) -> Callable[[Film], np.ndarray]:
    return lambda film: (sums_of(film, group) / np.maximum(film.counts, 1)[..., None]).astype(np.float32)


def first_sample_planes(group: str) -> Callable[[Film], np.ndarray]:
    """Planes to which sample 0 alone contributes. Raises FilmError for a part of a render without it."""

    def planes(film: Film) -> np.ndarray:
        if np.any(film.first):
            raise FilmError(f"{group} comes from sample 0; this film begins at sample {np.max(film.first)}")
        return sums_of(film, group).astype(np.float32)

    return planes


def divided(light: str, color: str) -> Callable[[Film], np.ndarray]:
    """Light over colour, as Cycles has it in direct and indirect passes: times the colour it is the light again.

    Where a colour's channel is 0 the light's is, too, and the mean of the others stands in (safe_divide_even_color).
    """

    def planes(film: Film) -> np.ndarray:
        under = sums_of(film, color)
        there = under != 0.0
        quotient = np.divide(sums_of(film, light), under, out=np.zeros_like(under), where=there)
        mean = quotient.sum(-1, keepdims=True) / np.maximum(there.sum(-1, keepdims=True), 1)
        return np.where(there, quotient, mean).astype(np.float32)

    return planes


def vector(film: Film) -> np.ndarray:
    """Mean over the samples that see a surface."""
    sums = sums_of(film, "vector")
    return (sums[..., :4] / np.maximum(sums[..., 4:], 1.0)).astype(np.float32)


def mist(film: Film) -> np.ndarray:
    """Sums are of what is clear of mist, so that where nothing is seen there is mist."""
    return 1.0 - mean_planes("mist")(film)


def mattes(kind: str) -> Callable[[Film], np.ndarray]:
    """Ids that cover most of a pixel, and how much: two pairs a pass, as many passes as levels ask for."""

    def planes(film: Film) -> np.ndarray:
        ranks = 2 * matte_passes(film.planes.levels)
        ids, units = film.all_mattes().of[kind].ranked(film.pixels, ranks)
        made = np.stack([ids, mean_of(film, units.T.reshape(ranks, *film.shape) / UNITS).reshape(ranks, -1).T], axis=-1)
        return made.reshape(*film.shape, 2 * ranks)

    return planes


def matte_passes(levels: int) -> int:
    return (levels + 1) // 2


def invalid(film: Film) -> np.ndarray:
    """How many of the pixel's samples were NaN, infinite or too large for float32, and count as 0."""
    return film.sum(INVALID).astype(np.float32)[..., None]


def sample_count(film: Film) -> np.ndarray:
    return np.broadcast_to(film.counts, film.shape)[..., None].astype(np.float32)


@dataclass(frozen=True)
class Pass:
    """A pass: name in settings, name in Blender and in files, channel ids, groups of planes that it is made of.

    `make` gives float32 (h, w, len(channels)), rows from the bottom. One of mattes of a kind is several in Blender, one
    behind the other in what `make` gives.
    """

    name: str
    blender_name: str
    channels: str
    groups: tuple[str, ...]
    make: Callable[[Film], np.ndarray]
    matte: str = ""

    def names(self, levels: int) -> list[str]:
        """Blender's."""
        name = self.blender_name
        return [f"{name}{number:02d}" for number in range(matte_passes(levels))] if self.matte else [name]


def first_sample_pass(name: str, blender_name: str, channels: str) -> Pass:
    return Pass(name, blender_name, channels, (name,), first_sample_planes(name))


def mean_pass(name: str, blender_name: str, channels: str = "RGB") -> Pass:
    return Pass(name, blender_name, channels, (name,), mean_planes(name))


def divided_pass(kind: str, light: str, blender_name: str) -> Pass:
    light, color = f"{kind}_{light}", f"{kind}_color"
    return Pass(light, blender_name, "RGB", (light, color), divided(light, color))


def light_passes(kind: str, short: str) -> tuple[Pass, ...]:
    """What closures of a kind bring: by light that comes to them directly, by other light, and their colour."""
    return (divided_pass(kind, "direct", f"{short}Dir"), divided_pass(kind, "indirect", f"{short}Ind"),
            mean_pass(f"{kind}_color", f"{short}Col"))


def matte_pass(kind: str) -> Pass:
    return Pass(f"crypto_{kind}", KINDS[kind], "rgba", (), mattes(kind), kind)


PASSES: dict[str, Pass] = {
    entry.name: entry
    for entry in (
        Pass("combined", "Combined", "RGBA", (), combined),
        first_sample_pass("depth", "Depth", "Z"),
        mean_pass("normal", "Normal", "XYZ"),
        mean_pass("albedo", "Albedo"),
        first_sample_pass("position", "Position", "XYZ"),
        mean_pass("uv", "UV", "UVA"),
        Pass("vector", "Vector", "XYZW", ("vector",), vector),
        Pass("mist", "Mist", "Z", ("mist",), mist),
        first_sample_pass("object_index", "IndexOB", "X"),
        first_sample_pass("material_index", "IndexMA", "X"),
        mean_pass("denoising_normal", "Denoising Normal", "XYZ"),
        mean_pass("denoising_albedo", "Denoising Albedo"),
        mean_pass("denoising_depth", "Denoising Depth", "Z"),
        mean_pass("ambient_occlusion", "AO"),
        *light_passes("diffuse", "Diff"),
        *light_passes("glossy", "Gloss"),
        *light_passes("transmission", "Trans"),
        mean_pass("emission", "Emit"),
        mean_pass("environment", "Env"),
        *(matte_pass(kind) for kind in KINDS),
        Pass(CATCHER, "Shadow Catcher", "RGB", (CATCHER,), shadow_catcher),
        Pass("sample_count", "Sample Count", "X", (), sample_count),
        Pass("invalid", "Invalid", "X", (), invalid),
        Pass("error", "Error", "RGB", (), pixel_error),  # one standard deviation of the pixel's mean
    )
}
# What a multilayer file gets where nobody says which: what costs next to nothing.
USUAL = ("combined", "depth", "normal", "albedo", "position", "sample_count", "invalid", "error")


def channels_of(names: Iterable[str], levels: int) -> dict[str, str]:
    """Blender's names of passes -> channel ids, where so many `levels` of Cryptomatte are shown."""
    return {name: entry.channels for entry in map(PASSES.get, names) for name in entry.names(levels)}


def check_passes(names: Iterable[str]) -> tuple[str, ...]:
    """The names in the table's order, each once. Raises ValueError naming one that is unknown, and those that exist."""
    names = list(names)
    for name in names:
        if name not in PASSES:
            raise ValueError(f"no pass {name!r}; there are {', '.join(PASSES)}")
    return tuple(name for name in PASSES if name in names)


def planes_for(names: Iterable[str], clamps: bool = False, named: Iterable[str] = (), levels: int = 6) -> Planes:
    """Planes that a film needs for these passes and AOVs, and where light is clamped."""
    wanted = [PASSES[name] for name in names]
    return make_planes((group for entry in wanted for group in entry.groups), clamps, named,
                       (entry.matte for entry in wanted if entry.matte), levels)


def with_catchers(settings: Settings, scene: Scene) -> Settings:
    """The settings with what it takes to show shadows where the scene catches any and the film is transparent."""
    return replace(settings, shadow_catchers=scene.catches and settings.film_transparent)


def film_planes(settings: Settings) -> Planes:
    """Planes of a film of these settings."""
    names = (*settings.passes, *[CATCHER] * settings.shadow_catchers)
    return planes_for(names, settings.clamps, settings.named, settings.matte_levels)


def make_passes(film: Film, names: Iterable[str]) -> dict[str, np.ndarray]:
    """Blender's name -> float32 (h, w, c) for each pass asked for. Raises FilmError where the film lacks its planes.

    Beside the shadows on catchers Combined is the matte alone, as in Blender.
    """
    made, names = {}, check_passes(names)
    for name in names:
        entry = PASSES[name]
        if missing := [group for group in entry.groups if group not in film.planes.groups]:
            raise FilmError(f"pass {name}: the film was made without {', '.join(missing)}")
        if entry.matte and entry.matte not in film.planes.mattes:
            raise FilmError(f"pass {name}: the film was made without mattes of {entry.matte}s")
        names_of_it = entry.names(film.planes.levels)
        values = matte(film) if name == "combined" and CATCHER in names else entry.make(film)
        made |= dict(zip(names_of_it, np.split(values, len(names_of_it), axis=-1), strict=True))
    return made


def named_pass(name: str) -> str:
    """Blender's name of a pass that the scene names."""
    kind, _, own = name.partition(":")
    return f"Combined_{own}" if kind == "light" else own


def make_named(film: Film) -> dict[str, np.ndarray]:
    """AOVs and light groups of a film by Blender's names: float32 (h, w, 1), (h, w, 4) for colours, (h, w, 3) for
    light."""
    made = {}
    for name in film.planes.named:
        sums = [film.sum(film.planes.first[name] + k) for k in range(named_width(name))]
        made[named_pass(name)] = np.stack([mean_of(film, each) for each in sums], axis=-1)
    return made
