"""What passes show beside light: UV maps, pass indices, mist, AOVs, mattes, occlusion, mirrors before what guides a
denoiser."""

import numpy as np

from isophote.cryptomatte import ids_of
from isophote.scene import Scene
from isophote.values import ARITHMETIC
from tests.scenes import POINT, Builder, ball, diffuse, emission, place, program, quad

CORNER = 4  # DOMAIN_ number
MIRROR = program(("glossy", (0.9, 0.8, 0.7), dict(roughness=0.0, multiscatter=0)))
VEIL = program(("transparent", 0.3), ("diffuse", (0.5, 0.2, 0.1)))


AOVS, GROUPS = ("color:Mask", "value:Height"), ("Key", "Sky", "Glow")
NAMED = (*AOVS, *(f"light:{name}" for name in GROUPS))


def shown() -> Scene:
    """A floor with a UV map under a veil, a mirror, a rough ball, and a sphere that has neither mesh nor UV."""
    b = Builder((20, 16), aovs=AOVS, light_groups=GROUPS)
    b.world = (0.3, 0.4, 0.5)
    b.look((0, -6, 2.5), (0, 0, 0.6), 0.45)
    place_of = ARITHMETIC.call("position", ())[:3]
    corners = np.array([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]])
    floor, uv = quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), [(CORNER, corners)]
    b.instance(b.mesh(floor, attributes=uv), b.material(diffuse((0.7, 0.6, 0.5)), [place_of, (place_of[0], 0.0, 0.0)]))
    veil = b.material(VEIL, [(1.0, 0.5, 0.25), (3.0, 0.0, 0.0)])
    b.instance(b.mesh(quad((-1, 0, 0.8), (0.8, 0, 0), (0, 0.2, 0.8)), attributes=uv), veil)
    mesh, material = b.mesh(ball((0, 0, 0), 0.7), attributes=[(0, np.zeros((0, 1)))]), b.material(MIRROR)
    b.instance(mesh, material, matrix=place((1.5, 0, 0.7)))
    b.instance(mesh, material, matrix=place((-1.5, 1, 0.7), (-1, 1, 1)))
    rough = program(("glossy", 0.8, dict(roughness=0.5, multiscatter=1)), ("diffuse", 0.1))
    b.sphere((0, 0.5, 0.7), 0.7, b.material(rough))
    b.lamp(POINT, 300.0, place((2, -3, 5)), size=(0.5, 0), flags=1 << 16)
    panel = b.mesh(quad((-2.5, 1, 2), (0.5, 0, 0), (0, 0, 0.5)), attributes=[(0, np.zeros((0, 1)))])
    b.instance(panel, b.material(emission((3, 2, 1))))
    ids = ids_of(["Floor", "Veil", "Ball", "Ball", "Panel", "Rough"])
    return b.make(mist=(4.0, 5.0, 0.5), uv_attribute=[0], instance_index=[1, 2, 3, 40000, 0],
                  sphere_index=[7], material_index=[0, 5, 0, 9, 0], instance_group=[0, 0, 0, 0, 3], world_group=2,
                  instance_matte=np.stack([ids[:5], ids[[0, 1, 1, 1, 0]]], axis=1), sphere_matte=ids[None, [5, 0]],
                  material_matte=ids_of("ABCDE"), occlusion_distance=1.5)
