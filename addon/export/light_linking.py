# SPDX-License-Identifier: GPL-3.0-or-later
"""Light linking and shadow linking (Blender 4.0 and newer): collections name what an emitter lights, or what stops its
light.

An object that such a collection includes is linked to it, one that it excludes is not, and all others are as long as
it includes none (Blender, depsgraph/intern/depsgraph_light_linking.cc). Objects with the same answers to all
collections are a set; an emitter has a mask of the sets to which it is not linked.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from isophote.records import numbers

KINDS = ("receiver_collection", "blocker_collection")
MOST_SETS = numbers()["MOST_SETS"]  # set 0 is that of objects that no collection names


class LightLinking:
    """Asked for each object once, and for all masks at the end, when all emitters are known."""

    def __init__(self, notes):
        self.notes = notes
        self.linked: list[tuple] = []  # (object, its instancer or None), originals
        self.collections = ({}, {})  # of each of KINDS: collection -> its place

    def of(self, instance, ob) -> int:
        """The number of an object, or of an instance of one, in `arrays`."""
        linking = getattr(ob.original, "light_linking", None)
        for kind, known in zip(KINDS, self.collections, strict=True):
            collection = getattr(linking, kind, None)
            if collection is not None:
                known.setdefault(collection, len(known))
        parent = instance.parent if instance.is_instance else None
        self.linked.append((ob.original, parent and parent.original))
        return len(self.linked) - 1

    def arrays(self, group: str, linked: list[int]) -> dict[str, np.ndarray]:
        """The scene's arrays of objects with these numbers, of a group of them: instance, sphere or light; none where
        nothing is linked."""
        if not any(self.collections):
            return {}
        sets, masks = (np.stack([each[k] for each in self.links], axis=1)[linked] for k in (0, 1))
        made = {f"{group}_unlinked": masks.astype(np.uint64).reshape(-1, 2)}
        return made if group == "light" else made | {f"{group}_sets": sets.astype(np.uint32).reshape(-1, 2)}

    @cached_property
    def links(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """By kind."""
        return [self.links_of(kind, known) for kind, known in zip(KINDS, self.collections, strict=True)]

    def links_of(self, kind: str, collections: dict) -> tuple[np.ndarray, np.ndarray]:
        """Sets of all objects, and masks of the sets to which they are not linked as emitters."""
        states = [states_of(collection) for collection in collections]
        by_answer = {(None,) * len(states): 0}
        sets = [self.set_of(ob, states, by_answer) for ob, _ in self.linked]
        parents = [self.set_of(parent, states, by_answer) if parent else 0 for _, parent in self.linked]
        masks = [unlinked(k, states[k], by_answer) for k in range(len(states))]
        own = [getattr(getattr(ob, "light_linking", None), kind, None) for ob, _ in self.linked]
        return (np.where(parents, parents, sets),  # an instancer's own set counts before its objects'
                np.array([0 if each is None else masks[collections[each]] for each in own], np.uint64))

    def set_of(self, ob, states: list[dict], by_answer: dict) -> int:
        answer = tuple(state.get(ob) for state in states)
        if answer not in by_answer and len(by_answer) == MOST_SETS:
            self.notes.add("object", ob.name, f"more than {MOST_SETS - 1} sets of linked objects: as if not linked")
            return 0
        return by_answer.setdefault(answer, len(by_answer))


def states_of(collection) -> dict:
    """Whether a collection includes an object, by object, for all that it names. What a nested one holds has the state
    of the outermost one; what is said last counts, objects after collections."""
    made = {}
    for child, row in zip(collection.children, collection.collection_children, strict=True):
        made |= dict.fromkeys(child.all_objects, row.light_linking.link_state == "INCLUDE")
    for ob, row in zip(collection.objects, collection.collection_objects, strict=True):
        made[ob] = row.light_linking.link_state == "INCLUDE"
    return made


def unlinked(place: int, state: dict, by_answer: dict) -> int:
    """The mask of sets to which a collection's emitters are not linked, given its place in the sets' answers."""
    includes = any(state.values())
    return sum(1 << number for answer, number in by_answer.items()
               if answer[place] is False or (includes and answer[place] is None))
