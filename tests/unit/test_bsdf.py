"""Closures: energy, reciprocity, tables, continuity, extremes, and float32 against float64."""

import functools
import importlib.util
import re

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from isophote import materials
from tests.bsdf_cases import (
    TOONS,
    Case,
    anisotropic,
    beckmann_glasses,
    diffuses,
    direction,
    fabrics,
    integrated_albedo,
    random_directions,
    reflections,
    refractions,
    sampled_albedo,
    unit,
)
from tests.kernel_lib import ROOT, CppKernels, instruction

SPEC = importlib.util.spec_from_file_location("make_albedo_tables", ROOT / "tools" / "make_albedo_tables.py")
tables_tool = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(tables_tool)

ROUGHNESSES = (0.0, 0.003, 0.01, 0.05, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)


@pytest.fixture(scope="module")
def kernels():
    return CppKernels()


@pytest.fixture(scope="module")
def reference():
    return CppKernels(reference=True)


# ------------------------------------------------------------------ lists


def test_operations_have_the_numbers_of_the_kernels():
    header = (ROOT / "kernels" / "bsdf" / "bsdf.h").read_text()
    numbers = {name.lower(): int(number) for name, number in re.findall(r"#define OP_(\w+) (\d+)", header)}
    assert numbers == {name: number for name, (number, _) in materials.OPERATIONS.items()}


def test_constants_lie_where_the_kernels_read_them():
    for name, (_, names) in materials.OPERATIONS.items():
        path = ROOT / "kernels" / "bsdf" / f"{name}.h"
        text = path.read_text() if path.exists() else ""
        for constant, place in re.findall(rf"#define {name.upper()}_(\w+) (\d+)", text):
            assert names[int(place)].startswith(constant.lower()), (name, constant)


def test_delta_threshold_is_that_of_the_kernels():
    header = (ROOT / "kernels" / "bsdf" / "microfacet.h").read_text()
    assert float(re.search(r"#define DELTA_ALPHA2 REAL\((.*?)\)", header)[1]) == materials.DELTA_ALPHA2


def test_is_delta_agrees_with_sampling(kernels):
    """u_choice 0 reflects, where a closure can: glass's refraction is never wider than its reflection."""
    for roughness in (0.0, 1e-4, 0.0037, 0.0038, 0.0067, 0.0068, 0.1):
        for front, back in zip(refractions(roughness)[:4] + reflections(roughness),
                               refractions(roughness)[4:] + reflections(roughness), strict=True):
            flags = [kernels.sample(case.instruction, direction(0.95)[None], np.array([[0, 0.5, 0.5]]),
                                    case.backfacing)[2] for case in (front, back)]
            c = front.instruction
            assert materials.is_delta(int(c["op"][0]), c["params"][0]) == all(f[0, 0] for f in flags), str(front)


def test_is_delta_agrees_with_sampling_of_two_roughnesses(kernels):
    for rough_x, rough_y in ((0.0, 0.0), (0.003, 0.004), (0.0099, 0.0099), (0.0101, 0.002), (0.0, 1.0), (0.5, 0.5)):
        for case in anisotropic(rough_x, rough_y):
            delta = kernels.sample(case.instruction, direction(0.95)[None], np.array([[0, 0.5, 0.5]]))[2][0, 0]
            c = case.instruction
            assert materials.is_delta(int(c["op"][0]), c["params"][0]) == delta, str(case)


# ----------------------------------------------------------------- energy


@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_white_furnace_of_single_scattering(kernels, roughness):
    cases = [*reflections(roughness, 0), *refractions(roughness, 0, iors=(1.0001, 1.45, 10.0)), *diffuses(), *TOONS,
             Case("sheen", dict(roughness=roughness)), *anisotropic(roughness, min(2 * roughness + 0.1, 1), 0)]
    for case in cases:
        for mu in (0.005, 0.05, 0.3, 0.7, 1.0):
            assert sampled_albedo(kernels, case, mu).max() <= 1 + 1e-4, (str(case), mu)


