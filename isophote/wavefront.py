"""Paths in flight on an OpenCL device: their memory, and the launches that take them to their end.

The host only launches. Paths and queues stay on the device; how many paths live is read back behind the
launches, so that the device never waits for the host, and the host still stops when the last path has died.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from isophote.planes import Planes
from isophote.records import numbers

# Columns of 4 bytes a path, by buffer; `columns` are as many as the film's further planes want.
COLUMNS = {"reals": 12, "uints": 7, "hit_reals": 3, "hit_uints": 2, "light_reals": 10, "light_uints": 3, "results": 4,
           "queue": 1, "next_queue": 1, "light_queue": 1}
MEDIUM_COLUMNS = 11  # kernels/walk.h
VOLUME_COLUMNS = 2 * numbers()["MOST_VOLUMES"] + 2  # kernels/volume.h
KERNELS = ("generate", "extend", "travel", "occlude", "shade", "complete", "connect", "accumulate")
GROUP = 64  # work-items of a group
# Of `shade` on GPUs. Barriers keep a group's threads at the same instructions, of which shading has more than an
# H200's cache holds: 512 took 0.78 to 1.03 of the time of 256, 0.62 to 1.05 of that of 128.
SHADE_GROUP = 512
MOST_BOUNCES = 515  # vertices of a path: 8 bits count those that scatter, 8 those that let it pass; one is below
# Kernels that trace: groups whose lanes take the group's rays as they come, on GPUs after the camera's rays, which
# keep together anyway. Fewer where groups would not fill the device.
TRACE_GROUP, RAYS_EACH, GROUPS_EACH_UNIT = 128, 8, 8
BOUNCES_AHEAD = 2  # launched before the host looks how many paths an earlier bounce has left


def path_columns(planes: Planes, features: int) -> dict[str, int]:
    """Columns of 4 bytes that each path takes, by buffer, for a film of these planes and a scene of these features."""
    n, made = numbers(), COLUMNS | {"columns": planes.columns}
    names = ("FEATURE_MOTION", "FEATURE_SUBSURFACE", "FEATURE_LINKING", "FEATURE_VOLUME")
    times, medium, linked, travels = (bool(features & n[name]) for name in names)
    made["reals"] += MEDIUM_COLUMNS * medium + times
    made["uints"] += VOLUME_COLUMNS * travels
    made["light_reals"] += planes.clamps + times
    made["light_uints"] += (1 + VOLUME_COLUMNS) * travels
    made["results"] += 2 * planes.clamps
    made["columns"] = max(planes.columns + linked, 1)
    return made


def shade_group(device, cl) -> int:
    """Work-items of a group of `shade`, for which the kernel is compiled; 0: any number."""
    return min(SHADE_GROUP, device.max_work_group_size) if device.type & cl.device_type.GPU else 0


class Wavefront:
    """Room for `paths` paths, and the kernels of `program` with their arguments set once for all launches.

    `cl` is the module pyopencl, `scene` the buffers in the order of kernels/scene_buffers.h. The program is for films
    of `planes` and scenes of `features`. Errors are those of pyopencl.
    """

    def __init__(self, cl, queue, program, scene: list, paths: int, planes: Planes, features: int):
        self.cl, self.queue, self.paths = cl, queue, paths
        self.completes = bool(features & numbers()["FEATURE_SHINES"])
        self.travels = bool(features & numbers()["FEATURE_VOLUME"])
        self.occludes = "ambient_occlusion" in planes.groups
        self.sees_behind = bool(features & numbers()["FEATURE_TRANSPARENT"])  # the camera, after its first ray
        context, flags = queue.context, cl.mem_flags
        self.buffers = {name: cl.Buffer(context, flags.READ_WRITE, 4 * columns * paths)
                        for name, columns in path_columns(planes, features).items()}
        self.limits = cl.Buffer(context, flags.READ_WRITE, 3 * 4 * numbers()["LIMITS"])
        lengths = 2 * MOST_BOUNCES + 2
        self.counts = cl.Buffer(context, flags.READ_WRITE, 4 * lengths)
        # Pinned: reading into other memory makes some drivers wait for the device.
        pinned = cl.Buffer(context, flags.READ_WRITE | flags.ALLOC_HOST_PTR, 4 * lengths)
        self.left, _ = cl.enqueue_map_buffer(queue, pinned, cl.map_flags.READ | cl.map_flags.WRITE, 0, lengths,
                                             np.uint32)
        self.group = {name: GROUP for name in KERNELS}
        self.rays_each, self.enough_groups = 1, GROUPS_EACH_UNIT * queue.device.max_compute_units
        if queue.device.type & cl.device_type.GPU:
            largest = min(TRACE_GROUP, queue.device.max_work_group_size)
            self.group |= {"shade": shade_group(queue.device, cl), "extend": largest, "connect": largest}
            self.rays_each = RAYS_EACH
        b, stride = self.buffers, np.uint32(paths)
        path, hit = (b["reals"], b["uints"], stride), (b["hit_reals"], b["hit_uints"])
        light, result = (b["light_reals"], b["light_uints"]), (b["results"], b["columns"], self.limits)
        # The queues change places with every bounce: kernels that use them exist twice. None: set for each launch.
        self.kernels = {("generate", 0): (*scene, None, *path, *result, b["queue"], self.counts,
                                        np.uint32(lengths), None, None)}
        for parity, (now, following) in enumerate([("queue", "next_queue"), ("next_queue", "queue")]):
            self.kernels |= {
                ("extend", parity): (*scene, None, *path, *hit, b[now], self.counts, None),
                ("shade", parity): (*scene, None, *path, *hit, *light, *result, b[now], b[following],
                                    b["light_queue"], self.counts, None)}
            if self.travels:
                self.kernels["travel", parity] = (*scene, None, *path, *hit, *result, b[now], self.counts, None)
            if self.occludes:
                self.kernels["occlude", parity] = (*scene, None, *path, *hit, b["columns"], b[now], self.counts, None)
        self.kernels |= {
            ("connect", 0): (*scene, None, stride, *light, *result, b["light_queue"], self.counts, None),
            ("accumulate", 0): (None, stride, *result, None, None, None)}
        if self.completes:
            self.kernels["complete", 0] = (*scene, None, stride, *light, b["light_queue"], self.counts, None)
        for (name, parity), arguments in self.kernels.items():
            kernel = cl.Kernel(program, name)
            for at, argument in enumerate(arguments):
                if argument is not None:
                    kernel.set_arg(at, argument)
            self.kernels[name, parity] = kernel, [at for at, argument in enumerate(arguments) if argument is None]

    def launch(self, name: str, count: int, *changing, parity: int = 0, each: int = 1):
        """Enqueue a kernel for `count` paths, about `each` of them a work-item; `changing` are the arguments that it
        lacks. Returns the event."""
        kernel, places = self.kernels[name, parity]
        for at, argument in zip(places, changing, strict=True):
            kernel.set_arg(at, argument)
        group = self.group[name]
        groups = max(-(-count // (group * each)), min(-(-count // group), self.enough_groups))
        return self.cl.enqueue_nd_range_kernel(self.queue, kernel, (groups * group,), (group,))

    def trace(self, params, film, first: int, pixels: int, samples: int, bounces: int,
              cancelled: Callable[[], bool]) -> bool:
        """Trace `samples` samples of pixels [first, first + pixels) of the region and add them to the film.

        `params`, one for each time that paths begin, and `film` are buffers; `bounces` is the largest number of
        vertices that a path may have. False where cancelled: the film is then worth nothing.
        """
        for each in params:
            if not self.trace_paths(each, first, pixels * samples, bounces, cancelled):
                return False
        self.launch("accumulate", pixels, params[0], film, np.uint32(first), np.uint32(pixels))
        return not cancelled()

    def trace_paths(self, params, first: int, count: int, bounces: int, cancelled: Callable[[], bool]) -> bool:
        """Paths from the camera to their ends; as in trace."""
        u = np.uint32
        looks = []
        self.launch("generate", count, params, u(first), u(count))
        alive = count
        for bounce in range(min(bounces, MOST_BOUNCES)):
            if bounce >= BOUNCES_AHEAD:
                looks[bounce - BOUNCES_AHEAD].wait()
                alive = int(self.left[bounce - BOUNCES_AHEAD])
                if cancelled():
                    return False
            if not alive:
                break
            parity, each = bounce % 2, self.rays_each if bounce else 1
            self.launch("extend", alive, params, u(bounce), parity=parity, each=each)
            if self.travels:
                self.launch("travel", alive, params, u(bounce), parity=parity)
            if self.occludes and (bounce == 0 or self.sees_behind):
                self.launch("occlude", alive, params, u(bounce), parity=parity)
            self.launch("shade", alive, params, u(bounce), parity=parity)
            if self.completes:
                self.launch("complete", alive, params, u(bounce))
            self.launch("connect", alive, params, u(bounce), each=each)
            looks.append(self.cl.enqueue_copy(self.queue, self.left[bounce:bounce + 1], self.counts,
                                              src_offset=8 * (bounce + 1), is_blocking=False))
            self.queue.flush()
        return True
