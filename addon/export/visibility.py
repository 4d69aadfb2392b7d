# SPDX-License-Identifier: GPL-3.0-or-later
"""Which kinds of rays see an object, and whether to the camera it is a hole."""

from __future__ import annotations

from dataclasses import dataclass

from isophote.records import numbers

RAYS = (("visible_camera", 1), ("visible_diffuse", 2), ("visible_glossy", 4), ("visible_transmission", 8),
        ("visible_shadow", 16))  # RAY_ bits of kernels/scene_records.h
RAY_CAMERA = 1
CATCHER_SHIFT = numbers()["CATCHER_SHIFT"]


@dataclass(frozen=True)
class Appearance:
    """What rays of a mask of RAY_ bits see: the object, or where it is held out a hole of its shape. Catchers of
    shadows have the mask twice (scene.FIELDS)."""

    visibility: int
    held_out: bool


def visibility_of(instance, ob, view_layer) -> int:
    """RAY_ bits of what is there: the object's, and for an instance its instancer's too."""
    mask = sum(bit for name, bit in RAYS if getattr(ob, name))
    top = top_of(instance, ob)
    if top is None:
        return mask
    if instance.is_instance:
        mask &= sum(bit for name, bit in RAYS if getattr(top, name))
    if top.original.indirect_only_get(view_layer=view_layer) and not is_held_out(instance, ob, view_layer):
        mask &= ~RAY_CAMERA
    return mask


def appearances(instance, ob, view_layer) -> list[Appearance]:
    """What is to be rendered of an object; nothing where no ray sees it.

    The camera alone sees that an object is held out (Cycles, integrate_surface_holdout). So it is there twice, for the
    camera and for all others, and nothing needs to ask while it is shaded.
    """
    visibility = visibility_of(instance, ob, view_layer)
    others = visibility | (visibility << CATCHER_SHIFT if is_catcher(instance, ob) else 0)
    if not is_held_out(instance, ob, view_layer):
        parts = [Appearance(others, False)]
    else:
        hidden = RAY_CAMERA | RAY_CAMERA << CATCHER_SHIFT
        parts = [Appearance(visibility & RAY_CAMERA, True), Appearance(others & ~hidden, False)]
    return [part for part in parts if part.visibility]


def is_held_out(instance, ob, view_layer) -> bool:
    """By its own flag or a collection's; of an instance that of its instancer counts alone, as in Cycles."""
    top = top_of(instance, ob)
    return top is not None and top.original.holdout_get(view_layer=view_layer)


def is_catcher(instance, ob) -> bool:
    return ob.is_shadow_catcher or bool(instance.is_instance and instance.parent and instance.parent.is_shadow_catcher)


def top_of(instance, ob):
    return instance.parent if instance.is_instance else ob