@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_white_furnace_of_beckmann_glass(kernels, roughness):
    """To what the fit of its masking errs."""
    for case in beckmann_glasses(roughness, iors=(1.0001, 1.45, 10.0)):
        for mu in (0.05, 0.3, 0.7, 1.0):
            assert sampled_albedo(kernels, case, mu).max() <= 1.004, (str(case), mu)


@pytest.mark.parametrize("roughness", ROUGHNESSES)
def test_white_furnace_with_multiscatter(kernels, roughness):
    """White glossy, and white glass seen from outside, keep all energy within what interpolation costs. From inside,
    glass keeps less, as Cycles' does (tools/make_albedo_tables.py), but never more."""
    glossy = Case("glossy", dict(roughness=roughness, multiscatter=1))
    for mu in (0.02, 0.05, 0.1, 0.3, 0.7, 1.0):
        assert sampled_albedo(kernels, glossy, mu) == pytest.approx(1, abs=0.003), mu
    for ior in (1.2, 1.45, 2.4):
        front, back = (Case("glass", dict(roughness=roughness, multiscatter=1, ior=ior), side) for side in (0, 1))
        for mu in (0.05, 0.1, 0.3, 0.7, 1.0):
            assert sampled_albedo(kernels, front, mu) == pytest.approx(1, abs=0.01), (ior, mu)
            assert sampled_albedo(kernels, back, mu).max() <= 1.01, (ior, mu)


def test_white_diffuse_keeps_all_light(reference):
    """Rough ones too: what further bounces between facets return is in closed form."""
    for case in diffuses():
        for mu in (0.001, 0.02, 0.3, 0.7, 1.0):
            assert integrated_albedo(reference, case, mu) == pytest.approx(1, abs=3e-4), (str(case), mu)


def test_albedo_of_colours_is_that_of_sampling(reference):
    cases = [Case("rough_diffuse", dict(roughness=0.7, albedo_r=0.9, albedo_g=0.5, albedo_b=0.1)),
             Case("sheen", dict(roughness=0.4))]
    for case in cases:
        for mu in (0.05, 0.5, 1.0):
            np.testing.assert_allclose(reference.albedo(case.instruction, direction(mu)[None])[0],
                                       sampled_albedo(reference, case, mu, 400), rtol=5e-3)


def test_equal_roughnesses_are_isotropic(reference):
    """aniso_NAME with alpha along y as along x is NAME, in value, density and direction."""
    rng = np.random.default_rng(9)
    wo, u = random_directions(rng, 5000), rng.random((5000, 3))
    for roughness in (0.0, 0.2, 1.0):
        plain = {case.closure: case for case in reflections(roughness)}
        for case in anisotropic(roughness, roughness)[:4]:
            same = plain[case.closure.removeprefix("aniso_")].instruction
            sampled, wanted = reference.sample(case.instruction, wo, u), reference.sample(same, wo, u)
            for mine, other in zip(sampled, wanted, strict=True):
                np.testing.assert_allclose(mine, other, rtol=1e-9, atol=1e-12)
            wi = wanted[0][wanted[2][:, 2] == 1]
            for mine, other in zip(reference.eval(case.instruction, wo[wanted[2][:, 2] == 1], wi),
                                   reference.eval(same, wo[wanted[2][:, 2] == 1], wi), strict=True):
                np.testing.assert_allclose(mine, other, rtol=1e-6)


def test_anisotropy_turns_with_the_frame(reference):
    """A quarter turn of both directions is the same as swapped roughnesses."""
    rng = np.random.default_rng(10)
    wo, wi = random_directions(rng, 5000), random_directions(rng, 5000)
    turned = [v[:, [1, 0, 2]] * (1, -1, 1) for v in (wo, wi)]
    for one, other in zip(anisotropic(0.5, 0.2), anisotropic(0.2, 0.5), strict=True):
        for mine, theirs in zip(reference.eval(one.instruction, wo, wi), reference.eval(other.instruction, *turned),
                                strict=True):
            np.testing.assert_allclose(mine, theirs, rtol=1e-9)


