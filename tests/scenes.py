"""Small scenes made with numpy, and films of them, for tests that need no Blender."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from bench.parity import expose, full_frame
from isophote.device import open_device
from isophote.film import Film
from isophote.material_program import join_materials, make_material
from isophote.materials import make_instruction
from isophote.passes import PASSES, film_planes
from isophote.prepare import Prepared, prepare
from isophote.records import numbers as constants
from isophote.scene import Scene, make_scene
from isophote.settings import Settings
from isophote.validate import clean, validate

EVERY_PASS = tuple(PASSES)
CAMERA, DIFFUSE, GLOSSY, TRANSMISSION, SHADOW, ALL = 1, 2, 4, 8, 16, 31  # kinds of rays
CATCHES = ALL | ALL << constants()["CATCHER_SHIFT"]  # and catches shadows in the eyes of all of them
POINT, SPOT, SUN, RECTANGLE, ELLIPSE = range(5)


# ------------------------------------------------------------------ transforms and shapes


def look_at(position, target, up=(0, 0, 1)) -> np.ndarray:
    """(3, 4) rigid matrix at `position` whose -z points to the target."""
    position = np.asarray(position, float)
    z = position - np.asarray(target, float)
    z /= np.linalg.norm(z)
    x = np.cross(up, z)
    if np.linalg.norm(x) < 1e-6:
        x = np.cross((0, 1, 0), z)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(z, x), z, position], axis=1)


def place(position=(0, 0, 0), scale=(1, 1, 1), angle=0.0) -> np.ndarray:
    """(3, 4) matrix: scales, turns about z, moves. Negative scales mirror."""
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    return np.concatenate([turn * np.broadcast_to(scale, 3), np.reshape(position, (3, 1))], axis=1)


def quad(center, u, v) -> tuple[np.ndarray, np.ndarray]:
    """(vertices, triangles) of the parallelogram center +- u +- v; its front looks along u x v."""
    c, u, v = (np.asarray(a, float) for a in (center, u, v))
    return np.array([c - u - v, c + u - v, c + u + v, c - u + v]), np.array([[0, 1, 2], [0, 2, 3]])


def join(*parts) -> tuple[np.ndarray, np.ndarray]:
    """One mesh of several (vertices, triangles)."""
    starts = np.cumsum([0, *(len(vertices) for vertices, _ in parts)])
    return (np.concatenate([vertices for vertices, _ in parts]),
            np.concatenate([triangles + start for (_, triangles), start in zip(parts, starts, strict=False)]))


def box(center=(0, 0, 0), half=(1, 1, 1)) -> tuple[np.ndarray, np.ndarray]:
    """An axis-aligned box, 12 triangles that look outwards, sides in the order -x +x -y +y -z +z."""
    sides = []
    for axis in range(3):
        for sign in (-1, 1):
            along, u, v = np.zeros((3, 3))
            along[axis] = sign * np.broadcast_to(half, 3)[axis]
            u[(axis + 1) % 3] = np.broadcast_to(half, 3)[(axis + 1) % 3]
            v[(axis + 2) % 3] = sign * np.broadcast_to(half, 3)[(axis + 2) % 3]
            sides.append(quad(np.asarray(center) + along, u, v))
    return join(*sides)


def ball(center=(0, 0, 0), radius=1.0, rings=8) -> tuple[np.ndarray, np.ndarray]:
    """A sphere of triangles (rings x 2 rings), looking outwards, its poles on z, without seams."""
    theta = np.linspace(0, np.pi, rings + 1)[1:-1]
    phi = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    t, p = np.meshgrid(theta, phi, indexing="ij")
    around = np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1).reshape(-1, 3)
    vertices = np.concatenate([around, [[0, 0, 1], [0, 0, -1]]])
    n, triangles = 2 * rings, []
    north, south, last = len(around), len(around) + 1, (rings - 2) * n
    for k in range(n):
        following = (k + 1) % n
        triangles += [[north, k, following], [south, last + following, last + k]]
        for ring in range(rings - 2):
            a, b = ring * n, (ring + 1) * n
            triangles += [[a + k, b + k, b + following], [a + k, b + following, a + following]]
    return np.asarray(center) + radius * vertices, np.array(triangles)


# ------------------------------------------------------------------ building


def program(*steps) -> list:
    """A material's instructions, of (operation, weight, {parameters}); weights may be one number, all may be Values."""
    return [make_instruction(name, np.broadcast_to(weight, 3), **(constants[0] if constants else {}))
            for name, weight, *constants in steps]


