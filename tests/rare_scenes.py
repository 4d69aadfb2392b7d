"""Scenes whose light arrives by rare events: what error bars find hardest, at low counts of samples."""

from isophote.scene import Scene
from tests.scenes import POINT, Builder, ball, box, diffuse, emission, place, program, quad

GLASS = program(("glass", 1.0, dict(roughness=0.0, ior=1.5, multiscatter=0)))
SIZE = (64, 64)


def bulb() -> Scene:
    """A tiny bright light within a bulb of clear glass: no light but by hitting it through the glass."""
    b = Builder(SIZE)
    b.look((0, -4, 1.5), (0, 0, 0.7), 0.5)
    b.add(quad((0, 0, 0), (4, 0, 0), (0, 4, 0)), diffuse(0.7))
    b.add(quad((0, 1.5, 2), (4, 0, 0), (0, 0, 2)), diffuse((0.6, 0.3, 0.2)))
    b.add(box((-0.9, 0.3, 0.3), 0.3), diffuse(0.5))
    b.sphere((0, 0, 1), 0.3, b.material(GLASS))
    b.sphere((0, 0, 1), 0.05, b.material(emission(300.0)))
    return b.make()


def caustic() -> Scene:
    """A glass ball on a floor, under a panel and a small bright light that only closures find: caustics beneath it."""
    b = Builder(SIZE)
    b.look((0, -4, 2.5), (0, 0, 0.3), 0.4)
    b.add(quad((0, 0, 0), (4, 0, 0), (0, 4, 0)), diffuse(0.7))
    b.sphere((0.2, 0, 0.6), 0.6, b.material(GLASS))
    b.sphere((-1.5, 0.5, 3), 0.15, b.material(emission(100.0)))
    b.add(quad((1.5, 0, 4), (0.5, 0, 0), (0, -0.5, 0)), emission(4.0))
    return b.make()


def fence() -> Scene:
    """Nothing but edges: thin slats before a bright world, and their shadows of a point light."""
    b = Builder(SIZE)
    b.world = (0.6, 0.7, 0.9)
    b.look((0, -6, 2), (0, 0, 0.8), 0.4)
    b.add(quad((0, 0, 0), (8, 0, 0), (0, 8, 0)), diffuse(0.6))
    slat, wood = b.mesh(box(half=(0.03, 0.03, 0.8))), b.material(diffuse((0.3, 0.2, 0.1)))
    for k in range(30):
        b.instance(slat, wood, matrix=place((0.17 * k - 2.5, 0.3 * (k % 3), 0.8), 1, 0.1 * k))
    b.lamp(POINT, 400.0, place((2, 3, 4)), (0.0, 0))
    return b.make()


def glints() -> Scene:
    """A glossy, bumpy ball that mirrors a small light here and there."""
    b = Builder(SIZE)
    b.world = 0.05
    b.look((0, -4, 1.2), (0, 0, 0.8), 0.4)
    b.add(quad((0, 0, 0), (4, 0, 0), (0, 4, 0)), program(("diffuse", 0.3), ("glossy", 0.4, dict(roughness=0.15,
                                                                                               multiscatter=0))))
    b.add(ball((0, 0, 0.8), 0.8, 12), program(("glossy", 0.9, dict(roughness=0.05, multiscatter=0))))
    b.sphere((-1, -1, 2.5), 0.08, b.material(emission(200.0)))
    return b.make()


def niche() -> Scene:
    """Uneven noise: a small room with a lamp behind a board, open to the front, on a wide floor under an even sky."""
    b = Builder(SIZE)
    b.world = (0.7, 0.75, 0.8)
    b.look((0, -4.2, 1.5), (0, 0, 0.8), 0.5)
    b.add(quad((0, 0, 0), (12, 0, 0), (0, 12, 0)), diffuse(0.6))
    for side in (quad((0, 1.2, 0.8), (0.8, 0, 0), (0, 0, 0.8)), quad((-0.8, 0.4, 0.8), (0, 0.8, 0), (0, 0, 0.8)),
                 quad((0.8, 0.4, 0.8), (0, -0.8, 0), (0, 0, 0.8)), quad((0, 0.4, 1.6), (0.8, 0, 0), (0, -0.8, 0)),
                 quad((0, 0.4, 0.01), (0.8, 0, 0), (0, 0.8, 0))):
        b.add(side, diffuse(0.75))
    b.add(quad((0, 0.4, 1.4), (0.3, 0, 0), (0, -0.3, 0)), diffuse(0.5))
    b.add(quad((0, 0.4, 1.5), (0.05, 0, 0), (0, 0.05, 0)), emission(100.0))
    return b.make()


SCENES = {scene.__name__: scene for scene in (bulb, caustic, fence, glints)}
UNEVEN = {scene.__name__: scene for scene in (niche,)}
