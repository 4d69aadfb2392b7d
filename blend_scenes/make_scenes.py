"""Makes the demo scenes of this folder. Blender 3.4 saves them, so that every later version opens them.

    blender -b --factory-startup --python blend_scenes/make_scenes.py -- [OUTDIR] [NAME ...]

Without OUTDIR the files go beside this script. Every scene is set so that Cycles and Isophote mean
the same by it: no clamping, no denoising, no adaptive sampling, no filtered glossy.
"""

import math
import sys
from pathlib import Path

import bpy
from mathutils import Matrix, Vector

WHITE, TERRACOTTA, SAGE = (0.74, 0.72, 0.68), (0.56, 0.17, 0.09), (0.16, 0.31, 0.23)
BLUE, WARM = (0.12, 0.22, 0.42), (1.0, 0.84, 0.64)


# --- parts -----------------------------------------------------------------------------------------


def new_scene(width=512, height=512):
    """An empty scene with the settings that all of them share, and a black world."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = width, height
    scene.render.resolution_percentage = 100
    scene.render.filepath = "//"
    scene.view_settings.view_transform = "Standard"
    cycles = scene.cycles
    cycles.samples = 64
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = cycles.caustics_refractive = True
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = 8
    cycles.transmission_bounces = cycles.transparent_max_bounces = 8
    cycles.pixel_filter_type, cycles.filter_width = "BLACKMAN_HARRIS", 1.5
    set_world(scene, (0.0, 0.0, 0.0))
    return scene


def set_world(scene, color, strength=1.0):
    scene.world = scene.world or bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    background = scene.world.node_tree.nodes["Background"]
    background.inputs["Color"].default_value = (*color, 1.0)
    background.inputs["Strength"].default_value = strength


def shader_material(name, *nodes, factor=None):
    """A material of one shader node, or of two with a Mix Shader; a node is (type, {input: value})."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    made = [new_shader(tree, *node) for node in nodes]
    if factor is not None:
        mix = tree.nodes.new("ShaderNodeMixShader")
        mix.inputs[0].default_value = factor
        for node, socket in zip(made, list(mix.inputs)[1:], strict=False):
            tree.links.new(node.outputs[0], socket)
        made = [mix]
    tree.links.new(made[0].outputs[0], output.inputs["Surface"])
    return material


def new_shader(tree, kind, inputs):
    node = tree.nodes.new(kind)
    if hasattr(node, "distribution"):
        node.distribution = "GGX"
    for name, value in inputs.items():
        node.inputs[name].default_value = (*value, 1.0) if isinstance(value, tuple) else value
    return node


def diffuse(name, color):
    return shader_material(name, ("ShaderNodeBsdfDiffuse", {"Color": color}))


def glossy(name, color, roughness):
    return shader_material(name, ("ShaderNodeBsdfGlossy", {"Color": color, "Roughness": roughness}))


def glass(name, color, roughness=0.0, ior=1.5):
    return shader_material(name, ("ShaderNodeBsdfGlass", {"Color": color, "Roughness": roughness, "IOR": ior}))


def emission(name, color, strength):
    return shader_material(name, ("ShaderNodeEmission", {"Color": color, "Strength": strength}))


def glazed(name, color, shine, roughness):
    """Diffuse with some gloss, as of glazed ceramics."""
    return shader_material(name, ("ShaderNodeBsdfDiffuse", {"Color": color}),
                           ("ShaderNodeBsdfGlossy", {"Color": (1.0, 1.0, 1.0), "Roughness": roughness}), factor=shine)


def new_object(name, data, material=None, location=(0, 0, 0), rotation=(0, 0, 0), scale=(1, 1, 1), collection=None):
    """An object in the scene, or in a collection; the material goes to the object's slot."""
    ob = bpy.data.objects.new(name, data)
    (collection or bpy.context.scene.collection).objects.link(ob)
    ob.location, ob.rotation_euler, ob.scale = location, rotation, scale
    if material is not None:
        if not data.materials:
            data.materials.append(None)
        ob.material_slots[0].link = "OBJECT"
        ob.material_slots[0].material = material
    return ob


def new_mesh(name, vertices, faces, smooth=False):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    mesh.polygons.foreach_set("use_smooth", [smooth] * len(mesh.polygons))
    mesh.update()
    return mesh


def box_mesh(name="box"):
    """A unit cube standing on z = 0."""
    vertices = [(x, y, z) for z in (0, 1) for y in (-0.5, 0.5) for x in (-0.5, 0.5)]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return new_mesh(name, vertices, faces)


def quad(name, corners, material):
    return new_object(name, new_mesh(name, corners, [(0, 1, 2, 3)]), material)


def subdivide(ob, levels, kind="CATMULL_CLARK"):
    modifier = ob.modifiers.new("subdivision", "SUBSURF")
    modifier.subdivision_type = kind
    modifier.levels, modifier.render_levels = min(levels, 3), levels
    return ob