def diffuse(albedo=1.0) -> list:
    return program(("diffuse", albedo))


def emission(radiance=1.0) -> list:
    return program(("emission", radiance))


def medium(absorption=0.0, scattering=0.0, anisotropy=0.0, glow=0.0) -> list:
    """A volume's instructions, 1/m; glow: radiance per metre."""
    parts = [("extinction", np.add(absorption, scattering)), ("emission", glow),
             ("scattering", scattering, dict(anisotropy=anisotropy))]
    return program(*(part for part in parts if np.any(part[1])))


@dataclass
class Builder:
    """Collects a scene piece by piece; `make` returns it. The camera looks along -z from the origin by default."""

    size: tuple[int, int] = (16, 16)
    materials: list = field(default_factory=list)
    meshes: list = field(default_factory=list)
    attributes: list = field(default_factory=list)
    instances: list = field(default_factory=list)
    keys: dict = field(default_factory=dict)  # by instance: matrices over the shutter's time
    shapes: dict = field(default_factory=dict)  # by mesh: vertices, and normals or None, over that time
    radii: dict = field(default_factory=dict)  # by mesh: those of the vertices of strands
    spheres: list = field(default_factory=list)
    lamps: list = field(default_factory=list)
    world: object = 0.0
    camera: dict = field(default_factory=dict)
    aovs: tuple[str, ...] = ()
    light_groups: tuple[str, ...] = ()
    shown: dict = field(default_factory=dict)  # by material: three numbers or Values for each AOV
    volumes: dict = field(default_factory=dict)  # by material, as Scene.material_volume has them

    def __post_init__(self):
        self.look((0, 0, 0), (0, 0, -1))

    def look(self, position, target, tangent=0.5, orthographic=False, clip=(1e-3, 1e4), up=(0, 0, 1),
             lens=(0, 1, 0, 0, 1)):
        """The camera; `tangent` is half the frame's width at distance 1, or in metres for an orthographic one. `lens`:
        radius, distance in focus, blades, rotation, ratio."""
        tall = tangent * self.size[1] / self.size[0]
        self.camera = dict(camera_kind=int(orthographic), camera_to_world=look_at(position, target, up),
                           camera_clip=clip, camera_lens=lens, camera_window=(-tangent, tangent, -tall, tall))

    def material(self, instructions, shown=(), volume=None) -> int:
        """`volume`: the instructions of what it encloses."""
        inside = None if volume is None else self.material(volume)
        self.materials.append(instructions)
        number = len(self.materials) - 1
        self.shown[number] = shown
        self.volumes[number] = 0 if inside is None else inside + 1
        return number

    def mesh(self, shape, slots=0, normals=None, attributes=(), shapes=None) -> int:
        """`normals`: per vertex (V, 3) for a smooth mesh, or None. `attributes`: (DOMAIN_ number, values (elements,
        components)) of each, as many for all meshes."""
        vertices, triangles = shape
        if shapes is not None:
            self.shapes[len(self.meshes)] = shapes
        self.attributes.append([(domain, np.asarray(values, np.float32)) for domain, values in attributes])
        self.meshes.append((np.asarray(vertices, np.float32), np.asarray(triangles),
                            np.broadcast_to(slots, len(triangles)), None if normals is None else np.asarray(normals)))
        return len(self.meshes) - 1

    def strands(self, points, radii, **others) -> int:
        """A mesh of strands of equally many points (strands, n, 3), and their radii (strands, n)."""
        points = np.asarray(points, float)
        starts = np.arange(points.shape[0] * points.shape[1]).reshape(points.shape[:2])[:, :-1].reshape(-1, 1)
        self.radii[len(self.meshes)] = np.broadcast_to(radii, points.shape[:2]).ravel()
        return self.mesh((points.reshape(-1, 3), starts + (0, 1, 0)), **others)

    def instance(self, mesh: int, *materials: int, matrix=None, visibility=ALL, values=(), keys=None):
        """`values`: what steps ask of it, as many for all instances. `keys`: matrices over the shutter's time."""
        if keys is not None:
            self.keys[len(self.instances)] = np.asarray(keys, float)
            matrix = self.keys[len(self.instances)][len(keys) // 2]
        matrix = place() if matrix is None else np.asarray(matrix)
        self.instances.append((mesh, matrix, materials, visibility, values))

    def add(self, shape, instructions, visibility=ALL, normals=None, volume=None):
        """A mesh of its own material, instanced once."""
        material = self.material(instructions, volume=volume)
        self.instance(self.mesh(shape, normals=normals), material, visibility=visibility)

    def fill_world(self, volume) -> dict:
        """For `make`: what fills the world."""
        return {"world_volume": self.material(volume) + 1}

    def sphere(self, center, radius, material: int, visibility=ALL):
        self.spheres.append((center, radius, material, visibility))

    def lamp(self, kind: int, strength, matrix=None, size=(0, 0), spot=(np.pi / 3, 0.5), flags=0, visibility=ALL,
             spread=0.0, material=None):
        """`material`: the number of one whose emission its light is multiplied with."""
        self.lamps.append((kind, place() if matrix is None else matrix, np.broadcast_to(strength, 3),
                           np.broadcast_to(size, 2), spot, flags, spread,
                           0 if material is None else material + 1, visibility))

    def attribute_arrays(self) -> dict:
        rows, values, length = [], [np.zeros(0, np.float32)], 0
        for attributes in self.attributes:
            rows.append([])
            for domain, numbers in attributes:
                rows[-1].append((length, domain, numbers.shape[1]))
                values.append(numbers.ravel())
                length += numbers.size
        return {"mesh_attributes": np.array(rows, np.uint32).reshape(len(rows), -1, 3),
                "attribute_values": np.concatenate(values)}

    def shape_arrays(self) -> dict:
        """`shapes`: for each mesh that deforms a list of (vertices, normals or None)."""
        if not self.shapes:
            return {}
        meshes = sorted(self.shapes)
        keys = [len(self.shapes.get(mesh, ())) for mesh in range(len(self.meshes))]
        normals = [each[1] for mesh in meshes for each in self.shapes[mesh] if each[1] is not None]
        vertices = [each[0] for mesh in meshes for each in self.shapes[mesh]]
        return {"mesh_keys": keys, "key_vertices": np.concatenate(vertices),
                "key_normals": np.concatenate(normals) if normals else np.zeros((0, 3))}

    def key_arrays(self) -> dict:
        if not self.keys:
            return {}
        return {"instance_keys": [len(self.keys.get(k, ())) for k in range(len(self.instances))],
                "key_to_world": np.concatenate([self.keys[k] for k in sorted(self.keys)])}

    def make(self, **others) -> Scene:
        """`others`: arrays of the scene beside those that were built."""
        arrays = dict(self.camera, resolution=self.size, world_radiance=np.broadcast_to(self.world, 3), **others)
        arrays["material_volume"] = [self.volumes[k] for k in range(len(self.materials))]
        arrays |= join_materials([make_material(each, self.shown[k]) for k, each in enumerate(self.materials)])
        if self.meshes:
            starts = np.cumsum([0, *(len(vertices) for vertices, *_ in self.meshes)])
            arrays["vertices"] = np.concatenate([vertices for vertices, *_ in self.meshes])
            arrays["triangles"] = np.concatenate([m[1] + start for m, start in zip(self.meshes, starts, strict=False)])
            slots = np.concatenate([m[2] for m in self.meshes])
            arrays["triangle_slots"] = slots if slots.any() else []
            arrays["mesh_vertices"] = starts
            arrays["mesh_triangles"] = np.cumsum([0, *(len(m[1]) for m in self.meshes)])
            smooth = [0 if m[3] is None else len(m[3]) for m in self.meshes]
            arrays["mesh_normals"] = np.where(smooth, np.cumsum([0, *smooth[:-1]]), -1)
            arrays |= self.attribute_arrays()
            arrays |= self.shape_arrays()
            if self.radii:
                counts = np.array([len(self.radii.get(mesh, ())) for mesh in range(len(self.meshes))])
                arrays["mesh_radii"] = np.where(counts, 1 + np.cumsum(counts) - counts, 0)
                arrays["radii"] = np.concatenate([self.radii[mesh] for mesh in sorted(self.radii)])
            if any(smooth):
                arrays["normals"] = np.concatenate([m[3] for m in self.meshes if m[3] is not None])
        if self.instances:
            meshes, matrices, materials, visibility, values = zip(*self.instances, strict=True)
            arrays |= dict(instance_mesh=meshes, instance_to_world=np.stack(matrices), instance_visibility=visibility,
                           instance_values=np.array(values),
                           instance_slots=np.cumsum([0, *(len(m) for m in materials[:-1])]),
                           slot_materials=np.concatenate([np.asarray(m, int) for m in materials]), **self.key_arrays())
        if self.spheres:
            names = ("sphere_center", "sphere_radius", "sphere_material", "sphere_visibility")
            arrays |= dict(zip(names, zip(*self.spheres, strict=True), strict=True))
        if self.lamps:
            names = ("kind", "to_world", "strength", "size", "spot", "flags", "spread", "material", "visibility")
            columns = zip(*self.lamps, strict=True)
            arrays |= {f"light_{name}": np.stack(column) for name, column in zip(names, columns, strict=True)}
        names = {"aovs": self.aovs, "light_groups": self.light_groups}
        scene = make_scene(names, **{name: np.asarray(value) for name, value in arrays.items()})
        errors = [str(problem) for problem in validate(scene) if problem.severity == "error"]
        assert not errors, errors
        return scene


# ------------------------------------------------------------------ films


def ready(scene: Scene) -> Prepared:
    return prepare(clean(scene)[0])


def render(scene: Scene, samples: int = 256, device: str = "openmp", **settings) -> Film:
    """A film of a scene; every bounce limit is 64 unless it is given."""
    bounces = dict.fromkeys(("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces",
                             "volume_bounces", "transparent_bounces"), 64)
    chosen = Settings(**bounces | dict(samples=samples) | settings)
    opened = open_device(device, chosen)
    try:
        opened.upload(ready(scene))
        film = Film(chosen.region or full_frame(scene), film_planes(chosen))
        return expose(opened, film, samples, chosen)
    finally:
        opened.close()


# ------------------------------------------------------------------ measuring


def pixels(film: Film) -> np.ndarray:
    """RGBA means, float64 (h, w, 4)."""
    return np.stack([(film.sum(c) + film.sum(4 + c)) / film.samples for c in range(4)], axis=-1)


def mean_and_error(film: Film) -> tuple[np.ndarray, np.ndarray]:
    """RGB mean of the picture and its standard error, (3) each, from the film's two replicates."""
    n0, n1 = film.replicate_samples
    halves = [np.stack([film.sum(4 * r + c) / n for c in range(3)], axis=-1) for r, n in enumerate((n0, n1))]
    variance = (halves[0] - halves[1]) ** 2 * (n0 * n1 / (n0 + n1) ** 2)
    return pixels(film)[..., :3].mean((0, 1)), np.sqrt(variance.sum((0, 1))) / variance[..., 0].size


def assert_mean(film: Film, expected, accuracy=0.005, sigmas=5.0, rounding=2e-6):
    """The picture's mean is as expected within its own error bar, which must be below `accuracy` (relative).

    `rounding` is the relative error allowed to float32 beyond that.
    """
    mean, error = mean_and_error(film)
    expected = np.broadcast_to(np.asarray(expected, float), 3)
    assert (error <= accuracy * np.abs(expected)).all(), f"too noisy to tell: {mean} +- {error}"
    off = np.abs(mean - expected)
    assert (off <= sigmas * error + rounding * np.abs(expected)).all(), \
        f"{mean} +- {error}, expected {expected}: {off / np.maximum(error, 1e-300)} sigma"


def assert_exactly(film: Film, expected, rounding=2e-6):
    """Every pixel is as expected but for float32: scenes without noise."""
    seen = pixels(film)[..., :3]
    np.testing.assert_allclose(seen, np.broadcast_to(expected, seen.shape), rtol=rounding, atol=0)
