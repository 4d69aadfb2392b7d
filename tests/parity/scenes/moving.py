"""A scene in which most things move while the shutter is open."""

import numpy as np

from isophote.materials import make_instruction
from isophote.records import numbers
from isophote.scene import Scene
from isophote.values import ARITHMETIC, clamp
from tests.parity.scenes.inputs import bent, glow
from tests.scenes import RECTANGLE, Builder, ball, box, diffuse, emission, look_at, place, program, quad

DOMAIN_VERTEX = numbers()["DOMAIN_VERTEX"]


def spots():
    """A colour by the place within the object, by its own place, and by the normal there."""
    found = [*ARITHMETIC.call("object_point"), *ARITHMETIC.call("object_location"), *ARITHMETIC.call("smooth_normal"),
             *ARITHMETIC.call("to_object", ARITHMETIC.call("position")),
             *ARITHMETIC.call("from_object", ARITHMETIC.call("true_normal"), data=2)]
    return [make_instruction("diffuse", tuple(clamp(sum(found[k::3]) * 0.2 + 0.5) for k in range(3)))]


def keys(count, position, turn=0.0, way=(0, 0, 0), scales=(1.0, 1.0)):
    """`count` matrices, evenly over a way."""
    change = np.subtract(scales[1], scales[0])
    return [place(np.add(position, np.multiply(way, t)), scales[0] + change * t, turn * t)
            for t in np.linspace(-0.5, 0.5, count)]


def moving() -> Scene:
    """Instances that turn, grow, mirror and vanish for a moment, meshes that deform, both at once; with values of the
    place, as lights, transparent, glass, below surfaces; seen by a camera that moves, too."""
    b = Builder((24, 18))
    b.world = (0.3, 0.35, 0.4)
    b.look((0, -8, 3.5), (0, 0, 0.8), 0.45)

    def mesh(shape, **others):
        places = shape[0] / np.linalg.norm(shape[0], axis=1, keepdims=True)
        tangents = np.concatenate([np.cross((0.1, 0.2, 1.0), places), np.ones((len(places), 1))], axis=1)
        return b.mesh(shape, attributes=[(DOMAIN_VERTEX, 0.5 + 0.5 * places), (DOMAIN_VERTEX, tangents)], **others)

    def add(number, material, **others):
        b.instance(number, material, values=(0.1 * len(b.instances), 0.5), **others)

    round_, block = ball(rings=5), box(half=(0.5, 0.4, 0.6))
    shared, smooth = mesh(block), mesh(round_, normals=round_[0])
    scattered = dict(anisotropy=0.5, ior=1.4, roughness=0.7, diffuse=0.0, radius_r=0.2, radius_g=0.1, radius_b=0.05,
                     albedo_r=0.9, albedo_g=0.6, albedo_b=0.4)
    matt, spotted, glass, clear, wax, glowing = (b.material(each) for each in (
        diffuse((0.7, 0.3, 0.2)), spots(), program(("glass", 0.9, dict(roughness=0.0, ior=1.4, multiscatter=0))),
        program(("transparent", 0.5), ("diffuse", (0.2, 0.2, 0.5))), program(("subsurface", 0.8, scattered)), glow()))
    shiny = program(("diffuse", 0.5), ("glossy", 0.3, dict(roughness=0.1, multiscatter=1)))
    add(mesh(quad((0, 0, -0.01), (6, 0, 0), (0, 6, 0))), b.material(shiny))
    add(shared, matt, matrix=place((3.5, 2, 0.6)))
    add(shared, matt, keys=keys(2, (-3, 0.5, 0.8), 2.0, (0.3, 0, 0.4)))
    add(shared, spotted, keys=keys(3, (-1.5, 0.3, 0.8), -1.0, (0, 0.5, 0), ((1, 1, 0.5), (0.6, 1, 1.2))))
    add(smooth, glass, keys=keys(5, (0, -1, 0.8), 3.0, (0.5, 0.2, 0), ((0.8, 0.6, 0.7), (0.6, 0.8, 0.7))))
    add(smooth, clear, keys=keys(3, (1.6, -1.5, 0.9), 0.1, (0.6, 0, 0), (0.6, 0.7)))
    add(smooth, wax, keys=keys(2, (-1.6, -1.8, 0.7), 1.0, (0.2, 0, 0.1), (0.6, 0.55)))
    add(shared, spotted, keys=keys(3, (3, 0.5, 1), 0.4, (0, 0, 0.5), ((-0.7, 0.7, 0.7), (-0.5, 0.8, 0.6))))
    add(shared, matt, keys=keys(3, (1, 2, 1), 0.0, (0, 0, 0), ((-1.0, 1.0, 1.0), (1.0, 1.0, 1.0))))
    swollen = [(round_[0] * (1 + 0.2 * k * np.abs(round_[0][:, 2:])), round_[0]) for k in (-1, 0, 2)]
    for at, material in (((-0.2, 1.2, 0.8), spotted), ((1.6, 1, 0.8), b.material(bent())), ((-3.6, -2, 0.6), glowing)):
        way = None if material > glowing else keys(3, at, 1.0, (0.3, 0, 0), (0.6, 0.7))
        shape = mesh((swollen[1][0], round_[1]), normals=round_[0], shapes=swollen)
        add(shape, material, keys=way, matrix=place(at, 0.6))
    panel = quad((0, 0, 0), (0.5, 0, 0), (0, -0.5, 0))
    folded = [(panel[0] + np.array([(0, 0, 0), (0, 0, z), (0, 0, 0), (0, 0, -z)]), None) for z in (0.0, 0.4)]
    flying = keys(2, (-1, -1, 3), 1.0, (2, 0, 0), ((1, 1, 1), (0.5, 1, 1)))
    add(mesh(panel), b.material(emission((9, 6, 3))), keys=flying)
    add(mesh((folded[1][0], panel[1]), shapes=folded), glowing, matrix=place((2, -2, 2.6)))
    b.sphere((3.2, -2, 0.5), 0.5, spotted)
    b.lamp(RECTANGLE, 60.0, look_at((2, -4, 6), (0, 0, 0)), (2, 1))
    poses = [(0.2 * k, -8, 3.5, 0, 0, 0.01 * k, np.sqrt(1 - 1e-4 * k * k)) for k in (-1, 0, 1)]
    return b.make(camera_poses=poses, shutter_curve=(0.3, 1.0, 0.4), occlusion_distance=1.5)


