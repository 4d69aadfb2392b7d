"""Closures at the ends of their ranges: furnaces, reciprocity, densities, indices near 1 and far from it, roughness
from 0 on, random numbers at both ends."""

import itertools
import zlib
from functools import cache

import numpy as np
import pytest
from scipy import stats

from tests.bsdf_cases import (
    Case,
    direction,
    integrate_pdf,
    random_directions,
    reflections,
    refractions,
    sampled_albedo,
)
from tests.conftest import missing
from tests.extremes.table import Row, step
from tests.extremes.variants import changed, film, rgb, spaces
from tests.kernel_lib import CppKernels, OpenclKernels, instruction
from tests.scenes import Builder, ball, box, mean_and_error, program

SPACES = ("applied", "instanced")
COSINES = step((0.02, 0.3, 1.0), (0.005, 0.02, 0.1, 0.3, 0.6, 0.9, 1.0))
ROUGHNESSES = step((0.0, 1e-4, 0.01, 0.1, 0.4, 1.0),
                   (0.0, 1e-4, 1e-3, 0.00376, 0.00377, 0.01, 0.03, 0.1, 0.2, 0.4, 0.7, 1.0))
IORS = (1.0, 1 + 1e-4, 1 - 1e-4, 1.45, 10.0)


@cache
def strict():
    return CppKernels()


@cache
def exact():
    return CppKernels(reference=True)


@cache
def opencl():
    try:
        return OpenclKernels()
    except LookupError as error:
        return missing(str(error))


def every_case(roughness, iors=IORS, multiscatter=0):
    """All closures; those that do not have the constant ignore it."""
    return [Case("diffuse"), Case("transparent"), *reflections(roughness, multiscatter),
            *refractions(roughness, multiscatter, iors)]


# ------------------------------------------------------------------ furnace


def test_no_closure_makes_light():
    """Single scattering, by sampling: at most 1, whatever roughness, index and angle."""
    with Row("white furnace", f"each closure; roughness 0 ... 1, index {', '.join(map(str, IORS))}, cosine 0.02 ... 1",
             "albedo above 1", 1e-4) as row:
        for roughness, mu in itertools.product(ROUGHNESSES, COSINES):
            for case in every_case(roughness):
                steps = 400 if case.closure.startswith("film") else 64  # their lobes differ more in colour
                row.see(max(0, sampled_albedo(strict(), case, mu, steps).max() - 1), f"{case} at {mu}")


def in_furnace(instructions, shape):
    b = Builder((12, 12))
    b.world = 1.0
    b.look((0, -3, 0), (0, 0, 0), 0.5)
    material = b.material(instructions)
    if shape == "sphere":
        b.sphere((0, 0, 0), 1, material)
    else:
        b.add(ball(rings=12) if shape == "ball" else box(half=0.6), instructions)
    return b.make()


LOSSLESS = {
    "diffuse": program(("diffuse", 1.0)),
    "transparent": program(("transparent", 1.0)),
    "mirror": program(("glossy", 1.0, dict(roughness=0.0, multiscatter=0))),
    "glass": program(("glass", 1.0, dict(roughness=0.0, ior=1.5, multiscatter=0))),
    "glass of index 10": program(("glass", 1.0, dict(roughness=0.0, ior=10.0, multiscatter=0))),
    "refraction of index 1": program(("refraction", 1.0, dict(roughness=0.0, ior=1.0))),
    "diffuse and mirror": program(("diffuse", 0.4), ("glossy", 0.6, dict(roughness=0.0, multiscatter=0))),
}


