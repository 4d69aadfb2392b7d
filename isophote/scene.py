"""The scene as flat numpy arrays: what the exporter writes and everything to its right reads.

One table, FIELDS, names each array with its type, shape and meaning; saving, loading, hashing and
validating walk over it.  Counts: V vertices, T triangles, N normals, E entries for triangles that have
slots (T, or 0 where all slots are 0), M meshes, I instances, Q slots, S spheres, P materials, K instructions, L lights,
Z steps, C numbers of tables, A attributes, B numbers of attributes, D AOVs, O instances of which values are known (I or
0), R numbers of each, G images, X bytes, W, U and Y 0 or 1, J poses of the camera (0 or 2 and
more), H numbers of a curve, f keys of instances, v and n vertices and normals of keys of meshes, r radii.
"""

from __future__ import annotations

import hashlib
import json
import zipfile
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from isophote.records import numbers

FORMAT = 6


@dataclass(frozen=True)
class Field:
    """One array of a scene: dtype, shape ("T" and "T+1" stand for counts) and what it holds."""

    dtype: str
    shape: tuple
    doc: str
    zeros: bool = False  # where it is not given: as many as the scene has of what it is about


FIELDS: dict[str, Field] = {
    "origin": Field("f8", (3,), "a place near the camera in Blender's world; all else is relative to it, metres"),
    "resolution": Field("i4", (2,), "width and height of the full frame, pixels"),
    "camera_kind": Field("i4", (), "CAMERA_ number (kernels/scene_records.h)"),
    "camera_to_world": Field("f8", (3, 4), "rigid, relative to origin; looks along its -z, panoramas along its x, of "
                                           "which -z is up (of a mirror ball along -y)"),
    "camera_window": Field("f8", (4,), "left, right, bottom, top at distance 1 (perspective), in metres (orthographic) "
                                       "or as kernels/panorama.h counts"),
    "camera_clip": Field("f8", (2,), "start and end, metres along -z, of a panorama from its place"),
    "camera_panorama": Field("f8", (8,), "how far from the middle of its window a fisheye sees (a polynomial: radians "
                                         "from its axis); five coefficients of the polynomial: radians by mm; by how "
                                         "much its window is shifted, of which window coordinates know nothing"),
    "camera_lens": Field("f8", (5,), "radius (0: a point), distance in focus, metres; blades (0: round), their "
                                     "rotation in radians, height over width"),
    "camera_stereo": Field("f8", (4,), "of a panorama that is one eye of two: offset to the right, distance where both "
                                       "look at the same (0: nowhere), metres; elevations between which the offset "
                                       "fades to nothing, radians (0: it stays)"),
    "camera_poses": Field("f8", ("J", 7), "of a camera that moves, evenly from the shutter's opening to its closing: "
                                          "place relative to origin; turn from camera_to_world, x, y, z, w"),
    "shutter_curve": Field("f8", ("H",), "how open the shutter is, evenly over its time; empty: open at once"),
    "vertices": Field("f4", ("V", 3), "object space"),
    "triangles": Field("u4", ("T", 3), "indices into vertices"),
    "triangle_slots": Field("u2", ("E",), "material slot of each triangle within its mesh; empty where all are 0"),
    "normals": Field("f4", ("N", 3), "unit normals of the vertices of smooth meshes, object space"),
    "mesh_vertices": Field("u4", ("M+1",), "first vertex of each mesh; the last entry is V"),
    "mesh_triangles": Field("u4", ("M+1",), "first triangle of each mesh; the last entry is T"),
    "mesh_normals": Field("i4", ("M",), "normal of the mesh's first vertex, the others' follow; -1 for flat meshes"),
    "mesh_radii": Field("i4", ("M",), "of strands (hair, fur, grass): one more than the number of the first vertex's "
                                      "radius, the others' follow. Their triangles are segments: two vertices that "
                                      "follow each other, and the first again. 0: no strands", zeros=True),
    "radii": Field("f4", ("r",), "object space"),
    "instance_mesh": Field("u4", ("I",), "mesh of each instance"),
    "instance_to_world": Field("f8", ("I", 3, 4), "object to world, relative to origin"),
    "instance_keys": Field("u4", ("I",), "of one that moves: how many of key_to_world it has, evenly from the opening "
                                         "of the shutter to its closing; instance_to_world is the middle. 0: it stays",
                           zeros=True),
    "key_to_world": Field("f8", ("f", 3, 4), "object to world, of the instances that move one after the other"),
    "mesh_keys": Field("u4", ("M",), "of one that deforms: how many shapes it has, likewise; vertices are the middle "
                                     "one. 0: it stays", zeros=True),
    "key_vertices": Field("f4", ("v", 3), "vertices of the shapes, of the meshes that deform one after the other"),
    "vectors": Field("u4", (), "1: nothing moves while the shutter is open; keys, three each, are of the frame before, "
                               "this one and the one after, for the Vector pass, and so are the camera's poses"),
    "key_normals": Field("f4", ("n", 3), "normals of the smooth ones, likewise"),
    "instance_slots": Field("u4", ("I",), "first entry of the instance in slot_materials"),
    "instance_index": Field("f4", ("I",), "Blender's pass index of the object", zeros=True),
    "instance_matte": Field("u4", ("I", 2), "Cryptomatte ids of its object and asset: bits of float32, 0: none",
                            zeros=True),
    "instance_group": Field("u4", ("I",), "light group of what it emits, 0: none, 1: the first", zeros=True),
    "instance_sets": Field("u4", ("I", 2), "sets of receivers and of blockers of light that it is in, below 64",
                           zeros=True),
    "instance_unlinked": Field("u8", ("I", 2), "masks of the sets of receivers that it does not light, and of blockers "
                                               "that do not stop its light", zeros=True),
    "instance_terminator": Field("f4", ("I",), "cosine below which rays to lights start above its smooth triangles "
                                               "(kernels/terminator.h); 0: nowhere", zeros=True),
    "instance_visibility": Field("u4", ("I",), "mask of RAY_ bits (kernels/scene_records.h), of catchers of shadows "
                                               "a second time CATCHER_SHIFT higher"),
    "slot_materials": Field("u4", ("Q",), "material of each slot"),
    "sphere_center": Field("f8", ("S", 3), "relative to origin"),
    "sphere_radius": Field("f8", ("S",), "metres"),
    "sphere_material": Field("u4", ("S",), ""),
    "sphere_visibility": Field("u4", ("S",), "as instance_visibility"),
    "sphere_group": Field("u4", ("S",), "light group", zeros=True),
    "sphere_sets": Field("u4", ("S", 2), "as instance_sets", zeros=True),
    "sphere_unlinked": Field("u8", ("S", 2), "as instance_unlinked", zeros=True),
    "sphere_matte": Field("u4", ("S", 2), "as instance_matte", zeros=True),
    "sphere_index": Field("f4", ("S",), "pass index of the object", zeros=True),
    "material_first": Field("u4", ("P+1",), "first instruction of each material; the last entry is K"),
    "material_volume": Field("u4", ("P",), "one more than the number of the material that fills what it encloses; 0: "
                                           "none. Without instructions it is no surface, but a volume's boundary",
                             zeros=True),
    "material_index": Field("f4", ("P",), "pass index of the material", zeros=True),
    "material_matte": Field("u4", ("P",), "Cryptomatte id", zeros=True),
    "instruction_op": Field("i4", ("K",), "operation (kernels/bsdf/bsdf.h, isophote/materials.py)"),
    "instruction_flags": Field("u4", ("K",), "INSTRUCTION_ flags, registers of normal and tangent (scene_records.h)",
                               zeros=True),
    "instruction_weight": Field("f4", ("K", 3), "RGB factor of the closure, or registers of it"),
    "instruction_params": Field("f4", ("K", 11), "constants, by operation, or registers of them"),
    "aov_values": Field("f4", ("P", "D", 3), "what AOV outputs show of each material, or registers of it", zeros=True),
    "aov_flags": Field("u4", ("P", "D"), "AOV_ flags (scene_records.h)", zeros=True),
    "material_steps": Field("u4", ("P+1",), "first step of each material; the last entry is Z", zeros=True),
    "material_shadow_steps": Field("u4", ("P",), "how many of them transparency needs, the first ones", zeros=True),
    "step_op": Field("i4", ("Z",), "operation (kernels/values/values.h)"),
    "step_to": Field("u4", ("Z",), "first register that it writes"),
    "step_from": Field("u4", ("Z", 11), "registers that it reads"),
    "step_repeat": Field("u4", ("Z",), "how often it runs"),
    "step_data": Field("u4", ("Z",), "an entry of value_tables, the number of an image or an attribute"),
    "step_number": Field("f4", ("Z",), "a constant"),
    "value_tables": Field("f4", ("C",), "curves and ramps that steps read"),
    "mesh_attributes": Field("u4", ("M", "A", 3), "first number in attribute_values, DOMAIN_, components (1 to 4)",
                             zeros=True),
    "uv_attribute": Field("u4", ("Y",), "attribute that the UV pass shows (Y = 1); else empty"),
    "attribute_values": Field("f4", ("B",), "by mesh, attribute, element and component"),
    "instance_values": Field("f4", ("O", "R"), "what steps ask of each instance, a column each"),
    "images": Field("i4", ("G", 6), "first word of image_texels, width, height, channels, TEXEL_ kind, IMAGE_ flags"),
    "image_texels": Field("u1", ("X",), "in words of four bytes; rows from the bottom up"),
    "light_kind": Field("i4", ("L",), "LIGHT_ numbers (kernels/scene_records.h)"),
    "light_to_world": Field("f8", ("L", 3, 4), "axes and place, relative to origin; shines along -z. Axes are unit, "
                                               "but those of a spot, whose lengths stretch its cone"),
    "light_strength": Field("f8", ("L", 3), "colour times power: W, W/m^2 for suns"),
    "light_size": Field("f8", ("L", 2), "radius (point, spot), full angle in radians (sun), full sizes (area)"),
    "light_spot": Field("f8", ("L", 2), "full cone angle in radians, blend 0..1"),
    "light_spread": Field("f8", ("L",), "full angle in radians within which an area lamp shines; 0: no limit",
                          zeros=True),
    "light_flags": Field("u4", ("L",), "LIGHT_NO_SHADOW, LIGHT_NO_MIS, LIGHT_DISK; LIGHT_BOUNCES, LIGHT_GROUP "
                                        "(kernels/scene_records.h)"),
    "light_material": Field("u4", ("L",), "one more than the number of the material whose emission multiplies its "
                                          "strength; 0: none", zeros=True),
    "light_unlinked": Field("u8", ("L", 2), "as instance_unlinked", zeros=True),
    "light_visibility": Field("u4", ("L",), "mask of RAY_ bits that see it"),
    "world_radiance": Field("f8", (3,), "of the world, the same in all directions, W/(m^2 sr)"),
    "world_material": Field("u4", ("W",), "whose emission it is instead, by direction (W = 1); else empty"),
    "world_volume": Field("u4", (), "one more than the number of the material that fills the world; 0: none"),
    "world_hidden": Field("u4", (), "mask of RAY_ bits that do not see the world"),
    "world_sun": Field("f8", ("U", 4), "a disc in it that is drawn apart (U = 1): unit direction of its middle, half "
                                       "its angle in radians"),
    "world_group": Field("u4", (), "light group"),
    "mist": Field("f8", (3,), "start, depth, metres from the camera; exponent of its falloff: 1, 2 or 0.5"),
    "occlusion_distance": Field("f8", (), "metres within which surfaces occlude in the Ambient Occlusion pass"),
}


