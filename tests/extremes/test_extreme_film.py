"""The film and what may reach it: fireflies, infinities, millions of samples, large numbers, denormal ones."""

import os
import subprocess
import sys

import numpy as np
import pytest

from bench.parity import differing_floats
from isophote.device import SceneTooLarge
from isophote.film import Film, merge
from isophote.memory import check_device_memory, check_host_memory
from isophote.settings import Settings
from isophote.totals import Total
from tests.extremes.table import Row, step
from tests.extremes.variants import changed, differing, film, opencl_film, openmp_film, rgb, settings_for
from tests.kernel_lib import BUILD, ROOT, find_compiler
from tests.scenes import POINT, Builder, ball, diffuse, pixels, place, program, quad, ready

# ------------------------------------------------------------------ fireflies


def test_caustics_are_finite():
    """A glass ball before a tiny lamp: rare paths as bright as can be. Nothing clamps unless it is asked to."""
    assert Settings().clamp_direct == Settings().clamp_indirect == 0
    with Row("fireflies", "glass and mirror balls, lamps of 1e-2 ... 1e-6 m", "pixels not finite or negative") as row:
        for power in (-2, -4, -6):
            b = Builder((16, 16))
            b.look((0, -6, 3), (0, 0, 0.5), 0.4)
            b.add(quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), diffuse(0.8))
            glass = b.material(program(("glass", 1.0, dict(roughness=0.0, ior=1.5, multiscatter=0))))
            b.sphere((0.5, 0, 1), 0.7, glass)
            b.add(ball((-1, 0, 0.6), 0.5), program(("glossy", 1.0, dict(roughness=0.01, multiscatter=0))))
            b.lamp(POINT, 1000.0, place((1, 1, 3)), (10.0 ** power, 0))
            seen = pixels(film(b.make(), step(256, 4096)))
            row.see(np.count_nonzero(~np.isfinite(seen) | (seen < 0)), f"1e{power} m")


# ------------------------------------------------------------------ accumulation


def constant(radiance):
    b = Builder((2, 2))
    b.world = radiance
    return b.make()


@pytest.mark.parametrize("radiance", step([0.1, 12345.6789], [0.1, 1 / 3, 12345.6789, 1e-30]))
def test_2_to_the_26_samples_of_a_constant(radiance):
    """2^16 samples are rendered, and as many again from far on; they stand for all others in the merge."""
    part = film(constant(radiance), 1 << step(14, 16))
    parts = []
    for number in range((1 << 26) // part.samples):
        copy = Film(part.region, part.planes, number * part.samples)
        copy.end = copy.first + part.samples
        copy.totals = [Total(total.hi, total.lo) for total in part.totals]
        parts.append(copy)
    with Row("accumulation", f"2^26 samples of {radiance:.6g}, {part.samples} of them rendered", "relative error",
             1e-6) as row:
        merged = merge(parts)
        assert merged.samples == 1 << 26
        row.see(rgb(merged) / np.float32(radiance) - 1)


# ------------------------------------------------------------------ counts


def test_the_last_of_2_to_the_32_samples():
    """Sample numbers up to 2^32 - 1, as others: finite, different, the same bits on OpenCL."""
    b = Builder((4, 4))
    b.world = 1.0
    b.look((0, 0, 3), (0, 0, 0), 1.0, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (0.5, 0, 0), (0, 0.5, 0)), diffuse(0.5))
    prepared, settings, region = ready(b.make()), settings_for(128), (0, 0, 4, 4)
    with Row("counts", "samples 2^31 - 64 ... 2^32 - 1", "floats that differ on OpenCL", 0) as row:
        near = rgb(film(b.make(), 128)).mean()
        for first in ((1 << 31) - 64, 1 << 31, (1 << 32) - 128):
            mine, other = (draw(prepared, region, 128, settings, first) for draw in (openmp_film, opencl_film))
            row.see(differing(mine, other), f"from {first}")
            assert rgb(mine).mean() == pytest.approx(near, rel=0.02)


