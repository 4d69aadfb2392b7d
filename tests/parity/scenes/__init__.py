"""Scenes that together use everything that kernels know: what must give the same bits everywhere."""

import numpy as np

from isophote.materials import make_instruction
from isophote.records import numbers
from isophote.scene import Scene
from isophote.values import ARITHMETIC, clamp
from tests.parity.scenes.caught import caught
from tests.parity.scenes.conversions import conversions
from tests.parity.scenes.inputs import inputs
from tests.parity.scenes.linked import linked
from tests.parity.scenes.moving import between_frames, moving
from tests.parity.scenes.pictures import pictures
from tests.parity.scenes.shown import NAMED, shown
from tests.parity.scenes.skies import under_skies
from tests.parity.scenes.strands import strands
from tests.parity.scenes.volumes import clouds, volumes
from tests.scenes import (
    CAMERA,
    DIFFUSE,
    ELLIPSE,
    GLOSSY,
    POINT,
    RECTANGLE,
    SHADOW,
    SPOT,
    SUN,
    TRANSMISSION,
    Builder,
    ball,
    box,
    diffuse,
    emission,
    look_at,
    place,
    program,
    quad,
)

INWARDS = np.s_[:, ::-1]  # turns triangles round
TINT = dict(tint_r=0.9, tint_g=0.8, tint_b=1.0)
MIRROR = program(("glossy", 0.95, dict(roughness=0.0, multiscatter=0)))
GLASS = program(("glass", 1.0, dict(roughness=0.0, ior=1.5, multiscatter=0)))


def cornell_like() -> Scene:
    """A closed box with coloured walls, two blocks, an emissive panel and a rectangle lamp."""
    b = Builder((20, 16))
    b.look((0, -3.8, 1), (0, 0, 1), 0.38)
    vertices, triangles = box((0, 0, 1), (1, 4, 1))
    white, red, green = (b.material(diffuse(albedo)) for albedo in (0.8, (0.7, 0.1, 0.1), (0.1, 0.6, 0.1)))
    slots = np.repeat([1, 2, 0, 0, 0, 0], 2)
    b.instance(b.mesh((vertices, triangles[INWARDS]), slots), white, red, green)
    block = b.mesh(box(half=(0.3, 0.3, 0.6)))
    b.instance(block, white, matrix=place((-0.35, 0.4, 0.6), 1, 0.3))
    b.instance(block, b.material(MIRROR), matrix=place((0.4, -0.2, 0.3), (1, 1, 0.5), -0.4))
    b.add(quad((0, 0, 1.99), (0.3, 0, 0), (0, -0.3, 0)), emission((12, 10, 8)))
    b.lamp(RECTANGLE, 5.0, look_at((0.7, -3, 1.6), (0, 0, 0.5)), (0.4, 0.2))
    return b.make()


def spheres() -> Scene:
    """Mirror, glass, rough glass and a smooth mesh on a floor under a world and a lamp; two spheres touch."""
    b = Builder((20, 16))
    b.world = (0.4, 0.5, 0.7)
    b.look((0, -6, 2.5), (0, 0, 0.6), 0.45)
    b.add(quad((0, 0, 0), (5, 0, 0), (0, 5, 0)), diffuse((0.7, 0.6, 0.5)))
    rough = program(("glass", 1.0, dict(roughness=0.4, ior=1.33, multiscatter=1, **TINT)))
    for x, instructions in ((-2.0, MIRROR), (0.0, GLASS), (2.0, rough)):
        b.sphere((x, 0, 1.0), 1.0, b.material(instructions))
    shape = ball(radius=0.6, rings=6)
    b.add((shape[0] + (0.3, -1.6, 0.6), shape[1]), diffuse((0.2, 0.7, 0.3)), normals=shape[0] / 0.6)
    b.add((shape[0] * 0.5 + (-1.2, -1.8, 0.4), shape[1]), GLASS, normals=shape[0] / 0.6)
    b.sphere((-0.9, -1.5, 0.1), 0.1, b.material(emission((4, 2, 1))))
    b.lamp(POINT, 300.0, place((3, -4, 5)), (0.3, 0))
    return b.make(instance_terminator=[0.1, 0.3, 0.1])


