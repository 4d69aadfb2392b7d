# SPDX-License-Identifier: Apache-2.0
"""Scene files in real Blenders, on the CPU and on an OpenCL device: a picture, and the same bits."""

from pathlib import Path

import numpy as np
import OpenImageIO as oiio
from test_addon import rgba

ROOT = Path(__file__).resolve().parents[2]
OWN = sorted((ROOT / "blend_scenes").glob("*.blend"))
OTHERS = [ROOT.parent / "shared/scenes/ignis/evaluation/blender/box.blend"]
# Blender 3.4.1 sums the normals of subdivided meshes in parallel, so that two exports of these scenes may
# differ in a last bit; then the two pictures are of two scenes (the hashes in them say so).
UNSTEADY = {"monkey_box", "torus_box"}


def scene_hash(path) -> str:
    spec = oiio.ImageInput.open(str(path)).spec()
    return next(a.value for a in spec.extra_attribs if a.name.startswith("isophote.") and a.name.endswith(".scene"))


def test_scene_files_have_the_same_bits_on_both_devices(host):
    files = OWN + [file for file in OTHERS if file.exists()]
    assert len(OWN) == 6
    found, log = host.scenario("scene_files", *map(str, files), timeout=400)
    assert found["files"] == len(files)
    for file in files:
        paths = [host.folder / f"{file.stem}_{device}.exr" for device in ("openmp", "opencl")]
        cpu, gpu = (rgba(path) for path in paths)
        assert cpu[..., :3].mean() > 0.01, f"{file.stem} is black"
        assert np.isfinite(cpu).all()
        if scene_hash(paths[0]) == scene_hash(paths[1]):
            assert np.array_equal(cpu.view(np.uint32), gpu.view(np.uint32)), f"{file.stem}: the devices differ"
        else:
            assert file.stem in UNSTEADY and found["version"] < [4, 0], f"{file.stem} was exported differently"
            assert np.median(np.abs(cpu - gpu)) < 1e-5
    assert log.count("Isophote: device") == 2 * len(files)
    assert "Isophote: error" not in log
