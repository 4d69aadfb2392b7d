"""What the scripts that run inside Blender share: an empty scene, exporting it, reading programs back."""

import os
import sys
import traceback
from pathlib import Path

import bpy
import numpy as np

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from addon.run_export import render_to_scene  # noqa: E402
from isophote.materials import OPERATIONS  # noqa: E402

NAMES = {number: (name, params) for name, (number, params) in OPERATIONS.items()}


def run_all(module) -> None:
    """Run every function of a module whose name starts with test_, each in an empty scene; end the process."""
    failed = 0
    for name, function in list(vars(module).items()):
        if name.startswith("test_"):
            try:
                reset()
                function()
                print("passed", name, flush=True)
            except Exception:
                traceback.print_exc()
                print("FAILED", name, flush=True)
                failed += 1
    print("ALL PASSED" if not failed else f"{failed} FAILED", bpy.app.version_string, flush=True)
    os._exit(1 if failed else 0)


def reset():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 64, 48, 100
    scene.camera = add("camera", bpy.data.cameras.new("camera"), (0.0, -5.0, 0.0), (np.pi / 2, 0.0, 0.0))


def add(name, data, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1), collection=None):
    ob = bpy.data.objects.new(name, data)
    (collection or bpy.context.scene.collection).objects.link(ob)
    ob.location, ob.rotation_euler, ob.scale = location, rotation, scale
    return ob


def mesh(vertices, faces, smooth=False, materials=(), indices=None):
    made = bpy.data.meshes.new("mesh")
    made.from_pydata(vertices, [], faces)
    for material in materials:
        made.materials.append(material)
    if indices is not None:
        made.polygons.foreach_set("material_index", indices)
    made.polygons.foreach_set("use_smooth", [smooth] * len(made.polygons))
    made.update()
    return made


def square(**options):
    return mesh([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [(0, 1, 2, 3)], **options)


def cube(**options):
    vertices = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return mesh(vertices, faces, **options)


def material(name, build=None):
    """A material; `build(tree, output)` makes its nodes, without it there is one Diffuse of its name's hash."""
    made = bpy.data.materials.new(name)
    made.use_nodes = True
    made.node_tree.nodes.clear()
    output = made.node_tree.nodes.new("ShaderNodeOutputMaterial")
    if build is None:
        node(made.node_tree, "ShaderNodeBsdfDiffuse", output.inputs["Surface"])
    else:
        build(made.node_tree, output)
    return made


def node(tree, kind, into=None, **inputs):
    """A node with input values by identifier (spaces as underscores), its first output linked into a socket."""
    made = tree.nodes.new(kind)
    for name, value in inputs.items():
        socket = next(s for s in made.inputs if s.identifier.replace(" ", "_") == name)
        socket.default_value = (*value, 1.0) if isinstance(value, tuple) and len(socket.default_value) == 4 else value
    if into is not None:
        tree.links.new(made.outputs[0], into)
    return made


def export():
    """The current scene as Blender would hand it to a final render."""
    return render_to_scene(bpy.context.scene)[0]


def program(scene, name):
    """[(operation, weight, {parameter: value})] of the material called `name`."""
    index = scene.names["materials"].index(name)
    steps = range(scene.material_first[index], scene.material_first[index + 1])
    read = []
    for k in steps:
        operation, params = NAMES[int(scene.instruction_op[k])]
        constants = dict(zip(params, scene.instruction_params[k].tolist(), strict=False))  # they are padded
        read.append((operation, scene.instruction_weight[k], constants))
    return read


def near(a, b, tolerance=1e-5):
    np.testing.assert_allclose(np.asarray(a, float), np.asarray(b, float), rtol=0, atol=tolerance)


def notes_of(scene, name):
    return [note["what"] for note in scene.notes if note["name"] == name]
