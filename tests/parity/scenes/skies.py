"""A scene under a sky with a sun that is drawn apart, and of surfaces that show skies of each kind."""

import math

import numpy as np

from isophote import skies
from isophote.records import numbers
from isophote.scene import Scene
from isophote.values import ARITHMETIC, maximum
from tests.scenes import Builder, ball, diffuse, emission, place, quad

ELEVATION, TURN, SIZE = 0.5, 0.8, 0.03


def outputs(name, *inputs, **data):
    return ARITHMETIC.call(name, inputs, **data)


def under_skies() -> Scene:
    b = Builder((24, 18))
    b.look((0, -9, 4), (0, 0, 0.5), 0.6)
    airs = [skies.Air(often, ELEVATION, 100.0, 1.0, 1.0, 1.0) for often in (False, True)]
    pictures = [skies.dome(airs[0])[::4, ::8], skies.globe(airs[1])[::4, ::8]]
    words = [picture.size for picture in pictures]
    flags = numbers()["IMAGE_LINEAR"] | numbers()["IMAGE_EXTEND"] << 2
    images = [(first, picture.shape[1], picture.shape[0], 3, numbers()["TEXEL_FLOAT"], flags)
              for first, picture in zip((0, words[0]), pictures, strict=True)]
    level = math.cos(ELEVATION)
    middle = np.array([-level * math.sin(TURN), level * math.cos(TURN), math.sin(ELEVATION)])
    disc = skies.setting_disc(airs[0], SIZE)
    tables = [skies.preetham(middle, 3.0), skies.hosek_wilkie(middle, 4.5, 0.3),
              [*middle, SIZE / 2, disc.lowest, disc.factor, disc.summand, *(disc.low * 1e-2), *(disc.high * 1e-2)]]
    first = np.cumsum([0, *map(len, tables)])
    direction = outputs("object_point")

    def analytic(model):
        found = outputs("daylight", *direction, data=int(first[model]), number=1.0 - model)
        return [maximum(x * 0.05, 0.0) for x in found]

    def shown(number, u, v):
        return outputs("image", u, v, data=number, repeat=4)[:3]

    u, v, left = outputs("dome_place", *direction, number=TURN)
    *glow, there = outputs("sun_disc", *direction, data=int(first[2]))
    sky = [0.1 * (c * left * (1.0 - there) + sun) for c, sun in zip(shown(0, u, v), glow, strict=True)]
    globe = [0.05 * c for c in shown(1, *outputs("globe_place", *direction, number=TURN))]
    b.add(quad((0, 0, 0), (9, 0, 0), (0, 9, 0)), diffuse(0.6))
    mesh = b.mesh(ball(rings=6), normals=ball(rings=6)[0])
    for number, color in enumerate((analytic(0), analytic(1), globe, sky)):
        material = b.material(emission(color) if number == 1 else diffuse(color))
        b.instance(mesh, material, matrix=place((2.4 * number - 3.6, 0.0, 1.0)))
    texels = np.concatenate([picture.ravel() for picture in pictures]).view(np.uint8)
    return b.make(images=images, image_texels=texels, value_tables=np.concatenate(tables),
                  world_material=[b.material(emission(sky))], world_sun=[(*middle, SIZE / 2)])