def test_the_far_corner_of_a_large_picture():
    """A region of a frame of 2^30 pixels and more; the frame's size is no part of what its pixels show."""
    b = Builder((4, 4))
    b.world = (0.2, 0.5, 0.8)
    b.look((0, 0, 3), (0, 0, 0), 1.0, up=(0, 1, 0))
    b.add(quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), diffuse(0.5))
    scene = b.make()
    with Row("counts", "the last pixels of pictures of 2^30 ... 2^34 pixels", "mean off albedo times world",
             1e-6) as row:
        for side in (1 << 15, 1 << 16, 1 << 17):
            large = ready(changed(scene, resolution=(side, side)))
            region = (side - 4, side - 4, side, side)
            settings = settings_for(64, region=region)
            mine, other = (draw(large, region, 64, settings) for draw in (openmp_film, opencl_film))
            assert differing(mine, other) == 0
            row.see(rgb(mine).mean((0, 1)) / (0.1, 0.25, 0.4) - 1, f"{side} x {side}")


def test_what_does_not_fit_is_said_before():
    """On paper: 100 million triangles where they have no room, pictures whose film has none."""
    with Row("counts", "100 M triangles, 10 M instances, 2^32 pixels on machines without room for them",
             "errors that do not name bytes") as row:
        for triangles, pixels_ in ((100_000_000, 1 << 20), (0, 1 << 32), (1 << 33, 1 << 34)):
            with pytest.MonkeyPatch.context() as limit:
                limit.setenv("ISOPHOTE_HOST_MEMORY", "16G")
                with pytest.raises(SceneTooLarge, match=r"\d+ bytes") as said:
                    check_host_memory(triangles, 8 * pixels_)
            row.see(0 if str(16 << 30) in str(said.value) else 1, triangles)
        with pytest.raises(SceneTooLarge, match=r"\d+ bytes"):
            check_device_memory("a device", {"instances": 112 * 10_000_000, "film": 1 << 20}, 1 << 30, 1 << 30)


def test_many_instances():
    """One ball, as many times as there is patience for; a row of them is seen where it should be."""
    count = step(100_000, 1_000_000)
    b = Builder((16, 16))
    b.world = 1.0
    mesh, black = b.mesh(ball(rings=3)), b.material(diffuse(0.0))
    b.look((0, 0, 5), (0, 0, 0), 0.1, up=(0, 1, 0), clip=(0.1, 1e6))
    b.instances = [(mesh, place((0, 0, -3.0 * k)), (black,), 31, ()) for k in range(count)]
    with Row("counts", f"{count} instances behind each other", "pixels that see none of them") as row:
        row.see(np.count_nonzero(rgb(film(b.make(), 4, filter_width=0.0))[..., 1]))


# ------------------------------------------------------------------ denormal numbers

CONTROL = """
#include <immintrin.h>
extern "C" void set_control(unsigned bits) { _mm_setcsr(_mm_getcsr() | bits); }
"""
SCRIPT = """
import ctypes, sys
import numpy as np
from tests.extremes.test_extreme_film import dim_scenes
from tests.extremes.variants import film
if sys.argv[1]:
    ctypes.CDLL(sys.argv[1]).set_control(0x8040)  # flush to zero, and take denormal numbers as zero
sums = [made.sum(plane) for scene in dim_scenes() for made in [film(scene, 64)] for plane in range(8)]
np.save(sys.argv[2], np.stack(sums))
"""


def dim_scenes():
    """Albedos and lengths that are denormal numbers, or lead to them; the light that arrives is none."""
    for world in (1.0, 1e-33):
        b = Builder((4, 4))
        b.world = (world, 1e-3 * world, 1e10)
        b.look((0, 0, 3), (0, 0, 0), 1.0, up=(0, 1, 0))
        b.add(quad((0, 0, 0), (0.5, 0, 0), (0, 0.5, 0)), diffuse((0.7, 1e-30, 1e-40)))
        b.sphere((1e-39, 0, 0.5), 0.3, b.material(program(("glossy", 0.8, dict(roughness=0.2, multiscatter=0)))))
        yield b.make()


def test_flush_to_zero_in_the_host_changes_no_bit(tmp_path):
    """In processes of their own: OpenCL's threads take over the mode of the one that made them."""
    library = BUILD / "control.so"
    BUILD.mkdir(parents=True, exist_ok=True)
    subprocess.run([find_compiler(), "-shared", "-fPIC", "-x", "c++", "-", "-o", str(library)], input=CONTROL,
                   text=True, check=True)
    found = []
    for switch in ("", str(library)):
        out = tmp_path / f"sums{len(found)}.npy"
        subprocess.run([sys.executable, "-c", SCRIPT, switch, str(out)], cwd=ROOT, check=True, env=os.environ)
        found.append(np.load(out))
    with Row("denormals", "host thread with and without flush-to-zero, throughput 1 ... 1e-40",
             "floats that differ") as row:
        row.see(differing_floats(*found))
