"""The one place that says what is wrong with a scene. Kernels trust what passed.

`validate` names every problem; `clean` drops what a render can do without (non-finite or zero-area
triangles, instances, spheres, lights) and says so. What is left of severity "error" stops the render.
"""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import dataclass, replace

import numpy as np

from isophote.check_motion import mark_bad_shapes, motion_errors
from isophote.flatten import flattened, instance_ranks, without_motion
from isophote.materials import OPERATIONS
from isophote.records import numbers
from isophote.scene import Scene
from isophote.strands import bad_segments, strand_errors, stranded
from isophote.values import operations
from isophote.volumes import asks_for_surfaces, is_deeply_nested

LIGHT_KINDS = 5  # point, spot, sun, rectangle, ellipse: those that a scene may hold


@dataclass(frozen=True)
class Problem:
    """`severity` is "error" (no render), "dropped" (clean leaves the thing out) or "warning"; `thing` names it."""

    severity: str
    thing: str
    what: str

    def __str__(self):
        return f"{self.thing}: {self.what}"


@dataclass
class Bad:
    """What clean leaves out of a scene: masks of its triangles, instances, spheres and lights."""

    triangles: np.ndarray
    instances: np.ndarray
    spheres: np.ndarray
    lights: np.ndarray
    ranks: np.ndarray  # of the instances' matrices (flatten.py)


def find_bad(scene: Scene) -> Bad:
    """A matrix of an instance is bad if it is not finite (in float32 too) or scales everything to a line or a point.

    One zero scale is no reason: a flat mesh squashed along its normal is still there.
    """
    ranks = instance_ranks(scene)
    return Bad(bad_triangles(scene), ranks < 2, bad_spheres(scene), bad_lights(scene), ranks)


def validate(scene: Scene) -> list[Problem]:
    """Every problem of a scene, errors first."""
    return check(scene)[0]


def clean(scene: Scene) -> tuple[Scene, list[dict]]:
    """The scene without what validate calls "dropped", and notes {"kind", "name", "what"} on it.

    Expects a scene without errors. Instances squashed flat become meshes of their own (flatten.py);
    instances of meshes without triangles go too, without a word. The same scene comes back where
    there is nothing to do.
    """
    return cleaned(scene, find_bad(scene))


def check(scene: Scene) -> tuple[list[Problem], Scene, list[dict]]:
    """(validate's problems, clean's scene and notes), looking at everything once; the scene itself after an error."""
    problems = camera_problems(scene) + (index_problems(scene) or material_problems(scene))
    notes: list[dict] = []
    if not any(problem.severity == "error" for problem in problems):  # the rest indexes with what was just checked
        bad = find_bad(scene)
        problems += geometry_problems(scene, bad) + light_problems(scene, bad) + world_problems(scene)
        if not any(problem.severity == "error" for problem in problems):
            scene, notes = cleaned(scene, bad)
            problems += volume_problems(scene)
    order = {"error": 0, "dropped": 1, "warning": 2}
    return sorted(problems, key=lambda problem: order[problem.severity]), scene, notes


def volume_problems(scene: Scene) -> list[Problem]:
    """Of a scene that was cleaned: what they lie in has to be finite."""
    if not is_deeply_nested(scene):
        return []
    return [Problem("warning", "scene", f"more than {numbers()['MOST_VOLUMES']} volumes may lie in each other: where "
                                        "that is so, the first ones count")]


