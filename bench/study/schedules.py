"""Schedules of the founding report around the kernels of kernels/study: who works on which path, and when.

A schedule traces all samples of some pixels to their end with a StudyDevice, as OpenCLDevice.render_pixels
does. `reserve` makes the buffers that it wants besides the device's own; `samples_per_path` says how many
samples a pass has for each path in flight.
"""

from __future__ import annotations

import numpy as np

from isophote.device import DeviceError
from isophote.opencl import BOUNCES_BETWEEN_LOOKS

U = np.uint32
NONE = 0xFFFFFFFF
SORT_BINS = 4096  # kernels/study/sort.cl
PAIRS_PER_PATH = 32  # room in the queues of breadth-first traversal


def bounce_limit(settings) -> int:
    """Bounces after which no path lives, as the shipping device counts them."""
    return settings.max_bounces + settings.transparent_bounces + 3


class Schedule:
    """The shipping schedule, which OpenCLDevice runs itself, and what the others have in common."""

    samples_per_path = 1

    def reserve(self, device, paths: int) -> None:
        """Make what is wanted besides the device's buffers for so many samples of a pass."""

    def accumulate(self, device, params, film, first: int, pixels: int) -> None:
        device.launch("accumulate", pixels, params, U(device.capacity), device.results, device.aovs, film, U(first),
                      U(pixels))


class Megakernel(Schedule):
    """Everything in one kernel: no state in memory, no queue; a group lives as long as its longest path."""

    def render_pixels(self, device, params, settings, film, first, pixels, samples, cancelled) -> bool:
        count = pixels * samples
        device.launch("megakernel", count, *device.scene, params, device.results, device.aovs, U(device.capacity),
                      U(first), U(count))
        self.accumulate(device, params, film, first, pixels)
        return not cancelled()


class Pipeline(Schedule):
    """A kernel a stage over a queue with a place for every path; ended paths keep theirs and do nothing."""

    def render_pixels(self, device, params, settings, film, first, pixels, samples, cancelled) -> bool:
        count, limit = pixels * samples, bounce_limit(settings)
        self.counts = device.buffer(array=self.lengths(count, limit))
        queue = device.queues[0]
        device.launch("generate", count, *device.scene, params, device.reals, device.uints, U(device.capacity),
                      device.results, device.aovs, queue, U(first), U(count))
        places = count
        for bounce in range(limit):
            queue = self.prepare(device, params, queue, places, bounce)
            self.bounce(device, params, queue, places, bounce)
            queue, places = self.reorder(device, queue, places, bounce)
            if not places:
                break
            if bounce % BOUNCES_BETWEEN_LOOKS == BOUNCES_BETWEEN_LOOKS - 1:
                if cancelled():
                    return False
                if not device.read(self.counts, 2 * bounce + 3)[0]:
                    break
        self.accumulate(device, params, film, first, pixels)
        if device.profile:
            device.alive = device.read(self.counts, 0, 2 * limit)[1::2].tolist()
        return not cancelled()

    def lengths(self, count: int, limit: int) -> np.ndarray:
        """counts[2 b], places of bounce b, and counts[2 b + 1], paths that begin it."""
        lengths = np.zeros(2 * limit + 4, np.uint32)
        lengths[0::2], lengths[1] = count, count
        return lengths

    def prepare(self, device, params, queue, places: int, bounce: int):
        """What happens to the queue before its paths are traced; returns the queue to use."""
        return queue

    def bounce(self, device, params, queue, places: int, bounce: int) -> None:
        path = (device.reals, device.uints, U(device.capacity))
        self.extend(device, params, queue, places, bounce)
        queue = self.between(device, params, queue, places, bounce)
        hit, light = (device.hit_reals, device.hit_uints), (device.light_reals, device.light_uints)
        size = device.strided(places)
        device.launch("shade_slots", size, *device.scene, params, *path, *hit, *light, device.results, device.aovs,
                      U(device.capacity), queue, device.light_queue, self.counts, U(bounce))
        together = device.variant.traversal == "list_local"
        device.launch("connect_together" if together else "connect_slots", size, *device.scene, params, *path, *light,
                      device.results, U(device.capacity), device.light_queue, self.counts, U(bounce))
        self.shaded = queue

    def extend(self, device, params, queue, places: int, bounce: int) -> None:
        together = device.variant.traversal == "list_local"
        device.launch("extend_together" if together else "extend_slots", device.strided(places), *device.scene, params,
                      device.reals, device.uints, U(device.capacity), device.hit_reals, device.hit_uints, queue,
                      self.counts, U(bounce))

    def between(self, device, params, queue, places: int, bounce: int):
        """What happens to the queue between tracing and shading."""
        return queue

    def reorder(self, device, queue, places: int, bounce: int):
        """Closes gaps after a bounce; returns the queue of the next one and an upper bound of its places."""
        return queue, places


class Groups(Pipeline):
    """Each work-group moves the living of its own stretch of the queue to the front, by an exclusive scan."""

    def reorder(self, device, queue, places, bounce):
        device.launch("reorder_groups", device.strided(places), queue, self.counts, U(bounce))
        return queue, places


