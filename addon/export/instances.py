# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects and instances: what the dependency graph shows, each mesh once, each appearance an instance.

Collections, vertices, faces, particles and geometry nodes all arrive through
depsgraph.object_instances, so that there is one loop for everything.
"""

from __future__ import annotations

import numpy as np

from isophote.material_program import Displacement, MaterialProgram
from isophote.records import numbers

from .. import compat
from .aovs import aovs_of
from .changes import Meshes
from .instance_values import KINDS, instance_values, property_value
from .light import Lamp, export_light
from .light_groups import LightGroups
from .light_linking import LightLinking
from .lookups import Lookups
from .material import held_out_program, material_program, strand_program
from .mattes import NO_MATERIAL, Mattes
from .strands import hair_material, hair_systems
from .visibility import Appearance, appearances, is_catcher, visibility_of
from .volume import material_volume

LINK = 7  # where the number in `linking` stands in the tuples of instances and of spheres
# Curves, surfaces and text come a second time, as instances of the meshes that they evaluate to.
WITH_MESH = {"MESH", "META"}
LEFT_OUT = {
    "POINTCLOUD": "point clouds are not supported: left out",
    "VOLUME": "volume objects are not supported: left out",
    "GPENCIL": "grease pencil is not supported: left out",
    "GREASEPENCIL": "grease pencil is not supported: left out",
}


def matrices_of(instances) -> np.ndarray:
    """matrix_world of all, f8 [n, 4, 4]: 30 times as fast as one mathutils.Matrix after the other."""
    columns = np.empty(16 * len(instances), np.float32)
    instances.foreach_get("matrix_world", columns)
    return columns.reshape(-1, 4, 4).swapaxes(1, 2).astype(np.float64)


class Gatherer:
    """Collects meshes, instances, spheres, materials and lamps while the dependency graph is walked."""

    def __init__(self, depsgraph, origin: np.ndarray, notes, meshes: Meshes, frame: int):
        self.depsgraph, self.origin, self.notes, self.meshes = depsgraph, origin, notes, meshes
        self.view_layer = depsgraph.view_layer_eval
        self.override = getattr(self.view_layer, "material_override", None)
        self.lookups = Lookups(frame, self.view_layer_value)
        self.uv = self.lookups.attribute("uv") if self.view_layer.use_pass_uv else None  # what the UV pass shows
        self.aovs, self.light_groups = aovs_of(self.view_layer), LightGroups(self.view_layer)
        self.linking, self.mattes = LightLinking(notes), Mattes(self.view_layer)
        pass_of_its_own = getattr(getattr(self.view_layer, "cycles", None), "use_pass_shadow_catcher", False)
        self.shows_shadows = depsgraph.scene_eval.render.film_transparent or pass_of_its_own
        self.lamps: list[Lamp] = []
        self.programs: list[MaterialProgram] = []
        self.displacements: dict[int, Displacement] = {}  # by material
        self.material_names: list[str] = []
        self.material_indices: list[int] = []
        self.volume_of: dict[int, int] = {}  # material of what a material encloses
        self.slots: list[int] = []
        # (number of its matrix, mesh, first slot, visibility, name, index, group, number in `linking`, terminator)
        self.instances: list[tuple] = []
        # (centre, radius, material, visibility, name, index, group, number in `linking`)
        self.spheres: list[tuple] = []
        self._material_of: dict[tuple, int] = {}
        self._slots_of: dict[tuple, int] = {}
        self._looks: dict[tuple, list[tuple]] = {}  # what instances of one object share: the end of each one's tuples
        self.matrices = np.zeros((0, 4, 4))

    def gather(self) -> None:
        """Walk over everything that the dependency graph shows.

        What an object looks like is asked for once and not for each of its instances.
        """
        instances = self.depsgraph.object_instances
        self.matrices = matrices_of(instances)
        for number, instance in enumerate(instances):
            ob = instance.object
            key = look_key(instance, ob)
            self.add_instance(number, instance, ob, key)
            if instance.show_particles and is_itself(instance, ob):  # behind its emitter, which motion follows
                self.add_hair(number, instance, ob, (*key, "hair"))

    def add_instance(self, number: int, instance, ob, key: tuple) -> None:
        if key in self._looks:
            if instance.show_self:
                self.instances += [(number, *look) for look in self._looks[key]]
            return
        self.note_extras(instance, ob)
        if not instance.show_self:
            return
        if ob.type == "LIGHT":
            self.add_lamp(number, instance, ob)
        elif ob.type in WITH_MESH:
            self.add_object(number, instance, ob, key)
        elif ob.type == "CURVES":
            self._looks[key] = self.strand_looks(instance, ob, None, 0)
            self.instances += [(number, *look) for look in self._looks[key]]
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
        visibility = visibility_of(instance, ob, self.depsgraph.view_layer)

        def known(kind, name):
            return KINDS[kind](instance, name, self.depsgraph)

        lamp = export_light(ob, self.matrices[number], self.origin, visibility, self.notes, self.lookups, known)
        if lamp is not None:
            lamp.flags |= self.light_groups.of(ob) << numbers()["LIGHT_GROUP_SHIFT"]
            lamp.link = self.linking.of(instance, ob)
            self.lamps.append(lamp)

    def add_object(self, number: int, instance, ob, key: tuple) -> None:
        parts = appearances(instance, ob, self.depsgraph.view_layer)
        if not parts:
            return
        if any(part.held_out for part in parts) and self.is_mere_volume(ob):
            parts = [Appearance(sum(part.visibility for part in parts), False)]  # as in Cycles: volumes have no holes
        self.mattes.meet(ob)
        shared = ob.name, ob.pass_index, self.light_groups.of(ob), self.linking.of(instance, ob)
        if is_sphere(ob):
            self.add_sphere(self.matrices[number], ob, parts, shared)
            return
        displaced = self.displacing_slots(ob)
        if displaced and compat.is_diced(ob):
            self.notes.add("object", ob.name, "adaptive subdivision is not supported: displaced as its modifier "
                                              "subdivides it")
        mesh = self.meshes.number_of(ob, self.attributes_of(ob), displaced)
        if mesh is None:
            return
        terminator = compat.terminator_offset(ob, "geometry")
        self._looks[key] = [(mesh, self.slots_of(ob, self.meshes.needed[mesh], part.held_out), part.visibility, *shared,
                             terminator) for part in parts]
        self.instances += [(number, *look) for look in self._looks[key]]

    def add_hair(self, number: int, instance, ob, key: tuple) -> None:
        """What particle systems grow on an object."""
        if key not in self._looks:
            self._looks[key] = [look for modifier in hair_systems(ob, self.depsgraph) for look in self.strand_looks(
                instance, ob, modifier, hair_material(modifier, self.slot_count(ob)))]
        self.instances += [(number, *look) for look in self._looks[key]]

    def strand_looks(self, instance, ob, modifier, slot: int) -> list[tuple]:
        """Of the hair that a particle modifier makes, or of a Curves object."""
        parts = appearances(instance, ob, self.depsgraph.view_layer)
        if not parts or not self.view_layer.use_strand:
            return []
        self.mattes.meet(ob)
        materials = {part: self.material_of(self.slot_of(ob, slot), part.held_out, strands=True) for part in parts}
        keys = self.attributes_read([self.programs[material] for material in materials.values()])
        mesh = self.meshes.number_of_strands(ob, modifier, self.depsgraph, keys)
        if mesh is None:
            return []
        return [(mesh, self.first_slot((material,)), part.visibility, ob.name, ob.pass_index, self.light_groups.of(ob),
                 self.linking.of(instance, ob), 0.0) for part, material in materials.items()]

    def add_sphere(self, matrix: np.ndarray, ob, parts: list[Appearance], shared: tuple) -> None:
        """An analytic sphere around the centre of the bounding box, half the longest world side in radius."""
        box = np.array([corner[:] for corner in ob.bound_box], dtype=np.float64)
        low, high = box.min(axis=0), box.max(axis=0)
        sides = (high - low) * np.linalg.norm(matrix[:3, :3], axis=0)
        if sides.max() - sides.min() > 1e-3 * sides.max():
            self.notes.add("object", ob.name, "rendered as a sphere, but its sides differ: the longest counts")
        centre = (matrix[:3, :3] * (0.5 * (low + high))).sum(axis=1) + matrix[:3, 3] - self.origin
        for part in parts:
            material = self.slot_list(ob, part.held_out)[0]
            self.spheres.append((centre, 0.5 * sides.max(), material, part.visibility, *shared))

    def slots_of(self, ob, needed: int, held_out: bool) -> int:
        """First entry in slot_materials of an object's slots; equal lists are kept once."""
        slots = self.slot_list(ob, held_out)
        # Faces with a higher slot than the object has take the last one, as in Cycles.
        return self.first_slot(tuple(slots[: max(needed, 1)]) + (slots[-1],) * (needed - len(slots)))

    def first_slot(self, slots: tuple[int, ...]) -> int:
        if slots not in self._slots_of:
            self._slots_of[slots] = len(self.slots)
            self.slots += slots
        return self._slots_of[slots]

    def slot_list(self, ob, held_out: bool = False) -> list[int]:
        return [self.material_of(self.slot_of(ob, slot), held_out) for slot in range(self.slot_count(ob))]

    def slot_count(self, ob) -> int:
        return 1 if self.override is not None else max(len(ob.material_slots), 1)

    def slot_of(self, ob, slot: int):
        """The material of a slot; None where there is none."""
        if self.override is not None:
            return self.override
        return ob.material_slots[slot].material if ob.material_slots else None

    def material_of(self, material, held_out: bool = False, strands: bool = False) -> int:
        """The number of a bpy Material; on strands it has neither what fills a surface nor what wanders below."""
        key = None if material is None else material.original.as_pointer(), held_out, strands
        if key not in self._material_of:
            make = held_out_program if held_out else strand_program if strands else material_program
            self._material_of[key] = len(self.programs)
            program, displacement = make(material, self.notes, self.lookups, self.aovs)
            if displacement and not strands:
                self.displacements[len(self.programs)] = displacement
            self.programs.append(program)
            self.material_names.append(NO_MATERIAL if material is None else material.name)
            self.material_indices.append(0 if material is None else material.pass_index)
            volume = None if strands else material_volume(material, self.notes, self.lookups)
            if volume:
                self.volume_of[self._material_of[key]] = self.add_program(volume, material.name)
        return self._material_of[key]

    def is_mere_volume(self, ob) -> bool:
        """Whether an object has no surface, only what fills it."""
        return all(number in self.volume_of and not self.programs[number].instructions for number in self.slot_list(ob))

    def displacing_slots(self, ob) -> tuple[int, ...]:
        """Materials of an object's slots where one of them displaces its mesh, else none."""
        slots = tuple(self.slot_list(ob))
        return slots if not self.displacements.keys().isdisjoint(slots) else ()

    def add_program(self, program: MaterialProgram, name: str) -> int:
        """The number of a material that no object has."""
        self.programs.append(program)
        self.material_names.append(name)
        self.material_indices.append(0)
        return len(self.programs) - 1

    def attributes_of(self, ob) -> list[tuple]:
        """Keys of the attributes that an object's materials read."""
        if not self.lookups.attributes:
            return []
        slots = self.slot_list(ob)
        programs = [self.programs[material] for material in slots]
        programs += [self.programs[self.volume_of[material]] for material in slots if material in self.volume_of]
        programs += [self.displacements[material].program for material in slots if material in self.displacements]
        return self.attributes_read(programs)

    def attributes_read(self, programs: list[MaterialProgram]) -> list[tuple]:
        """Keys of the attributes that programs, or the UV pass, read."""
        wanted = {number for program in programs for number in program.attributes}
        wanted |= {self.uv} if self.uv is not None else set()
        return [key for key, number in self.lookups.attributes.items() if number in wanted]

    def note_extras(self, instance, ob) -> None:
        """What an object has besides its surface and that is left out."""
        if ob.type != "LIGHT" and is_catcher(instance, ob) and not self.shows_shadows:
            self.notes.add("object", ob.name, "shadow catchers want a transparent film: rendered as a usual object")
        if compat.terminator_offset(ob, "shading") > 0.0:
            self.notes.add("object", ob.name, "the shading offset of its shadow terminator is not supported: left out")
        if any(m.type == "FLUID" and m.fluid_type == "DOMAIN" and m.domain_settings.domain_type == "GAS"
               for m in ob.modifiers):
            self.notes.add("object", ob.name, "grids of smoke are not supported: its volume is as dense everywhere")


def look_key(instance, ob) -> tuple:
    """Equal for instances that differ in their matrices only: of one object and its data, made by one other.

    The object at hand is one and the same for all instances, with the place filled in; the original is not.
    """
    data, parent = ob.data, instance.parent if instance.is_instance else None
    return (ob.original.as_pointer(), data.as_pointer() if data else 0,
            parent.original.as_pointer() if parent else 0)


def is_itself(instance, ob) -> bool:
    """Whether an instance has its object's own data: those that geometry nodes make do not, and have no hair."""
    return not instance.is_instance or instance.instance_object.data == ob.data


def is_sphere(ob) -> bool:
    """The add-on's "render as sphere", or a custom property of that name."""
    settings = getattr(ob, "isophote", None)
    return bool(getattr(settings, "as_sphere", False)) or bool(ob.get("isophote_as_sphere", False))