class SceneError(ValueError):
    """A scene, or a scene file, that cannot be used; the message names the thing."""


@dataclass
class Scene:
    """Arrays by name (see FIELDS), the names of things for messages, and notes on what was left out.

    `names` maps "meshes", "instances", "spheres", "materials" and "lights" to lists of names, "aovs" and
    "light_groups" to those of the passes that the scene names, AOVs as Planes has them, and "assets" to those of which
    there are mattes.
    `notes` is a list of dicts {"kind", "name", "what"}: one for each node, light or object that was
    approximated or left out. `settings` is what the scene's file asks for, by name of settings.Settings;
    no part of the scene's hash. `identities` tells instances from each other while they are followed through time
    (addon/export/moving.py), and is not saved.
    """

    arrays: dict[str, np.ndarray]
    names: dict[str, list[str]] = field(default_factory=dict)
    notes: list[dict] = field(default_factory=list)
    settings: dict = field(default_factory=dict)
    identities: list[tuple] = field(default_factory=list)

    def __getattr__(self, name):
        try:
            return self.__dict__["arrays"][name]
        except KeyError:
            raise AttributeError(name) from None

    @property
    def aovs(self) -> tuple[str, ...]:
        """Its AOV outputs, as Planes has them."""
        return tuple(self.names.get("aovs", ()))

    @property
    def named(self) -> tuple[str, ...]:
        """The passes that it names, as Planes has them."""
        return (*self.aovs, *(f"light:{name}" for name in self.names.get("light_groups", ())))

    @property
    def catches(self) -> bool:
        """Whether some object catches shadows."""
        shift = numbers()["CATCHER_SHIFT"]
        return any((visibility >> shift).any() for visibility in (self.instance_visibility, self.sphere_visibility))

    def name_of(self, group: str, index: int) -> str:
        """The name of a thing for messages, or its number where it has none."""
        names = self.names.get(group, [])
        return names[index] if index < len(names) else f"{group}[{index}]"

    @property
    def content_hash(self) -> str:
        """SHA-256 over all arrays: equal scenes have equal hashes, whatever their names."""
        digest = hashlib.sha256(f"isophote scene {FORMAT}".encode())
        for name in FIELDS:
            array = np.ascontiguousarray(self.arrays[name])
            digest.update(f"{name}{array.shape}".encode())
            digest.update(array.reshape(-1).view(np.uint8))
        return digest.hexdigest()


