"""Schedules of the founding report around the kernels of kernels/study: who works on which path, and when.

Each is what isophote.wavefront.Wavefront is to the shipping device: room for some samples of a pass, and `trace`, which
takes all samples of some pixels to their end. `samples_per_path` says how many samples a pass has for each path in
flight. The first argument is the StudyDevice that launches.
"""

from __future__ import annotations

import numpy as np

from isophote.device import DeviceError
from isophote.records import numbers
from isophote.wavefront import Wavefront, path_columns

U = np.uint32
NONE = 0xFFFFFFFF
SORT_BINS, SORT_TILE = 4096, 4096  # kernels/study/sort.cl
PAIRS_PER_PATH = 32  # room in the queues of breadth-first traversal
BOUNCES_BETWEEN_LOOKS = 8  # the number of paths alive is read that often, to stop early and to cancel


class Shipping(Wavefront):
    """The shipping schedule, with groups of the variant's size, and its launches kept for their times."""

    samples_per_path = 1

    def __init__(self, device, paths: int):
        super().__init__(device.cl, device.queue, device.program, [*device.scene.values()], paths,
                         device.planes, device.features)
        self.device = device
        if device.variant.group:
            self.group = dict.fromkeys(self.group, device.variant.group)

    def launch(self, name, count, *changing, parity=0, each=1):
        event = super().launch(name, count, *changing, parity=parity, each=each)
        self.device.keep(name, event)
        return event


class Schedule:
    """What the report's schedules have in common: the paths' buffers, by name in `buffers` (isophote.wavefront)."""

    samples_per_path = 1

    def __init__(self, device, paths: int):
        self.device, self.paths = device, paths
        b = {name: device.buffer(4 * count * paths) for name, count in path_columns(device.planes, 0).items()}
        self.limits = device.buffer(3 * 4 * numbers()["LIMITS"])
        self.buffers, self.path = b, (b["reals"], b["uints"], U(paths))
        self.hit, self.light = (b["hit_reals"], b["hit_uints"]), (b["light_reals"], b["light_uints"])
        self.result = (b["results"], b["columns"], self.limits)
        self.reserve(paths)

    def reserve(self, paths: int) -> None:
        """Make what is wanted besides."""

    def launch(self, name: str, count: int, params, *arguments) -> None:
        """Launch a kernel that takes the scene."""
        self.device.launch(name, count, *self.device.scene.values(), params, *arguments)

    def accumulate(self, params, film, first: int, pixels: int) -> None:
        self.device.launch("accumulate", pixels, params, U(self.paths), *self.result, film, U(first), U(pixels))


class Megakernel(Schedule):
    """Everything in one kernel: no state in memory, no queue; a group lives as long as its longest path."""

    def trace(self, params, film, first, pixels, samples, bounces, cancelled) -> bool:
        (params,), count = params, pixels * samples
        self.launch("megakernel", count, params, *self.result, U(self.paths), U(first), U(count))
        self.accumulate(params, film, first, pixels)
        return not cancelled()