def put_down(ob):
    """Move an object up or down until its evaluated mesh stands on z = 0."""
    graph = bpy.context.evaluated_depsgraph_get()
    mesh = ob.evaluated_get(graph).to_mesh()
    ob.location.z -= min((ob.matrix_world @ vertex.co).z for vertex in mesh.vertices)
    return ob


def primitive(call, **settings):
    """The mesh that a primitive operator makes, without its object; smooth."""
    call(**settings)
    ob = bpy.context.object
    mesh = ob.data
    bpy.data.objects.remove(ob)
    mesh.polygons.foreach_set("use_smooth", [True] * len(mesh.polygons))
    return mesh


def room(left, right, depth=1.0, back=WHITE):
    """A box 2 m wide and high, open towards the camera, with front at y = -1."""
    white = diffuse("white", WHITE)
    y0, y1 = -1.0, depth
    quad("floor", [(-1, y0, 0), (1, y0, 0), (1, y1, 0), (-1, y1, 0)], white)
    quad("ceiling", [(-1, y1, 2), (1, y1, 2), (1, y0, 2), (-1, y0, 2)], white)
    quad("back", [(-1, y1, 0), (1, y1, 0), (1, y1, 2), (-1, y1, 2)], white if back == WHITE else diffuse("back", back))
    quad("left", [(-1, y0, 0), (-1, y1, 0), (-1, y1, 2), (-1, y0, 2)], diffuse("left", left))
    quad("right", [(1, y1, 0), (1, y0, 0), (1, y0, 2), (1, y1, 2)], diffuse("right", right))
    return white


def ceiling_lamp(strength, width=0.62, depth=0.5, y=0.0):
    """A bright panel in a thin frame that it closes: light does not linger inside."""
    x0, x1, y0, y1, z = -width / 2, width / 2, y - depth / 2, y + depth / 2, 1.966
    quad("lamp", [(x0, y1, z), (x1, y1, z), (x1, y0, z), (x0, y0, z)], emission("lamp", WARM, strength))
    frame = box_mesh("frame")
    metal = diffuse("frame", (0.30, 0.29, 0.28))
    for name, place, size in (("frame left", (x0 - 0.01, y), (0.02, depth + 0.04)),
                              ("frame right", (x1 + 0.01, y), (0.02, depth + 0.04)),
                              ("frame front", (0, y0 - 0.01), (width, 0.02)),
                              ("frame back", (0, y1 + 0.01), (width, 0.02))):
        new_object(name, frame, metal, (*place, 1.965), scale=(*size, 0.0349))


def area_lamp(name, location, target, shape, size, power, color=(1.0, 1.0, 1.0)):
    lamp = bpy.data.lights.new(name, "AREA")
    lamp.shape, lamp.energy, lamp.color = shape, power, color
    lamp.size, lamp.size_y = size
    ob = new_object(name, lamp, location=location)
    ob.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    return ob


def camera(location, target, degrees):
    data = bpy.data.cameras.new("camera")
    data.angle = math.radians(degrees)
    ob = new_object("camera", data, location=location)
    ob.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.camera = ob


def front_camera():
    """Looks straight into a room; its front just fills the picture."""
    camera((0.0, -4.1, 1.0), (0.0, 0.0, 1.0), 35.6)


# --- scenes ----------------------------------------------------------------------------------------


def cornell_box():
    new_scene()
    white = room(TERRACOTTA, SAGE)
    ceiling_lamp(19.0)
    mesh = box_mesh()
    tall = new_object("tall block", mesh, white, (-0.36, 0.34, 0.0), (0, 0, math.radians(17)), (0.58, 0.58, 1.18))
    short = new_object("short block", mesh, white, (0.37, -0.28, 0.0), (0, 0, math.radians(-18)), (0.58, 0.58, 0.56))
    for block in (tall, short):
        bevel = block.modifiers.new("bevel", "BEVEL")
        bevel.width, bevel.segments = 0.008, 2
    front_camera()


def sphere_box():
    """The founding report's box: a mirror and a glass sphere, drawn by Isophote as true spheres."""
    new_scene()
    room(TERRACOTTA, BLUE)
    ceiling_lamp(19.0)
    cube = box_mesh("ball")
    cube.transform(Matrix.Translation((0, 0, -0.5)))
    cube.polygons.foreach_set("use_smooth", [True] * 6)
    for name, material, place, radius in (
            ("mirror sphere", glossy("mirror", (0.93, 0.93, 0.93), 0.0), (-0.40, 0.30, 0.44), 0.44),
            ("glass sphere", glass("glass", (1.0, 1.0, 1.0)), (0.42, -0.22, 0.36), 0.36)):
        ob = new_object(name, cube, material, place, scale=(radius, radius, radius))
        subdivide(ob, 7)
        # Cycles sees 196,608 triangles whose corners lie on the sphere.
        cast = ob.modifiers.new("to a sphere", "CAST")
        cast.factor, cast.cast_type, cast.use_radius_as_size, cast.size = 1.0, "SPHERE", False, 1.0
        ob["isophote_as_sphere"] = True
    front_camera()