def film_sum(mu, ior, thickness, film_ior):
    """Reflectance under a film by complex amplitudes, all orders, for each of many wavelengths between 360 and 830 nm:
    (their wave numbers in 1/nm, the reflectances)."""
    number = np.linspace(1 / 830, 1 / 360, 4000)
    total = 0
    for pol in (0, 1):
        def amplitude(c, cos_t, eta, pol=pol):
            return (c - eta * cos_t) / (c + eta * cos_t) if pol == 0 else (eta * c - cos_t) / (eta * c + cos_t)
        inside = np.sqrt(1 - (1 - mu**2) / film_ior**2)
        below = np.sqrt(1 - (1 - mu**2) / ior**2)
        top, bottom = amplitude(mu, inside, film_ior), amplitude(inside, below, ior / film_ior)
        turn = np.exp(4j * np.pi * number * film_ior * thickness * inside)
        total = total + 0.5 * np.abs((top + bottom * turn) / (1 + top * bottom * turn)) ** 2
    return number, total


@pytest.mark.parametrize("ior, thickness, film_ior", [(1.5, 200, 1.33), (1.5, 500, 1.7), (2.5, 350, 1.4)])
def test_film_is_the_sum_of_all_waves(reference, ior, thickness, film_ior):
    """Against sums of complex amplitudes weighted with the fit's Gaussians: what truncating the sum costs."""
    film = instruction("film_specular", roughness_x=0.0, roughness_y=0.0, multiscatter=0, ior=ior, thickness=thickness,
                       film_ior=film_ior)
    peaks = ((1.7953e-3, 9.3046e-9), (2.2084e-3, 6.6121e-9))  # of Y and Z: wave number in 1/nm, variance
    to_yz = np.linalg.inv([[3.0799545, -1.5371385, -0.54281594], [-0.92125826, 1.8760108, 0.04524742],
                           [0.05288738, -0.2040259, 1.15113851]])[1:]
    for mu in (0.2, 0.6, 1.0):
        rgb = reference.albedo(film, direction(mu)[None])[0]
        number, waves = film_sum(mu, ior, thickness, film_ior)
        for seen, (peak, variance) in zip(to_yz @ rgb, peaks, strict=True):
            weight = np.exp(-(number - peak) ** 2 / (4 * variance))
            assert seen == pytest.approx(np.average(waves, weights=weight), abs=5e-3)


def test_film_without_an_interface_is_none(reference):
    """A film of the index in front of it or behind it reflects as if it were not there, and a thin one is not."""
    for thickness, film_ior in ((300, 1.0), (300, 1.5), (0.09, 1.8)):
        params = dict(multiscatter=0, ior=1.5, tint_r=0.5)
        film = instruction("film_specular", roughness_x=0.0, roughness_y=0.0, thickness=thickness, film_ior=film_ior,
                           **params)
        wo = np.array([direction(mu) for mu in (0.1, 0.5, 1.0)])
        plain = [reference.sample(c, wo, np.full((3, 3), 0.5))[1] for c in (film, instruction("specular", roughness=0.0,
                                                                                           **params))]
        tinted = slice(0, 3) if thickness < 1 else slice(1, 3)  # films have their own way of tinting
        np.testing.assert_allclose(plain[0][:, tinted], plain[1][:, tinted], rtol=2e-6)


def test_ior_one_is_invisible(kernels):
    rng = np.random.default_rng(5)
    wo = random_directions(rng, 10_000)
    for roughness in (0.0, 0.3, 1.0):
        for name in ("glass", "refraction"):
            params = dict(roughness=roughness, ior=1.0) | (dict(multiscatter=1) if name == "glass" else {})
            wi, f, flags = kernels.sample(instruction(name, **params), wo, rng.random((10_000, 3)))
            valid = flags[:, 2] == 1
            np.testing.assert_allclose(wi[valid], -wo[valid].astype(np.float32), atol=1e-6)
            assert np.all(flags[valid, 0] == 1)
            if roughness == 0:
                assert valid.all() and np.allclose(f, 1, atol=1e-6)