def instances() -> Scene:
    """Instances turned, squeezed and mirrored, smooth and emissive ones, behind coincident transparent planes."""
    b = Builder((20, 16))
    b.world = (0.6, 0.6, 0.8)
    b.look((0, -8, 3), (0, 0, 0.8), 0.4)
    shape = ball(rings=5)
    smooth = b.mesh(shape, normals=shape[0])
    cube, panel = b.mesh(box(half=0.5)), b.mesh(quad((0, 0, 0), (1, 0, 0), (0, 0, 1)))
    glossy = b.material(program(("glossy", 0.9, dict(roughness=0.3, multiscatter=1, **TINT))))
    coated = b.material(program(("specular", 1.0, dict(roughness=0.2, multiscatter=1, ior=1.5)),
                                ("layer_specular", 1.0, dict(roughness=0.2, multiscatter=1, ior=1.5)),
                                ("diffuse", (0.6, 0.2, 0.1))))
    veil = b.material(program(("transparent", (0.8, 0.6, 0.9)), ("diffuse", (0.1, 0.2, 0.1))))
    glow = b.material(program(("emission", (3, 2, 1)), ("diffuse", 0.3)))
    b.instance(cube, b.material(diffuse(0.7)), matrix=place((0, 0, -0.5), (12, 12, 1)))
    for k, scale in enumerate(((1, 1, 1), (-1, 1, 1), (0.5, 1.2, 0.7), (-0.6, -0.8, -1))):
        b.instance(smooth, glossy if k % 2 else coated, matrix=place((2.2 * k - 3.3, 0.8, 1), scale, 0.5 * k))
        small = place((1.5 * k - 2.2, -1.2, 0.5), np.multiply(scale, 0.7), k)
        b.instance(cube, glow if k == 2 else coated, matrix=small)
    for _ in range(3):
        b.instance(panel, veil, matrix=place((0.5, -2.2, 0.6), (1.5, 1, 1.2)))
    b.lamp(SUN, 2.0, look_at((3, -2, 6), (0, 0, 0)), (0.1, 0))
    return b.make(instance_terminator=[0.1 * (k % 3) for k in range(len(b.instances))])


def lamps() -> Scene:
    """Every lamp with and without a size, and objects that hide from one kind of rays each."""
    b = Builder((20, 16))
    b.look((0, -7, 4), (0, 0, 0.3), 0.5)
    b.add(quad((0, 0, 0), (6, 0, 0), (0, 6, 0)),
          program(("diffuse", 0.6), ("glossy", 0.3, dict(roughness=0.2, multiscatter=0))))
    b.add(quad((0, 4, 2), (6, 0, 0), (0, 0, 2)), diffuse((0.5, 0.6, 0.8)))
    for k, kind in enumerate((POINT, SPOT, SUN, RECTANGLE, ELLIPSE)):
        for size in (0.0, 0.4):
            strength = 0.3 if kind == SUN else 40.0
            where = look_at((1.5 * k - 3.2, 1.5 - 3 * size, 2 + size), (1.2 * k - 2.5, 0, 0))
            area = (max(size, 0.2), 0.3)
            b.lamp(kind, strength * np.array((1, 0.8, 0.3 + 0.1 * k)), where, area if kind >= RECTANGLE else (size, 0),
                   (0.8, 0.3 * (size > 0)), visibility=31 - CAMERA * (k % 2))
    paint = b.material(diffuse((0.8, 0.3, 0.2)))
    cube = box(half=0.4)
    for k, kind in enumerate((CAMERA, DIFFUSE, GLOSSY, TRANSMISSION, SHADOW)):
        b.instance(b.mesh(cube), paint, matrix=place((1.4 * k - 2.8, -1.5, 0.4), 1, k), visibility=31 - kind)
    b.sphere((0, -2.6, 0.3), 0.3, paint, visibility=31 - SHADOW)
    return b.make()