def cleaned(scene: Scene, bad: Bad) -> tuple[Scene, list[dict]]:
    whole, scene = scene, flattened(scene, bad.ranks)
    if scene is not whole:
        bad = find_bad(scene)
    notes = [{"kind": "geometry", "name": problem.thing, "what": problem.what}
             for problem in geometry_problems(scene, bad) + light_problems(scene, bad) if problem.severity == "dropped"]
    counts = np.diff(scene.mesh_triangles.astype(np.int64)) - bad_of_meshes(scene, bad)
    instances = bad.instances | (counts[scene.instance_mesh] == 0)
    if scene is whole and not notes and not instances.any():
        return scene, []
    arrays, names = dict(without_motion(scene, instances).arrays), dict(scene.names)
    drop_attributes(arrays, bad.triangles)
    drop_triangles(arrays, bad.triangles)
    drop_rows(arrays, names, "instances", "instance_", instances)
    drop_rows(arrays, names, "spheres", "sphere_", bad.spheres)
    drop_rows(arrays, names, "lights", "light_", bad.lights)
    return replace(scene, arrays=arrays, names=names), notes


def bad_of_meshes(scene: Scene, bad: Bad) -> np.ndarray:
    """How many triangles of each mesh (M) are bad."""
    return np.diff(np.searchsorted(np.flatnonzero(bad.triangles), scene.mesh_triangles))


def drop_rows(arrays: dict, names: dict, group: str, prefix: str, bad: np.ndarray) -> None:
    if not bad.any():
        return
    for name in arrays:
        if name.startswith(prefix) and len(arrays[name]):
            arrays[name] = arrays[name][~bad]
    if names.get(group):
        names[group] = [name for name, is_bad in zip(names[group], bad, strict=False) if not is_bad]


def drop_attributes(arrays: dict, bad: np.ndarray) -> None:
    """Of attributes by triangle or corner, leave out the values of triangles that go."""
    n = numbers()
    per_triangle = {n["DOMAIN_TRIANGLE"]: 1, n["DOMAIN_CORNER"]: 3}
    if not bad.any() or not arrays["mesh_attributes"].size:
        return
    made = arrays["mesh_attributes"] = arrays["mesh_attributes"].copy()
    gone = np.zeros(len(arrays["attribute_values"]), bool)
    for mesh, number in np.argwhere(np.isin(made[:, :, 1], list(per_triangle))).tolist():
        first, domain, components = made[mesh, number].tolist()
        rows = np.repeat(bad[arrays["mesh_triangles"][mesh]:arrays["mesh_triangles"][mesh + 1]],
                         per_triangle[domain] * components)
        gone[first:first + len(rows)] = rows
    made[:, :, 0] -= np.concatenate([[0], np.cumsum(gone)])[made[:, :, 0]].astype(np.uint32)
    arrays["attribute_values"] = arrays["attribute_values"][~gone]


def drop_triangles(arrays: dict, bad: np.ndarray) -> None:
    """Leave out triangles, keeping the numbers of meshes and vertices."""
    if not bad.any():
        return
    first = arrays["mesh_triangles"].astype(np.int64)
    arrays["mesh_triangles"] = np.concatenate([[0], np.cumsum(~bad)])[first].astype(np.uint32)
    arrays["triangles"] = arrays["triangles"][~bad]
    if len(arrays["triangle_slots"]):
        arrays["triangle_slots"] = arrays["triangle_slots"][~bad]


def camera_problems(scene: Scene) -> list[Problem]:
    problems = []
    if not scene.camera_to_world.any():
        return [Problem("error", "camera", "the scene has no camera")]
    width, height = scene.resolution
    if width < 1 or height < 1:
        problems.append(Problem("error", "resolution", f"{width} x {height} pixels"))
    if not 0 <= scene.camera_kind < numbers()["CAMERA_KINDS"]:
        problems.append(Problem("error", "camera", f"kind {int(scene.camera_kind)} is not known"))
    for name in ("camera_to_world", "camera_window", "camera_clip", "camera_lens", "camera_panorama", "camera_stereo",
                 "camera_poses", "shutter_curve", "origin"):
        if not np.isfinite(scene.arrays[name]).all():
            problems.append(Problem("error", "camera", f"{name} is not finite"))
    if problems:
        return problems
    axes = scene.camera_to_world[:, :3]
    left, right, bottom, top = scene.camera_window
    if np.abs(axes.T @ axes - np.eye(3)).max() > 1e-3:
        problems.append(Problem("error", "camera", "camera_to_world is not rigid"))
    elif len(scene.camera_poses) == 1 or (scene.shutter_curve < 0.0).any():
        problems.append(Problem("error", "camera", "it has one pose alone to move by, or a negative shutter curve"))
    elif scene.camera_lens[0] > 0 and not (scene.camera_lens[[1, 4]] > 0).all():
        problems.append(Problem("error", "camera", "its lens has no distance in focus, or no ratio"))
    elif scene.camera_kind >= numbers()["CAMERA_EQUIRECTANGULAR"]:
        problems += panorama_problems(scene)
    elif not (right > left and top > bottom):
        problems.append(Problem("error", "camera", "its window is empty"))
    return problems