def make_scene(names: dict | None = None, notes: list | None = None, **arrays) -> Scene:
    """Build a scene from the arrays given; those left out are empty. Shapes and types are checked.

    Raises SceneError naming the array that does not fit.
    """
    unknown = set(arrays) - set(FIELDS)
    if unknown:
        raise SceneError(f"unknown scene arrays: {', '.join(sorted(unknown))}")
    made, counts = {}, {}
    for name in sorted(FIELDS, key=lambda name: name not in arrays and FIELDS[name].zeros):  # those follow the others
        spec = FIELDS[name]
        value = arrays.get(name)
        if value is None:
            value = np.zeros([length_of(n, counts if spec.zeros else {}) for n in spec.shape])
        made[name] = checked(name, spec, value, counts)
    return Scene({name: made[name] for name in FIELDS}, dict(names or {}), list(notes or []))


def length_of(n, counts: dict) -> int:
    """Of a dimension of an array that is not given."""
    return counts.get(n[0], 0) + n.endswith("+1") if isinstance(n, str) else n


def checked(name: str, spec: Field, value, counts: dict) -> np.ndarray:
    """The value as an array of the field's type and shape; counts collects what each letter stands for."""
    try:
        array = np.ascontiguousarray(value, dtype=spec.dtype)
    except (TypeError, ValueError) as error:
        raise SceneError(f"scene array {name}: {error}") from None
    if np.ndim(value) == 0:  # made one of a row; any other that fits stays the object that it is
        array = array.reshape(())
    if array.dtype.kind in "iu" and np.asarray(value).dtype != array.dtype and not np.array_equal(array, value):
        raise SceneError(f"scene array {name}: values that {array.dtype} does not hold")
    if array.ndim != len(spec.shape):
        raise SceneError(f"scene array {name}: shape {array.shape}, wanted {spec.shape}")
    for size, want in zip(array.shape, spec.shape, strict=True):
        if isinstance(want, str):
            letter, plus = want[0], want.endswith("+1")
            want = counts.setdefault(letter, size - plus) + plus
        if size != want:
            raise SceneError(f"scene array {name}: shape {array.shape}, wanted {spec.shape} with {counts}")
    return array