class Scan(Pipeline):
    """The living of the whole queue move to its front by a recursive exclusive scan; the host reads how many there are
    and launches that many work-items."""

    def reserve(self, device, paths):
        group = device.variant.group
        self.levels, count = [device.buffer(4 * paths)], paths
        while count > 1:
            count = -(-count // group)
            self.levels.append(device.buffer(4 * count))

    def lengths(self, count, limit):
        lengths = super().lengths(count, limit)
        lengths[2::2] = 0
        return lengths

    def reorder(self, device, queue, places, bounce):
        following = device.queues[1] if queue is device.queues[0] else device.queues[0]
        device.launch("flag_living", places, queue, self.levels[0], U(places))
        self.scan(device, 0, places)
        device.launch("move_living", places, queue, self.levels[0], following, self.counts, U(bounce), U(places))
        return following, int(device.read(self.counts, 2 * bounce + 2)[0])

    def scan(self, device, level: int, count: int) -> None:
        """Exclusive sums in place of self.levels[level]."""
        groups = -(-count // device.variant.group)
        device.launch("scan_groups", count, self.levels[level], self.levels[level + 1], U(count))
        if groups > 1:
            self.scan(device, level + 1, groups)
            device.launch("add_sums", count, self.levels[level], self.levels[level + 1], U(count))


class Compact(Pipeline):
    """The living move to another queue, one atomic a work-group; lengths stay on the device. With a sort, the queue
    is ordered by material before shading or by ray before tracing."""

    def reserve(self, device, paths):
        if device.variant.sort:
            self.keys, self.bins = device.buffer(4 * paths), device.buffer(4 * SORT_BINS)
            self.spare = device.buffer(4 * paths)

    def lengths(self, count, limit):
        lengths = super().lengths(count, limit)
        lengths[2::2] = 0
        return lengths

    def prepare(self, device, params, queue, places, bounce):
        # The rays of the camera are in order as they are.
        return self.sort(device, params, queue, places, bounce) if device.variant.sort == "ray" and bounce else queue

    def between(self, device, params, queue, places, bounce):
        return self.sort(device, params, queue, places, bounce) if device.variant.sort == "material" else queue

    def sort(self, device, params, queue, places, bounce):
        size = device.strided(places)
        device.fill(self.bins, 0, SORT_BINS)
        device.launch("sort_count", size, *device.scene, params, device.reals, device.uints, U(device.capacity),
                      device.hit_uints, queue, self.counts, self.keys, self.bins, U(device.variant.sort == "material"),
                      U(bounce))
        device.launch("sort_places", device.variant.group, self.bins)
        device.launch("sort_move", size, queue, self.counts, self.keys, self.bins, self.spare, U(bounce))
        return self.spare

    def reorder(self, device, queue, places, bounce):
        following = device.queues[(bounce + 1) % 2]
        device.launch("compact", device.strided(places), self.shaded, following, self.counts, U(bounce))
        return following, places


class Regeneration(Pipeline):
    """A path that ends starts the next sample at once, so that all places work until the samples run out."""

    samples_per_path = 16

    def reserve(self, device, paths):
        self.pool = max(1, paths // self.samples_per_path)
        self.next = device.buffer(4)

    def render_pixels(self, device, params, settings, film, first, pixels, samples, cancelled) -> bool:
        count = pixels * samples
        pool = min(self.pool, count)
        rounds = bounce_limit(settings) * (-(-count // pool) + 1)
        lengths = np.zeros(2 * rounds + 4, np.uint32)
        lengths[0::2] = pool
        self.counts, queue = device.buffer(array=lengths), device.queues[0]
        device.fill(queue, NONE, pool)
        device.fill(self.next, 0, 1)
        for bounce in range(rounds):
            device.launch("regenerate", device.strided(pool), *device.scene, params, device.reals, device.uints,
                          U(device.capacity), device.results, device.aovs, U(device.capacity), queue, self.counts,
                          self.next, U(bounce), U(first), U(count))
            self.bounce(device, params, queue, pool, bounce)
            if bounce % BOUNCES_BETWEEN_LOOKS == BOUNCES_BETWEEN_LOOKS - 1:
                if cancelled():
                    return False
                if not device.read(self.counts, 2 * bounce + 3)[0] and device.read(self.next, 0)[0] >= count:
                    break
        self.accumulate(device, params, film, first, pixels)
        return not cancelled()


class BreadthFirst(Compact):
    """Rays go down the tree level by level in queues of (ray, node) pairs; shadow rays as they always do."""

    def reserve(self, device, paths):
        self.capacity = PAIRS_PER_PATH * paths
        self.pairs = [[device.buffer(4 * self.capacity) for _ in range(3)] for _ in range(2)]
        lists = [device.buffer(4 * self.capacity) for _ in range(3)]
        self.leaves = [device.buffer(4 * paths), *lists, device.buffer(4)]
        self.level_counts = device.buffer(4 * 256)

    def extend(self, device, params, queue, places, bounce):
        path = (device.reals, device.uints, U(device.capacity))
        size, counts = device.strided(places), self.level_counts
        device.fill(counts, 0, 256)
        device.fill(self.leaves[-1], 0, 1)
        device.launch("bfs_start", size, *device.scene, params, queue, self.counts, *self.pairs[0], *self.leaves,
                      U(self.capacity), counts, U(bounce))
        for level in range(255):
            device.launch("bfs_level", device.strided(self.capacity), *device.scene, params, *path,
                          *self.pairs[level % 2], *self.pairs[1 - level % 2], *self.leaves, U(self.capacity), counts,
                          U(level))
            following = int(device.read(counts, level + 1)[0])
            leaves = int(device.read(self.leaves[-1], 0)[0])
            if max(following, leaves) > self.capacity:
                raise DeviceError(f"breadth_first: {max(following, leaves)} pairs of rays and nodes, there is room for "
                                  f"{self.capacity}: give it fewer paths")
            if not following:
                break
        device.launch("bfs_finish", size, *device.scene, params, *path, device.hit_reals, device.hit_uints, queue,
                      self.counts, *self.leaves[:4], U(bounce))


SCHEDULES = {"shipping": Schedule, "megakernel": Megakernel, "pipeline": Pipeline, "groups": Groups, "scan": Scan,
             "compact": Compact, "regeneration": Regeneration, "breadth_first": BreadthFirst}
