# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials ask of each instance of an object: colours, random numbers, properties, its particle.

Kinds, and what their parts are: color (RGB and alpha), index, random; generated and uv (coordinates on what made the
instance); object and instancer (a property, RGB and alpha); particle (an output of Particle Info).
"""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from .hashes import hash_pair, hash_text, to_unit


def instance_values(depsgraph, numbers: list[int], keys: list[tuple[str, str, int]]) -> np.ndarray:
    """f4 [instances, keys]: the parts that Lookups.instance was asked for, of instances by their numbers in
    depsgraph.object_instances, ascending."""
    made, row = np.zeros((len(numbers), len(keys)), np.float32), 0
    for number, instance in enumerate(depsgraph.object_instances):
        if row == len(numbers):
            break
        if number == numbers[row]:
            found = {key[:2]: KINDS[key[0]](instance, key[1], depsgraph) for key in keys}
            end = bisect_right(numbers, number)  # one that is held out is there twice
            made[row:end] = [found[kind, name][part] for kind, name, part in keys]
            row = end
    return made


def color(instance, _, depsgraph):
    return tuple(instance.object.color)


def index(instance, _, depsgraph):
    return (instance.object.pass_index,)


def random(instance, _, depsgraph):
    """As Cycles makes it (blender/object.cpp): of the name where the object is no instance."""
    own = not instance.is_instance
    return (to_unit(hash_pair(hash_text(instance.object.name), 0) if own else instance.random_id & 0xFFFFFFFF),)


def generated(instance, _, depsgraph):
    if not instance.is_instance:
        return 0.0, 0.0, 0.0
    return tuple(0.5 * x - 0.5 for x in instance.orco)


def uv(instance, _, depsgraph):
    return tuple(instance.uv) if instance.is_instance else (0.0, 0.0)


def of_object(instance, name, depsgraph):
    return property_value((instance.object, instance.object.data), name)


def of_instancer(instance, name, depsgraph):
    parent = instance.parent if instance.is_instance else None
    return property_value((parent, parent and parent.data), name)


def particle(instance, name, depsgraph):
    system = instance.particle_system
    if system is None:
        return (to_unit(hash_pair(0, 0)),) if name == "Random" else (0.0, 0.0, 0.0)
    number = instance.persistent_id[0]
    if name in ("Index", "Random"):
        return (float(number) if name == "Index" else to_unit(hash_pair(number, 0)),)
    one = system.particles[number]
    if name == "Age":
        return (depsgraph.scene_eval.frame_current_final - one.birth_time,)
    found = getattr(one, name.lower().replace(" ", "_"))
    return tuple(found) if name in ("Location", "Velocity", "Angular Velocity") else (found,)


KINDS = {"color": color, "index": index, "random": random, "generated": generated, "uv": uv, "object": of_object,
         "instancer": of_instancer, "particle": particle}


def property_value(owners, name: str) -> tuple[float, float, float, float]:
    """RGB and alpha of the first property of that name, a custom one or Blender's own, that holds one to four numbers;
    0 where there is none."""
    for owner in owners:
        for path in (f'["{name}"]', name):
            found = numbers_of(resolved(owner, path))
            if len(found) == 1:
                return (*found * 3, 1.0)
            if 2 <= len(found) <= 4:
                rgb = (*found, 0.0)[:3]
                return (*rgb, found[3] if len(found) == 4 else 1.0)
    return 0.0, 0.0, 0.0, 0.0


def resolved(owner, path: str):
    try:
        return None if owner is None else owner.path_resolve(path)
    except (ValueError, AttributeError):
        return None


def numbers_of(value) -> list[float]:
    """Of a property's value; none where it holds something else."""
    try:
        return [float(value)] if isinstance(value, int | float) else [float(x) for x in value]
    except (TypeError, ValueError):
        return []
