# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's evaluated scene as a Scene of flat numpy arrays. bpy ends here."""

from __future__ import annotations

import numpy as np

from isophote.material_program import join_materials
from isophote.scene import Scene, make_scene

from .attributes import join_attributes
from .camera import camera_of, export_camera, resolution_of, view_of
from .changes import Changes, Meshes, OthersMet
from .instances import LINK, Gatherer
from .light import join_lights
from .motion import follows_motion, middle_of_shutter, with_motion
from .moving import identities
from .notes import Notes
from .world import export_world, mist_of, occlusion_distance_of

__all__ = ["export_scene", "follows_motion", "middle_of_shutter", "seen_from"]


def export_scene(depsgraph, *, resolution: tuple[int, int] | None = None, camera=None,
                 changes: Changes | None = None, frame: int | None = None) -> Scene:
    """Everything that the dependency graph shows, as a Scene with the names of things and notes.

    `depsgraph` is evaluated for rendering (as RenderEngine.render gets it) or for the viewport; its
    view layer is the one exported. `resolution` (width, height in pixels) and `camera` (an Object)
    stand in for the scene's own, `frame` for its frame as far as pictures go. `changes` belongs to the engine and saves
    reading meshes again that its dependency graph has not evaluated anew. Raises SceneError, naming the scene, where
    there is no camera.
    """
    changes = changes or Changes()
    before = changes.unchanged_meshes(depsgraph)
    try:
        meshes = Meshes(before)
        scene = export_with(meshes, depsgraph, resolution, camera, frame)
    except OthersMet:
        meshes = Meshes()
        scene = export_with(meshes, depsgraph, resolution, camera, frame)
    changes.exported(meshes)
    return scene


def seen_from(scene: Scene, engine, depsgraph, view: str = "") -> Scene:
    """The exported scene as the engine's active view, of this name, sees it while the shutter is open: all but the
    camera stays."""
    notes, arrays = Notes(), {}
    if view:
        camera = camera_of(engine, depsgraph)
        seen = view_of(engine, camera, view)
        arrays = export_camera(depsgraph.scene_eval, camera, scene.resolution, notes, seen, scene.origin)
    arrays |= with_motion(scene, engine, depsgraph, view, notes)
    made = make_scene(scene.names, scene.notes, **scene.arrays | arrays)
    made.notes += [note for note in notes.entries if note not in made.notes]
    return made


def export_with(meshes: Meshes, depsgraph, resolution, camera, frame) -> Scene:
    """As export_scene. Raises OthersMet where the meshes are those of an export before, and others are there now."""
    notes = Notes()
    scene = depsgraph.scene_eval
    camera = camera or scene.camera
    if camera is not None:
        camera = camera.evaluated_get(depsgraph)
    resolution = resolution or resolution_of(scene.render)
    arrays = export_camera(scene, camera, resolution, notes)
    gatherer = Gatherer(depsgraph, arrays["origin"], notes, meshes, scene.frame_current if frame is None else frame)
    gatherer.gather()
    materials = list(gatherer.material_names)  # of objects
    world = export_world(scene, notes, gatherer.lookups)
    arrays |= {"world_radiance": world.radiance, "world_hidden": world.hidden}
    if world.program:
        arrays["world_material"] = [gatherer.add_program(world.program, scene.world.name)]
        arrays["world_sun"] = world.sun
    if world.volume:
        arrays["world_volume"] = gatherer.add_program(world.volume, scene.world.name) + 1
    arrays |= meshes.join() | join_lights(gatherer.lamps, gatherer.add_program)
    arrays |= join_instances(gatherer) | join_spheres(gatherer.spheres) | join_materials(gatherer.programs)
    for group, linked in (("instance", gatherer.instances), ("sphere", gatherer.spheres)):
        arrays |= gatherer.linking.arrays(group, [each[LINK] for each in linked])
    arrays |= gatherer.linking.arrays("light", [lamp.link for lamp in gatherer.lamps])
    arrays |= gatherer.lookups.arrays() | gatherer.instance_values()
    arrays |= {"material_volume": [gatherer.volume_of.get(k, -1) + 1 for k in range(len(gatherer.programs))],
               "material_index": np.array(gatherer.material_indices, np.float32), "mist": mist_of(scene.world),
               "world_group": gatherer.light_groups.of(scene.world),
               "occlusion_distance": occlusion_distance_of(scene.world),
               "uv_attribute": [] if gatherer.uv is None else [gatherer.uv]}
    if gatherer.lookups.attributes:
        arrays |= join_attributes(list(gatherer.lookups.attributes), meshes.attributes)
    names = {
        "meshes": list(meshes.names),
        "instances": [instance[4] for instance in gatherer.instances],
        "spheres": [sphere[4] for sphere in gatherer.spheres],
        "materials": gatherer.material_names,
        "lights": [lamp.name for lamp in gatherer.lamps],
        "aovs": list(gatherer.aovs) if gatherer.programs else [],
        "light_groups": list(gatherer.light_groups.names),
        "assets": sorted(set(gatherer.mattes.assets.values())),
    }
    arrays |= gatherer.mattes.arrays(names["instances"], names["spheres"], materials,
                                      len(gatherer.programs) - len(materials))
    made = make_scene(names, notes.entries, **arrays)
    if follows_motion(depsgraph):
        made.identities = identities(depsgraph, [instance[0] for instance in gatherer.instances])
    if not gatherer.displacements:
        return made
    from isophote.displace import displaced  # the add-on loads without the native module, to say what is wrong

    return displaced(made, gatherer.displacements, meshes.flat_normals)


def join_instances(gatherer: Gatherer) -> dict[str, np.ndarray]:
    if not gatherer.instances:
        return {}
    numbers, meshes, slots, visibility, _, indices, groups, _, terminators = zip(*gatherer.instances, strict=True)
    matrices = gatherer.matrices[list(numbers), :3]
    matrices[:, :, 3] -= gatherer.origin
    return {
        "instance_mesh": np.array(meshes, np.uint32),
        "instance_to_world": matrices,
        "instance_slots": np.array(slots, np.uint32),
        "instance_visibility": np.array(visibility, np.uint32),
        "instance_index": np.array(indices, np.float32),
        "instance_terminator": np.array(terminators, np.float32),
        "instance_group": np.array(groups, np.uint32),
        "slot_materials": np.array(gatherer.slots, np.uint32),
    }


def join_spheres(spheres: list[tuple]) -> dict[str, np.ndarray]:
    if not spheres:
        return {}
    centres, radii, materials, visibility, _, indices, groups, _ = zip(*spheres, strict=True)
    return {
        "sphere_center": np.stack(centres),
        "sphere_radius": np.array(radii, np.float64),
        "sphere_material": np.array(materials, np.uint32),
        "sphere_visibility": np.array(visibility, np.uint32),
        "sphere_index": np.array(indices, np.float32),
        "sphere_group": np.array(groups, np.uint32),
    }