def save_scene(scene: Scene, path: str | Path) -> None:
    """Write a scene as .npz (uncompressed: loading is a copy)."""
    text = json.dumps({"format": FORMAT, "names": scene.names, "notes": scene.notes, "settings": scene.settings})
    with open(path, "wb") as file:
        np.savez(file, isophote=np.array(text), **scene.arrays)


def load_scene(path: str | Path) -> Scene:
    """Read a scene written by save_scene. Raises SceneError naming the file where it is none."""
    try:
        with np.load(path, allow_pickle=False) as data:
            if "isophote" not in data:
                raise SceneError(f"{path}: a .npz file, but no Isophote scene")
            head = json.loads(str(data["isophote"]))
            if head.get("format") != FORMAT:
                raise SceneError(f"{path}: scene format {head.get('format')}, this version reads {FORMAT}")
            arrays = {name: data[name] for name in FIELDS if name in data}
    except FileNotFoundError:
        raise SceneError(f"{path}: no such file") from None
    except (OSError, ValueError, zipfile.BadZipFile, EOFError, KeyError) as error:
        if isinstance(error, SceneError):
            raise
        raise SceneError(f"{path}: not a readable scene file ({error})") from None
    missing = set(FIELDS) - set(arrays)
    if missing:
        raise SceneError(f"{path}: scene without {', '.join(sorted(missing))}")
    scene = make_scene(head["names"], head["notes"], **arrays)
    scene.settings = head.get("settings", {})
    return scene


def resized(scene: Scene, size: tuple[int, int]) -> Scene:
    """The scene at another size in pixels: what is seen from left to right stays, the height follows the aspect, but
    for panoramas that fill any frame."""
    n = numbers()
    left, right, bottom, top = scene.camera_window
    if n["CAMERA_EQUIRECTANGULAR"] <= scene.camera_kind < n["CAMERA_EQUISOLID"]:
        return replace(scene, arrays=scene.arrays | {"resolution": np.array(size, np.int32)})
    old, new = scene.resolution[1] / scene.resolution[0], size[1] / size[0]
    middle, half = (bottom + top) / 2, (top - bottom) / 2 * (new / old if scene.resolution.all() else 1.0)
    arrays = scene.arrays | {"resolution": np.array(size, np.int32),
                             "camera_window": np.array([left, right, middle - half, middle + half])}
    return replace(scene, arrays=arrays)


def slots_of(scene: Scene, mesh: int) -> np.ndarray:
    """Material slot of each of a mesh's triangles, int64 [T]."""
    first, end = scene.mesh_triangles[mesh:mesh + 2].astype(np.int64)
    slots = scene.triangle_slots[first:end].astype(np.int64)
    return slots if len(scene.triangle_slots) else np.broadcast_to(0, end - first)
