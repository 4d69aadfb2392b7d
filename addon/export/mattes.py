# SPDX-License-Identifier: GPL-3.0-or-later
"""Names by which Cryptomatte tells objects, materials and assets apart, where a view layer asks for it."""

from __future__ import annotations

import numpy as np

from isophote.cryptomatte import ids_of

SWITCHES = tuple(f"use_pass_cryptomatte_{kind}" for kind in ("object", "material", "asset"))
NO_MATERIAL = "default_surface"  # as in Cycles


class Mattes:
    """Collects assets by the names of their objects: an object's is the topmost of its parents, as in Cycles."""

    def __init__(self, view_layer):
        self.wanted = any(getattr(view_layer, switch) for switch in SWITCHES)
        self.assets: dict[str, str] = {}

    def meet(self, ob) -> None:
        if self.wanted:
            top = ob
            while top.parent:
                top = top.parent
            self.assets[ob.name] = top.name

    def arrays(self, instances: list[str], spheres: list[str], materials: list[str],
               others: int) -> dict[str, np.ndarray]:
        """Ids of the names of objects and of their materials, behind which there are `others`."""
        if not self.wanted:
            return {}
        both = [np.stack([ids_of(names), ids_of(self.assets[name] for name in names)], axis=1)
                for names in (instances, spheres)]
        return {"instance_matte": both[0], "sphere_matte": both[1],
                "material_matte": np.concatenate([ids_of(materials), np.zeros(others, np.uint32)])}
