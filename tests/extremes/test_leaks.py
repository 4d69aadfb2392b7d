"""Rays that leave a surface and rays that meet one: no light leaks in, no surface shadows itself, no crack, no plane
met twice."""

import numpy as np
import pytest

from tests.extremes.table import Row, step
from tests.extremes.variants import film, rgb, spaces
from tests.scenes import (
    POINT,
    SUN,
    Builder,
    ball,
    box,
    diffuse,
    join,
    look_at,
    mean_and_error,
    pixels,
    place,
    program,
    quad,
)

INSIDE = np.s_[:, ::-1]
SPACES = ("applied", "instanced", "mirrored")


# ------------------------------------------------------------------ closed rooms


def slivers(shape, pieces):
    """Each triangle as a fan of triangles to points along one edge: the more, the skinnier."""
    vertices, triangles = shape
    parts = []
    for a, b, c in vertices[triangles]:
        along = b + np.linspace(0, 1, pieces + 1)[:, None] * (c - b)
        parts.append((np.concatenate([[a], along]), np.array([[0, k + 1, k + 2] for k in range(pieces)])))
    return join(*parts)


def room(shape, normals=None, **arrays):
    """A room of walls of albedo 0.9 without a lamp, in a blinding world."""
    b = Builder((16, 16))
    b.world = 1e6
    b.look((0.3, -0.2, 0.4), (1, 1, 0.2), 1.5)
    b.lamp(SUN, 1e6, look_at((1, 2, 3), (0, 0, 0)), (0.1, 0))
    b.lamp(POINT, 1e6, look_at((9, 2, 3), (0, 0, 0)), (0.1, 0))
    vertices, triangles = shape
    b.add((vertices, triangles[INSIDE]), diffuse(0.9), normals=normals)
    return b.make(**arrays)


def turned(shape, seed):
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return shape[0] @ (turn * np.sign(np.linalg.det(turn))).T * 1.37 + 0.011, shape[1]


ROOMS = {"box": box(), "turned box": turned(box(), 5), "ball": ball(radius=1.5, rings=9),
         "slivers": slivers(turned(box(), 6), 50), "long": box(half=(1, 1, 1000)), "longer": box(half=(1, 1, 10000))}


@pytest.mark.parametrize("space", SPACES)
def test_closed_rooms_let_nothing_in(space):
    samples = step(128, 2048)
    with Row("leaks", f"closed rooms ({', '.join(ROOMS)}), {16 * 16 * samples:.0e} paths each, {space}",
             "pixels that light has reached") as row:
        for name, shape in ROOMS.items():
            row.see(np.count_nonzero(pixels(film(spaces(room(shape))[space], samples))[..., 0]), name)


@pytest.mark.parametrize("space", SPACES)
def test_lifted_rays_let_nothing_in(space):
    """Rooms with the normals of a ball, from which rays to lights start as high as they may."""
    samples = step(128, 2048)
    with Row("leaks", f"smooth closed rooms, shadow terminator offsets 0.1 and 1, {space}",
             "pixels that light has reached") as row:
        for name in ("box", "turned box", "ball"):
            vertices, triangles = ROOMS[name]
            normals = -vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
            for offset in (0.1, 1.0):
                scene = room((vertices, triangles), normals=normals, instance_terminator=[offset])
                row.see(np.count_nonzero(pixels(film(spaces(scene)[space], samples))[..., 0]), f"{name}, {offset}")


# ------------------------------------------------------------------ acne and cracks


def tiled(parts, half=20.0):
    """A plane of parts x parts squares, coplanar and touching."""
    steps = (np.arange(parts) - (parts - 1) / 2) * 2 / parts * half
    return join(*(quad((x, y, 0), (half / parts, 0, 0), (0, half / parts, 0)) for x in steps for y in steps))


GROUNDS = {"one quad": quad((3, 2, 0), (20, 0, 0), (0, 20, 0)), "touching squares": tiled(9),
           "coincident squares": join(*(quad((3 + 0.1 * k, 2, 0), (20, 0, 0), (0, 20, 0)) for k in range(4))),
           "slivers": slivers(quad((3, 2, 0), (20, 0, 0), (0, 20, 0)), 300),
           "10 km": quad((3e3, 2e3, 0), (1e4, 0, 0), (0, 1e4, 0)),
           "10 km by 1 m": quad((0.1, 2e3, 0), (1, 0, 0), (0, 1e4, 0))}