def test_what_scatters_has_a_share(kernels):
    """A closure is chosen by its albedo: nowhere may that be 0 where it scatters, as refraction beyond the critical
    angle of a smooth interface does."""
    for roughness in (0.05, 0.3, 1.0):
        cases = [*reflections(roughness), *refractions(roughness), *beckmann_glasses(roughness), *diffuses(), *TOONS,
                 *fabrics(roughness), *anisotropic(roughness, 1.0)]
        for case in cases:
            for mu in (0.02, 0.3, 0.6, 1.0):
                if sampled_albedo(kernels, case, mu, 40).any():
                    assert kernels.albedo(case.instruction, direction(mu)[None], case.backfacing).sum() > 0, str(case)


# ------------------------------------------------------------ reciprocity


@pytest.mark.parametrize("roughness", (0.05, 0.3, 1.0))
def test_reflection_is_reciprocal(reference, roughness):
    """Of single scattering; compensation depends on wo only, and is not."""
    rng = np.random.default_rng(11)
    a, b = random_directions(rng, 20_000), random_directions(rng, 20_000)
    for case in [*reflections(roughness, 0), *refractions(roughness, 0), Case("rough_diffuse", dict(
            roughness=roughness, albedo_r=0.9, albedo_g=0.5, albedo_b=0.2)), Case("velvet", dict(sigma=roughness)),
            *anisotropic(roughness, 0.5 * roughness, 0)]:
        forth, _ = reference.eval(case.instruction, a, b, case.backfacing)
        back, _ = reference.eval(case.instruction, b, a, case.backfacing)
        np.testing.assert_allclose(forth * a[:, 2:], back * b[:, 2:], rtol=1e-8, atol=1e-300)


@pytest.mark.parametrize("roughness", (0.05, 0.3, 1.0))
def test_refraction_obeys_the_generalised_reciprocity(reference, roughness):
    """Radiance over the square of the index is what refraction conserves (Veach 1997, section 5.2)."""
    rng = np.random.default_rng(12)
    a, b = random_directions(rng, 20_000), random_directions(rng, 20_000) * [1, 1, -1]
    for ior in (1.1, 1.5, 3.0):
        for name, others in (("refraction", {}), ("glass", dict(multiscatter=0)), ("beckmann_glass", dict(reflects=1))):
            c = instruction(name, roughness=roughness, ior=ior, **others)
            forth, _ = reference.eval(c, a, b, 0)
            back, _ = reference.eval(c, -b, -a, 1)
            np.testing.assert_allclose(forth * a[:, 2:], back * np.abs(b[:, 2:]) * ior**2, rtol=1e-6, atol=1e-300)


# ----------------------------------------------------------------- tables


@pytest.mark.parametrize("roughness", (0.25, 0.5, 0.8, 1.0))
@pytest.mark.parametrize("mu", (0.06, 0.3, 0.9))
def test_tables_agree_with_integrals_over_directions(reference, roughness, mu):
    """E of the tool, and E as read from the tables (white's gain is 1/E), against the sphere's integral of f."""
    for name, params, back in (("glossy", {}, 0), ("glass", dict(ior=1.45), 0), ("glass", dict(ior=1.45), 1),
                               ("glass", dict(ior=2.0), 0), ("glass", dict(ior=2.0), 1)):
        single, multi = (Case(name, params | dict(roughness=roughness, multiscatter=m), back) for m in (0, 1))
        albedo = integrated_albedo(reference, single, mu)
        at = np.array([mu])
        if name == "glossy":
            tool, counted = tables_tool.ggx_albedo(roughness, at)[0], 0.0
        else:
            tool, kept = (tables_tool.glass_albedo(roughness, at, single.ior, flag)[0] for flag in (False, True))
            counted = kept - tool
        assert tool == pytest.approx(albedo, abs=2e-3), str(single)
        wo = direction(mu)[None]
        values = [reference.eval(case.instruction, wo, wo * [-1, -1, 1], back)[0][0, 0] for case in (single, multi)]
        assert values[0] / values[1] == pytest.approx(tool + counted, abs=0.008), str(single)


