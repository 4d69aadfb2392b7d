"""Whole .blend files: the project's own scenes, and those of ../shared/scenes where it lies beside the checkout."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import bpy
import numpy as np
from common import ROOT, export, run_all

SHARED = ROOT.parent / "shared" / "scenes"
OWN = {  # instances, spheres, triangles
    "cornell_box": (12, 0, 240),
    "sphere_box": (10, 2, 24),
    "torus_box": (13, 0, 73752),
    "monkey_box": (7, 0, 125962),
    "instances": (3601, 0, 482),
}


def load(path):
    bpy.ops.wm.open_mainfile(filepath=str(path))
    scene = bpy.context.scene
    scene.render.resolution_percentage = 10
    return export()


def test_own_scenes():
    for name, (instances, spheres, triangles) in OWN.items():
        scene = load(ROOT / "blend_scenes" / f"{name}.blend")
        assert not scene.notes, (name, scene.notes)
        assert (len(scene.instance_mesh), len(scene.sphere_radius), len(scene.triangles)) == (
            instances, spheres, triangles), name


def test_own_instances_have_mirrored_ones():
    scene = load(ROOT / "blend_scenes" / "instances.blend")
    mirrored = np.linalg.det(scene.instance_to_world[:, :, :3]) < 0
    assert mirrored.sum() == 1200 and len(scene.names["meshes"]) == 6


def test_shared_scenes_export():
    if not SHARED.is_dir():
        print("skipped: no ../shared/scenes")
        return
    for path in sorted(SHARED.rglob("*.blend")):
        try:
            scene = load(path)
        except ValueError as error:
            assert "no camera" in str(error), path  # what that file deserves
            print(path.name, error)
        except RuntimeError as error:
            if "bpy.ops.wm.open_mainfile" not in str(error) and "not a blend file" not in str(error):
                raise
            print(path.name, "does not open in this version")
        else:
            print(path.name, len(scene.triangles), "triangles", len(scene.notes), "notes", flush=True)


run_all(sys.modules[__name__])