@pytest.mark.parametrize("space", SPACES)
def test_lossless_surfaces_vanish(space):
    """Rendered: bodies of closures that keep all light are not to be seen in a white world."""
    with Row("white furnace", f"{', '.join(LOSSLESS)}: rendered, {space}", "mean off 1, beyond 3 standard errors",
             1e-5) as row:
        for (name, instructions), shape in itertools.product(LOSSLESS.items(), ("sphere", "ball", "box")):
            if (space != "applied" and shape == "sphere") or (name == "glass of index 10" and shape == "ball"):
                continue  # facets trap light of index 10 beyond any limit of bounces
            made = film(spaces(in_furnace(instructions, shape))[space], step(64, 1024), max_bounces=254,
                        transmission_bounces=254, glossy_bounces=254, diffuse_bounces=254)
            mean, error = mean_and_error(made)
            row.see(np.maximum(0, np.abs(mean - 1) - 3 * error), f"{name}, {shape}")


def test_smooth_normals_make_no_light():
    """Bodies of few facets with normals of a ball: where the two normals disagree light is lost, never made."""
    with Row("shadow terminator", "smooth balls of 3 ... 24 rings, albedo 1, in a white world",
             "mean above 1, beyond 3 standard errors", 1e-5) as row:
        for rings in (3, 4, 8, 24):
            b = Builder((12, 12))
            b.world = 1.0
            b.look((0, -3, 0), (0, 0, 0), 0.5)
            b.add(ball(rings=rings), program(("diffuse", 1.0)), normals=ball(rings=rings)[0])
            for space, scene in spaces(b.make()).items():
                mean, error = mean_and_error(film(scene, step(64, 1024)))
                row.see(np.maximum(0, mean - 1 - 3 * error), f"{rings} rings, {space}")


def test_rough_surfaces_with_multiscatter_keep_their_light():
    """Within what the tables interpolate: white glossy 0.3 %, glass from outside 1 %."""
    for name, limit, constants in (("glossy", 0.003, {}), ("glass", 0.01, dict(ior=1.45))):
        with Row("white furnace", f"{name} with multiscatter, roughness 0 ... 1", "albedo off 1", limit) as row:
            for roughness, mu in itertools.product(ROUGHNESSES, COSINES):
                if name == "glossy" or mu >= 0.05:
                    case = Case(name, dict(roughness=roughness, multiscatter=1) | constants)
                    row.see(sampled_albedo(strict(), case, mu) - 1, f"roughness {roughness} at {mu}")


# ------------------------------------------------------------------ reciprocity and densities


def test_reciprocity():
    """f(a, b) / cos = f(b, a) / cos of reflection; with the square of the index between the sides of refraction."""
    rng = np.random.default_rng(11)
    n = step(2_000, 50_000)
    a, b = random_directions(rng, n), random_directions(rng, n)
    for kernels, name, limit in ((exact(), "float64", 1e-7), (strict(), "float32", 2e-3)):
        with Row("reciprocity", f"each closure, roughness 0.05 ... 1, {n} pairs, {name}",
                 "difference relative to the largest, 999 of 1000", limit) as row:
            for roughness in (0.05, 0.3, 1.0):
                for case in [*reflections(roughness, 0), Case("diffuse"), *refractions(roughness, 0)]:
                    forth, back = (kernels.eval(case.instruction, x, y, case.backfacing)[0].astype(float)
                                   for x, y in ((a, b), (b, a)))
                    row.see(off(forth * a[:, 2:], back * b[:, 2:]), f"{case}, reflected")
                below = b * [1, 1, -1]
                for ior in (1.1, 1.5, 3.0):
                    c = instruction("refraction", roughness=roughness, ior=ior)
                    forth = kernels.eval(c, a, below, 0)[0].astype(float)
                    back = kernels.eval(c, -below, -a, 1)[0].astype(float)
                    row.see(off(forth * a[:, 2:], back * b[:, 2:] * ior ** 2), f"refraction, index {ior}")


def off(x, y):
    scale = np.maximum(np.maximum(np.abs(x), np.abs(y)), 1e-30)
    relative = (np.abs(x - y) / scale)[(scale > 1e-12 * scale.max())]
    return np.quantile(relative, 0.999) if relative.size else 0.0


