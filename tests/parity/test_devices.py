"""The same bits everywhere: every number of threads, instruction set, split, restart, region, and OpenCL.

Films are compared sum by sum, bit for bit, and so are all passes. The scenes (tests/parity/scenes) use
every closure, lamp, kind of geometry and setting that kernels treat in their own way.
"""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from bench.parity import (
    EVERY_PASS,
    differences,
    differing_floats,
    expose,
    full_frame,
    main,
    opened,
    render_in_parts,
    render_with_break,
)
from bench.specialise import generalised
from isophote import _native
from isophote.device import list_kind
from isophote.film import COMBINED_PLANES, Film
from isophote.passes import film_planes, make_passes
from isophote.records import numbers
from isophote.scene import save_scene
from isophote.settings import Settings
from tests.conftest import missing
from tests.parity.scenes import SCENES, SETTINGS
from tests.scenes import ready

BOUNCES = dict(max_bounces=12, diffuse_bounces=6)
SAMPLES = 96  # one block and a half: the last block stays open
MATTES = ("crypto_object", "crypto_material", "crypto_asset")
POCL = "Portable Computing Language"


@cache
def scene_of(name):
    return SCENES[name]()


@cache
def prepared_of(name):
    return ready(scene_of(name))


def settings_of(name, **changes) -> Settings:
    return Settings(**dict(samples=SAMPLES, threads=1, passes=EVERY_PASS) | BOUNCES | SETTINGS[name] | changes)


def film_of(name, device="openmp", parts=1, step=64, **changes) -> Film:
    settings = settings_of(name, **changes)
    holder = opened(device, settings, prepared_of(name))
    try:
        return render_in_parts(holder, settings.region or full_frame(scene_of(name)), settings, parts, step)
    finally:
        holder.close()


@cache
def plain_film(name) -> Film:
    """What everything is compared with: one thread, in one go."""
    return film_of(name)


def assert_same(film, other):
    counts = differences(film, other)
    assert not any(counts.values()), counts


@pytest.fixture(params=SCENES)
def name(request):
    return request.param


def test_scenes_show_something(name):
    """A picture of nothing would have the same bits everywhere, too."""
    film = plain_film(name)
    passes = make_passes(film, EVERY_PASS)
    assert all(np.isfinite(image).all() for image in passes.values())
    shown = passes["Combined"][..., :3] + np.abs(passes["Shadow Catcher"] - 1)
    assert (shown.sum(-1) > 0).mean() > 0.7
    assert len(np.unique(shown[..., 0])) > 0.6 * film.shape[0] * film.shape[1]
    assert len(np.unique(passes["Depth"])) > 10 and passes["Error"].max() > 0
    if settings_of(name).film_transparent:
        assert passes["Combined"][..., 3].min() < 1


def test_scenes_use_every_operation_and_lamp():
    """Otherwise these tests would not cover a closure or lamp that is added later."""
    from isophote.materials import OPERATIONS

    scenes = [scene_of(name) for name in SCENES]
    assert {int(op) for s in scenes for op in s.instruction_op} == {number for number, _ in OPERATIONS.values()}
    lamps = {(int(kind), bool(size[0])) for s in scenes for kind, size in zip(s.light_kind, s.light_size, strict=True)}
    assert lamps == {(kind, sized) for kind in range(5) for sized in (False, True) if sized or kind < 3}
    features = np.bitwise_or.reduce([prepared_of(name).features for name in SCENES])
    assert features == sum(number for feature, number in numbers().items() if feature.startswith("FEATURE_"))


@pytest.mark.parametrize("threads", [2, 7])
def test_threads(name, threads):
    assert_same(plain_film(name), film_of(name, threads=threads))


STRICT = [(variant, supported) for variant, precision, _, supported in _native.variants if precision == "strict"]


@pytest.mark.parametrize("variant,supported", STRICT, ids=[variant for variant, _ in STRICT])
def test_instruction_sets(name, variant, supported, monkeypatch):
    if not supported:
        pytest.skip(f"this processor does not run {variant}")  # in CI too: it is no part that could be installed
    monkeypatch.setenv("ISOPHOTE_ISA", variant.partition("_")[2])
    assert_same(plain_film(name), film_of(name))


@pytest.mark.parametrize("step", [1, 7, 32])
def test_items_of_any_size(name, step):
    """A device may be given the samples of a block in any portions."""
    assert_same(plain_film(name), film_of(name, step=step))


