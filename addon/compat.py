# SPDX-License-Identifier: GPL-3.0-or-later
"""Every difference between Blender versions, and nowhere else: 3.4 to 5.x."""

from __future__ import annotations

import ctypes
import os
import signal
import sys
import threading
from contextlib import contextmanager

import bpy
import numpy as np

# ---- export: reading meshes, lights and nodes (addon/export) ------------------------------------

# From CIE XYZ to Rec. 709 (IEC 61966-2-1), as Cycles takes it from the OpenColorIO configuration: rounded before 5.0.
RGB_OF_XYZ = np.array([[3.24096994, -1.53738318, -0.49861076], [-0.96924364, 1.8759675, 0.04155506],
                       [0.05563008, -0.20397696, 1.05697151]]
                      if bpy.app.version >= (5, 0) else
                      [[3.2404542, -1.5371385, -0.4985314], [-0.9692660, 1.8760108, 0.0415560],
                       [0.0556434, -0.2040259, 1.0572252]])

LARGE = 10_000  # items from which on reading memory pays
SAMPLES = 32  # of them that are compared with what Blender's interface says


def read_all(collection, name: str, columns: int, dtype) -> np.ndarray:
    """A property of all items of a collection, (n, columns), 4 bytes each and the first that an item holds.

    foreach_get asks Blender for one item after the other where no attribute stands behind the collection:
    0.13 s for a million triangles. So where many lie in memory one after the other, that is copied.
    """
    count = len(collection)
    values = in_memory(collection, name, columns, dtype) if count >= LARGE else None
    if values is None:
        values = np.empty(count * columns, dtype)
        collection.foreach_get(name, values)
    return values.reshape(count, columns)


