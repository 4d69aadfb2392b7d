"""Makes a scene of 20 Principled materials, each with pictures for colour, roughness and normals of its own.

    python blend_scenes/nodes/make_textured.py -- OUT.blend        (or blender -b --python ...)

Balls on a floor in a room, under an area lamp: what textures cost where light bounces.
"""

import sys

import bpy
import numpy as np

SIDE = 512  # texels
COLUMNS, ROWS = 5, 4


def waves(seed: int) -> np.ndarray:
    """A smooth periodic height in [0, 1], f4 [SIDE, SIDE]."""
    random = np.random.default_rng(seed)
    x, y = np.meshgrid(*2 * [np.linspace(0, 2 * np.pi, SIDE, endpoint=False)])
    height = sum(np.sin(a * x + b * y + phase) / (1 + abs(a) + abs(b))
                 for a, b, phase in zip(*random.integers(-9, 10, (2, 12)), random.uniform(0, 6.3, 12), strict=True))
    return ((height - height.min()) / np.ptp(height)).astype(np.float32)


def picture(name: str, texels: np.ndarray, space: str) -> bpy.types.Image:
    made = bpy.data.images.new(name, SIDE, SIDE)
    made.colorspace_settings.name = space
    made.pixels.foreach_set(np.concatenate([texels, np.ones((SIDE, SIDE, 1), np.float32)], axis=2).ravel())
    made.pack()
    return made


def textured(seed: int) -> bpy.types.Material:
    height = waves(seed)
    hue = np.random.default_rng(seed).uniform(0.1, 0.9, (2, 3)).astype(np.float32)
    color = hue[0] * height[..., None] + hue[1] * (1 - height[..., None])
    slopes = [np.roll(height, 1, axis) - np.roll(height, -1, axis) for axis in (1, 0)]
    normal = np.stack([*(4.0 * slope for slope in slopes), np.ones_like(height)], axis=2)
    normal = 0.5 + 0.5 * normal / np.linalg.norm(normal, axis=2, keepdims=True)
    made = bpy.data.materials.new(f"textured {seed}")
    made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"]
    shader.inputs["Metallic"].default_value = float(seed % 3 == 0)

    def texture(name, texels, space):
        node = nodes.new("ShaderNodeTexImage")
        node.image = picture(f"{name} {seed}", texels.astype(np.float32), space)
        return node.outputs["Color"]

    links.new(texture("color", color, "sRGB"), shader.inputs["Base Color"])
    rough = texture("roughness", np.repeat(0.2 + 0.6 * height[..., None], 3, axis=2), "Non-Color")
    links.new(rough, shader.inputs["Roughness"])
    bent = nodes.new("ShaderNodeNormalMap")
    links.new(texture("normal", normal, "Non-Color"), bent.inputs["Color"])
    links.new(bent.outputs["Normal"], shader.inputs["Normal"])
    return made


def main(path: str) -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    for number in range(COLUMNS * ROWS):
        place = (2.2 * (number % COLUMNS - 2), 2.2 * (number // COLUMNS), 1.0)
        bpy.ops.mesh.primitive_uv_sphere_add(segments=64, ring_count=32, location=place)
        bpy.ops.object.shade_smooth()
        bpy.context.object.data.materials.append(textured(number))
    bpy.ops.mesh.primitive_cube_add(size=14, location=(0, 2, 7))
    bpy.ops.object.light_add(type="AREA", location=(0, 2, 9))
    bpy.context.object.data.energy, bpy.context.object.data.size = 300, 4
    bpy.ops.object.camera_add(location=(0, -4.5, 5.5), rotation=(1.0, 0, 0))
    scene.camera = bpy.context.object
    scene.camera.data.lens = 30
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = 720
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = scene.cycles.glossy_bounces = 8
    bpy.ops.wm.save_as_mainfile(filepath=path)


if __name__ == "__main__":
    main(sys.argv[-1])