class Pipeline(Schedule):
    """A kernel a stage over a queue with a place for every path; ended paths keep theirs and do nothing."""

    def trace(self, params, film, first, pixels, samples, bounces, cancelled) -> bool:
        (params,), count = params, pixels * samples
        self.counts = self.device.buffer(array=self.lengths(count, bounces))
        queue, places = self.buffers["queue"], count
        self.launch("start_slots", count, params, *self.path, *self.result, queue, U(first), U(count))
        for bounce in range(bounces):
            queue = self.bounce(params, queue, places, bounce)
            queue, places = self.reorder(queue, places, bounce)
            if not places:
                break
            if bounce % BOUNCES_BETWEEN_LOOKS == BOUNCES_BETWEEN_LOOKS - 1:
                if cancelled():
                    return False
                if not self.device.read(self.counts, 2 * bounce + 3)[0]:
                    break
        self.accumulate(params, film, first, pixels)
        if self.device.profile:
            self.device.add_alive(self.device.read(self.counts, 0, 2 * bounces)[1::2])
        return not cancelled()

    def lengths(self, count: int, bounces: int) -> np.ndarray:
        """counts[2 b], places of bounce b, and counts[2 b + 1], paths that begin it."""
        lengths = np.zeros(2 * bounces + 4, np.uint32)
        lengths[0::2], lengths[1] = count, count
        return lengths

    def size(self, places: int) -> int:
        """Work-items of a launch over so many places."""
        return places

    def bounce(self, params, queue, places: int, bounce: int):
        """Trace, shade and connect the paths of a queue; returns the queue as it was shaded."""
        self.extend(params, queue, places, bounce)
        self.launch("shade_slots", self.size(places), params, *self.path, *self.hit, *self.light, *self.result,
                    U(self.paths), queue, self.buffers["light_queue"], self.counts, U(bounce))
        together = self.device.variant.traversal == "list_local"
        self.launch("connect_together" if together else "connect_slots", self.size(places), params, *self.path,
                    *self.light, *self.result, U(self.paths), self.buffers["light_queue"], self.counts,
                    U(bounce))
        return queue

    def extend(self, params, queue, places: int, bounce: int) -> None:
        together = self.device.variant.traversal == "list_local"
        self.launch("extend_together" if together else "extend_slots", self.size(places), params, *self.path, *self.hit,
                    queue, self.counts, U(bounce))

    def reorder(self, queue, places: int, bounce: int):
        """Closes gaps after a bounce; returns the queue of the next one and an upper bound of its places."""
        return queue, places

    def other(self, queue):
        """The queue that is free while this one is read."""
        return self.buffers["next_queue" if queue is self.buffers["queue"] else "queue"]


class Groups(Pipeline):
    """Each work-group moves the living of its own stretch of the queue to the front, by an exclusive scan."""

    def reorder(self, queue, places, bounce):
        self.device.launch("reorder_groups", places, queue, self.counts, U(bounce))
        return queue, places


