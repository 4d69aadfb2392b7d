# SPDX-License-Identifier: GPL-3.0-or-later
"""Measures the sheen tables that Cycles shades with, into isophote/data/sheen_tables.npy.

    python bench/sheen_table.py [output.npy]

Zeltner, Burley and Chiang 2022, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines", fit
three numbers to simulated fibres, as functions of the cosine mu of the viewer and of the roughness: the albedo
R and the entries a, b of the matrix that turns the lobe into a cosine. A picture that looks like Cycles' needs
the very numbers of that fit, so they are read off its pictures: facets of every mu and roughness, lit by one sun
at a time. A facet's radiance over the sun's irradiance is R/pi z (a/q)^2 with q = (a x + b z)^2 + (a y)^2 + z^2
for a sun towards (x, y, z), x being the viewer's side. Its inverse's square root is linear in three unknowns.

It wants a Python with the bpy wheel. kernels/bsdf/sheen.h documents the layout: [3][roughness][mu].
"""

from __future__ import annotations

import math
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy as np

NODES = 32  # of both axes, as in Cycles, which interpolates linearly between them
PIXELS = 4  # of a facet's side
SUNS = np.array([(0.3, 0.0, 0.95), (0.8, 0.3, 0.5), (0.6, -0.6, 0.5), (0.95, 0.1, 0.3), (0.5, 0.5, 0.7)])
SUNS /= np.linalg.norm(SUNS, axis=1, keepdims=True)


def measured_coordinates() -> np.ndarray:
    """Where both axes are measured: nodes, but next to the ends, where Cycles clamps or a facet is not seen."""
    steps = np.arange(NODES, dtype=np.float64)
    steps[0], steps[-1] = 0.5, NODES - 1.5
    return steps / (NODES - 1)


def to_nodes(values: np.ndarray, axis: int) -> np.ndarray:
    """Extrapolate along an axis from the halves of the outer cells to their ends."""
    v = np.moveaxis(values, axis, 0).copy()
    v[0], v[-1] = 2 * v[0] - v[1], 2 * v[-1] - v[-2]
    return np.moveaxis(v, 0, axis)


def make_facets(coordinates: np.ndarray) -> None:
    """Facet (i, j) fills the cell [j, j + 1] x [i, i + 1] of the view along -z; mu by column, roughness by row."""
    for i, roughness in enumerate(coordinates):
        material = bpy.data.materials.new(f"row {i}")
        material.use_nodes = True
        tree = material.node_tree
        tree.nodes.clear()
        sheen = tree.nodes.new("ShaderNodeBsdfSheen")
        sheen.inputs["Color"].default_value = (1, 1, 1, 1)
        sheen.inputs["Roughness"].default_value = roughness
        tree.links.new(sheen.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
        vertices, faces = [], []
        for j, mu in enumerate(coordinates):
            drop = math.sqrt(1 - mu * mu) / mu  # the normal leans towards +x
            faces.append(tuple(len(vertices) + k for k in range(4)))
            vertices += [(j, i, 0), (j + 1, i, -drop), (j + 1, i + 1, -drop), (j, i + 1, 0)]
        mesh = bpy.data.meshes.new(f"row {i}")
        mesh.from_pydata(vertices, [], faces)
        mesh.materials.append(material)
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(f"row {i}", mesh))


def make_scene() -> None:
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples, scene.cycles.use_adaptive_sampling, scene.cycles.use_denoising = 1, False, False
    scene.cycles.max_bounces, scene.cycles.filter_width = 0, 0.01
    scene.render.resolution_x = scene.render.resolution_y = NODES * PIXELS
    scene.render.resolution_percentage = 100
    image = scene.render.image_settings
    image.file_format, image.color_mode, image.color_depth = "OPEN_EXR", "RGB", "32"
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", NODES, 1000
    scene.camera = bpy.data.objects.new("camera", camera)
    scene.camera.location = (NODES / 2, NODES / 2, 10)
    scene.collection.objects.link(scene.camera)


def render_sun(direction: np.ndarray, folder: str) -> np.ndarray:
    """Radiance of all facets in the light of a sun of irradiance 1 from `direction`, f8 [roughness, mu]."""
    scene = bpy.context.scene
    sun = bpy.data.lights.new("sun", "SUN")
    sun.angle, sun.energy, sun.use_shadow = 0.0, 1.0, False
    ob = bpy.data.objects.new("sun", sun)
    ob.rotation_mode = "AXIS_ANGLE"
    axis = np.cross((0, 0, 1), direction)
    ob.rotation_axis_angle = (math.acos(direction[2]), *(axis / np.linalg.norm(axis)))
    scene.collection.objects.link(ob)
    scene.render.filepath = str(Path(folder) / "sun.exr")
    bpy.ops.render.render(write_still=True)
    picture = bpy.data.images.load(scene.render.filepath)
    pixels = np.array(picture.pixels[:], np.float64).reshape(NODES * PIXELS, NODES * PIXELS, -1)[..., 0]
    bpy.data.images.remove(picture)
    bpy.data.objects.remove(ob)
    return pixels.reshape(NODES, PIXELS, NODES, PIXELS)[:, 1:-1, :, 1:-1].mean(axis=(1, 3))


def solve(radiance: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """(a, b, R) [3, roughness, mu] from radiances [sun, roughness, mu]. Where nothing is seen R is 0 and the lobe is
    that of the next rougher row."""
    sine = np.sqrt(1 - mu * mu)
    out = np.empty((3, *radiance.shape[1:]))
    for i, j in np.ndindex(radiance.shape[1:]):
        x, y, z = np.array([(-mu[j], 0, sine[j]), (0, -1, 0), (sine[j], 0, mu[j])]) @ SUNS.T
        matrix = np.stack([x * x + y * y, 2 * x * z, z * z], axis=1)
        p = np.linalg.lstsq(matrix, np.sqrt(z / np.maximum(radiance[:, i, j], 1e-30)), rcond=None)[0]
        t = p[1] / p[0]
        a = 1 / np.sqrt(p[2] / p[0] - t * t)
        out[:, i, j] = a, t * a, np.pi / (p[0] / a) ** 2
    for i in reversed(range(NODES - 1)):
        unseen = ~np.isfinite(out[:, i]).all(axis=0) | (radiance[:, i].min(axis=0) < 1e-9)
        out[:2, i, unseen], out[2, i, unseen] = out[:2, i + 1, unseen], 0
    return out


def main() -> None:
    default = Path(__file__).parents[1] / "isophote" / "data" / "sheen_tables.npy"
    coordinates = measured_coordinates()
    make_scene()
    make_facets(coordinates)
    with tempfile.TemporaryDirectory() as folder:
        radiance = np.stack([render_sun(direction, folder) for direction in SUNS])
    tables = to_nodes(to_nodes(solve(radiance, coordinates), 1), 2)
    tables[0], tables[2] = np.maximum(tables[0], 1e-3), np.clip(tables[2], 0, 1)
    np.save(sys.argv[1] if len(sys.argv) > 1 else default, tables.astype(np.float32))


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # the bpy module sometimes hangs while it is torn down after a render