def panorama_problems(scene: Scene) -> list[Problem]:
    n = numbers()
    left, right, bottom, top = scene.camera_window  # may be mirrored
    if right == left or top == bottom:
        return [Problem("error", "camera", "its window is empty")]
    if scene.camera_kind == n["CAMERA_POLYNOMIAL"] and scene.camera_panorama[2] == 0.0:
        return [Problem("error", "camera", "its polynomial has no linear term")]
    if scene.camera_kind >= n["CAMERA_MIRROR_BALL"] and not scene.camera_panorama[0] > 0.0:
        return [Problem("error", "camera", "its fisheye lens sees nothing")]
    return []


def index_problems(scene: Scene) -> list[Problem]:
    """Every index against what it points into; the thing that owns the first wrong one is named."""
    a, problems = scene.arrays, []

    def inside(group, array, end, into, owner=lambda row: row):
        values = np.atleast_1d(a[array])
        if values.size and int(values.max()) >= end:
            row = int(np.argmax(values.reshape(len(values), -1).max(axis=1)))
            problems.append(Problem("error", scene.name_of(group, owner(row)),
                                    f"{array} points to {into} {int(values.max())} of {end}"))

    def ascending(group, array, end):
        values = a[array].astype(np.int64)
        if values[0] != 0 or values[-1] != end or (np.diff(values) < 0).any():
            problems.append(Problem("error", group, f"{array} does not ascend from 0 to {end}"))

    def mesh_of(triangle):
        return int(np.searchsorted(a["mesh_triangles"], triangle, side="right")) - 1

    ascending("meshes", "mesh_triangles", len(a["triangles"]))
    ascending("materials", "material_first", len(a["instruction_op"]))
    ascending("materials", "material_steps", len(a["step_op"]))
    ascending("meshes", "mesh_vertices", len(a["vertices"]))
    inside("meshes", "triangles", len(a["vertices"]), "vertex", mesh_of)
    if len(a["triangle_slots"]) not in (0, len(a["triangles"])):
        what = f"{len(a['triangle_slots'])} slots for {len(a['triangles'])} triangles"
        problems.append(Problem("error", "meshes", what))
    inside("instances", "instance_mesh", len(a["mesh_normals"]), "mesh")
    inside("slots", "slot_materials", len(a["material_first"]) - 1, "material")
    inside("spheres", "sphere_material", len(a["material_first"]) - 1, "material")
    inside("worlds", "world_material", len(a["material_first"]) - 1, "material")
    inside("instances", "instance_sets", numbers()["MOST_SETS"], "set of linked objects")
    inside("spheres", "sphere_sets", numbers()["MOST_SETS"], "set of linked objects")
    inside("lights", "light_material", len(a["material_first"]), "material")
    inside("materials", "material_volume", len(a["material_first"]), "material")
    inside("worlds", "world_volume", len(a["material_first"]), "material")
    problems += [Problem("error", scene.name_of(group, index), what) for group, index, what in motion_errors(scene)]
    if problems:
        return problems
    counts = np.diff(a["mesh_triangles"].astype(np.int64))
    first = a["mesh_vertices"].astype(np.int64)
    smooth_end = a["mesh_normals"].astype(np.int64) + np.diff(first)
    outside = (a["mesh_normals"] >= 0) & (smooth_end > len(a["normals"]))
    for mesh in np.flatnonzero(outside | (a["mesh_normals"] < -1)):
        problems.append(Problem("error", scene.name_of("meshes", mesh), "its normals lie outside the array"))
    low, high = vertices_used(a, counts)
    for mesh in np.flatnonzero((counts > 0) & ((low < first[:-1]) | (high >= first[1:]))):
        problems.append(Problem("error", scene.name_of("meshes", mesh), "its triangles have vertices of other meshes"))
    slots = slots_used(a, counts)[a["instance_mesh"]] + a["instance_slots"].astype(np.int64)
    for instance in np.flatnonzero((counts[a["instance_mesh"]] > 0) & (slots > len(a["slot_materials"]))):
        problems.append(Problem("error", scene.name_of("instances", instance),
                                f"its material slots reach {slots[instance]} of {len(a['slot_materials'])}"))
    if not problems:
        problems = [Problem("error", scene.name_of(group, index), what) for group, index, what in strand_errors(scene)]
    return problems