def shaped_lamps() -> Scene:
    """Lamps with a spread, a stretched cone, programs of their own; hidden from kinds of rays or from many bounces."""
    b = Builder((20, 16))
    b.look((0, -7, 4), (0, 0, 0.3), 0.5)
    b.add(quad((0, 0, 0), (6, 0, 0), (0, 6, 0)),
          program(("diffuse", 0.6), ("glossy", 0.3, dict(roughness=0.2, multiscatter=0))))
    b.add(quad((0, 4, 2), (6, 0, 0), (0, 0, 2)), diffuse((0.5, 0.6, 0.8)))
    x, y, z = ARITHMETIC.call("position")
    striped = [ARITHMETIC.call("sine", (part * 9.0,))[0] * 0.4 + 0.6 for part in (x, y, z)]
    made = b.material(program(("emission", striped)))
    for k, kind in enumerate((POINT, SPOT, SUN, RECTANGLE, ELLIPSE)):
        where = look_at((1.5 * k - 3.2, 1.0, 2.2), (1.2 * k - 2.5, 0, 0))
        if kind == SPOT:
            where = where * (0.6, 1.3, 0.9, 1)
        area = (0.5, 0.3)
        for material, flags in ((None, 3 << 8), (made, 0)):
            strength = (0.3 if kind == SUN else 40.0) * np.array((1, 0.8, 0.3 + 0.1 * k))
            b.lamp(kind, strength, where, area if kind >= RECTANGLE else (0.2, 0), (0.8, 0.3), flags,
                   visibility=31 - (DIFFUSE, GLOSSY, CAMERA)[k % 3], spread=0.9 if kind >= RECTANGLE else 0.0,
                   material=material)
    b.instance(b.mesh(box(half=0.4)), b.material(diffuse((0.8, 0.3, 0.2))), matrix=place((0.5, -1.5, 0.4), 1, 0.5))
    return b.make()


def closures() -> Scene:
    """One ball for each closure at two roughnesses, and mixes of them, under a world."""
    b = Builder((24, 16))
    b.world = (0.8, 0.9, 1.0)
    b.look((0, -9, 3), (0, 0, 0.5), 0.55)
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    metal = dict(f0_r=0.9, f0_g=0.6, f0_b=0.3, f82_r=0.8, f82_g=0.9, f82_b=1.0)
    leaf = dict(transmission_r=0.9, transmission_g=0.5, transmission_b=0.2, ior=1.45, **TINT)
    mesh = b.mesh(ball(rings=6), normals=ball(rings=6)[0])
    for row, roughness in enumerate((0.0, 0.35)):
        common = dict(roughness=roughness, multiscatter=row)
        materials = [
            program(("refraction", 0.9, dict(roughness=roughness, ior=1.3))),
            program(("glass", 1.0, dict(ior=1.6, **common, **TINT))),
            program(("metal", 1.0, common | metal)),
            program(("principled_glass", 0.7, common | leaf), ("diffuse", 0.2), ("transparent", (0.1, 0, 0))),
            program(("specular", 1.0, dict(ior=1.5, **common)), ("layer_specular", 1.0, dict(ior=1.5, **common)),
                    ("diffuse", (0.1, 0.3, 0.7)), ("emission", (0.1, 0.05, 0))),
            program(("glossy", (0.5, 0.5, 0.4), common), ("diffuse", 0.3)),
        ]
        for column, instructions in enumerate(materials):
            b.instance(mesh, b.material(instructions), matrix=place((1.7 * column - 4.2, 1.5 - 3 * row, 0.8), 0.75))
    b.lamp(RECTANGLE, 200.0, look_at((2, -4, 6), (0, 0, 0)), (2, 1))
    return b.make()