def test_a_thousand_samples_in_any_split():
    """16 x 16 pixels, 1,024 samples in 1, 3 and 16 parts."""
    name, region = "spheres", (2, 0, 18, 16)
    films = [film_of(name, parts=parts, samples=1024, region=region, threads=2) for parts in (1, 3, 16)]
    assert films[0].samples == 1024
    for film in films[1:]:
        assert_same(films[0], film)


@pytest.mark.parametrize("parts", [3, 16])
def test_splits(name, parts):
    """Films of parts have no sample 0, so only the first knows depth and position."""
    samples = 3 * 64 + 5
    assert_same(film_of(name, samples=samples), film_of(name, samples=samples, parts=parts))


@pytest.mark.parametrize("cut", [1, 63, 64, 70])
def test_resuming_from_a_checkpoint(name, cut):
    settings = settings_of(name, threads=2)
    device = opened("openmp", settings, prepared_of(name))
    assert_same(plain_film(name), render_with_break(device, scene_of(name), settings, cut))
    device.close()


def test_regions_apart(name):
    """Regions rendered on their own have the bits of the whole frame: sums and all passes but the pooled error."""
    whole = plain_film(name)
    width, height = (int(n) for n in scene_of(name).resolution)
    x, y = 7, 5  # on no border of a tile
    for region in ((0, 0, x, y), (x, 0, width, y), (0, y, x, height), (x, y, width, height)):
        part = film_of(name, region=region)
        x0, y0, x1, y1 = region
        for plane in range(whole.planes.sums):
            mine = np.ascontiguousarray(whole.sum(plane)[y0:y1, x0:x1])
            assert differing_floats(mine, part.sum(plane)) == 0, (region, plane)
        for mine, others in zip(*(make_passes(f, MATTES).values() for f in (whole, part)), strict=True):
            assert differing_floats(mine[y0:y1, x0:x1], others) == 0, region


def test_other_passes_change_nothing(name):
    """Without AOVs less is computed, but the picture stays."""
    film, lean = plain_film(name), film_of(name, passes=("combined",))
    for plane in range(COMBINED_PLANES):
        assert differing_floats(film.sum(plane), lean.sum(plane)) == 0


def test_another_seed_is_another_picture(name):
    """The comparison can fail."""
    assert differences(plain_film(name), film_of(name, seed=12345))["Combined"] > 100


def pocl() -> str:
    for info in list_kind("opencl"):
        if POCL in info.driver and info.usable:
            return info.id
    return missing(f"no OpenCL platform {POCL!r}")


def test_opencl(name):
    """PoCL, whole and in three parts, through one device that compiles once."""
    settings = replace(settings_of(name, samples=SAMPLES + 64), threads=0)
    device = opened(pocl(), settings, prepared_of(name))
    assert device.strict is True
    region = full_frame(scene_of(name))
    whole = film_of(name, samples=SAMPLES + 64)
    assert_same(whole, render_in_parts(device, region, settings))
    assert_same(whole, render_in_parts(device, region, settings, 3, step=16))
    part = expose(device, Film((3, 2, 17, 13), film_planes(settings)), 64, settings)
    for plane in range(part.planes.sums):
        mine = expose_region(name, (3, 2, 17, 13)).sum(plane)
        assert differing_floats(mine, part.sum(plane)) == 0
    device.close()


def test_general_kernels(name):
    """What a scene does not use and kernels therefore leave out changes no bit."""
    for device in ["openmp", *([pocl()] if name == "spheres" else [])]:  # PoCL compiles for seconds
        settings = settings_of(name, device=device, samples=SAMPLES, passes=("combined",))
        holder = opened(device, settings, generalised(prepared_of(name)))
        film = render_in_parts(holder, settings.region or full_frame(scene_of(name)), settings)
        holder.close()
        for plane in range(COMBINED_PLANES):
            assert differing_floats(film.sum(plane), plain_film(name).sum(plane)) == 0


@cache
def expose_region(name, region):
    return film_of(name, region=region, samples=64)


def test_the_program_says_whether_bits_differ(tmp_path, capsys, monkeypatch):
    path = tmp_path / "box.npz"
    save_scene(scene_of("cornell_like"), path)
    arguments = [str(path), *"--devices openmp --size 6x5 --samples 130 --threads 1,2 --splits 1,3".split()]
    assert main(arguments) == 0
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5 and '"verdict": "the same bits"' in lines[-1]
    import bench.parity

    plain = bench.parity.render_in_parts
    monkeypatch.setattr(bench.parity, "render_in_parts", lambda device, region, settings, parts, **rest: plain(
        device, region, replace(settings, seed=parts), parts, **rest))
    assert main(arguments) == 1
    assert '"verdict": "bits differ"' in capsys.readouterr().out
