"""A scene of pictures: of every kind of texel, interpolation and extension, on surfaces, on lights and as the world."""

import numpy as np

from isophote.materials import make_instruction
from isophote.records import numbers
from isophote.scene import Scene
from isophote.values import ARITHMETIC
from tests.scenes import POINT, Builder, ball, diffuse, emission, place, quad

TEXELS = (("TEXEL_BYTE", np.uint8, 255), ("TEXEL_SHORT", np.uint16, 65535), ("TEXEL_HALF", np.float16, 2.0),
          ("TEXEL_FLOAT", np.float32, 2.0))
SHAPES = ((5, 7, 4), (6, 4, 3), (8, 5, 1))  # rows, columns, channels


def outputs(name, *inputs, **data):
    return ARITHMETIC.call(name, inputs, **data)


def images() -> tuple[list, np.ndarray]:
    """Rows of the scene's images and their texels: each kind and shape with another mode."""
    n, rng = numbers(), np.random.default_rng(3)
    rows, texels, words = [], [], 0
    for kind, (name, dtype, high) in enumerate(TEXELS):
        for shape, (height, width, channels) in enumerate(SHAPES):
            plain = (rng.random((height, width, channels)) * high).astype(dtype).reshape(-1).view(np.uint8)
            mode = (kind + shape) % 3 << 2 | (kind + 2 * shape) % 4 << 4
            rows.append((words, width, height, channels, n[name], mode | (n["IMAGE_SRGB"] if kind < 2 else 0)
                         | (n["IMAGE_DIVIDE_ALPHA"] if channels == 4 else 0)))
            texels.append(np.pad(plain, (0, -len(plain) % 4)))
            words += len(texels[-1]) // 4
    return rows, np.concatenate(texels)


def shown(rows, number, u, v):
    """Colour of an image, dimmed by its alpha."""
    repeat = 4 ** (rows[number][5] >> 2 & 3)
    red, green, blue, alpha = outputs("image", u, v, data=number, repeat=repeat)
    return red * alpha, green * alpha, blue * alpha


def pictures() -> Scene:
    b = Builder((24, 18))
    b.look((0, -9, 4), (0, 0, 0.5), 0.6)
    rows, texels = images()
    x, y, z = outputs("object_point")
    tiles = outputs("tiled_image", x * 0.7 + 1.0, y * 0.5 + 0.5, data=0, repeat=4)
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(tiles[:3]))
    mesh = b.mesh(ball(rings=6), normals=ball(rings=6)[0])
    for number in range(len(rows)):
        projection = ("sphere_place", "tube_place", "mirror_ball_place")[number % 3]
        u, v = outputs(projection, x * 0.5 + 0.5, y * 0.5 + 0.5, z * 0.5 + 0.5)
        color = shown(rows, number, 1.7 * u - 0.4, 1.7 * v - 0.4)
        if number % 4 == 3:
            first, second, third, *forward = outputs("box_sides", number=0.3)
            color = tuple(c * (first + second * 0.5 + third * forward[0]) for c in color)
        where = (1.7 * (number % 6) - 4.2, 1.5 - 3 * (number // 6), 0.8)
        material = b.material(emission(color) if number % 5 == 4 else diffuse(color))
        b.instance(mesh, material, matrix=place(where, (0.75, 0.75, -0.75 if number % 2 else 0.75)))
    lit = [make_instruction("emission", tuple(6.0 * c for c in shown(rows, 10, x * 0.6, y * 0.8)))]
    b.add(quad((-3, 3, 3), (1, 0, 0), (0, 0.5, 0.8)), lit)
    mirrored = b.mesh(quad((0, 0, 0), (0.7, 0, 0), (0, 0.4, 0.8)))
    b.instance(mirrored, b.material(lit), matrix=place((3, 3, 3), (-1, 1, 1)))
    b.lamp(POINT, 100.0, place((3, -4, 5)), (0.3, 0))
    u, v = outputs("sky_place", *outputs("object_point"))
    red, green, blue = shown(rows, 7, u, v)
    world = b.material(emission((red * 0.5, green * 0.6, blue * 0.8)))
    return b.make(images=rows, image_texels=texels, value_tables=[3.0, 1.0, 4.0, 7.0], world_material=[world])