def rare_closures() -> Scene:
    """One ball for each closure that few scenes have, and stacks of layers, under a world."""
    b = Builder((24, 18))
    b.world = (0.8, 0.9, 1.0)
    b.look((0, -9, 4), (0, 0, 0.5), 0.6, lens=(0.1, 9.0, 5, 0.3, 1.4))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    rough = dict(roughness_x=0.5, roughness_y=0.2)
    common = dict(multiscatter=1, **rough)
    silver = dict(n_r=0.15, n_g=0.12, n_b=0.14, k_r=4.8, k_g=3.5, k_b=2.4)
    metal = dict(f0_r=0.9, f0_g=0.6, f0_b=0.3, f82_r=0.8, f82_g=0.9, f82_b=1.0)
    film = dict(ior=1.6, thickness=400.0, film_ior=1.4, **TINT)
    leaf = dict(transmission_r=0.9, transmission_g=0.5, transmission_b=0.2)
    coat = dict(roughness=0.1, multiscatter=1, ior=1.5)
    stack = program(
        ("sheen", 0.5, dict(roughness=0.4)), ("layer_sheen", 0.5, dict(roughness=0.4)), ("specular", 0.8, coat),
        ("layer_specular", 0.8, coat), ("layer_absorption", 0.8, dict(ior=1.5, **TINT)), ("diffuse", 0.4),
        ("layer_reset", 1.0), ("film_specular", 0.5, common | film), ("layer_film_specular", 1.0, common | film),
        ("rough_diffuse", 0.5, dict(roughness=0.6, albedo_r=0.9, albedo_g=0.5, albedo_b=0.2)))
    materials = [
        stack,
        program(("film_glass", 1.0, dict(roughness=0.3, multiscatter=1) | film | leaf)),
        program(("translucent", 0.8), ("velvet", 0.2, dict(sigma=0.4))),
        program(("diffuse_toon", 0.5, dict(size=0.6, smooth=0.1)), ("glossy_toon", 0.5, dict(size=0.2, smooth=0.1))),
        program(("beckmann", 0.9, rough)),
        program(("ashikhmin_shirley", 0.9, rough)),
        program(("beckmann_glass", 1.0, dict(roughness=0.4, ior=1.5, reflects=1, **TINT))),
        program(("conductor", 1.0, dict(roughness=0.3, multiscatter=1) | silver)),
        program(("aniso_conductor", 1.0, common | silver)),
        program(("aniso_metal", 1.0, common | metal)),
        program(("aniso_glossy", 0.9, common | TINT)),
        program(("aniso_specular", 0.9, dict(ior=1.5) | common), ("holdout", 0.1)),
    ]
    mesh = b.mesh(ball(rings=6), normals=ball(rings=6)[0])
    for k, instructions in enumerate(materials):
        b.instance(mesh, b.material(instructions), matrix=place((1.7 * (k % 6) - 4.2, 1.5 - 3 * (k // 6), 0.8), 0.75))
    b.lamp(RECTANGLE, 200.0, look_at((2, -4, 6), (0, 0, 0)), (2, 1))
    return b.make()


def moving_panorama() -> Scene:
    """A fisheye lens, one eye of two, that turns and moves while its shutter opens slowly; what it sees knows of it."""
    b = Builder((24, 18))
    b.world = (0.3, 0.4, 0.5)
    turns = [(0.1 * k, 0, 1, 0.1 * k, 0.05, 0, np.sqrt(1 - 0.0025 - 0.01 * k * k)) for k in (-1, 0, 1)]
    b.camera = dict(camera_kind=numbers()["CAMERA_EQUISOLID"], camera_clip=(0.1, 100),
                    camera_lens=(0.05, 2, 5, 0.3, 1.4),
                    camera_to_world=[(0, -1, 0, 0), (1, 0, 0, 0), (0, 0, -1, 1)], camera_window=(-1.5, 1.5, -1.1, 1.1),
                    camera_panorama=(1.5, 0, 0, 0, 0, 0, 0.1, 0), camera_stereo=(0.1, 2.0, 0.5, 1.0))
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.5))
    b.add(quad((0, 5, 0), (9, 0, 0), (0, 0, 9)), diffuse(0.5))
    window = ARITHMETIC.call("window_point", ARITHMETIC.call("camera_point", ()))
    for material in (diffuse(0.6), program(("emission", list(window))), program(("transparent", 0.7))):
        b.instance(b.mesh(quad((0, 0, 0), (1, 0, 0), (0, 0, 1))), b.material(material),
                   matrix=place((2.2 * len(b.instances) - 6.6, 2.5, 1)))
    b.lamp(RECTANGLE, 100.0, look_at((2, -4, 6), (0, 0, 0)), (2, 1))
    return b.make(camera_poses=turns, shutter_curve=(0.2, 1.0, 0.5))


def skins() -> Scene:
    """Light below surfaces: of a sphere with another one in it, of instances, some mirrored; constants and what varies,
    with normals of its own, mixed and layered; seen in a floor that is rough and glossy."""
    b = Builder((20, 16))
    b.world = (0.6, 0.7, 0.9)
    b.look((0, -7, 3), (0, 0, 0.7), 0.45)
    b.add(quad((0, 0, 0), (6, 0, 0), (0, 6, 0)),
          program(("diffuse", 0.4), ("glossy", 0.4, dict(roughness=0.1, multiscatter=1))))

    def walk(radius, albedo, **others):
        params = dict(anisotropy=0.0, ior=1.4, roughness=0.7, diffuse=0.0) | others
        params |= {f"{name}_{c}": v for name, three in (("radius", radius), ("albedo", albedo))
                   for c, v in zip("rgb", three, strict=True)}
        return "subsurface", albedo, params

    wax = walk((0.1, 0.2, 0.05), (0.9, 0.8, 0.4))
    skin = walk((0.3, 0.1, 0.1), (0.8, 0.1, 0.0), anisotropy=0.8, diffuse=0.5)
    coat = dict(roughness=0.2, multiscatter=1, ior=1.5)
    marbled = clamp(ARITHMETIC.call("position")[0] * 0.5 + 0.5)
    uneven = walk((marbled * 0.3 + 0.05,) * 3, (0.9, marbled, 0.3))
    x, y, z = ARITHMETIC.call("shading_normal")
    bent = ARITHMETIC.call("unit_normal", (x + 0.3, y, z))[:3]
    bumped = [make_instruction(*uneven[:2], normal=bent, **uneven[2]), *program(("diffuse", 0.1))]
    body = b.mesh(ball(rings=6), normals=ball(rings=6)[0])
    coated = program(("specular", 1.0, coat), ("layer_specular", 1.0, coat), wax)
    for k, (instructions, scale) in enumerate([
            (program(wax), (1, 1, 1)), (program(skin, ("diffuse", 0.2)), (-1, 1, 0.7)), (coated, (0.7, -0.8, 1)),
            (program(uneven), (1, 1, 1)), (bumped, (0.9, 1, 1))]):
        b.instance(body, b.material(instructions), matrix=place((1.9 * k - 3.8, 0.8, 0.9), np.multiply(scale, 0.9), k))
    b.sphere((-1.2, -1.6, 0.6), 0.6, b.material(program(skin)))
    b.sphere((-1.2, -1.6, 0.6), 0.4, b.material(diffuse((0.1, 0.8, 0.1))))
    b.add((0.5 * ball(rings=5)[0] + (1.0, -1.8, 0.5), ball(rings=5)[1]), program(wax, ("transparent", 0.3)))
    b.lamp(POINT, 300.0, place((3, -4, 5)), (0.3, 0))
    return b.make()


SCENES = {scene.__name__: scene for scene in (
    cornell_like, spheres, instances, lamps, shaped_lamps, closures, rare_closures, conversions, inputs, pictures,
    shown, under_skies, moving_panorama, skins, linked, moving, between_frames, caught, volumes, clouds, strands)}
# Settings of each beside the defaults: short paths for one, clamping and a transparent film for others.
SETTINGS = {
    "cornell_like": {},
    "spheres": dict(max_bounces=8, filter_width=2.5),
    "instances": dict(film_transparent=True),
    "lamps": dict(diffuse_bounces=1, clamp_direct=4.0, clamp_indirect=1.0),
    "shaped_lamps": dict(max_bounces=4),
    "closures": dict(seed=7),
    "rare_closures": dict(seed=8, film_transparent=True),
    "conversions": dict(max_bounces=2),
    "moving_panorama": dict(max_bounces=4),
    "between_frames": dict(max_bounces=3),
    "moving": dict(max_bounces=6, clamp_indirect=8.0),
    "inputs": dict(max_bounces=6),
    "shown": dict(film_transparent=True, named=NAMED),
    "skins": dict(film_transparent=True, clamp_indirect=4.0),
    "linked": dict(film_transparent=True, max_bounces=5),
    "caught": dict(film_transparent=True, max_bounces=5, clamp_indirect=10.0),
    "pictures": dict(max_bounces=6, clamp_direct=20.0, clamp_indirect=10.0),
    "under_skies": dict(max_bounces=4),
    "clouds": dict(volume_bounces=2, max_bounces=4),
    "strands": dict(max_bounces=5),
    "volumes": dict(volume_bounces=3, film_transparent=True, clamp_indirect=4.0),
}
