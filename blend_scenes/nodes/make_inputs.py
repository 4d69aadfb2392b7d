"""Scenes of the input nodes: each output of each node as a patch of one picture.

    python blend_scenes/nodes/make_inputs.py -- FOLDER

Writes inputs.blend and instances.blend (values that patches emit, noise-free), paths.blend (Light Path, over floors
that scatter light in different ways) and normals.blend (normal maps, bump and displacement under a sun). Needs bpy.
"""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

COLUMNS = 6


def empty_scene() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs[0].default_value = 0.0, 0.0, 0.0, 1.0
    scene.view_settings.view_transform = "Standard"


def add_camera(place, rotation=(0.0, 0.0, 0.0), width: float | None = None) -> None:
    """Orthographic, `width` metres wide, or with Blender's own lens."""
    data = bpy.data.cameras.new("Camera")
    if width:
        data.type, data.ortho_scale = "ORTHO", width
    camera = bpy.data.objects.new("Camera", data)
    camera.location, camera.rotation_euler = place, rotation
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera


def new_material(name: str):
    """(material, its tree, the output node)."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    return material, tree, tree.nodes.new("ShaderNodeOutputMaterial")


def emitting(name: str, build, scale: float = 0.5, shift: float = 0.5):
    """A material that emits what build(tree) returns, an output socket, times a scale and shifted."""
    material, tree, output = new_material(name)
    light = tree.nodes.new("ShaderNodeEmission")
    mapped = tree.nodes.new("ShaderNodeCombineXYZ")
    parts = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(build(tree), parts.inputs[0])
    for k in range(3):
        scaled = tree.nodes.new("ShaderNodeMath")
        scaled.operation = "MULTIPLY_ADD"
        scaled.inputs[1].default_value, scaled.inputs[2].default_value = scale, shift
        tree.links.new(parts.outputs[k], scaled.inputs[0])
        tree.links.new(scaled.outputs[0], mapped.inputs[k])
    tree.links.new(mapped.outputs[0], light.inputs["Color"])
    tree.links.new(light.outputs[0], output.inputs["Surface"])
    return material


def node_output(kind: str, output: str, inputs=None, **properties):
    """A function of a tree that adds a node and returns one of its outputs."""
    def build(tree):
        node = tree.nodes.new(kind)
        for name, value in properties.items():
            setattr(node, name, value)
        for name, value in (inputs or {}).items():
            node.inputs[name].default_value = value
        return node.outputs[output]
    return build


def add_shape(shape: str, name: str, place, material, scale=(1.0, 1.0, 1.0), rotation=(0.0, 0.0, 0.0)):
    """A smooth ball or monkey, a torus or a flat tile, with UV map, colour attribute and a custom property."""
    make = {"ball": lambda: bpy.ops.mesh.primitive_uv_sphere_add(segments=24, ring_count=12, radius=0.45),
            "monkey": lambda: bpy.ops.mesh.primitive_monkey_add(size=0.9),
            "torus": lambda: bpy.ops.mesh.primitive_torus_add(major_radius=0.3, minor_radius=0.14),
            "tile": lambda: bpy.ops.mesh.primitive_plane_add(size=0.9)}
    make[shape]()
    ob = bpy.context.active_object
    ob.name, ob.location, ob.scale, ob.rotation_euler = name, place, scale, rotation
    for polygon in ob.data.polygons:
        polygon.use_smooth = shape != "tile"
    colors = ob.data.color_attributes.new("Paint", "FLOAT_COLOR", "CORNER")
    for k, each in enumerate(colors.data):
        each.color = k % 3 / 2.0, k % 5 / 4.0, k % 7 / 6.0, 0.25 + k % 2 / 2.0
    ob["tint"] = 0.1, 0.6, 0.9
    ob.color, ob.pass_index = (0.2, 0.5, 0.8, 0.6), 3
    ob.data.materials.append(material)
    return ob


def place_of(number: int, columns: int = COLUMNS) -> tuple[float, float, float]:
    return number % columns + 0.5, -(number // columns) - 0.5, 0.0


def frame(count: int, columns: int = COLUMNS) -> None:
    """An orthographic camera over so many patches."""
    rows = -(-count // columns)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = 32 * columns, 32 * rows
    scene.render.resolution_percentage = 100
    add_camera((columns / 2.0, -rows / 2.0, 10.0), width=float(max(columns, rows)))


def make_inputs() -> None:
    empty_scene()
    other = bpy.data.objects.new("Other", None)
    other.location, other.rotation_euler, other.scale = (1.0, -2.0, 0.3), (0.3, 0.2, 0.9), (1.0, 2.0, 0.5)
    bpy.context.scene.collection.objects.link(other)
    bpy.context.view_layer["strength"] = 0.7
    cases = [node_output("ShaderNodeTexCoord", name) for name in
             ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection")]
    cases.append(node_output("ShaderNodeTexCoord", "Object", object=other))
    cases += [node_output("ShaderNodeNewGeometry", name) for name in
              ("Position", "Normal", "Tangent", "True Normal", "Incoming", "Parametric", "Backfacing",
               "Random Per Island", "Pointiness")]
    cases += [node_output("ShaderNodeObjectInfo", name) for name in
              ("Location", "Color", "Alpha", "Object Index", "Material Index", "Random")]
    cases += [node_output("ShaderNodeLayerWeight", name, {"Blend": blend}) for name in ("Fresnel", "Facing")
              for blend in (0.2, 0.5, 0.8)]
    cases += [node_output("ShaderNodeFresnel", "Fac", {"IOR": ior}) for ior in (0.7, 1.45)]
    cases += [node_output("ShaderNodeCameraData", name) for name in ("View Vector", "View Z Depth", "View Distance")]
    cases += [node_output("ShaderNodeTangent", "Tangent", axis=axis) for axis in "XYZ"]
    cases.append(node_output("ShaderNodeTangent", "Tangent", direction_type="UV_MAP"))
    cases += [node_output("ShaderNodeAttribute", name, attribute_name="Paint") for name in ("Color", "Fac", "Alpha")]
    cases.append(node_output("ShaderNodeAttribute", "Color", attribute_name="tint", attribute_type="OBJECT"))
    cases.append(node_output("ShaderNodeAttribute", "Color", attribute_name="strength", attribute_type="VIEW_LAYER"))
    cases.append(node_output("ShaderNodeVertexColor", "Color", layer_name="Paint"))
    cases.append(node_output("ShaderNodeVertexColor", "Alpha"))
    cases.append(node_output("ShaderNodeUVMap", "UV"))
    cases.append(node_output("ShaderNodeWireframe", "Fac", {"Size": 0.03}))
    cases.append(node_output("ShaderNodeWireframe", "Fac", {"Size": 2.0}, use_pixel_size=True))
    cases += [node_output("ShaderNodeHairInfo", "Is Strand"), node_output("ShaderNodeParticleInfo", "Random"),
              node_output("ShaderNodeLightPath", "Ray Length"), node_output("ShaderNodeLightPath", "Is Camera Ray")]
    shapes = ("ball", "torus", "monkey")
    for number, build in enumerate(cases):
        material = emitting(f"{number}", build, 0.1, 0.5)
        material.pass_index = 2
        mirrored = -1.0 if number % 2 else 1.0
        add_shape(shapes[number % 3], f"patch {number}", place_of(number), material,
                  scale=(mirrored, 1.0, 0.8), rotation=(0.4, 0.3, 0.2))
    frame(len(cases))
    bpy.context.scene.cycles.filter_width = 0.01  # a pixel is the value at its centre


def with_normal(build, shader: str = "ShaderNodeBsdfDiffuse", roughness: float = 0.3):
    """A shader whose normal build(tree) makes; the displacement of the output where build.displaces."""
    material, tree, output = new_material("normal")
    closure = tree.nodes.new(shader)
    if shader != "ShaderNodeBsdfDiffuse":
        closure.inputs["Roughness"].default_value = roughness
    tree.links.new(closure.outputs[0], output.inputs["Surface"])
    made = build(tree)
    tree.links.new(made, output.inputs["Displacement"] if made.name == "Displacement" else closure.inputs["Normal"])
    return material


def curved(tree, node, socket: str, vector: bool = False):
    """Links an input to x (x + y) of the object, or to a colour that follows the UV map to steep angles."""
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    parts = tree.nodes.new("ShaderNodeSeparateXYZ")
    tree.links.new(coordinates.outputs["UV" if vector else "Object"], parts.inputs[0])
    if vector:
        color = tree.nodes.new("ShaderNodeCombineXYZ")
        for k in range(2):
            tree.links.new(parts.outputs[k], color.inputs[k])
        color.inputs[2].default_value = 0.8
        tree.links.new(color.outputs[0], node.inputs[socket])
        return
    total, product = tree.nodes.new("ShaderNodeMath"), tree.nodes.new("ShaderNodeMath")
    product.operation = "MULTIPLY"
    for k in range(2):
        tree.links.new(parts.outputs[k], total.inputs[k])
    tree.links.new(parts.outputs[0], product.inputs[0])
    tree.links.new(total.outputs[0], product.inputs[1])
    tree.links.new(product.outputs[0], node.inputs[socket])


def normal_map(space: str, strength: float, fixed=None):
    def build(tree):
        node = tree.nodes.new("ShaderNodeNormalMap")
        node.space, node.inputs["Strength"].default_value = space, strength
        if fixed:
            node.inputs["Color"].default_value = (*fixed, 1.0)
        else:
            curved(tree, node, "Color", vector=True)
        return node.outputs[0]
    return build


def bump(strength: float, distance: float, invert: bool = False):
    def build(tree):
        node = tree.nodes.new("ShaderNodeBump")
        node.invert = invert
        node.inputs["Strength"].default_value, node.inputs["Distance"].default_value = strength, distance
        curved(tree, node, "Height")
        return node.outputs[0]
    return build


def displacement(kind: str, space: str, scale: float):
    def build(tree):
        node = tree.nodes.new(kind)
        node.space, node.inputs["Scale"].default_value = space, scale
        vector = kind == "ShaderNodeVectorDisplacement"
        curved(tree, node, "Vector" if vector else "Height", vector)
        return node.outputs[0]
    return build


def make_normals() -> None:
    empty_scene()
    steep = 0.5 + 0.5 * 0.8660254, 0.5, 0.75
    cases = [normal_map("TANGENT", 1.0), normal_map("TANGENT", 0.4), normal_map("TANGENT", 1.7),
             normal_map("TANGENT", 1.0, steep), normal_map("OBJECT", 1.0), normal_map("WORLD", 0.6),
             normal_map("BLENDER_OBJECT", 1.0, (0.6, 0.4, 0.1)), normal_map("BLENDER_WORLD", 0.8, (0.4, 0.7, 0.2)),
             normal_map("WORLD", 1.0, (0.5,) * 3),
             bump(1.0, 1.0), bump(0.5, 2.0), bump(1.0, 1.0, True),
             displacement("ShaderNodeDisplacement", "OBJECT", 1.0),
             displacement("ShaderNodeDisplacement", "WORLD", 1.0),
             displacement("ShaderNodeVectorDisplacement", "OBJECT", 0.1)]
    shaders = ("ShaderNodeBsdfDiffuse", "ShaderNodeBsdfGlossy", "ShaderNodeBsdfPrincipled")
    number = 0
    for build in cases:
        for shader in shaders:
            shape = ("ball", "tile", "torus")[number // 3 % 3]
            tilt = (3.3, 0.3, 0.2) if number % 9 == 1 else (0.4, 0.3, 0.2)  # some show their backs
            add_shape(shape, f"patch {number}", place_of(number, 9), with_normal(build, shader, 0.35),
                      scale=(-1.0 if number % 2 else 1.0, 1.0, 0.7), rotation=tilt)
            number += 1
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.data.angle, lamp.rotation_euler = 2.0, 0.3, (0.5, 0.6, 0.0)
    bpy.context.scene.collection.objects.link(lamp)
    background = bpy.context.scene.world.node_tree.nodes["Background"]
    background.inputs[0].default_value = 0.3, 0.4, 0.5, 1.0
    frame(number, 9)


def seen_by(name: str, output: str, scale: float):
    """Transparent or emitting, by an output of Light Path: so that shadow rays ask for it, too."""
    material, tree, end = new_material(name)
    path = tree.nodes.new("ShaderNodeLightPath")
    scaled = tree.nodes.new("ShaderNodeMath")
    scaled.operation, scaled.use_clamp, scaled.inputs[1].default_value = "MULTIPLY", True, scale
    tree.links.new(path.outputs[output], scaled.inputs[0])
    clear, diffuse = tree.nodes.new("ShaderNodeBsdfTransparent"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    mixed = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(scaled.outputs[0], mixed.inputs[0])
    tree.links.new(diffuse.outputs[0], mixed.inputs[1])
    tree.links.new(clear.outputs[0], mixed.inputs[2])
    tree.links.new(mixed.outputs[0], end.inputs["Surface"])
    return material


def plain(shader: str, roughness: float | None = None):
    material, tree, end = new_material(shader)
    node = tree.nodes.new(shader)
    if roughness is not None:
        node.inputs["Roughness"].default_value = roughness
    tree.links.new(node.outputs[0], end.inputs["Surface"])
    return material


def make_paths() -> None:
    """Balls over a floor, a mirror and glass: what they are follows from how rays get to them."""
    empty_scene()
    floors = [plain("ShaderNodeBsdfDiffuse"), plain("ShaderNodeBsdfGlossy", 0.0), plain("ShaderNodeBsdfGlossy", 0.3),
              plain("ShaderNodeBsdfGlass", 0.0)]
    outputs = [("Is Camera Ray", 1.0), ("Is Shadow Ray", 0.7), ("Is Diffuse Ray", 1.0), ("Is Glossy Ray", 1.0),
               ("Is Singular Ray", 1.0), ("Is Reflection Ray", 1.0), ("Is Transmission Ray", 1.0), ("Ray Length", 0.2),
               ("Ray Depth", 0.3), ("Diffuse Depth", 0.4), ("Glossy Depth", 0.4), ("Transmission Depth", 0.4),
               ("Transparent Depth", 0.4)]
    number = 0
    for output, scale in outputs:
        for floor in floors:
            x, y, _ = place_of(number, 8)
            add_shape("tile", f"floor {number}", (x, y, -0.4), floor)
            add_shape("ball", f"ball {number}", (x, y, 0.1), seen_by(f"{output} {number}", output, scale),
                      scale=(0.5, 0.5, 0.5))
            number += 1
    lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    lamp.data.energy, lamp.data.angle, lamp.rotation_euler = 2.0, 0.2, (0.5, 0.5, 0.0)
    bpy.context.scene.collection.objects.link(lamp)
    bpy.context.scene.world.node_tree.nodes["Background"].inputs[0].default_value = 0.4, 0.4, 0.4, 1.0
    frame(number, 8)


def grid(name: str, place) -> bpy.types.Object:
    """A square of nine faces with a UV map, from which others are instanced."""
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=3, y_subdivisions=3, size=0.9)
    ob = bpy.context.active_object
    ob.name, ob.location = name, place
    ob["tint"] = 0.9, 0.3, 0.1
    return ob


def make_instances() -> None:
    """Tiles that faces and particles of a grid carry: what they know of themselves and of what carries them."""
    empty_scene()
    faces = [node_output("ShaderNodeTexCoord", name, from_instancer=True) for name in ("Generated", "UV")]
    faces += [node_output("ShaderNodeUVMap", "UV", from_instancer=True),
              node_output("ShaderNodeObjectInfo", "Random"), node_output("ShaderNodeObjectInfo", "Location"),
              node_output("ShaderNodeAttribute", "Color", attribute_name="tint", attribute_type="INSTANCER")]
    particles = [node_output("ShaderNodeParticleInfo", name) for name in
                 ("Index", "Random", "Age", "Lifetime", "Location", "Size")]
    for number, build in enumerate(faces + particles):
        carrier = grid(f"grid {number}", place_of(number))
        shape = "tile" if number < len(faces) else "ball"  # particles turn what they carry
        tile = add_shape(shape, f"{shape} {number}", place_of(number), emitting(f"{number}", build, 0.1, 0.3),
                         scale=(0.2, 0.2, 0.2))
        if number < len(faces):
            carrier.instance_type, carrier.show_instancer_for_render = "FACES", False
            tile.parent, tile.location = carrier, (0.0, 0.0, 0.0)
            continue
        tile.location.z = -5.0  # far below: only the particles' copies show
        tile.location.x += 100.0
        carrier.show_instancer_for_render = False
        settings = carrier.modifiers.new("particles", "PARTICLE_SYSTEM").particle_system.settings
        settings.count, settings.frame_start, settings.frame_end, settings.lifetime = 20, 0.0, 1.0, 40.0
        settings.render_type, settings.instance_object, settings.particle_size = "OBJECT", tile, 0.5
        settings.physics_type, settings.size_random, settings.lifetime_random = "NO", 0.5, 0.3
    bpy.context.scene.frame_set(1)  # where particle systems begin
    frame(len(faces + particles))
    bpy.context.scene.cycles.filter_width = 0.01


SCENES = {"inputs": make_inputs, "instances": make_instances, "normals": make_normals, "paths": make_paths}


def main(folder: Path) -> None:
    for name, make in SCENES.items():
        make()
        bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"))


if __name__ == "__main__":
    main(Path(sys.argv[-1]))
