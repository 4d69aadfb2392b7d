# SPDX-License-Identifier: GPL-3.0-or-later
"""Image Texture and Environment Texture: places on pictures, and what is there (kernels/values/image.h)."""

from __future__ import annotations

from isophote.values import mix

from ..images import MISSING, Unreadable, multiplied, read_picture, sequence_frame
from ..lookups import IMAGE_DIVIDE_ALPHA
from ..values import each, outputs, source, triple
from .inputs import place, uv_of
from .vectors import texture_mapped

INTERPOLATIONS = {"Closest": 0, "Linear": 1, "Cubic": 2, "Smart": 2}  # IMAGE_ numbers of kernels/scene_records.h
EXTENSIONS = {"REPEAT": 0, "EXTEND": 1, "MIRROR": 2, "CLIP": 3}
FIRST_TILE = 1001


def image_texture(values, node, socket, stack):
    if values.lookups is None:
        return None
    linked = values.is_linked(node, stack, "Vector")
    co = texture_mapped(values.vector(node, stack, "Vector") if linked else uv_of(values), node.texture_mapping)
    if node.projection == "BOX":
        return box(values, node, socket, co)
    if node.projection in ("SPHERE", "TUBE"):
        co = outputs("sphere_place" if node.projection == "SPHERE" else "tube_place", *co)
    return looked_up(values, node, socket, *co[:2])


def environment_texture(values, node, socket, stack):
    if values.lookups is None:
        return None
    linked = values.is_linked(node, stack, "Vector")
    co = texture_mapped(values.vector(node, stack, "Vector") if linked else place(values), node.texture_mapping)
    operation = "sky_place" if node.projection == "EQUIRECTANGULAR" else "mirror_ball_place"
    return looked_up(values, node, socket, *outputs(operation, *co))


def box(values, node, socket, co):
    """The picture from three sides, weighted by the object's normal."""
    *weights, x_forward, y_forward, z_forward = outputs("box_sides", number=node.projection_blend)
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
        name, data, stored = lookup_of(values, node)
    except Unreadable as error:
        values.note(f"{node.name}: {error}: rendered magenta")
        return 1.0 if socket.name == "Alpha" else triple(*MISSING)
    *color, alpha = outputs(name, u, v, data=data, repeat=4 ** INTERPOLATIONS[node.interpolation])
    if socket.name == "Alpha":
        return alpha
    alpha_output = node.outputs.get("Alpha")
    if not (alpha_output and alpha_output.is_linked and multiplied(node.image)):
        stored &= ~IMAGE_DIVIDE_ALPHA  # colours stay as they are stored
    return source("stored_color", *color, alpha, data=stored) if stored else triple(*color)


def lookup_of(values, node) -> tuple[str, int, int]:
    """Operation and its data for a node's image, and how its colours are stored (Lookups.image). Raises Unreadable."""
    image = node.image
    if image is None:
        raise Unreadable("it has no image")
    modes = INTERPOLATIONS[node.interpolation] | EXTENSIONS[getattr(node, "extension", "REPEAT")] << 2
    if image.source == "TILED" and node.bl_idname == "ShaderNodeTexImage" and node.projection != "BOX":
        return "tiled_image", *tile_table(values, image, modes)
    frame = sequence_frame(node.image_user, values.lookups.frame) if image.source == "SEQUENCE" else 0
    return "image", *values.lookups.image((image.as_pointer(), frame), modes, lambda: read_picture(image, frame))


def tile_table(values, image, modes: int) -> tuple[int, int]:
    """Where the numbers of the tiles stand in value_tables, for tiled_image; how the tiles are stored."""
    numbers, stored = {}, 0
    for tile in image.tiles:
        key = image.as_pointer(), tile.number
        try:
            number, own = values.lookups.image(key, modes, lambda tile=tile: read_picture(image, 0, tile.number))
        except Unreadable as error:
            values.note(f"{image.name}, tile {tile.number}: {error}: rendered magenta")
        else:
            numbers[tile.number - FIRST_TILE] = number
            stored |= own
    missing = values.lookups.missing_image()
    places = max(numbers, default=-1) + 1
    entries = [places + 1, *(numbers.get(place, missing) for place in range(places)), missing]
    return values.lookups.table(entries), stored


NODES = {
    "ShaderNodeTexImage": image_texture,
    "ShaderNodeTexEnvironment": environment_texture,
}
