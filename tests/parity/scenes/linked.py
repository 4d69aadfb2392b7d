"""Lights that are linked to some objects only, in all of their kinds."""

import numpy as np

from isophote.scene import Scene
from isophote.values import ARITHMETIC
from tests.scenes import (
    POINT,
    RECTANGLE,
    SPOT,
    SUN,
    Builder,
    ball,
    diffuse,
    emission,
    look_at,
    place,
    program,
    quad,
)


def linked() -> Scene:
    """Lamps, one with a program, panels and a sphere that shine, under a world that is drawn; each does not light or is
    not stopped by some of a floor, balls, a veil, a mirror and a sphere."""
    b = Builder((20, 16))
    b.look((0, -6, 2.5), (0, 0, 0.6), 0.45)
    b.add(quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), diffuse((0.7, 0.6, 0.5)))
    b.add(quad((-1, -1, 0.8), (0.8, 0, 0), (0, 0.2, 0.8)), program(("transparent", 0.3), ("diffuse", 0.4)))
    body = b.mesh(ball((0, 0, 0), 0.7, 5))
    for k, instructions in enumerate([program(("glossy", 0.9, dict(roughness=0.0, multiscatter=0))), diffuse(0.6),
                                      program(("glossy", 0.7, dict(roughness=0.3, multiscatter=1)), ("diffuse", 0.2))]):
        b.instance(body, b.material(instructions), matrix=place((1.6 * k - 1.6, 0.5, 0.7)))
    panel, glow = b.mesh(quad((0, 0, 0), (0.5, 0, 0), (0, 0, 0.5))), b.material(emission((3, 2, 1)))
    for x in (-2.5, 2.5):
        b.instance(panel, glow, matrix=place((x, 1, 2)))
    b.sphere((0, -2, 0.4), 0.4, b.material(diffuse(0.5)))
    b.sphere((1.5, -2, 0.3), 0.3, b.material(emission(2)))
    x = ARITHMETIC.call("position")[0]
    computed = b.material(program(("emission", (x * 0.2 + 1.0,) * 3)))
    b.lamp(POINT, 300.0, place((2, -3, 5)), size=(0.5, 0))
    b.lamp(SPOT, 500.0, look_at((-2, -3, 4), (0, 0, 0)), size=(0.2, 0), material=computed)
    b.lamp(SUN, 1.0, look_at((3, 3, 5), (0, 0, 0)), size=(0.1, 0))
    b.lamp(RECTANGLE, 80.0, look_at((0, 0, 4), (0, 0, 0), (0, 1, 0)), size=(1, 2))
    z = ARITHMETIC.call("position")[2]
    sky = b.material(program(("emission", (z * 0.2 + 0.3,) * 3)))
    masks = [[0, 0], [0b10, 0], [1 << 33, 0b100], [0, 1 << 62], [0b110, 0b110]]
    instances = [masks[0]] * 5 + [masks[2], masks[1]]
    return b.make(world_material=[sky], instance_unlinked=np.array(instances, np.uint64),
                  sphere_unlinked=np.array([masks[0], masks[1]], np.uint64),
                  light_unlinked=np.array(masks[1:], np.uint64),
                  instance_sets=[[0, 0], [1, 2], [33, 1], [2, 62], [1, 2], [0, 1], [0, 0]],
                  sphere_sets=[[33, 62], [0, 0]])
