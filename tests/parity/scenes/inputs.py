"""A scene of values of the point, the ray, the object and the mesh, and of closures with normals of their own."""

import numpy as np

from isophote.materials import make_instruction
from isophote.records import numbers
from isophote.scene import Scene
from isophote.values import ARITHMETIC, call1, clamp, operations
from tests.scenes import Builder, ball, diffuse, place, quad

SHIFTS = (0, 8, 16, 24)  # of counts of bounces


def outputs(name, *inputs, **data):
    return ARITHMETIC.call(name, inputs, **data)


def folded(numbers_of):
    """Their sum, within [0, 1]: values of any size count, and no picture is black or white for it."""
    total = sum(clamp(x * 0.5 + 0.5) for x in numbers_of)
    return total * (1.0 / len(numbers_of))


def glow():
    """Emits every input without inputs, and those that turn vectors."""
    n = numbers()
    without = [name for name, each in operations().items() if each.number // 32 in (0, 7) and each.inputs == 0
               and name not in ("constant", "attribute", "ray_is", "ray_bounces", "instance_value")]
    found = [x for name in without for x in outputs(name)]
    found += [x for name in ("attribute", "instance_value") for k in range(2) for x in outputs(name, data=k)]
    found += [call1("ray_is", data=n[name]) for name in ("RAY_CAMERA", "RAY_DIFFUSE", "RAY_SINGULAR", "RAY_SOFT")]
    found += [call1("ray_bounces", data=shift) * 0.2 for shift in SHIFTS]
    position, normal = outputs("position"), outputs("shading_normal")
    for name in ("to_object_vector", "to_world_vector", "to_object_normal", "to_world_normal", "to_camera_vector",
                 "frame_tangent"):
        found += outputs(name, *position)
    found += outputs("window_point", *outputs("camera_point"))
    found += [call1("wireframe", 0.1), call1("wireframe", 2.0, data=1), call1("fresnel", 1.4, *normal),
              call1("facing", 0.7, *normal)]
    return [make_instruction("emission", (folded(found[::3]), folded(found[1::3]), folded(found[2::3])))]


def bent():
    """A bumped diffuse closure under a mirror with a normal map, along a tangent, beside a plain one."""
    height, step, (u, v) = outputs("attribute", data=0), outputs("footprint"), outputs("barycentric")
    beside = [outputs("attribute_at", u + step[6 + 2 * k], v + step[7 + 2 * k], data=0)[0] for k in (0, 1)]
    bumped = outputs("bump", *outputs("shading_normal"), height[0], *beside, 0.8, 0.7, number=1.0)
    mapped = outputs("tangent_space", height[1] - 0.5, height[2] - 0.5, 0.8, *outputs("attribute", data=1),
                     *outputs("smooth_normal"))
    *mirror, seen = outputs("visible_normal", *outputs("blended_normal", *mapped, 1.3))
    tangent = outputs("turned_tangent", *outputs("frame_tangent", 0.0, 0.0, 1.0), *mirror, 0.1)
    shiny = dict(roughness=0.4, multiscatter=1.0, tint_r=0.9, tint_g=0.8, tint_b=0.7)
    return [make_instruction("diffuse", (0.5, 0.4, 0.3), outputs("unit_normal", *bumped)),
            make_instruction("glossy", (seen * 0.3, seen * 0.3, seen * 0.3), tuple(mirror), tangent, **shiny),
            make_instruction("diffuse", (0.1, 0.2, 0.1))]


def passing():
    """Lets rays through by how they got there, shadow rays too."""
    n = numbers()
    clear = clamp(call1("ray_is", data=n["RAY_SHADOW"]) * 0.6 + call1("ray_bounces", data=0) * 0.3
                  + call1("ray_bounces", data=24) * 0.2 + call1("ray_passed") * 0.1 + call1("ray_length") * 0.02)
    return [make_instruction("transparent", (clear, clear, clear)),
            make_instruction("diffuse", (1.0 - clear, 1.0 - clear, 0.5 - clear * 0.5))]


def inputs() -> Scene:
    """Balls, plain, mirrored, smooth, instanced and as a sphere, of these materials over a floor."""
    n, b = numbers(), Builder((20, 16))
    b.world = (0.4, 0.5, 0.6)
    b.look((0, -6, 2.5), (0, 0, 0.6), 0.5)
    glowing, bumpy, thin, white = (b.material(each) for each in (glow(), bent(), passing(), diffuse(0.7)))
    shape = ball(radius=0.6, rings=6)
    meshes = []
    for normals in (shape[0] / 0.6, shape[0] / 0.6, None):
        unit = shape[0] / 0.6
        tangents = np.concatenate([np.cross((0.1, 0.2, 1.0), unit), np.ones((len(unit), 1))], axis=1)
        by_corner = tangents[shape[1].ravel()]
        meshes.append(b.mesh(shape, normals=normals, attributes=[(n["DOMAIN_VERTEX"], 0.5 + 0.5 * unit),
                                                               (n["DOMAIN_CORNER"], by_corner)]))
    floor = b.mesh(quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), attributes=[(n["DOMAIN_NONE"], np.zeros((0, 1)))] * 2)
    b.instance(floor, white, values=(0.1, 0.2))
    b.instance(meshes[0], glowing, matrix=place((-1.8, 0, 0.6), (-1, 1, 0.8), 0.4), values=(0.3, 0.9))
    b.instance(meshes[1], bumpy, matrix=place((0, 0, 0.6), (1, -1, 1), 0.2), values=(0.5, 0.1))
    b.instance(meshes[1], glowing, matrix=place((0.3, -1.5, 0.4), 0.5), values=(0.2, 0.6))
    b.instance(meshes[2], thin, matrix=place((1.8, 0, 0.6)), values=(0.7, 0.3))
    b.instance(meshes[2], bumpy, matrix=place((1.2, 1.8, 0.9), (1, 1, 1.5)), values=(0.4, 0.4))
    b.sphere((-0.9, 1.4, 0.5), 0.5, glowing)
    b.lamp(2, 2.0, place((0, 0, 5)), (0.1, 0))
    return b.make(occlusion_distance=2.0)