class Scan(Pipeline):
    """The living of the whole queue move to its front by a recursive exclusive scan; the host reads how many there are
    and launches that many work-items."""

    def reserve(self, paths):
        self.levels, count = [self.device.buffer(4 * paths)], paths
        while count > 1:
            count = -(-count // self.device.group)
            self.levels.append(self.device.buffer(4 * count))

    def lengths(self, count, bounces):
        lengths = super().lengths(count, bounces)
        lengths[2::2] = 0
        return lengths

    def reorder(self, queue, places, bounce):
        self.device.launch("flag_living", places, queue, self.levels[0], U(places))
        self.scan(0, places)
        self.device.launch("move_living", places, queue, self.levels[0], self.other(queue), self.counts, U(bounce),
                           U(places))
        return self.other(queue), int(self.device.read(self.counts, 2 * bounce + 2)[0])

    def scan(self, level: int, count: int) -> None:
        """Exclusive sums in place of self.levels[level]."""
        groups = -(-count // self.device.group)
        self.device.launch("scan_groups", count, self.levels[level], self.levels[level + 1], U(count))
        if groups > 1:
            self.scan(level + 1, groups)
            self.device.launch("add_sums", count, self.levels[level], self.levels[level + 1], U(count))


class Compact(Pipeline):
    """The living move to another queue, one atomic a work-group; lengths stay on the device. With a sort, the queue
    is ordered by material before shading or by ray before tracing."""

    def reserve(self, paths):
        if self.device.variant.sort:
            self.keys, self.bins = self.device.buffer(4 * paths), self.device.buffer(4 * SORT_BINS)
            self.spare = self.device.buffer(4 * paths)

    def lengths(self, count, bounces):
        lengths = super().lengths(count, bounces)
        lengths[2::2] = 0
        return lengths

    def size(self, places):
        return self.device.strided(places)

    def bounce(self, params, queue, places, bounce):
        self.unsorted = queue
        if self.device.variant.sort == "ray" and bounce:  # the camera's rays are in order as they are
            queue = self.sort(params, queue, places, bounce)
        return super().bounce(params, queue, places, bounce)

    def extend(self, params, queue, places, bounce):
        super().extend(params, queue, places, bounce)
        if self.device.variant.sort == "material":  # in place: shading reads the same queue
            self.device.copy(self.sort(params, queue, places, bounce), queue, places)

    def sort(self, params, queue, places, bounce):
        size = -(-places // SORT_TILE) * self.device.group
        self.device.fill(self.bins, 0, SORT_BINS)
        self.launch("sort_count", size, params, *self.path, self.buffers["hit_uints"], queue, self.counts, self.keys,
                    self.bins, U(self.device.variant.sort == "material"), U(bounce))
        self.device.launch("sort_places", self.device.group, self.bins)
        self.device.launch("sort_move", size, queue, self.counts, self.keys, self.bins, self.spare, U(bounce))
        return self.spare

    def reorder(self, queue, places, bounce):
        following = self.other(self.unsorted)
        self.device.launch("compact", self.size(places), queue, following, self.counts, U(bounce))
        return following, places


class Regeneration(Pipeline):
    """A path that ends starts the next sample at once, so that all places work until the samples run out."""

    samples_per_path = 16

    def reserve(self, paths):
        self.pool = max(1, paths // self.samples_per_path)
        self.next = self.device.buffer(4)

    def size(self, places):
        return self.device.strided(places)

    def trace(self, params, film, first, pixels, samples, bounces, cancelled) -> bool:
        count = pixels * samples
        pool = min(self.pool, count)
        rounds = bounces * (-(-count // pool) + 1)
        lengths = np.zeros(2 * rounds + 4, np.uint32)
        lengths[0::2] = pool
        self.counts, queue = self.device.buffer(array=lengths), self.buffers["queue"]
        self.device.fill(queue, NONE, pool)
        self.device.fill(self.next, 0, 1)
        for bounce in range(rounds):
            self.launch("regenerate", self.size(pool), params, *self.path, *self.result, U(self.paths), queue,
                        self.counts, self.next, U(bounce), U(first), U(count))
            self.bounce(params, queue, pool, bounce)
            if bounce % BOUNCES_BETWEEN_LOOKS == BOUNCES_BETWEEN_LOOKS - 1:
                if cancelled():
                    return False
                left = self.device.read(self.counts, 2 * bounce + 3)[0]
                if not left and self.device.read(self.next, 0)[0] >= count:
                    break
        self.accumulate(params, film, first, pixels)
        return not cancelled()


class BreadthFirst(Compact):
    """Rays go down the tree level by level in queues of (ray, node) pairs; shadow rays as they always do."""

    def reserve(self, paths):
        buffer, self.capacity = self.device.buffer, PAIRS_PER_PATH * paths
        self.pairs = [[buffer(4 * self.capacity) for _ in range(3)] for _ in range(2)]
        self.leaves = [buffer(4 * paths), *(buffer(4 * self.capacity) for _ in range(3)), buffer(4)]
        self.levels = buffer(4 * 256)

    def extend(self, params, queue, places, bounce):
        device, capacity = self.device, U(self.capacity)
        device.fill(self.levels, 0, 256)
        device.fill(self.leaves[-1], 0, 1)
        self.launch("bfs_start", self.size(places), params, queue, self.counts, *self.pairs[0], *self.leaves, capacity,
                    self.levels, U(bounce))
        for level in range(255):
            self.launch("bfs_level", self.size(self.capacity), params, *self.path, *self.pairs[level % 2],
                        *self.pairs[1 - level % 2], *self.leaves, capacity, self.levels, U(level))
            following = int(device.read(self.levels, level + 1)[0])
            needed = max(following, int(device.read(self.leaves[-1], 0)[0]))
            if needed > self.capacity:
                raise DeviceError(f"breadth_first: {needed} pairs of rays and nodes, there is room for "
                                  f"{self.capacity}: give it fewer paths")
            if not following:
                break
        self.launch("bfs_finish", self.size(places), params, *self.path, *self.hit, queue, self.counts,
                    *self.leaves[:4], U(bounce))


SCHEDULES = {"shipping": Shipping, "megakernel": Megakernel, "pipeline": Pipeline, "groups": Groups, "scan": Scan,
             "compact": Compact, "regeneration": Regeneration, "breadth_first": BreadthFirst}
