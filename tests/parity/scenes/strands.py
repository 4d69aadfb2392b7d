"""A scene of hair: strands of many forms, still, moving and deforming."""

import numpy as np

from isophote.materials import make_instruction
from isophote.records import numbers
from isophote.scene import Scene
from isophote.values import ARITHMETIC, clamp
from tests.scenes import RECTANGLE, Builder, diffuse, emission, look_at, place, program, quad

DOMAIN_VERTEX, DOMAIN_TRIANGLE = numbers()["DOMAIN_VERTEX"], numbers()["DOMAIN_TRIANGLE"]


def tuft(count: int, points: int, bend: float, seed: int) -> np.ndarray:
    """Strands (count, points, 3) that grow out of a disc and bow."""
    rng = np.random.default_rng(seed)
    root = np.concatenate([rng.uniform(-0.5, 0.5, (count, 2)), np.zeros((count, 1))], axis=1)
    lean = np.concatenate([rng.normal(0, bend, (count, 2)), np.zeros((count, 1))], axis=1)
    t = np.linspace(0, 1, points)[None, :, None]
    return root[:, None] + t * np.array([0, 0, 1.2]) + t ** 2 * lean[:, None]


def by_length():
    """A colour by a vertex's number along the strand and by the strand."""
    along, strand = (ARITHMETIC.call("attribute", data=k)[0] for k in (0, 1))
    return [make_instruction("diffuse", (clamp(along), clamp(strand), clamp(1.0 - along)))]


def strands() -> Scene:
    """Thick and thin ones, pointed, balls without length, one ball within the other; instances that are squeezed and
    mirrored; transparent, shiny, emissive; one that moves, one that deforms."""
    b = Builder((24, 18))
    b.world = (0.4, 0.45, 0.5)
    b.look((0, -7, 2.5), (0, 0, 0.7), 0.42)
    b.add(quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), diffuse((0.6, 0.55, 0.5)))

    def grow(points, radii, **others):
        count, length = points.shape[:2]
        along = np.tile(np.linspace(0, 1, length), count)[:, None]
        strand = np.repeat(np.linspace(0, 1, count), length - 1)[:, None]
        return b.strands(points, radii, attributes=[(DOMAIN_VERTEX, along), (DOMAIN_TRIANGLE, strand)], **others)

    b.attributes[0] = [(0, np.zeros((0, 1))), (0, np.zeros((0, 1)))]
    matt, coloured, veil, shiny, glowing = (b.material(each) for each in (
        diffuse((0.7, 0.4, 0.2)), by_length(), program(("transparent", 0.6), ("diffuse", (0.2, 0.1, 0.1))),
        program(("diffuse", 0.2), ("glossy", 0.6, dict(roughness=0.2, multiscatter=1))), emission((3, 2, 1))))
    thin = grow(tuft(60, 5, 0.4, 1), np.linspace(0.02, 0.0, 5))
    thick = grow(tuft(5, 4, 0.6, 2), np.array([0.15, 0.02, 0.12, 0.05]))
    fine = grow(tuft(80, 3, 0.2, 3), 3e-4)
    beads = np.array([[(0, 0, 0.3), (0, 0, 0.3), (0.1, 0, 0.5), (0.1, 0.05, 0.5)]])
    for x, mesh, material in ((-3.0, thin, coloured), (-1.5, thick, matt), (0.0, thin, veil), (1.5, thick, shiny),
                              (3.0, fine, matt)):
        b.instance(mesh, material, matrix=place((x, 0, 0)))
    b.instance(thin, coloured, matrix=place((-2.2, -1.5, 0), (-1, 1, 0.6), 0.4))
    b.instance(thick, veil, matrix=place((0.8, -1.6, 0), (0.4, 0.9, -0.8), 1.0))
    b.instance(grow(beads, (0.3, 0.05, 0.1, 0.25)), shiny, matrix=place((2.2, -1.5, 0.1)))
    b.instance(grow(tuft(6, 3, 0.3, 4), 0.03), glowing, matrix=place((-0.6, -1.4, 0), 0.6))
    b.instance(thin, matt, keys=[place((-3.4, 1 + 0.3 * k, 0), (1, 1, 1 + 0.1 * k), 0.3 * k) for k in range(3)])
    swaying = tuft(20, 4, 0.5, 5)
    shapes = [((swaying + np.array([0.4 * k, 0, 0]) * np.linspace(0, 1, 4)[:, None] ** 2).reshape(-1, 3), None)
              for k in (-1, 0, 1)]
    b.instance(grow(swaying, 0.02, shapes=shapes), coloured, matrix=place((2.2, 1.2, 0)))
    b.lamp(RECTANGLE, 150.0, look_at((2, -4, 5), (0, 0, 0.5)), (1.0, 1.0))
    return b.make()