@pytest.mark.parametrize("space", SPACES)
def test_no_surface_shadows_itself(space):
    """A plane, tilted, of albedo 1/2 in a white world has radiance 1/2: a ray that meets it again would be lost."""
    tilt = np.array([[np.cos(0.3), 0, np.sin(0.3)], [0, 1, 0], [-np.sin(0.3), 0, np.cos(0.3)]])
    with Row("self-intersection", f"planes ({', '.join(GROUNDS)}), tilted, {space}",
             "mean off albedo times world, beyond 3 standard errors", 1e-5) as row:
        for name, (vertices, triangles) in GROUNDS.items():
            b = Builder((8, 8))
            b.world = 1.0
            b.look((0.2, 0.1, 3), (0.2, 0.1, 0), 0.1, up=(0, 1, 0))
            b.add((vertices @ tilt.T, triangles), diffuse(0.5))
            mean, error = mean_and_error(film(spaces(b.make())[space], step(256, 4096)))
            row.see(np.maximum(0, np.abs(mean - 0.5) - 3 * error), name)


@pytest.mark.parametrize("space", SPACES)
def test_no_cracks_along_edges_and_through_vertices(space):
    """Rays straight through vertices and along edges, from straight above and from the sides: not one passes."""
    b = Builder((32, 32))
    b.world = 1.0
    grid = (np.arange(9) - 4) / 4.0
    vertices = np.array([(x, y, 0.0) for x in grid for y in grid])
    triangles = np.array([t for i in range(8) for j in range(8) for t in
                          ((9 * i + j, 9 * i + j + 9, 9 * i + j + 10), (9 * i + j, 9 * i + j + 10, 9 * i + j + 1))])
    vertices[:, 2] += np.random.default_rng(3).uniform(-0.05, 0.05, len(vertices))
    b.add((vertices, triangles), diffuse(0.0))
    with Row("cracks", f"camera rays through the vertices and along the edges of a mesh of 128 triangles, {space}",
             "rays that pass") as row:
        for toward in ((0, 0, 1), (1, 0, 1), (1, 1, 1), (-1, 2, 3)):
            # Pixels' centers fall on vertices and edges; the filter is a point.
            b.look(5 * np.array(toward, float), (0, 0, 0), 0.5, orthographic=True, up=(0, 1, 0))
            seen = pixels(film(spaces(b.make())[space], 2, filter_width=0.0))[..., 0]
            row.see(np.count_nonzero(seen), toward)


# ------------------------------------------------------------------ layers


@pytest.mark.parametrize("space", SPACES)
def test_each_of_64_planes_counts_once(space):
    """Coincident and nearly coincident planes, met by paths and by shadow rays."""
    kept = np.array((0.99, 0.97, 0.9))
    with Row("mid-ray restart", f"64 planes, 0 ... 1e-3 m apart, path and shadow rays, {space}",
             "transmittance, relative", 3e-5) as row:
        for gap in (0.0, 1e-12, 1e-7, 1e-5, 1e-3):
            b = Builder((8, 8))
            b.world = 1.0
            b.look((0, 0, 1), (0.1, 0.2, 0), 0.3, up=(0, 1, 0))
            veil = b.material(program(("transparent", kept)))
            for k in range(64):
                b.instance(b.mesh(quad((8, 0, 0), (20, 0, 0), (0, 20, 0))), veil, matrix=place((0, 0, -gap * k)))
            made = rgb(film(spaces(b.make())[space], 4, transparent_bounces=64))
            row.see(made / kept ** 64 - 1, f"path, {gap:g} m")
            b.world = 0.0
            b.look((0, 0, -1.5), (0, 0, -2), 0.1, up=(0, 1, 0))  # behind them all, at a lit floor
            b.add(quad((8, 0, -2), (20, 0, 0), (0, 20, 0)), diffuse(1.0))
            b.lamp(SUN, np.pi, look_at((0.1, 0.2, 1), (0, 0, 0)))
            toward = np.array((0.1, 0.2, 1)) / np.linalg.norm((0.1, 0.2, 1))
            made = rgb(film(spaces(b.make())[space], 4, transparent_bounces=64, max_bounces=0))
            row.see(made / (kept ** 64 * toward[2]) - 1, f"shadow, {gap:g} m")