def test_layer_leaves_what_the_coat_does_not_reflect(reference):
    """At a node of the table (mu = 1, ior of z = 6/15) against an average over microfacets in closed form
    for a smooth coat, and against sampling for a rough one."""
    z = 6 / 15
    ior = (1 + z * z) / (1 - z * z)
    f0 = ((ior - 1) / (ior + 1)) ** 2
    smooth = instruction("layer_specular", roughness=0.0, multiscatter=0, ior=ior)
    np.testing.assert_allclose(reference.albedo(smooth, direction(1.0)[None]), 1 - f0, rtol=1e-6)
    case = Case("specular", dict(roughness=0.4, multiscatter=1, ior=ior))
    rough = instruction("layer_specular", **case.params)
    kept = reference.albedo(rough, direction(0.6)[None])[0]
    np.testing.assert_allclose(kept, 1 - sampled_albedo(reference, case, 0.6), atol=2e-3)


def test_layers_weigh_and_begin_anew(reference):
    """Half a layer takes half; a tint is that of the way along the normal, longer by the refracted cosine."""
    wo = direction(0.5)[None]
    sheen = instruction("layer_sheen", roughness=0.5)
    taken = reference.albedo(instruction("sheen", roughness=0.5), wo)[0, 0]
    for weight in (0.5, 1.0):
        sheen["weight"] = weight, 0.1, 0
        np.testing.assert_allclose(reference.albedo(sheen, wo)[0], 1 - weight * taken, rtol=1e-6)
    tint = np.array([0.5, 0.9, 0.0])
    coat = instruction("layer_absorption", ior=1.5, **{f"tint_{c}": t for c, t in zip("rgb", tint, strict=True)})
    np.testing.assert_allclose(reference.albedo(coat, direction(1.0)[None])[0], tint, atol=1e-6)
    length = 1 / np.sqrt(1 - 0.75 / 1.5**2)
    coat["weight"] = 0.25
    np.testing.assert_allclose(reference.albedo(coat, wo)[0], 0.75 + 0.25 * tint ** length, atol=1e-6)
    np.testing.assert_array_equal(reference.albedo(instruction("layer_reset"), wo), 1)


def test_multiscatter_saturates_colours(reference):
    """A tint t < 1 is applied again at every further bounce: the albedo's ratio to white falls below t."""
    wo = direction(0.5)[None]
    for roughness in (0.5, 1.0):
        tinted = reference.albedo(instruction("glossy", roughness=roughness, multiscatter=1, tint_r=0.5), wo)[0]
        assert tinted[0] < 0.5 and tinted[1] == pytest.approx(1)


# ------------------------------------------------------- continuity, extremes


def every_lobe(roughness: float) -> list[Case]:
    return [*reflections(roughness), *refractions(roughness)]


def test_continuous_towards_the_delta(kernels):
    """Across the threshold neither the albedo nor the direction jumps."""
    below, above = 0.0037, 0.0038
    assert below**4 < materials.DELTA_ALPHA2 < above**4
    wo, u = direction(0.5)[None], np.array([[0.5, 0.3, 0.4]])
    for pair in zip(every_lobe(below), every_lobe(above), strict=True):
        for mu in (0.1, 0.5, 1.0):
            np.testing.assert_allclose(*(sampled_albedo(kernels, case, mu) for case in pair), rtol=2e-3)
        np.testing.assert_allclose(*(kernels.sample(c.instruction, wo, u, c.backfacing)[0] for c in pair), atol=1e-4)


def test_albedo_changes_slowly_with_roughness(kernels):
    steps = np.linspace(0, 0.2, 41)
    albedos = np.array([[sampled_albedo(kernels, case, 0.4, 48) for case in every_lobe(r)] for r in steps])
    assert np.abs(np.diff(albedos, axis=0)).max() < 0.01


roughness_values = st.one_of(st.sampled_from([0.0, 1e-4, 1e-3, 0.00376, 0.00377, 0.01, 1.0]), st.floats(0, 1))
ior_values = st.one_of(st.sampled_from([1.0, 1 - 1e-4, 1 + 1e-4, 1 + 1e-6, 1.5, 10.0, 0.1, 100.0, 1e-5]),
                       st.floats(0.5, 3))