def test_densities_integrate_to_the_share_of_valid_samples():
    samples = step(50_000, 1_000_000)
    u = np.random.default_rng(4).random((samples, 3), np.float32)
    cases = [case for roughness in step((0.1, 1.0), (0.01, 0.1, 0.4, 1.0))
             for case in every_case(roughness, (1.1, 1.45, 10.0)) if case.closure != "transparent"]
    with Row("pdf integral", f"each closure, roughness 0.1 ... 1, index 1.1, 1.45, 10, {samples} samples",
             "integral off the share of valid samples, beyond 4 standard errors", 3e-3) as row:
        for case, mu in itertools.product(cases, (0.1, 0.7)):
            integral = sum(p.sum() for _, _, p in integrate_pdf(strict(), case, mu, 24))
            _, _, flags = strict().sample(case.instruction, np.tile(direction(mu), (samples, 1)), u, case.backfacing)
            if flags[:, 0].any():
                continue  # a delta has no density
            spread = np.sqrt(max(integral * (1 - integral), 1e-6) / samples)
            row.see(max(0, abs(flags[:, 2].mean() - integral) - 4 * spread), f"{case} at {mu}")


# ------------------------------------------------------------------ index of refraction


def behind_glass(ior, layers, roughness=0.0):
    """A bright box behind nested balls, or without them behind nothing."""
    b = Builder((12, 12))
    b.world = (0.2, 0.4, 0.8)
    b.look((0, -4, 1), (0, 0, 0.5), 0.5)
    b.add(box((0, 3, 0.5), 0.8), program(("emission", (3, 2, 1))))
    glass = program(("glass", 1.0, dict(roughness=roughness, ior=ior, multiscatter=0)))
    for k in range(layers):
        b.add(ball((0.05 * k, 0, 0.5), 1.0 - 0.1 * k, rings=8), glass)
    return b.make()


@pytest.mark.parametrize("space", SPACES)
def test_index_one_is_invisible(space):
    """Where a pixel holds an edge of what is behind, a sample may fall to its other side: the median is told."""
    settings = dict(max_bounces=254, transmission_bounces=254, glossy_bounces=254)
    free = rgb(film(behind_glass(1.0, 0), 64))
    with Row("index of refraction", f"1: up to 8 overlapping balls, roughness 0 ... 1, {space}",
             "median pixel, relative to no glass", 1e-5) as row:
        for layers, roughness in itertools.product((1, 8), (0.0, 0.3, 1.0)):
            seen = rgb(film(spaces(behind_glass(1.0, layers, roughness))[space], 64, **settings))
            row.see(np.median(np.abs(seen / free - 1)), f"{layers} balls, roughness {roughness}")


@pytest.mark.parametrize("space", SPACES)
def test_stacks_of_glass_are_white(space):
    """Smooth glass keeps all light, however bodies overlap. (More than 1.1 traps it beyond 254 bounces.)"""
    iors = (1 + 1e-4, 1 - 1e-4, 0.8, 1.1)
    settings = dict(max_bounces=254, transmission_bounces=254, glossy_bounces=254)
    with Row("index of refraction",
             f"{', '.join(f'{i:g}' for i in iors)}: 5 overlapping balls in a white world, {space}",
             "mean off 1, beyond 3 standard errors", 1e-4) as row:
        for ior in iors:
            scene = behind_glass(ior, 5)
            white = np.where(np.arange(len(scene.instruction_op))[:, None] == 0, 1.0, scene.instruction_weight)
            scene = changed(scene, world_radiance=np.ones(3), instruction_weight=white)  # all that shines
            mean, error = mean_and_error(film(spaces(scene)[space], step(128, 1024), **settings))
            row.see(np.maximum(0, np.abs(mean - 1) - 3 * error), f"index {ior}")


# ------------------------------------------------------------------ roughness


def test_roughness_is_continuous():
    """The albedo from 0 through the delta's threshold to 1; sampled, in float32."""
    ends = np.concatenate([[0.0], np.geomspace(1e-4, 0.1, step(30, 100)), np.linspace(0.12, 1, step(45, 90))])
    with Row("roughness", f"0, 1e-4 ... 1 in {len(ends)} steps, each closure", "step of the albedo", 0.05) as row:
        for mu in (0.1, 0.7):
            albedos = np.array([[sampled_albedo(strict(), case, mu, 48) for case in every_case(r, (1.45,))]
                                for r in ends])
            row.see(np.diff(albedos, axis=0), f"cosine {mu}")


