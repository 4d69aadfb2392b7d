"""Shadows on catchers, in front of which and behind which there is more."""

from isophote.scene import Scene
from isophote.values import ARITHMETIC
from tests.scenes import (
    ALL,
    CATCHES,
    POINT,
    RECTANGLE,
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


def caught() -> Scene:
    """A floor with a transparent part, an instance and a sphere that catch; balls, one of wax, a veil, a mirror, a
    panel and a sphere that shines beside them, in fog; a world that is drawn and lamps."""
    b = Builder((20, 16))
    b.look((0, -6, 2.5), (0, 0, 0.6), 0.45)
    b.instance(b.mesh(quad((0, 0, 0), (5, 0, 0), (0, 5, 0))),
               b.material(program(("diffuse", (0.5, 0.4, 0.3)), ("transparent", 0.2),
                                  ("glossy", 0.2, dict(roughness=0.2, multiscatter=1)))), visibility=CATCHES)
    body = b.mesh(ball((0, 0, 0), 0.7, 5))
    walk = {f"{name}_{c}": 0.2 if name == "radius" else 0.8 for name in ("radius", "albedo") for c in "rgb"}
    wax = program(("subsurface", 0.8, dict(anisotropy=0.0, ior=1.4, roughness=0.5, diffuse=0.0) | walk))
    mirror = program(("glossy", 0.9, dict(roughness=0.0, multiscatter=0)))
    for k, instructions in enumerate([wax, mirror, diffuse(0.6)]):
        b.instance(body, b.material(instructions), matrix=place((1.6 * k - 1.6, 0.5, 0.7)),
                   visibility=CATCHES if k == 2 else ALL)
    b.add(quad((-1, -1, 0.8), (0.8, 0, 0), (0, 0.2, 0.8)), program(("transparent", 0.5), ("diffuse", 0.3)))
    b.add(quad((0, 2, 1), (0.8, 0, 0), (0, 0, 0.8)), emission((3, 2, 1)))
    b.sphere((0, -2, 0.4), 0.4, b.material(diffuse(0.5)), visibility=CATCHES)
    b.sphere((1.5, -2, 0.3), 0.3, b.material(emission(2)))
    z = ARITHMETIC.call("position")[2]
    b.lamp(POINT, 300.0, place((2, -3, 5)), size=(0.5, 0))
    b.lamp(RECTANGLE, 80.0, look_at((0, 0, 4), (0, 0, 0), (0, 1, 0)), size=(1, 2))
    b.add(box((0.8, -0.5, 0.8), (1.5, 1.5, 0.7)), [], volume=medium(0.1, 0.4))
    b.sphere((-1.5, -1, 0.6), 0.5, b.material([], volume=medium(0.2, 0.5)), visibility=CATCHES)
    sky = b.material(program(("emission", (z * 0.2 + 0.3,) * 3)))
    return b.make(occlusion_distance=1.5, world_material=[sky], **b.fill_world(medium(0.01, 0.03)))
