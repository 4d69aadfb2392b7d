# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a glowing room around a camera.

    python blend_scenes/make_cameras.py -- OUT.blend CAMERA SURFACE        (or blender -b --python ...)

CAMERA: one of CAMERAS. SURFACE, what the walls show: place (in the room), window (Texture Coordinate), view (Camera
Data's vector), distances (Camera Data's depth and distance), wires (a Wireframe's, two pixels wide), marks (a chequer).
"""

import math
import sys

import bpy

SIZE = 4.0  # half of the room's, metres
# What a camera is: its type, properties of its panorama, of its data, and of the render.
PERSPECTIVE, EQUIDISTANT, EQUISOLID = "PERSP", "FISHEYE_EQUIDISTANT", "FISHEYE_EQUISOLID"
CAMERAS = {
    "perspective": (PERSPECTIVE, {}, {}, {}),
    "equirectangular": ("EQUIRECTANGULAR", {}, {}, {}),
    "part": ("EQUIRECTANGULAR",
             {"latitude_min": -0.4, "latitude_max": 1.2, "longitude_min": -2.0, "longitude_max": 0.9},
             {"shift_x": 0.1, "shift_y": -0.05}, {}),
    "equidistant": (EQUIDISTANT, {"fisheye_fov": math.radians(200.0)}, {}, {}),
    "equisolid": (EQUISOLID, {"fisheye_fov": math.radians(170.0), "fisheye_lens": 12.0}, {"shift_y": 0.05}, {}),
    "polynomial": ("FISHEYE_LENS_POLYNOMIAL",
                   {"fisheye_fov": math.radians(150.0), "fisheye_polynomial_k0": 0.0, "fisheye_polynomial_k1": -5.79e-2,
                    "fisheye_polynomial_k3": 9.48e-5, "fisheye_polynomial_k4": -7.67e-6}, {}, {}),
    "mirror_ball": ("MIRRORBALL", {}, {}, {}),
    "cube_face": ("EQUIANGULAR_CUBEMAP_FACE", {}, {"shift_x": 0.05}, {}),
    "cylinder": ("CENTRAL_CYLINDRICAL",
                 {"central_cylindrical_range_u_min": -2.0, "central_cylindrical_range_u_max": 2.5,
                  "central_cylindrical_range_v_min": -1.5, "central_cylindrical_range_v_max": 2.0,
                  "central_cylindrical_radius": 1.5}, {}, {}),
    # A sensor that fits the other side, oblong pixels.
    "portrait": (EQUISOLID, {"fisheye_fov": math.radians(170.0), "fisheye_lens": 7.0},
                 {"sensor_fit": "VERTICAL", "sensor_height": 20.0},
                 {"resolution_x": 48, "resolution_y": 96, "pixel_aspect_x": 1.3}),
    "clipped": (EQUIDISTANT, {"fisheye_fov": math.radians(180.0)}, {"clip_start": 3.2, "clip_end": 5.2}, {}),
    "focused": (EQUIDISTANT, {"fisheye_fov": math.radians(180.0)}, {"lens": 500.0}, {}),
}


def new_scene(name, surface):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return furnish(bpy.context.scene, name, surface)


def furnish(scene, name, surface):
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.resolution_x, render.resolution_y, render.resolution_percentage = 96, 72, 100
    cycles.use_denoising = cycles.use_adaptive_sampling = False
    cycles.filter_width = 0.01
    kind, panorama, data, others = CAMERAS[name]
    camera = bpy.data.cameras.new("camera")
    if kind == PERSPECTIVE:
        camera.type = kind
    else:
        camera.type = "PANO"
        holder = camera if hasattr(camera, "panorama_type") else camera.cycles
        holder.panorama_type = kind
        set_all(holder, panorama)
    set_all(camera, data)
    set_all(render, others)
    if name == "focused":
        dof = camera.dof
        dof.use_dof, dof.focus_distance, dof.aperture_fstop, dof.aperture_blades = True, 2.5, 0.8, 3
        dof.aperture_rotation, dof.aperture_ratio = 0.3, 1.6
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location, scene.camera.rotation_euler = (0.5, -0.3, 0.7), (1.2, 0.15, 0.4)
    scene.collection.objects.link(scene.camera)
    scene.collection.objects.link(bpy.data.objects.new("room", room(surface)))
    return scene


def set_all(thing, values):
    for name, value in values.items():
        setattr(thing, name, value)


def room(surface):
    corners = [(x, y, z) for x in (-SIZE, SIZE) for y in (-SIZE, SIZE) for z in (-SIZE, SIZE)]
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    mesh = bpy.data.meshes.new("room")
    mesh.from_pydata(corners, [], faces)
    mesh.materials.append(glow(surface))
    return mesh


def glow(surface):
    """Emission of what `surface` names, brought to 0 to 1."""
    material = bpy.data.materials.new(surface)
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader, output = tree.nodes.new("ShaderNodeEmission"), tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])

    def scaled(socket, factor, term):
        node = tree.nodes.new("ShaderNodeVectorMath")
        node.operation = "MULTIPLY_ADD"
        node.inputs[1].default_value, node.inputs[2].default_value = (factor,) * 3, (term,) * 3
        tree.links.new(socket, node.inputs[0])
        return node.outputs[0]

    place = tree.nodes.new("ShaderNodeTexCoord")
    camera = tree.nodes.new("ShaderNodeCameraData")
    if surface == "place":
        found = scaled(place.outputs["Object"], 0.5 / SIZE, 0.5)
    elif surface == "window":
        found = scaled(place.outputs["Window"], 0.5, 0.25)
    elif surface == "view":
        found = scaled(camera.outputs["View Vector"], 0.5, 0.5)
    elif surface == "distances":
        both = tree.nodes.new("ShaderNodeCombineXYZ")
        tree.links.new(camera.outputs["View Z Depth"], both.inputs["X"])
        tree.links.new(camera.outputs["View Distance"], both.inputs["Y"])
        found = scaled(both.outputs[0], 0.05, 0.5)
    elif surface == "wires":
        wires = tree.nodes.new("ShaderNodeWireframe")
        wires.use_pixel_size, wires.inputs["Size"].default_value = True, 2.0
        found = wires.outputs[0]
    else:
        marks = tree.nodes.new("ShaderNodeTexChecker")
        marks.inputs["Scale"].default_value = 1.1
        tree.links.new(place.outputs["Object"], marks.inputs["Vector"])
        found = marks.outputs["Color"]
    tree.links.new(found, shader.inputs["Color"])
    return material


if __name__ == "__main__":
    path, camera_name, surface_name = sys.argv[sys.argv.index("--") + 1:]
    new_scene(camera_name, surface_name)
    bpy.ops.wm.save_as_mainfile(filepath=path)
