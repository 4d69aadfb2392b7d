# SPDX-License-Identifier: GPL-3.0-or-later
"""Image Texture and Environment Texture: places on pictures, and what is there (kernels/values/image.h)."""

from __future__ import annotations

from isophote.values import Value, call1, mix

from ..images import MISSING, Unreadable, multiplied, read_picture, sequence_frame
from ..lookups import IMAGE_DIVIDE_ALPHA
from ..values import each, triple
from .inputs import place, uv_of

INTERPOLATIONS = {"Closest": 0, "Linear": 1, "Cubic": 2, "Smart": 2}  # IMAGE_ numbers of kernels/scene_records.h
EXTENSIONS = {"REPEAT": 0, "EXTEND": 1, "MIRROR": 2, "CLIP": 3}
FIRST_TILE, TILES_IN_A_ROW = 1001, 10


def image_texture(values, node, socket, stack):
    if values.lookups is None:
        return None
    linked = values.is_linked(node, stack, "Vector")
    co = values.vector(node, stack, "Vector") if linked else uv_of(values)
    if node.projection == "BOX":
        return box(values, node, socket, co)
    if node.projection in ("SPHERE", "TUBE"):
        co = outputs("sphere_place" if node.projection == "SPHERE" else "tube_place", 2, *co)
    return looked_up(values, node, socket, *co[:2])


def environment_texture(values, node, socket, stack):
    if values.lookups is None:
        return None
    linked = values.is_linked(node, stack, "Vector")
    co = values.vector(node, stack, "Vector") if linked else place(values)
    operation = "sky_place" if node.projection == "EQUIRECTANGULAR" else "mirror_ball_place"
    return looked_up(values, node, socket, *outputs(operation, 2, *co))


def box(values, node, socket, co):
    """The picture from three sides, weighted by the object's normal."""
    *weights, x_forward, y_forward, z_forward = outputs("box_sides", 6, number=node.projection_blend)
    x, y, z = co
    sides = [(mix(1.0 - y, y, x_forward), z), (mix(x, 1.0 - x, y_forward), z), (mix(y, 1.0 - y, z_forward), x)]
    total = 0.0
    for weight, side in zip(weights, sides, strict=True):
        total = each(lambda sum_, part, weight=weight: sum_ + part * weight, total,
                     looked_up(values, node, socket, *side))
    return total[0] if socket.name == "Alpha" else total


def looked_up(values, node, socket, u, v):
    """Colour or alpha of a node's image at a place; magenta where it has none, as in Cycles."""
    try:
        found = lookup_of(values, node)
    except Unreadable as error:
        values.note(f"{node.name}: {error}: rendered magenta")
        return 1.0 if socket.name == "Alpha" else triple(*MISSING)
    name, data, repeat = found
    red, green, blue, alpha = outputs(name, 4, u, v, data=data, repeat=repeat)
    return alpha if socket.name == "Alpha" else triple(red, green, blue)


def lookup_of(values, node) -> tuple[str, int, int]:
    """Operation, its data and how often it repeats for a node's image. Raises Unreadable."""
    image = node.image
    if image is None:
        raise Unreadable("it has no image")
    note_mapping(values, node)
    interpolation = INTERPOLATIONS[node.interpolation]
    flags = interpolation << 2 | EXTENSIONS[getattr(node, "extension", "REPEAT")] << 4
    taps = 4 ** interpolation
    alpha = node.outputs.get("Alpha")
    if alpha and alpha.is_linked and multiplied(image):
        flags |= IMAGE_DIVIDE_ALPHA
    if image.source == "TILED" and node.bl_idname == "ShaderNodeTexImage" and node.projection != "BOX":
        return "tiled_image", tile_table(values, image, flags), taps
    frame = sequence_frame(node.image_user, values.lookups.frame) if image.source == "SEQUENCE" else 0
    return "image", values.lookups.image((image.as_pointer(), frame), flags,
                                         lambda: read_picture(image, frame)), taps


def tile_table(values, image, flags: int) -> int:
    """Where the tiles' images stand in value_tables, as the operation tiled_image reads them."""
    numbers = {}
    for tile in image.tiles:
        try:
            numbers[tile.number - FIRST_TILE] = values.lookups.image(
                (image.as_pointer(), tile.number), flags, lambda tile=tile: read_picture(image, 0, tile.number))
        except Unreadable as error:
            values.note(f"{image.name}, tile {tile.number}: {error}: rendered magenta")
    missing = values.lookups.missing_image()
    places = max(numbers, default=-1) + 1
    return values.lookups.table([places + 1, *(numbers.get(place, missing) for place in range(places)), missing])


def note_mapping(values, node) -> None:
    mapping = node.texture_mapping
    if (tuple(mapping.translation), tuple(mapping.rotation), tuple(mapping.scale)) != ((0,) * 3, (0,) * 3, (1,) * 3):
        values.note(f"{node.name}: its own texture mapping is not supported: left out")


def outputs(name: str, count: int, *inputs, **data) -> list[Value]:
    call = call1(name, *inputs, **data).call
    return [Value(call, k) for k in range(count)]


NODES = {
    "ShaderNodeTexImage": image_texture,
    "ShaderNodeTexEnvironment": environment_texture,
}
