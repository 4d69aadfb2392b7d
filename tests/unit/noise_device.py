"""A real device without a renderer: radiance is a pure pseudo-random function of pixel, sample, seed and plane."""

import time
from dataclasses import dataclass, field

import numpy as np

from isophote.device import DeviceError
from isophote.passes import USUAL, planes_for
from isophote.scene import make_scene

AOV_PLANES = planes_for(USUAL)


class NoGeometry:
    def settle(self, keep_bvh2):
        pass

    def drop_wide_tree(self):
        pass


@dataclass
class Prepared:
    buffers: dict = field(default_factory=dict)
    geometry: NoGeometry = field(default_factory=NoGeometry)
    features: int = 0
    build_seconds: float = 0.25
    notes: list = field(default_factory=list)


def hashed(*keys) -> np.ndarray:
    """Uniform float64 in (0, 1) of integer arrays that broadcast (a chain of SplitMix64 finalisers)."""
    h = np.uint64(0x9E3779B97F4A7C15)
    with np.errstate(over="ignore"):
        for key in keys:
            h = h ^ np.asarray(key, np.uint64)
            h = (h ^ (h >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
            h = (h ^ (h >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
            h = h ^ (h >> np.uint64(31))
    return (h >> np.uint64(11)).astype(np.float64) * 2.0**-53 + 2.0**-54


def radiance(region, sample: int, seed: int, planes: int, pixels=None) -> np.ndarray:
    """What one sample adds to the planes of a region or of a WorkItem's pixels, float32 (planes, h, w); the
    mean of RGB is x + 1."""
    x0, y0, x1, y1 = region
    y, x = np.mgrid[y0:y1, x0:x1]
    values = np.zeros((planes, y1 - y0, x1 - x0), np.float32)
    first = 4 * (sample & 1)
    if pixels is not None:
        x, y, sample = (column[None] for column in (pixels + [0, 0, sample]).T)
    for channel in range(3):
        values[first + channel] = -(x + 1) * np.log(hashed(x, y, sample, seed, channel))
    values[first + 3] = 1.0
    if len(values) >= int(AOV_PLANES):
        values[13:19] = hashed(x, y, sample, seed, np.arange(6)[:, None, None] + 10)
        values[9] = (x + 10.0) * (sample == 0)
        values[10:13] = np.stack([x, y, x + y]) * (sample == 0)
    return values


class NoiseDevice:
    """`fail_after`: samples after which render raises; `on_sample` is called before each; `delay` seconds a sample."""

    driver, strict, compile_seconds, kernels_from, notes, memory, ended = "numpy", True, 0.0, "", (), {}, 0

    def __init__(self, settings=None, kind="openmp", fail_after=None, on_sample=None, delay=0.0, planes_seen=None):
        self.name, self.kind = f"noise {kind}", kind
        self.fail_after, self.on_sample, self.delay = fail_after, on_sample, delay
        self.uploads, self.closed, self.items = 0, False, []

    def check_room(self, prepared):
        pass

    def upload(self, prepared):
        self.uploads += 1
        if self.fail_after == -1:
            raise DeviceError("out of device memory")

    def render(self, item, settings, sums, cancelled):
        self.items.append(item)
        part = sums.copy()  # a failure leaves sums as they were
        for count in range(item.samples):
            offset = item.first_sample + count
            sample = offset + (0 if item.pixels is None else int(item.pixels[:, 2].max()))
            if self.on_sample:
                self.on_sample(sample)
            if cancelled():
                sums[:] = part
                return count
            if self.fail_after is not None and sample >= self.fail_after:
                raise DeviceError("the driver reset")
            time.sleep(self.delay)
            part += radiance(item.region, offset, settings.seed, len(sums), item.pixels)
        sums[:] = part
        return item.samples

    def close(self):
        self.closed = True


def tiny_scene(width=12, height=10, **changes):
    """One triangle, one material, one point light, before a camera; `changes` replaces arrays."""
    arrays = dict(
        resolution=[width, height], camera_to_world=np.eye(3, 4), camera_window=[-1, 1, -1, 1], camera_clip=[0.1, 100],
        vertices=[[-1, -1, -3], [1, -1, -3], [0, 1, -3]], triangles=[[0, 1, 2]],
        mesh_vertices=[0, len(changes.get("vertices", range(3)))], mesh_triangles=[0, 1], mesh_normals=[-1],
        instance_mesh=[0], instance_to_world=[np.eye(3, 4)], instance_slots=[0],
        instance_visibility=[31], slot_materials=[0], material_first=[0, 1], instruction_op=[1],
        instruction_weight=[[0.8, 0.8, 0.8]], instruction_params=np.zeros((1, 11)), light_kind=[0],
        light_to_world=[np.eye(3, 4)], light_strength=[[10, 10, 10]], light_size=[[0, 0]], light_spot=[[0, 0]],
        light_flags=[0], light_visibility=[31],
    )
    names = {"meshes": ["Mesh"], "instances": ["Triangle"], "materials": ["Grey"], "lights": ["Lamp"]}
    return make_scene(names=names, **(arrays | changes))
