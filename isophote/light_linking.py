"""Light linking, from a scene's arrays to what kernels/light_linking.h reads."""

from __future__ import annotations

import numpy as np

from isophote.records import make_records, numbers
from isophote.scene import Scene


def is_linked(scene: Scene) -> bool:
    """Whether some light does not light all, or is not stopped by all."""
    return any(scene.arrays[f"{kind}_unlinked"].any() for kind in ("instance", "sphere", "light"))


def link_features(scene: Scene) -> int:
    """FEATURE_ bits. Shadow rays that some objects do not stop go through these as through transparent ones."""
    n = numbers()
    passes = any(scene.arrays[f"{kind}_unlinked"][:, 1].any() for kind in ("instance", "light"))
    return is_linked(scene) * n["FEATURE_LINKING"] | passes * n["FEATURE_TRANSPARENT"]


def link_records(scene: Scene, lamps: np.ndarray) -> np.ndarray:
    """Link records of instances, spheres and of these lamps of the scene, by number, then one of the world, which is
    linked to all; none where nothing is linked."""
    if not is_linked(scene):
        return make_records("Link", 0)
    sets = np.concatenate([scene.instance_sets, scene.sphere_sets, np.zeros((len(lamps) + 1, 2), np.uint32)])
    masks = np.concatenate([scene.instance_unlinked, scene.sphere_unlinked, scene.light_unlinked[lamps],
                            np.zeros((1, 2), np.uint64)])
    return make_records("Link", len(sets), receiver=sets[:, 0], blocker=sets[:, 1], unlit=in_words(masks[:, 0]),
                        unblocked=in_words(masks[:, 1]))


def in_words(masks: np.ndarray) -> np.ndarray:
    """u8 [N] as u4 [N, 2], the lower bits first."""
    return np.stack([masks & 0xFFFFFFFF, masks >> 32], axis=1).astype(np.uint32)


def lit_sets(scene: Scene, lights: np.ndarray, lamps: np.ndarray) -> np.ndarray | None:
    """Of Light records of which the first ones are these lamps of the scene: whether each lights each set of receivers,
    bool [N, sets]; None where nothing is linked."""
    if not is_linked(scene):
        return None
    masks = np.zeros(len(lights), np.uint64)
    masks[:len(lamps)] = scene.light_unlinked[lamps, 0]
    triangle = lights["kind"] == numbers()["LIGHT_TRIANGLE"]
    masks[triangle] = scene.instance_unlinked[lights["instance"][triangle], 0]
    last = max(scene.instance_sets[:, 0].max(initial=0), scene.sphere_sets[:, 0].max(initial=0))
    return masks[:, None] >> np.arange(last + 1, dtype=np.uint64) & np.uint64(1) == 0


def lit_shares(shares: np.ndarray) -> np.ndarray:
    """As kernels read them: in 65535ths, never 0 where something is lit."""
    return np.ceil(shares * 65535.0 * (1 - 1e-12)).astype(np.uint16).ravel()