def slots_used(arrays: dict, counts: np.ndarray) -> np.ndarray:
    """Material slots of each mesh: the highest that its triangles use, plus 1; 0 for an empty mesh."""
    used, full = (counts > 0).astype(np.int64), counts > 0
    if full.any() and len(arrays["triangle_slots"]):
        starts = arrays["mesh_triangles"][:-1][full].astype(np.int64)
        used[full] = np.maximum.reduceat(arrays["triangle_slots"], starts) + np.int64(1)
    return used


def vertices_used(arrays: dict, counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest vertex of each mesh's triangles, 0 for an empty mesh."""
    full, low, high = counts > 0, np.zeros(len(counts), np.int64), np.zeros(len(counts), np.int64)
    if full.any():
        starts = 3 * arrays["mesh_triangles"][:-1][full].astype(np.int64)
        corners = arrays["triangles"].reshape(-1)
        low[full], high[full] = np.minimum.reduceat(corners, starts), np.maximum.reduceat(corners, starts)
    return low, high


def material_problems(scene: Scene) -> list[Problem]:
    ops, problems = scene.instruction_op, []
    owner = owner_of_rows(scene, "material_first")
    known = np.isin(ops, [number for number, _ in OPERATIONS.values()])
    for row in np.flatnonzero(~known)[:10]:
        problems.append(Problem("error", owner(row), f"operation {ops[row]} is not known"))
    finite = np.isfinite(scene.instruction_params).all(axis=1) & np.isfinite(scene.instruction_weight).all(axis=1)
    for row in np.flatnonzero(~finite)[:10]:
        problems.append(Problem("error", owner(row), "a constant is not finite"))
    counts = np.diff(np.cumsum([0, *(ops != OPERATIONS["emission"][0])])[scene.material_first.astype(np.int64)])
    for material in np.flatnonzero(counts > numbers()["MOST_INSTRUCTIONS"]):
        what = f"{counts[material]} closures and layers, {numbers()['MOST_INSTRUCTIONS']} are possible"
        problems.append(Problem("error", scene.name_of("materials", material), what))
    return problems or value_problems(scene)


def owner_of_rows(scene: Scene, starts: str):
    """Names the material to which a row of instructions or steps belongs."""
    return lambda row: scene.name_of("materials", int(np.searchsorted(scene.arrays[starts], row, side="right")) - 1)


def value_problems(scene: Scene) -> list[Problem]:
    """Steps, and instructions that read their registers: what they name must be there."""
    n, steps = numbers(), len(scene.step_op)
    known = np.isin(scene.step_op, [each.number for each in operations().values()])
    outputs = {each.number: each.outputs for each in operations().values()}
    ends = scene.step_to + np.array([outputs.get(op, 0) for op in scene.step_op.tolist()], np.int64)
    rows = {"an operation on values is not known": ~known,
            "a step names a register that there is not": (ends > n["MOST_REGISTERS"])
            | (scene.step_from >= n["MOST_REGISTERS"]).any(axis=1),
            "a step's constant is not finite": ~np.isfinite(scene.step_number),
            "a step reads what there is not": data_outside(scene)}
    owner = owner_of_rows(scene, "material_steps")
    problems = [Problem("error", owner(row), what)
                for what, wrong in rows.items() for row in np.flatnonzero(wrong)[:10]]
    counts = np.diff(scene.material_steps.astype(np.int64))
    for material in np.flatnonzero(scene.material_shadow_steps > counts):
        problems.append(Problem("error", scene.name_of("materials", material), "more steps for shadows than steps"))
    reading = scene.instruction_flags & n["INSTRUCTION_VARIES"] != 0
    highest = int(ends.max(initial=0)) if steps else 0
    named = np.concatenate([scene.instruction_weight, scene.instruction_params], axis=1)
    outside = reading & ((named < 0) | (named >= highest)).any(axis=1)
    owner = owner_of_rows(scene, "material_first")
    problems += [Problem("error", owner(row), "a closure names a register that nothing writes")
                 for row in np.flatnonzero(outside)[:10]]
    problems += [Problem("error", scene.name_of("materials", material), "as a volume it asks for what surfaces have")
                 for material in (asks_for_surfaces(scene) if not problems else ())]
    wrong = ~np.isfinite(scene.aov_values).all(-1)
    wrong |= (scene.aov_flags & n["AOV_VARIES"] != 0) & ((scene.aov_values < 0) | (scene.aov_values >= highest)).any(-1)
    what = "an AOV output is not finite, or names a register that nothing writes"
    problems += [Problem("error", scene.name_of("materials", row), what) for row in np.flatnonzero(wrong.any(-1))[:10]]
    if len(scene.aovs) != scene.aov_values.shape[1]:
        problems.append(Problem("error", "scene", f"{len(scene.aovs)} names of {scene.aov_values.shape[1]} AOVs"))
    return problems + table_problems(scene)


def data_outside(scene: Scene) -> np.ndarray:
    """Mask (Z) of steps that name an attribute, an image or an entry of the tables that there is not."""
    attributes = scene.mesh_attributes.shape[1]
    lengths = {"attribute": attributes, "attribute_at": attributes, "image": len(scene.images),
               "instance_value": scene.instance_values.shape[1]}
    outside = np.zeros(len(scene.step_op), bool)
    for name, length in lengths.items():
        if name in operations():
            outside |= (scene.step_op == operations()[name].number) & (scene.step_data >= length)
    for row in np.flatnonzero(scene.step_op == operations()["tiled_image"].number):
        outside[row] = tiles_outside(scene, int(scene.step_data[row]))
    for name in ("table", "table_extended", "table_stepped"):
        end = scene.step_data + scene.step_number.astype(np.float64)
        fits = (scene.step_number >= 2.0) & (end <= len(scene.value_tables))
        outside |= (scene.step_op == operations()[name].number) & ~fits
    return outside


def tiles_outside(scene: Scene, first: int) -> bool:
    """Whether the numbers of a tiled image, from `first` on in value_tables, are not there or name no image."""
    table = scene.value_tables[first:]
    if not len(table) or not 1 <= table[0] < len(table):
        return True
    images = table[1:1 + int(table[0])]
    return not ((images >= 0) & (images < len(scene.images))).all()


def table_problems(scene: Scene) -> list[Problem]:
    """Attributes and images against the arrays that hold their values."""
    n, problems = numbers(), []
    a = scene.mesh_attributes.astype(np.int64)
    vertices, triangles = (np.diff(scene.arrays[name].astype(np.int64)) for name in ("mesh_vertices", "mesh_triangles"))
    counts = np.stack([0 * triangles, 1 + 0 * triangles, vertices, triangles, 3 * triangles], axis=1)  # by domain
    known = (a[:, :, 1] <= n["DOMAIN_CORNER"]) & (a[:, :, 2] <= 4) & ((a[:, :, 2] > 0) | (a[:, :, 1] == 0))
    ends = a[:, :, 0] + a[:, :, 2] * np.take_along_axis(counts, np.minimum(a[:, :, 1], n["DOMAIN_CORNER"]), axis=1)
    for mesh in np.flatnonzero((~known | (ends > len(scene.attribute_values))).any(axis=1)):
        problems.append(Problem("error", scene.name_of("meshes", mesh), "an attribute's values lie outside the array"))
    sizes = {n["TEXEL_BYTE"]: 1, n["TEXEL_SHORT"]: 2, n["TEXEL_HALF"]: 2, n["TEXEL_FLOAT"]: 4}
    i = scene.images.astype(np.int64)
    fits = (i[:, 0] >= 0) & (i[:, 1:3] > 0).all(axis=1) & np.isin(i[:, 3], (1, 3, 4))
    size = np.array([sizes.get(kind, 0) for kind in i[:, 4].tolist()], np.int64)
    end = 4 * i[:, 0] + i[:, 1] * i[:, 2] * i[:, 3] * size
    for image in np.flatnonzero(~fits | (size == 0) | (end > len(scene.image_texels))):
        problems.append(Problem("error", scene.name_of("images", image), "its pixels lie outside the array"))
    if len(scene.instance_values) not in (0, len(scene.instance_mesh)):
        problems.append(Problem("error", "instances", "there is not one row of values for each"))
    return problems


def bad_triangles(scene: Scene) -> np.ndarray:
    """Mask (T): a vertex or normal that is not finite, no area, or a length whose square overflows float32."""
    from isophote import _native  # a scene with errors can be told without it

    bad, threads = np.empty(len(scene.triangles), np.uint8), os.cpu_count() or 1
    _native.find_bad_triangles(scene.vertices, scene.triangles, threads, bad)
    bad = bad.view(bool)
    mark_bad_shapes(scene, bad)
    for mesh in np.flatnonzero(stranded(scene)):
        bad[scene.mesh_triangles[mesh]:scene.mesh_triangles[mesh + 1]] = bad_segments(scene, mesh)
    if not _native.all_finite(scene.normals.reshape(-1), threads):
        bad |= bad_normals(scene)
    return bad


def bad_normals(scene: Scene) -> np.ndarray:
    """Mask (T): a normal that is not finite."""
    wrong, bad = ~np.isfinite(scene.normals).all(axis=1), np.zeros(len(scene.triangles), bool)
    for mesh in np.flatnonzero(scene.mesh_normals >= 0):
        own = slice(scene.mesh_triangles[mesh], scene.mesh_triangles[mesh + 1])
        to_normal = int(scene.mesh_normals[mesh]) - int(scene.mesh_vertices[mesh])
        bad[own] = wrong[scene.triangles[own].astype(np.int64) + to_normal].any(axis=1)
    return bad


def bad_spheres(scene: Scene) -> np.ndarray:
    with np.errstate(invalid="ignore", over="ignore"):
        return ~(np.isfinite(scene.sphere_center.astype(np.float32)).all(axis=1)
                 & (scene.sphere_radius.astype(np.float32) > 0.0) & np.isfinite(scene.sphere_radius.astype(np.float32)))


def bad_lights(scene: Scene) -> np.ndarray:
    finite = [np.isfinite(scene.arrays[name]).all(axis=tuple(range(1, scene.arrays[name].ndim)))
              for name in ("light_to_world", "light_strength", "light_size", "light_spot", "light_spread")]
    return ~np.logical_and.reduce(finite)


def geometry_problems(scene: Scene, bad: Bad) -> list[Problem]:
    """What clean drops of triangles, instances and spheres: counted for each mesh, named for each other thing."""
    counts, totals = bad_of_meshes(scene, bad), np.diff(scene.mesh_triangles)
    problems = [Problem("dropped", scene.name_of("meshes", mesh),
                        f"{counts[mesh]} of {totals[mesh]} triangles have no area, or are too large or not finite")
                for mesh in np.flatnonzero(counts)]
    problems += dropped(scene, "instances", bad.instances, "its matrix is not finite, or scales it to nothing")
    problems += dropped(scene, "spheres", bad.spheres, "not finite, or its radius is not above 0")
    return problems


def dropped(scene: Scene, group: str, bad: np.ndarray, what: str) -> list[Problem]:
    """A problem for each name: instances share theirs by the thousand."""
    counts = Counter(scene.name_of(group, index) for index in np.flatnonzero(bad))
    return [Problem("dropped", name, what + (f" ({count} of that name)" if count > 1 else ""))
            for name, count in counts.items()]


def light_problems(scene: Scene, bad: Bad) -> list[Problem]:
    problems = [Problem("error", scene.name_of("lights", index), f"light kind {scene.light_kind[index]} is not known")
                for index in np.flatnonzero((scene.light_kind < 0) | (scene.light_kind >= LIGHT_KINDS))]
    problems += dropped(scene, "lights", bad.lights, "its place, strength or size is not finite")
    return problems


def world_problems(scene: Scene) -> list[Problem]:
    problems = []
    if len(scene.world_material) > 1:
        problems.append(Problem("error", "world", f"{len(scene.world_material)} materials where there is room for one"))
    if not np.isfinite(scene.world_radiance).all():
        problems.append(Problem("error", "world", "its radiance is not finite"))
    directions, halves = scene.world_sun[:, :3], scene.world_sun[:, 3]
    if len(halves) > 1 or not (np.abs(np.linalg.norm(directions, axis=1) - 1.0) < 1e-5).all():
        problems.append(Problem("error", "world", "its sun is not one unit direction"))
    elif not ((halves > 0.0) & (halves <= np.pi / 2)).all():
        problems.append(Problem("error", "world", "its sun's half angle is not above 0 and up to 90 degrees"))
    if not np.isfinite(scene.mist).all():
        problems.append(Problem("error", "world", "its mist is not finite"))
    if len(scene.uv_attribute) > 1 or (scene.uv_attribute >= scene.mesh_attributes.shape[1]).any():
        problems.append(Problem("error", "scene", f"its UV pass shows attribute {scene.uv_attribute.tolist()}, of "
                                                  f"{scene.mesh_attributes.shape[1]}"))
    most = len(scene.names.get("light_groups", ()))
    of_lights = scene.light_flags >> numbers()["LIGHT_GROUP_SHIFT"]
    groups = {"instances": scene.instance_group, "spheres": scene.sphere_group, "lights": of_lights,
              "worlds": np.atleast_1d(scene.world_group)}
    problems += [Problem("error", scene.name_of(name, index), f"is in light group {of[index]} of {most}")
                 for name, of in groups.items() for index in np.flatnonzero(of > most)[:10]]
    for group in ("instances", "spheres", "materials"):
        for index in np.flatnonzero(~np.isfinite(scene.arrays[f"{group.removesuffix('s')}_index"])):
            problems.append(Problem("error", scene.name_of(group, index), "its pass index is not finite"))
    dark = not (scene.world_radiance.any() or len(scene.world_material))
    if not len(scene.instance_mesh) and not len(scene.sphere_radius):
        black = ", and the world is black" if dark else ""
        problems.append(Problem("warning", "scene", f"it is empty: only the world is rendered{black}"))
    elif dark and not len(scene.light_kind) and not (scene.instruction_op == OPERATIONS["emission"][0]).any():
        problems.append(Problem("warning", "scene", "nothing gives light: no lamp, no world, no material that emits"))
    return problems