cosines = st.one_of(st.sampled_from([1e-38, 1e-20, 1e-7, 1e-4, 0.5, 1.0]), st.floats(1e-6, 1))
random_numbers = st.one_of(st.sampled_from([0.0, 2.0**-24, 0.5, 1 - 2.0**-24]), st.floats(0, 1 - 2.0**-24))


@settings(max_examples=400, deadline=None)
@given(roughness=roughness_values, ior=ior_values, mu=cosines, mu_i=cosines, azimuth=st.floats(0, 6.3),
       u=st.tuples(random_numbers, random_numbers, random_numbers), back=st.integers(0, 1),
       multiscatter=st.integers(0, 1))
@example(roughness=0.0, ior=1e-5, mu=1.0, mu_i=1e-38, azimuth=0.0, u=(0.0, 0.0, 0.0), back=0, multiscatter=0)
def test_extremes_stay_finite(roughness, ior, mu, mu_i, azimuth, u, back, multiscatter):
    kernels = extreme_kernels()
    cases = [*reflections(roughness, multiscatter), *refractions(roughness, multiscatter, iors=(ior,)),
             Case("specular", dict(roughness=roughness, multiscatter=multiscatter, ior=ior)),
             Case("rough_diffuse", dict(roughness=roughness, albedo_r=1, albedo_g=0.5, albedo_b=0)),
             Case("transparent"), *diffuses(), *fabrics(roughness),
             *anisotropic(roughness, mu), *anisotropic(mu_i, roughness), *beckmann_glasses(roughness, iors=(ior,)),
             *(Case(name, dict(size=roughness, smooth=mu)) for name in ("diffuse_toon", "glossy_toon"))]
    wo = direction(mu, azimuth)[None]
    for case in cases:
        c = case.instruction
        wi, f, flags = kernels.sample(c, wo, np.array([u]), back)
        assert np.isfinite(wi).all() and np.isfinite(f).all() and (f >= 0).all(), str(case)
        if flags[0, 2]:
            assert np.linalg.norm(wi) == pytest.approx(1, abs=1e-6), str(case)
        albedo = kernels.albedo(c, wo, back)
        assert np.isfinite(albedo).all() and (albedo >= 0).all(), str(case)
        for light in (wi, direction(mu_i, 0.3)[None], -direction(mu_i, 3.4)[None], -wo, wo * [-1, -1, 1]):
            value, pdf = kernels.eval(c, wo, light, back)
            for numbers in (value, pdf):
                assert np.isfinite(numbers).all() and (numbers >= 0).all(), str(case)
            assert (value[pdf == 0] == 0).all(), str(case)


@functools.cache
def extreme_kernels():
    """Hypothesis calls its test many times; fixtures of modules are not for it."""
    return CppKernels()


# ------------------------------------------------------- float32 and float64


@pytest.mark.parametrize("roughness, tolerance", [(0.02, 2e-2), (0.1, 1e-3), (0.4, 2e-4), (1.0, 2e-4)])
def test_float_agrees_with_double(kernels, reference, roughness, tolerance):
    """f/pdf of sampled directions: relative error of float32, 999 of 1000 within the tolerance."""
    rng = np.random.default_rng(21)
    wo = random_directions(rng, 20_000).astype(np.float32)
    wo = unit(wo.astype(np.float64)).astype(np.float32)
    u = rng.random((20_000, 3), np.float32)
    for case in [*reflections(roughness), *refractions(roughness), *diffuses(), *fabrics(max(roughness, 0.1)),
                 *beckmann_glasses(roughness), *anisotropic(roughness, min(2 * roughness, 1))]:
        wi, _, flags = kernels.sample(case.instruction, wo, u, case.backfacing)
        valid = flags[:, 2] == 1
        (f32, p32), (f64, p64) = (k.eval(case.instruction, wo[valid], wi[valid], case.backfacing)
                                  for k in (kernels, reference))
        error = np.abs(p32 - p64) / np.maximum(p64, 1e-30)
        assert np.quantile(error, 0.999) < tolerance, (str(case), "pdf")
        error = np.abs(f32 - f64).max(axis=1) / np.maximum(f64.max(axis=1), 1e-30)
        assert np.quantile(error, 0.999) < tolerance, (str(case), "f")
