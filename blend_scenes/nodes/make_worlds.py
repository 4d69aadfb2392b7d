"""Makes a scene of balls on a floor under a world, or lit by textures.

    python blend_scenes/nodes/make_worlds.py -- OUT.blend WORLD        (or blender -b --python ...)

WORLD: sky (an equirectangular picture), sunny (the same with a small sun), ball (a mirror ball's picture), hidden (from
some rays), light_path (another one for the camera), lamps (sunny, with lamps), screens (black, lit by textures).
"""

import math
import sys

import bpy
import numpy as np


def new_scene():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 96, 72, 100
    cycles = scene.cycles
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    scene.camera = add(scene, "camera", bpy.data.cameras.new("camera"), (0, -6, 2.5), (math.radians(72.0), 0, 0))
    floor = bpy.data.meshes.new("floor")
    floor.from_pydata([(-6, -6, 0), (6, -6, 0), (6, 6, 0), (-6, 6, 0)], [], [(0, 1, 2, 3)])
    floor.materials.append(shader("floor", "ShaderNodeBsdfDiffuse", Color=(0.7, 0.6, 0.5, 1.0)))
    add(scene, "floor", floor)
    for x, material in ((-1.5, shader("diffuse", "ShaderNodeBsdfDiffuse", Color=(0.3, 0.7, 0.4, 1.0))),
                        (1.5, shader("glossy", "ShaderNodeBsdfGlossy", Roughness=0.3))):
        mesh = ball()
        mesh.materials.append(material)
        add(scene, material.name, mesh, (x, 0.0, 1.0))
    scene.world = bpy.data.worlds.new("world")
    scene.world.use_nodes = True
    return scene


def add(scene, name, data, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1)):
    placed = bpy.data.objects.new(name, data)
    placed.location, placed.rotation_euler, placed.scale = location, rotation, scale
    scene.collection.objects.link(placed)
    return placed


def shader(name, kind, **inputs):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(kind)
    for key, value in inputs.items():
        node.inputs[key].default_value = value
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def ball(rings=12):
    angles = [(math.pi * (row + 0.5) / rings, math.pi * column / rings) for row in range(rings)
              for column in range(2 * rings)]
    points = [(math.sin(a) * math.cos(b), math.sin(a) * math.sin(b), math.cos(a)) for a, b in angles]
    ring = 2 * rings
    faces = [(row * ring + k, (row + 1) * ring + k, (row + 1) * ring + (k + 1) % ring, row * ring + (k + 1) % ring)
             for row in range(rings - 1) for k in range(ring)]
    mesh = bpy.data.meshes.new("ball")
    mesh.from_pydata(points, [], [*faces, tuple(range(ring))[::-1], tuple(range((rings - 1) * ring, rings * ring))])
    return mesh


def picture(width=512, sun=0.0):
    """A sky over brown ground; a sun of radiance `sun` and 2.3 degrees across."""
    height = width // 2
    theta = np.pi * (1.0 - (np.arange(height) + 0.5) / height)[:, None]
    phi = 2.0 * np.pi * (0.5 - (np.arange(width) + 0.5) / width)[None]
    x, y, z = np.broadcast_arrays(np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta))
    blue = np.array((0.3, 0.5, 1.0)) * (1.0 - 0.7 * z[..., None]) + 0.1
    colors = np.where(z[..., None] > 0.0, blue, (0.2, 0.15, 0.1))
    towards = np.array((math.cos(0.9) * math.cos(2.0), math.cos(0.9) * math.sin(2.0), math.sin(0.9)))
    lit = (np.stack((x, y, z), axis=-1) @ towards)[..., None] > math.cos(0.02)
    texels = np.ones((height, width, 4), np.float32)
    texels[:, :, :3] = colors + lit * sun * np.array((1.0, 0.9, 0.7))
    made = bpy.data.images.new("sky", width, height, alpha=True, float_buffer=True)
    made.pixels.foreach_set(texels.ravel())
    made.pack()
    return made


def environment(scene, image, projection="EQUIRECTANGULAR"):
    tree = scene.world.node_tree
    node = tree.nodes.new("ShaderNodeTexEnvironment")
    node.image, node.projection = image, projection
    tree.links.new(node.outputs["Color"], tree.nodes["Background"].inputs["Color"])


def light_path(scene):
    """The camera sees blue, all else is lit by the picture."""
    environment(scene, picture())
    tree = scene.world.node_tree
    mix, seen, path = (tree.nodes.new(kind) for kind in ("ShaderNodeMixShader", "ShaderNodeBackground",
                                                         "ShaderNodeLightPath"))
    seen.inputs["Color"].default_value = (0.1, 0.2, 0.6, 1.0)
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    tree.links.new(tree.nodes["Background"].outputs[0], mix.inputs[1])
    tree.links.new(seen.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], tree.nodes["World Output"].inputs["Surface"])


def lamps(scene):
    environment(scene, picture(sun=3000.0))
    point, sun = bpy.data.lights.new("point", "POINT"), bpy.data.lights.new("sun", "SUN")
    point.energy, point.shadow_soft_size = 300.0, 0.2
    sun.energy, sun.angle = 2.0, 0.05
    add(scene, "point", point, (2, -2, 3))
    add(scene, "sun", sun, (0, 0, 0), (0.5, 0.3, 0))


def screens(scene):
    """Two squares of one mesh, one of them mirrored, that shine with a picture."""
    scene.world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0.0
    material = shader("screen", "ShaderNodeEmission", Strength=15.0)
    tree = material.node_tree
    node = tree.nodes.new("ShaderNodeTexImage")
    node.image = picture(64)
    tree.links.new(node.outputs["Color"], tree.nodes["Emission"].inputs["Color"])
    mesh = bpy.data.meshes.new("screen")
    mesh.from_pydata([(-1, 0, -0.7), (1, 0, -0.7), (1, 0, 0.7), (-1, 0, 0.7)], [], [(0, 1, 2, 3)])
    layer = mesh.uv_layers.new(name="map")
    for corner, uv in enumerate(((0, 0), (1, 0), (1, 1), (0, 1))):
        layer.data[corner].uv = uv
    mesh.materials.append(material)
    add(scene, "screen", mesh, (0, 2.5, 2), (0.3, 0, 0))
    add(scene, "mirrored", mesh.copy(), (-3, 0, 2), (0.3, 0, 0.4), (-1, 1, 1))


def hidden(scene):
    environment(scene, picture())
    scene.world.cycles_visibility.camera = scene.world.cycles_visibility.glossy = False


WORLDS = {
    "sky": lambda scene: environment(scene, picture()),
    "sunny": lambda scene: environment(scene, picture(sun=3000.0)),
    "ball": lambda scene: environment(scene, picture(), "MIRROR_BALL"),
    "hidden": hidden,
    "light_path": light_path,
    "lamps": lamps,
    "screens": screens,
}


if __name__ == "__main__":
    out, world = sys.argv[sys.argv.index("--") + 1:]
    WORLDS[world](new_scene())
    bpy.ops.wm.save_as_mainfile(filepath=out)