def between_frames() -> Scene:
    """What goes from frame to frame but stays while the shutter is open: an object, a mesh that deforms, mirrored, both
    at once, and a panorama's place; for the Vector pass."""
    b = Builder((24, 18))
    b.world = (0.4, 0.5, 0.6)
    b.camera = dict(camera_kind=numbers()["CAMERA_EQUISOLID"], camera_clip=(0.1, 100), camera_panorama=(1.5, *(0,) * 7),
                    camera_to_world=[(0, -1, 0, 0), (1, 0, 0, -5), (0, 0, -1, 1)], camera_window=(-0.8, 0.8, -0.6, 0.6))
    b.add(quad((0, 0, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.5))
    b.add(quad((0, 3, 0), (9, 0, 0), (0, 0, 9)), diffuse(0.6))
    round_ = ball(rings=5)
    swollen = [(round_[0] * (1 + 0.2 * k * np.abs(round_[0][:, 2:])), round_[0]) for k in (-1, 0, 2)]
    for x, mesh in ((-2, None), (0, swollen), (2, swollen)):
        shape = b.mesh(round_, normals=round_[0], shapes=mesh)
        mirrored = keys(3, (x, 0, 0.9), 0.5, (0.3, 0, 0.1), ((-0.8, 0.7, 0.7), (-0.7, 0.8, 0.7)))
        b.instance(shape, b.material(diffuse((0.7, 0.4, 0.2))), keys=mirrored if x else None,
                   matrix=place((x, 0, 0.9), (-0.8, 0.7, 0.7)))
    poses = [(0.1 * k, -5, 1, 0, 0, 0.02 * k, np.sqrt(1 - 4e-4 * k * k)) for k in (-1, 0, 1)]
    b.lamp(RECTANGLE, 90.0, look_at((2, -4, 4), (0, 0, 0)), (3, 2))
    return b.make(camera_poses=poses, vectors=1)