def torus_box():
    new_scene()
    room((0.50, 0.33, 0.10), (0.13, 0.24, 0.34))
    ceiling_lamp(19.0)
    ring = primitive(bpy.ops.mesh.primitive_torus_add, major_segments=48, minor_segments=16,
                     major_radius=0.42, minor_radius=0.13)
    gold = glossy("gold", (0.95, 0.69, 0.36), 0.22)
    ceramic = glazed("ceramic", (0.62, 0.60, 0.56), 0.06, 0.15)
    # Two rings through each other, one lying, one standing in it; a small one of glass in front.
    subdivide(new_object("ceramic ring", ring, ceramic, (-0.20, 0.16, 0.13)), 2)
    subdivide(new_object("gold ring", ring, gold, (0.20, 0.24, 0.55), (math.radians(90), 0, math.radians(24))), 2)
    subdivide(new_object("glass ring", ring, glass("glass", (0.86, 0.95, 0.93)), (0.44, -0.50, 0.0651),
                         scale=(0.5, 0.5, 0.5)), 2)
    front_camera()


def monkey_box():
    scene = new_scene()
    room((0.14, 0.30, 0.32), (0.60, 0.30, 0.14))
    area_lamp("ceiling lamp", (0.0, -0.1, 1.98), (0.0, -0.1, 0.0), "RECTANGLE", (0.9, 0.7), 30.0, WARM)
    set_world(scene, (0.55, 0.65, 0.80), 0.12)
    head = primitive(bpy.ops.mesh.primitive_monkey_add, size=1.0)
    for name, material, place, turn, size in (
            ("clay monkey", glazed("clay", (0.58, 0.22, 0.13), 0.05, 0.2), (-0.34, 0.22), 24, 0.98),
            ("gold monkey", glossy("gold", (0.96, 0.72, 0.38), 0.18), (0.46, -0.36), -30, 0.60)):
        rotation = (math.radians(-32.0), 0, math.radians(turn))
        put_down(subdivide(new_object(name, head, material, (*place, 0.0), rotation, (size, size, size)), 3))
    front_camera()


def petal_mesh(tilt):
    """A petal along +y, 1 m long, raised by `tilt` degrees, bent to one side, so that a mirrored one shows."""
    across, along = 6, 8
    vertices, faces = [], []
    for j in range(along + 1):
        t = j / along
        width = 0.30 * math.sin(math.pi * (0.08 + 0.90 * t)) ** 0.8
        for i in range(across + 1):
            s = 2.0 * i / across - 1.0
            bend = 0.22 * t * t
            vertices.append((s * width + bend, t, 0.42 * t ** 1.6 + 0.25 * width * s * s))
    for j in range(along):
        for i in range(across):
            a = j * (across + 1) + i
            faces.append((a, a + 1, a + across + 2, a + across + 1))
    mesh = new_mesh("petal", vertices, faces, smooth=True)
    mesh.transform(Matrix.Rotation(math.radians(tilt), 4, "X"))
    return mesh


def instances():
    """Three flowers, two of them mirror images: collections, in them petals on the vertices of spirals."""
    scene = new_scene(640, 480)
    set_world(scene, (0.62, 0.72, 0.90), 0.35)
    area_lamp("key", (-3.2, -0.6, 3.6), (0.0, 0.2, 0.0), "DISK", (1.4, 1.4), 330.0, (1.0, 0.86, 0.70))
    quad("floor", [(-12, -12, 0), (12, -12, 0), (12, 12, 0), (-12, 12, 0)], diffuse("floor", (0.20, 0.27, 0.28)))
    flower = bpy.data.collections.new("flower")
    rings = (  # petals from, to; their size and tilt; colour
        (0, 70, 0.17, 84, glazed("heart", (0.24, 0.05, 0.03), 0.04, 0.3)),
        (70, 250, 0.24, 66, glazed("red", (0.52, 0.09, 0.05), 0.04, 0.3)),
        (250, 520, 0.32, 46, glazed("coral", (0.72, 0.24, 0.12), 0.04, 0.3)),
        (520, 860, 0.40, 27, glazed("apricot", (0.80, 0.47, 0.24), 0.04, 0.3)),
        (860, 1200, 0.46, 10, glazed("cream", (0.80, 0.70, 0.54), 0.04, 0.3)),
    )
    golden = math.pi * (3.0 - math.sqrt(5.0))
    for first, last, size, tilt, material in rings:
        polar = [(0.0245 * math.sqrt(n + 0.5), n * golden) for n in range(first, last)]
        points = [(r * math.cos(angle), r * math.sin(angle), 0.0) for r, angle in polar]
        name = f"spiral {material.name}"
        spiral = new_object(name, new_mesh(name, points, []), collection=flower)
        spiral.instance_type, spiral.use_instance_vertices_rotation = "VERTS", True
        spiral.location.z = 0.03 + 0.10 * (1.0 - first / 1200.0)
        petal = new_object(f"petal {material.name}", petal_mesh(tilt), material, scale=(size, size, size),
                           collection=flower)
        petal.track_axis, petal.up_axis = "POS_Y", "Z"
        petal.parent = spiral
    for name, x, y, mirror, size in (("flower", 0.0, -0.25, 1, 1.0), ("left flower", -1.70, 1.00, 1, 0.62),
                                     ("right flower", 1.70, 1.00, -1, 0.62)):
        empty = new_object(name, None, location=(x, y, 0), scale=(mirror * size, size, size))
        empty.instance_type, empty.instance_collection = "COLLECTION", flower
    camera((0.0, -4.5, 3.7), (0.0, 0.18, 0.05), 43.5)


