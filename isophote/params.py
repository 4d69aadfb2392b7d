"""The settings of a work item as kernels take them (kernels/params.h)."""

from __future__ import annotations

import numpy as np

from isophote.passes import CATCHER, film_planes
from isophote.records import numbers, params_dtype
from isophote.schedule import WorkItem
from isophote.settings import Settings

MOST_BOUNCES = 254  # paths count them in 8 bits


def times_of_paths(features: int, settings: Settings) -> tuple[int, ...]:
    """A CATCHING_ number for each time that paths begin in scenes of these FEATURE_ bits."""
    n = numbers()
    if features & n["FEATURE_CATCHERS"] and CATCHER in film_planes(settings).groups:
        return n["CATCHING_FIRST"], n["CATCHING_ALONE"]
    return n["CATCHING_NONE"],


def make_params(item: WorkItem, settings: Settings, planes: int, catching: int = 0) -> np.ndarray:
    """The bytes of a Params record and, behind it, of the item's list of pixels, uint8 (n,), for a film of the
    settings' planes. Raises ValueError where `planes`, how many there is room for, are others.

    Bounce limits grow by one, so that 0 still allows direct light; a clamp, given as a brightness,
    is compared with the sum of three channels: both as Cycles does it.
    """
    wanted = film_planes(settings)
    if planes != int(wanted):
        raise ValueError(f"the settings want {int(wanted)} planes, not {planes}")
    x0, y0, x1, y1 = item.region
    values = {
        "x0": x0, "y0": y0, "width": x1 - x0, "height": y1 - y0,
        "first_sample": item.first_sample, "samples": item.samples, "seed": settings.seed & 0xFFFFFFFF,
        **{name: min(getattr(settings, name), MOST_BOUNCES) + 1 for name in (
            "max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces",
            "transparent_bounces")},
        "filter_width": settings.filter_width,
        "clamp_direct": 3 * settings.clamp_direct, "clamp_indirect": 3 * settings.clamp_indirect,
        "cut_plane": wanted.cut,
        "film_transparent": settings.film_transparent,
        "groups": wanted.mask, "named_planes": wanted.named_planes, "light_plane": wanted.light_plane,
        "matte_rows": wanted.matte_rows, "catching": catching,
        "listed": item.pixels is not None,
    }
    record = np.zeros(1, params_dtype())
    for name in record.dtype.names:
        record[name] = values[name]
    bytes_of_it = record.view(np.uint8).reshape(-1)
    if item.pixels is None:
        return bytes_of_it
    return np.concatenate([bytes_of_it, np.ascontiguousarray(item.pixels, "<i4").view(np.uint8).reshape(-1)])