def in_memory(collection, name: str, columns: int, dtype) -> np.ndarray | None:
    """The same, copied from where the items lie; None unless they lie evenly and samples are what Blender says."""
    count = len(collection)
    chosen = np.linspace(0, count - 1, SAMPLES).astype(int)
    places = np.array([collection[i].as_pointer() for i in chosen.tolist()])
    stride = int(places[-1] - places[0]) // (count - 1)
    if stride not in range(4 * columns, 65, 4) or not np.array_equal(places, places[0] + stride * chosen):
        return None
    words = (ctypes.c_uint32 * (count * stride // 4)).from_address(int(places[0]))
    values = np.array(np.frombuffer(words, dtype).reshape(count, -1)[:, :columns])
    wanted = [np.ravel(getattr(collection[i], name)).tolist() for i in chosen.tolist()]
    return values if values[chosen].tolist() == wanted else None


def reading_changes(mesh) -> bool:
    """Whether a mesh has to be copied first, because its normals are computed into it (before 4.1)."""
    return getattr(mesh, "use_auto_smooth", False)


def vertex_positions(mesh) -> np.ndarray:
    """Positions of a mesh, f4 [3 V]."""
    positions = np.empty(len(mesh.vertices) * 3, np.float32)
    attribute = mesh.attributes.get("position")  # 3.5 and newer: a plain copy
    if attribute is not None:
        attribute.data.foreach_get("vector", positions)
    else:
        mesh.vertices.foreach_get("co", positions)
    return positions


def corner_vertices(mesh) -> np.ndarray:
    """Vertex of each corner, u4 [C]."""
    attribute = mesh.attributes.get(".corner_vert")  # 3.6 and newer: a plain copy
    if attribute is None:
        return read_all(mesh.loops, "vertex_index", 1, np.int32).reshape(-1).view(np.uint32)
    vertices = np.empty(len(mesh.loops), np.int32)
    attribute.data.foreach_get("value", vertices)
    return vertices.view(np.uint32)


def uv_of(layer) -> np.ndarray:
    """Coordinates of a UV map's corners, f4 [C, 2]."""
    if hasattr(layer, "uv"):  # since 3.5
        return read_all(layer.uv, "vector", 2, np.float32).reshape(-1, 2)
    return read_all(layer.data, "uv", 2, np.float32).reshape(-1, 2)


def triangle_corners(mesh, count: int) -> np.ndarray:
    """The three corners of each of the mesh's loop triangles, i4 [3 T]."""
    if count == len(mesh.polygons):  # nothing but triangles
        return np.arange(3 * count, dtype=np.int32)
    return read_all(mesh.loop_triangles, "loops", 3, np.int32).reshape(-1)


def triangle_polygons(mesh, count: int) -> np.ndarray:
    """The polygon of each triangle, i4 [T]."""
    polygons = np.empty(count, np.int32)
    if hasattr(mesh, "loop_triangle_polygons"):  # 4.0 and newer: a plain copy
        mesh.loop_triangle_polygons.foreach_get("value", polygons)
    else:
        mesh.loop_triangles.foreach_get("polygon_index", polygons)
    return polygons


def triangle_slots(mesh, count: int) -> np.ndarray | None:
    """The material slot of each triangle, u2 [T]; None where all are 0."""
    attribute = mesh.attributes.get("material_index")  # missing where every face has slot 0
    if attribute is None or attribute.domain != "FACE" or attribute.data_type != "INT":
        return None
    slots = np.empty(len(mesh.polygons), np.int32)
    attribute.data.foreach_get("value", slots)
    if not slots.any():
        return None
    slots = np.clip(slots, 0, 0xFFFF).astype(np.uint16)
    return slots if count == len(slots) else slots[triangle_polygons(mesh, count)]


def corner_normals(mesh, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray | None:
    """Unit normal of each corner, f4 [C, 3], or None where every face is flat.

    `vertices` is the vertex of each corner, [C], `triangles` the corners of each triangle, [T, 3].
    """
    normals = np.empty((len(mesh.loops), 3), np.float32)
    if hasattr(mesh, "corner_normals"):  # 4.1 and newer
        if mesh.normals_domain == "FACE":
            return None
        mesh.corner_normals.foreach_get("vector", normals.reshape(-1))
        return normals
    smooth = np.empty(len(mesh.polygons), bool)
    mesh.polygons.foreach_get("use_smooth", smooth)
    if mesh.use_auto_smooth and (mesh.has_custom_normals or smooth.any()):
        mesh.calc_normals_split()
        mesh.loops.foreach_get("normal", normals.reshape(-1))
        return normals
    if not smooth.any():
        return None
    # Without auto smooth a corner has its vertex' normal, or its face's where that is flat.
    np.take(read_all(mesh.vertex_normals, "vector", 3, np.float32), vertices, axis=0, out=normals)
    if not smooth.all():
        faces = read_all(mesh.polygon_normals, "vector", 3, np.float32)
        polygons = triangle_polygons(mesh, len(triangles))
        flat = ~smooth[polygons]
        normals[triangles[flat]] = faces[polygons[flat]][:, None, :]
    return normals


def panorama_of(camera):
    """What holds a camera's panorama: its data, or in older versions Cycles' properties of it; None without these."""
    return camera if hasattr(camera, "panorama_type") else getattr(camera, "cycles", None)


def shutter_position(scene) -> str:
    """Where the frame lies in the time that the shutter is open: START, CENTER or END."""
    position = getattr(scene.render, "motion_blur_position", None)  # of Cycles in older versions
    return position or getattr(getattr(scene, "cycles", None), "motion_blur_position", "CENTER")


def casts_shadow(light) -> bool:
    """Whether Cycles lets a lamp cast shadows: a property of its own until 4.1, Blender's since."""
    cycles = getattr(light, "cycles", None)
    return bool(getattr(cycles, "cast_shadow", True)) if hasattr(cycles, "cast_shadow") else bool(light.use_shadow)


def soft_falloff(light) -> bool:
    """Whether Cycles draws a point or spot lamp as a disk that faces each shading point: always before 4.2."""
    return bool(getattr(light, "use_soft_falloff", True))


def light_energy(light) -> float:
    """Power or strength in today's units: before 4.0 an area lamp's radiance was P/4 by area, not P/pi.

    Rounded as Blender's own conversion of old files rounds it.
    """
    if light.type == "AREA" and bpy.app.version < (4, 0, 0):
        return float(np.float32(light.energy * (np.pi / 4.0)))
    return light.energy


def light_factor(light) -> np.ndarray:
    """Colour temperature times exposure, f8 [3]; 1 in versions that have neither (before 4.5)."""
    factor = np.ones(3)
    if getattr(light, "use_temperature", False):
        factor *= np.array(light.temperature_color, dtype=np.float64)[:3]
    return factor * 2.0 ** float(getattr(light, "exposure", 0.0))


def uses_nodes(data) -> bool:
    """Whether a material, light or world has a node tree in use (5.0 and newer: where it has one)."""
    if data.node_tree is None:
        return False
    if bpy.app.version >= (5, 0, 0) and not isinstance(data, bpy.types.Light):
        return True  # asking for use_nodes is deprecated there
    return bool(data.use_nodes)


def noise_kind(node) -> tuple[str, bool]:
    """The kind of a Noise Texture (a choice since 4.1), and whether it is scaled to [0, 1] (a choice since 4.0)."""
    return getattr(node, "noise_type", "FBM"), getattr(node, "normalize", True)


def most_noise_roughness() -> float:
    """To what Cycles limits the roughness of fractal noise."""
    return 1.0 if bpy.app.version < (4, 0, 0) else float("inf")


def voronoi_cells_are_whole() -> bool:
    """Whether Cycles hashes the cells of Voronoi Textures as whole numbers (since 5.0), which makes others of them."""
    return bpy.app.version >= (5, 0, 0)


def dust_density(sky) -> float:
    """Of a Sky Texture; called aerosols since 5.0."""
    return sky.aerosol_density if hasattr(sky, "aerosol_density") else sky.dust_density


def absolute_path(image) -> str:
    """The path of an image's file, with tokens as they are."""
    return bpy.path.abspath(image.filepath_raw, library=image.library).replace("\\", "/")


def ies_text(node) -> str:
    """The text of an IES Texture node's file, or of its text within Blender. Raises OSError."""
    if node.mode == "INTERNAL":
        return node.ies.as_string() if node.ies else ""
    path = bpy.path.abspath(node.filepath, library=node.id_data.library)
    with open(path, encoding="latin-1") as file:
        return file.read()


def scene_linear_converter(space: str):
    """A function that brings float32 (h, w, 3) from a colour space of Blender's configuration to scene-linear colours;
    None where this Blender has no module for it (Debian's 3.4)."""
    python = f"python{sys.version_info[0]}.{sys.version_info[1]}"
    folder = bpy.utils.system_resource("PYTHON")  # where the bpy module does not look
    bundled = os.path.join(folder, "lib", python, "site-packages")
    sys.path.append(bundled)
    try:
        import PyOpenColorIO as ocio
    except ImportError:
        return None
    finally:
        sys.path.remove(bundled)
    config = ocio.Config.CreateFromFile(os.path.join(bpy.utils.system_resource("DATAFILES"), "colormanagement",
                                                     "config.ocio"))
    processor = config.getProcessor(space, "scene_linear").getDefaultCPUProcessor()

    def convert(colors: np.ndarray) -> np.ndarray:
        made = np.array(colors, np.float32)
        processor.applyRGB(made.reshape(-1, 3))
        return made

    return convert


def bump_filter(node) -> float:
    """How many footprints of a pixel a Bump node looks to the side: its Filter Width, one before 4.2."""
    socket = node.inputs.get("Filter Width")
    return max(float(socket.default_value), 1e-3) if socket is not None else 1.0


def terminator_offset(ob, kind: str) -> float:
    """An object's shadow terminator offset, of kind "geometry" or "shading"; Cycles' own property before 4.1."""
    name, default = {"geometry": ("shadow_terminator_geometry_offset", 0.1),
                     "shading": ("shadow_terminator_shading_offset", 0.0)}[kind]
    older = getattr(ob, "cycles", None)
    if hasattr(ob, name):
        return getattr(ob, name)
    return getattr(older, name.replace("_shading", ""), default)


def is_diced(ob) -> bool:
    """Whether Cycles would subdivide an object by how large the camera sees it: of its modifier since 5.0."""
    owners = (getattr(ob, "cycles", None), *ob.modifiers[-1:])
    return any(getattr(owner, "use_adaptive_subdivision", False) for owner in owners)


def displacement_method(material) -> str:
    """BUMP, DISPLACEMENT or BOTH: what Cycles makes of a material's displacement; Cycles' own property before 4.1."""
    for owner in (material, getattr(material, "cycles", None)):
        method = getattr(owner, "displacement_method", None)
        if method is not None:
            return {"TRUE": "DISPLACEMENT"}.get(method, method)
    return "BUMP"


def aov_name(node) -> str:
    """Of an AOV Output node, which before 4.2 bears the name itself."""
    return getattr(node, "aov_name", node.name)


# ---- the render engine and its panels (addon/*.py) ----------------------------------------------


def frame_border(render, resolution) -> tuple[int, int, int, int]:
    """The part of the frame that is rendered, x0, y0, x1, y1 in pixels from the lower left, cut as Blender cuts it.

    Blender multiplies in float32 and drops the fraction (RE_InitState, all versions so far).
    """
    width, height = (int(n) for n in resolution)
    if not render.use_border:
        return 0, 0, width, height
    ends = np.array([render.border_min_x, render.border_min_y, render.border_max_x, render.border_max_y], np.float32)
    x0, y0, x1, y1 = (ends * np.array([width, height, width, height], np.float32)).astype(int).tolist()
    return x0, y0, x1, y1


# Since 5.0 passes have the names that panels show; in files, too.
PASS_NAMES = {
    **{f"{short}{of}": f"{kind} {word}" for short, kind in (("Diff", "Diffuse"), ("Gloss", "Glossy"),
                                                            ("Trans", "Transmission"))
       for of, word in (("Dir", "Direct"), ("Ind", "Indirect"), ("Col", "Color"))},
    "IndexOB": "Object Index",
    "IndexMA": "Material Index",
    "Emit": "Emission",
    "Env": "Environment",
    "AO": "Ambient Occlusion",
}


def pass_name(name: str) -> str:
    """What this Blender calls a pass of Blender 4's name."""
    return PASS_NAMES.get(name, name) if bpy.app.version >= (5, 0, 0) else name


def set_pass(render_pass, values: np.ndarray) -> None:
    """Copy float32 (h, w, c) into a pass: flat for newer versions, (h w, c) for those before 4.0."""
    values = np.ascontiguousarray(values, np.float32)
    flat = bpy.app.version >= (4, 0, 0)
    render_pass.rect.foreach_set(values.ravel() if flat else values.reshape(-1, values.shape[-1]))


def shadow_switch(light):
    """(owner, name) of the switch for a lamp's shadow, None where this version has none."""
    cycles = getattr(light, "cycles", None)
    if hasattr(cycles, "cast_shadow"):
        return cycles, "cast_shadow"
    return (light, "use_shadow") if hasattr(light, "use_shadow") else None


_interrupt = threading.Event()


@contextmanager
def catch_interrupts():
    """Ctrl-C ends a render in good order in the bpy module too, where Blender has no handler for it."""
    _interrupt.clear()
    if bpy.app.binary_path or threading.current_thread() is not threading.main_thread():
        yield  # the program turns Ctrl-C into RenderEngine.test_break
        return
    before = signal.signal(signal.SIGINT, lambda *_: _interrupt.set())
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def interrupted() -> bool:
    """Whether Ctrl-C was pressed since catch_interrupts began."""
    return _interrupt.is_set()