def garlands():
    """Many lights: four strings of 60 glowing bulbs (8 triangles each) before a wall that 60 spots graze."""
    scene = new_scene(640, 400)
    scene.cycles.max_bounces = scene.cycles.diffuse_bounces = 4
    wall, floor = diffuse("wall", (0.55, 0.50, 0.44)), diffuse("floor", (0.30, 0.26, 0.22))
    quad("floor", [(-6, -5, 0), (6, -5, 0), (6, 3, 0), (-6, 3, 0)], floor)
    quad("wall", [(-6, 3, 0), (6, 3, 0), (6, 3, 5), (-6, 3, 5)], wall)
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    bulb = new_mesh("bulb", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1.4), (0, 0, -1.4)], faces)
    colors = [emission(f"glow {k}", color, 60.0) for k, color in enumerate(
        (WARM, (1.0, 0.45, 0.20), (0.45, 0.75, 1.0), (1.0, 0.30, 0.40), (0.50, 1.0, 0.55)))]
    for string, (y, top, sag) in enumerate(((-2.6, 2.3, 0.9), (-1.0, 2.9, 1.1), (0.7, 3.4, 1.3), (2.2, 4.0, 1.5))):
        for k in range(60):
            x = (k + 0.5) / 60 * 2.0 - 1.0
            z = top - sag * (1.0 - x * x) + 0.04 * math.sin(7.0 * k)
            place = (5.2 * x, y + 0.1 * math.sin(5.0 * k), z)
            new_object(f"bulb {string}.{k}", bulb, colors[(3 * k + string) % 5], place, scale=(0.028, 0.028, 0.028))
    for k in range(60):
        lamp = bpy.data.lights.new(f"spot {k}", "SPOT")
        lamp.energy, lamp.color, lamp.spot_size, lamp.spot_blend = 9.0, (1.0, 0.9, 0.75), math.radians(50), 0.4
        lamp.shadow_soft_size = 0.0
        new_object(f"spot {k}", lamp, location=(-5.8 + 11.6 * k / 59, 2.8, 0.02), rotation=(math.radians(165), 0, 0))
    cube, steel = box_mesh(), glossy("steel", (0.80, 0.80, 0.82), 0.25)
    for k in range(9):
        size = 0.5 + 0.25 * (k % 3)
        new_object(f"block {k}", cube, steel if k % 3 == 1 else wall, (-4.4 + 1.1 * k, -1.6 + 1.3 * (k % 4), 0.0),
                   (0, 0, 0.4 * k), (size, size, 0.6 + 0.5 * (k % 2)))
    camera((0.0, -9.5, 2.6), (0.0, 0.0, 1.7), 47.0)


SCENES = {function.__name__: function for function in (cornell_box, sphere_box, torus_box, monkey_box, instances,
                                                       garlands)}


def save(folder, name):
    for mesh in [m for m in bpy.data.meshes if not m.users]:
        bpy.data.meshes.remove(mesh)
    bpy.context.preferences.filepaths.save_version = 0
    for space in (space for screen in bpy.data.screens for area in screen.areas for space in area.spaces):
        if space.type == "FILE_BROWSER" and space.params:
            space.params.directory = b"//"
    # As a copy of a file without a name: no path is stored in it.
    bpy.ops.wm.save_as_mainfile(filepath=str(folder / f"{name}.blend"), compress=True, copy=True)


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else []
    folder = Path(arguments[0] if arguments else Path(__file__).parent).resolve()
    folder.mkdir(parents=True, exist_ok=True)
    for name in arguments[1:] or SCENES:
        SCENES[name]()
        save(folder, name)


main()
