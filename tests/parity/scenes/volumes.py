"""Volumes: in balls, boxes and glass, in each other, in instances and in the world, with the camera in one of them; and
such that differ from point to point."""

import numpy as np

from isophote.scene import Scene
from isophote.values import ARITHMETIC
from tests.scenes import (
    ALL,
    POINT,
    RECTANGLE,
    SHADOW,
    SUN,
    Builder,
    ball,
    box,
    diffuse,
    emission,
    look_at,
    medium,
    place,
    program,
    quad,
)

GLASS = program(("glass", 1.0, dict(roughness=0.1, ior=1.4, multiscatter=0)))
SKIN = dict(anisotropy=0.0, ior=1.4, roughness=0.7, diffuse=0.0, radius_r=0.3, radius_g=0.2, radius_b=0.1,
            albedo_r=0.8, albedo_g=0.7, albedo_b=0.5)


def volumes() -> Scene:
    b = Builder((20, 16))
    b.world = (0.4, 0.5, 0.7)
    b.look((0, -7, 3), (0, 0, 0.7), 0.45, lens=(0.05, 6, 0, 0, 1))
    b.add(quad((0, 0, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.5))
    b.add(quad((0, 3, 3), (2, 0, 0), (0, 0, 1)), emission(2.0))
    b.add(box((0, -5, 2), 2.5), [], volume=medium(0.01, (0.05, 0.03, 0.02), 0.6))  # around the camera
    body = b.mesh(ball(rings=6), normals=ball(rings=6)[0])
    fog = b.material([], volume=medium((0.1, 0.4, 1.0), 2.0, -0.4))
    glass = b.material(GLASS, volume=medium((0.1, 0.4, 1.0), 1.0, 0.9, glow=(0.1, 0.0, 0.0)))
    veil = b.material(program(("transparent", 0.8), ("diffuse", 0.2)), volume=medium((1.0, 0.2, 0.2)))
    wax = b.material(program(("subsurface", (0.8, 0.7, 0.5), SKIN)), volume=medium(1.0, 3.0))
    for k, material in enumerate((fog, glass, veil, wax, fog)):
        b.instance(body, material, matrix=place((1.9 * k - 3.8, 0.8, 0.9), (0.9, -0.8 if k % 2 else 0.8, 0.9), k))
    b.sphere((-1.2, -1.6, 0.6), 0.6, glass)
    b.sphere((-0.8, -1.4, 0.6), 0.6, fog)
    b.sphere((1.2, -1.6, 0.6), 0.7, fog)
    b.sphere((1.2, -1.6, 0.6), 0.4, b.material([], volume=medium(0.0, 3.0, glow=(0.0, 0.4, 0.8))))
    b.instance(b.mesh(box()), fog, matrix=place((2.8, -1.8, 0.5), (0.5, 0.5, 0.5), 0.3), visibility=ALL & ~SHADOW)
    b.lamp(POINT, 200.0, place((-3, -3, 4)), (0.3, 0))
    b.lamp(RECTANGLE, 100.0, look_at((2, -4, 5), (0, 0, 0)), (1, 1), visibility=30)
    b.lamp(SUN, 0.5, look_at((1, 1, 5), (0, 0, 0)), (0.0, 0))
    deep = b.material(program(("emission", (ARITHMETIC.call("ray_bounces", data=24)[0] * 0.5 + 1.0,) * 3)))
    b.lamp(POINT, 60.0, place((3, 2, 2)), (0.2, 0), material=deep)
    world = b.fill_world(medium((0.004, 0.006, 0.0), (0.01, 0.01, 0.0), 0.3))
    blocks = [0, 0, 2, 0]  # some lamps are not stopped by every second object
    return b.make(occlusion_distance=2.0, instance_terminator=[0.2] * len(b.instances),
                  instance_sets=[[0, k % 2] for k in range(len(b.instances))],
                  light_unlinked=np.array([[0, each] for each in blocks], np.uint64), **world)


def clouds() -> Scene:
    """Densities, colours, phases and emission that vary, in an instance, a sphere and even haze."""
    b = Builder((10, 8))
    b.world = (0.4, 0.5, 0.7)
    b.look((0, -7, 3), (0, 0, 0.7), 0.45)
    b.add(quad((0, 0, 0), (6, 0, 0), (0, 6, 0)), diffuse(0.5))
    x, y, z = ARITHMETIC.call("object_point")
    dense = x * x + y * y * 0.5
    lumpy = program(("extinction", [dense * 2.5, dense * 2.0, dense * 1.5]), ("emission", [dense * 0.2, 0.0, 0.0]),
                    ("scattering", [dense * 2.0, dense, dense], dict(anisotropy=z * 0.5, alpha=0.5)))
    height = ARITHMETIC.call("position")[2]
    thin = [0.02 / (height * height + 1.0)] * 3
    haze = program(("extinction", thin), ("scattering", thin, dict(anisotropy=0.2)))
    body = b.mesh(ball(rings=6))
    for k, scale in enumerate((1.0, -0.8)):
        b.instance(body, b.material([], volume=lumpy), matrix=place((2.2 * k - 1.5, 0, 1.0), (scale, 1, 1), k))
    b.sphere((2.8, 0, 0.8), 0.7, b.material(GLASS, volume=haze))
    b.add(box((0, 0, 1.2), (3, 2, 1.1)), [], volume=medium(0.02, 0.05))
    b.lamp(POINT, 300.0, place((3, -4, 5)), (0.3, 0))
    b.lamp(POINT, 50.0, place((-1, -1.5, 1.5)), (0.2, 0))
    return b.make(occlusion_distance=3.0, **b.fill_world(medium(0.002, 0.004)))