def test_narrow_lobes_follow_their_density():
    """Pearson's test just above the delta's threshold, at grazing angles and near index 1."""
    samples = 50_000
    narrow = [c for r in (0.0069, 0.02) for c in (*reflections(r), *refractions(r))]
    cases = [*itertools.product(narrow, (0.98, 0.1)), *itertools.product(refractions(0.5, iors=(1.02, 10.0)), (0.02,))]
    with Row("roughness", f"chi-squared of narrow and grazing lobes, {len(cases)} cases", "1 - p of the worst",
             1 - 0.001 / len(cases)) as row:
        for case, mu in cases:
            row.see(chi_squared(case, mu, samples), f"{case} at {mu}")


def chi_squared(case, mu, samples):
    """1 - p of Pearson's test of a closure's samples against its density."""
    rng = np.random.default_rng(zlib.crc32(f"{case} {mu}".encode()))
    wi, _, flags = strict().sample(case.instruction, np.tile(direction(mu), (samples, 1)),
                                   rng.random((samples, 3), np.float32), case.backfacing)
    wi, valid = wi.astype(np.float64), flags[:, 2] == 1
    if (flags[:, 0] == 1).any():
        return 0.0
    observed, expected = [], []
    for transmits, grid, probabilities in integrate_pdf(exact(), case, mu, 24):
        expected.append(probabilities * samples)
        observed.append(grid.count(wi[valid & ((wi[:, 2] < 0) == transmits)]))
    observed, expected = np.concatenate(observed), np.concatenate(expected)
    big = expected >= 10
    observed, expected = (np.array([*v[big], v[~big].sum()]) for v in (observed, expected))
    kept = expected >= 10
    if kept.sum() < 2:
        return 0.0
    expected *= observed.sum() / expected.sum()
    return 1 - stats.chi2.sf(np.sum((observed[kept] - expected[kept]) ** 2 / expected[kept]), kept.sum() - 1)


# ------------------------------------------------------------------ random numbers


def test_random_numbers_at_both_ends():
    """0 and 1 - 2^-24 in all places: finite, unit length, the same on OpenCL."""
    ends = (0.0, 2.0 ** -24, 0.5, 1 - 2.0 ** -24)
    u = np.array(list(itertools.product(ends, ends, ends)), np.float32)
    with Row("u at 0 and 1 - 2^-24", "each closure, roughness 0 ... 1, cosine 1e-20 ... 1, OpenMP and OpenCL",
             "length off 1, or not finite", 1e-6) as row:
        for roughness, mu in itertools.product((0.0, 1e-4, 0.1, 1.0), (1e-20, 1e-4, 0.5, 1.0)):
            for case in every_case(roughness, (1 + 1e-4, 1.45, 10.0), 1):
                wo = np.tile(direction(mu), (len(u), 1)).astype(np.float32)
                made = strict().sample(case.instruction, wo, u, case.backfacing)
                other = opencl().sample(case.instruction, wo, u, case.backfacing)
                assert all(np.array_equal(a.view(np.uint32), b.view(np.uint32)) for a, b in
                           zip(made, other, strict=True)), f"{case}: OpenMP and OpenCL differ"
                wi, f, flags = made
                valid = flags[:, 2] == 1
                row.see(np.linalg.norm(wi[valid].astype(float), axis=1) - 1, f"{case} at {mu}")
                row.see(np.where(np.isfinite(f).all(1) & (f >= 0).all(1), 0, np.inf), f"{case} at {mu}, f")
                value, pdf = strict().eval(case.instruction, wo, wi, case.backfacing)
                row.see(np.where(np.isfinite(value).all(1) & np.isfinite(pdf), 0, np.inf), f"{case} at {mu}, eval")
