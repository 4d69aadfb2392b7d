# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects and instances: what the dependency graph shows, each mesh once, each appearance an instance.

Collections, vertices, faces, particles and geometry nodes all arrive through
depsgraph.object_instances, so that there is one loop for everything.
"""

from __future__ import annotations

import numpy as np

from isophote.material_program import MaterialProgram
from isophote.records import numbers

from .aovs import aovs_of
from .changes import Meshes
from .instance_values import KINDS, instance_values, property_value
from .light import Lamp, export_light
from .light_groups import LightGroups
from .lookups import Lookups
from .material import material_program
from .volume import material_volume

RAYS = (("visible_camera", 1), ("visible_diffuse", 2), ("visible_glossy", 4), ("visible_transmission", 8),
        ("visible_shadow", 16))  # RAY_ bits of kernels/scene_records.h
RAY_CAMERA = 1

# Curves, surfaces and text come a second time, as instances of the meshes that they evaluate to.
WITH_MESH = {"MESH", "META"}
LEFT_OUT = {
    "CURVES": "hair curves are not supported: left out",
    "POINTCLOUD": "point clouds are not supported: left out",
    "VOLUME": "volume objects are not supported: left out",
    "GPENCIL": "grease pencil is not supported: left out",
    "GREASEPENCIL": "grease pencil is not supported: left out",
}


class Gatherer:
    """Collects meshes, instances, spheres, materials and lamps while the dependency graph is walked."""

    def __init__(self, depsgraph, origin: np.ndarray, notes, meshes: Meshes):
        self.depsgraph, self.origin, self.notes, self.meshes = depsgraph, origin, notes, meshes
        self.view_layer = depsgraph.view_layer_eval
        self.override = getattr(self.view_layer, "material_override", None)
        self.lookups = Lookups(depsgraph.scene_eval.frame_current, self.view_layer_value)
        self.uv = self.lookups.attribute("uv") if self.view_layer.use_pass_uv else None  # what the UV pass shows
        self.aovs, self.light_groups = aovs_of(self.view_layer), LightGroups(self.view_layer)
        self.lamps: list[Lamp] = []
        self.programs: list[MaterialProgram] = []
        self.material_names: list[str] = []
        self.material_indices: list[int] = []
        self.volume_of: dict[int, int] = {}  # material of what a material encloses
        self.slots: list[int] = []
        self.instances: list[tuple] = []  # (number of its matrix, mesh, first slot, visibility, name, index, group)
        self.spheres: list[tuple] = []  # (centre, radius, material, visibility, name, index, group)
        self._material_of: dict = {}
        self._slots_of: dict[tuple, int] = {}
        self._looks: dict[tuple, tuple] = {}  # what instances of one object share: the end of their tuple
        self.matrices = np.zeros((0, 4, 4))

    def gather(self) -> None:
        """Walk over everything that the dependency graph shows.

        What an object looks like is asked for once and not for each of its instances.
        """
        instances = self.depsgraph.object_instances
        columns = np.empty(16 * len(instances), np.float32)
        instances.foreach_get("matrix_world", columns)  # 30 times as fast as one mathutils.Matrix after the other
        self.matrices = columns.reshape(-1, 4, 4).swapaxes(1, 2).astype(np.float64)
        for number, instance in enumerate(instances):
            ob = instance.object
            key = look_key(instance, ob)
            if key in self._looks:
                if instance.show_self:
                    self.instances.append((number, *self._looks[key]))
                continue
            self.note_extras(instance, ob)
            if not instance.show_self:
                continue
            if ob.type == "LIGHT":
                self.add_lamp(number, instance, ob)
            elif ob.type in WITH_MESH:
                self.add_object(number, instance, ob, key)
            elif ob.type in LEFT_OUT:
                self.notes.add("object", ob.name, LEFT_OUT[ob.type])

    def instance_values(self) -> dict[str, np.ndarray]:
        """The scene's array of what materials ask of instances; the dependency graph is walked once more for it."""
        columns = list(self.lookups.instance_columns)
        if not columns:
            return {}
        return {"instance_values": instance_values(self.depsgraph, [each[0] for each in self.instances], columns)}

    def view_layer_value(self, name: str) -> tuple:
        scene = self.depsgraph.scene_eval
        return property_value((self.view_layer, scene, scene.world), name)

    def add_lamp(self, number: int, instance, ob) -> None:
        visibility = self.visibility(instance, ob)
        def known(kind, name):
            return KINDS[kind](instance, name, self.depsgraph)

        lamp = export_light(ob, self.matrices[number], self.origin, visibility, self.notes, self.lookups, known)
        if lamp is not None:
            lamp.flags |= self.light_groups.of(ob) << numbers()["LIGHT_GROUP_SHIFT"]
            self.lamps.append(lamp)

    def add_object(self, number: int, instance, ob, key: tuple) -> None:
        visibility = self.visibility(instance, ob)
        if visibility == 0:
            return
        if is_sphere(ob):
            self.add_sphere(self.matrices[number], ob, visibility)
            return
        mesh = self.meshes.number_of(ob, self.attributes_of(ob))
        if mesh is None:
            return
        slots = self.slots_of(ob, self.meshes.needed[mesh])
        self._looks[key] = mesh, slots, visibility, ob.name, ob.pass_index, self.light_groups.of(ob)
        self.instances.append((number, *self._looks[key]))

    def add_sphere(self, matrix: np.ndarray, ob, visibility: int) -> None:
        """An analytic sphere around the centre of the bounding box, half the longest world side in radius."""
        box = np.array([corner[:] for corner in ob.bound_box], dtype=np.float64)
        low, high = box.min(axis=0), box.max(axis=0)
        sides = (high - low) * np.linalg.norm(matrix[:3, :3], axis=0)
        if sides.max() - sides.min() > 1e-3 * sides.max():
            self.notes.add("object", ob.name, "rendered as a sphere, but its sides differ: the longest counts")
        centre = (matrix[:3, :3] * (0.5 * (low + high))).sum(axis=1) + matrix[:3, 3] - self.origin
        material = self.slot_list(ob)[0]
        look = material, visibility, ob.name, ob.pass_index, self.light_groups.of(ob)
        self.spheres.append((centre, 0.5 * sides.max(), *look))

    def slots_of(self, ob, needed: int) -> int:
        """First entry in slot_materials of an object's slots; equal lists are kept once."""
        slots = self.slot_list(ob)
        # Faces with a higher slot than the object has take the last one, as in Cycles.
        slots = tuple(slots[: max(needed, 1)]) + (slots[-1],) * (needed - len(slots))
        if slots not in self._slots_of:
            self._slots_of[slots] = len(self.slots)
            self.slots += slots
        return self._slots_of[slots]

    def slot_list(self, ob) -> list[int]:
        if self.override is not None:
            return [self.material_of(self.override)]
        return [self.material_of(slot.material) for slot in ob.material_slots] or [self.material_of(None)]

    def material_of(self, material) -> int:
        key = None if material is None else material.original.as_pointer()
        if key not in self._material_of:
            self._material_of[key] = len(self.programs)
            self.programs.append(material_program(material, self.notes, self.lookups, self.aovs))
            self.material_names.append("default" if material is None else material.name)
            self.material_indices.append(0 if material is None else material.pass_index)
            volume = material_volume(material, self.notes, self.lookups)
            if volume:
                self.volume_of[self._material_of[key]] = self.add_program(volume, material.name)
        return self._material_of[key]

    def add_program(self, program: MaterialProgram, name: str) -> int:
        """The number of a material that no object has."""
        self.programs.append(program)
        self.material_names.append(name)
        self.material_indices.append(0)
        return len(self.programs) - 1

    def attributes_of(self, ob) -> list[tuple]:
        """Keys of the attributes that an object's materials read."""
        if not self.lookups.attributes:
            self.slot_list(ob)  # which exports the materials
        if not self.lookups.attributes:
            return []
        materials = [self.volume_of.get(each, each) for each in self.slot_list(ob)] + self.slot_list(ob)
        wanted = {number for material in materials for number in self.programs[material].attributes}
        wanted |= {self.uv} if self.uv is not None else set()
        return [key for key, number in self.lookups.attributes.items() if number in wanted]

    def visibility(self, instance, ob) -> int:
        """RAY_ bits: the object's, and for an instance its instancer's too."""
        mask = sum(bit for name, bit in RAYS if getattr(ob, name))
        top = instance.parent if instance.is_instance else ob
        if top is None:
            return mask
        if instance.is_instance:
            mask &= sum(bit for name, bit in RAYS if getattr(top, name))
        if top.original.indirect_only_get(view_layer=self.depsgraph.view_layer):
            mask &= ~RAY_CAMERA
        return mask

    def note_extras(self, instance, ob) -> None:
        """What an object has besides its surface and that is left out."""
        if ob.is_shadow_catcher and ob.type != "LIGHT":
            self.notes.add("object", ob.name, "shadow catchers are not supported: rendered as a usual object")
        in_holdout = not instance.is_instance and ob.original.holdout_get(view_layer=self.depsgraph.view_layer)
        if ob.is_holdout or in_holdout:
            self.notes.add("object", ob.name, "holdouts are not supported: rendered as a usual object")
        linking = getattr(ob, "light_linking", None)
        if linking is not None and (linking.receiver_collection or linking.blocker_collection):
            self.notes.add("object", ob.name, "light linking is not supported: left out")
        if any(m.type == "FLUID" and m.fluid_type == "DOMAIN" and m.domain_settings.domain_type == "GAS"
               for m in ob.modifiers):
            self.notes.add("object", ob.name, "grids of smoke are not supported: its volume is as dense everywhere")
        if instance.show_particles:
            for system in ob.particle_systems:
                if system.settings.type == "HAIR" and system.settings.render_type == "PATH":
                    self.notes.add("object", ob.name, f"hair of {system.name} is not supported: left out")


def look_key(instance, ob) -> tuple:
    """Equal for instances that differ in their matrices only: of one object and its data, made by one other.

    The object at hand is one and the same for all instances, with the place filled in; the original is not.
    """
    data, parent = ob.data, instance.parent if instance.is_instance else None
    return (ob.original.as_pointer(), data.as_pointer() if data else 0,
            parent.original.as_pointer() if parent else 0)


def is_sphere(ob) -> bool:
    """The add-on's "render as sphere", or a custom property of that name."""
    settings = getattr(ob, "isophote", None)
    return bool(getattr(settings, "as_sphere", False)) or bool(ob.get("isophote_as_sphere", False))
