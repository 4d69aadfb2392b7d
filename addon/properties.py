# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user can set: scene.isophote, view_layer.isophote and object.isophote. Defaults come from Settings."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty

from isophote.settings import Settings

DEFAULTS = Settings()
PRECISION_ITEMS = (
    ("strict", "Strict", "The same bits on every device"),
    ("fast", "Fast", "Whatever the compiler and the device can do; close to strict, not the same bits"),
    ("reference", "Reference", "64-bit arithmetic on the CPU, to see what 32 bits cost; slow"),
)
DEVICE_ITEMS = (
    ("openmp", "CPU", "All cores of this machine, through OpenMP"),
    ("opencl", "OpenCL", "A GPU, or anything else with an OpenCL driver"),
)


def bounces(setting: str, description: str):
    """A bounce limit with the default of the setting of that name."""
    name = setting.removesuffix("_bounces").title()
    return IntProperty(name=name, description=description, default=getattr(DEFAULTS, setting), min=0, max=1024)


def layer_pass(name: str, description: str):
    return BoolProperty(name=name, description=description, default=False, update=refresh)


def refresh(settings, _context) -> None:
    """Let the compositor's sockets follow the passes."""
    for layer in settings.id_data.view_layers:
        layer.update_render_passes()


class IsophoteSceneSettings(bpy.types.PropertyGroup):
    """Settings of a scene's renders."""

    samples: IntProperty(
        name="Samples", description="Paths a pixel", default=DEFAULTS.samples, min=1, max=1 << 30, soft_max=1 << 16
    )
    time_limit: FloatProperty(
        name="Time Limit",
        description="Stop after this time, 0 for no limit; exporting and preparing do not count",
        default=DEFAULTS.time_limit,
        min=0.0,
        subtype="TIME_ABSOLUTE",
        unit="TIME_ABSOLUTE",
    )
    error_percent: FloatProperty(
        name="Error",
        description="Stop when 95 % of the pixels are within this much of their brightness, 0 to go by samples and time"
        " alone",
        default=100.0 * DEFAULTS.error_target,
        min=0.0,
        soft_max=20.0,
        max=1000.0,
        precision=2,
        subtype="PERCENTAGE",
    )
    adaptive: BoolProperty(
        name="Adaptive",
        description="With a wanted error: samples go where they are needed, not as many to every pixel. Samples is"
        " then the most that a pixel may get",
        default=DEFAULTS.adaptive,
    )
    seed: IntProperty(name="Seed", description="Another seed gives another noise", default=DEFAULTS.seed, min=0)
    device: EnumProperty(name="Device", items=DEVICE_ITEMS, default=DEFAULTS.device)
    opencl_device: IntProperty(
        name="OpenCL Device", description="Number of the device, -1 for the first that is usable", default=-1, min=-1
    )
    wait_for_kernels: BoolProperty(
        name="Wait for Kernels",
        description="Do not let the CPU render while an OpenCL device compiles; the bits are the same either way",
        default=DEFAULTS.wait_for_kernels,
    )
    precision: EnumProperty(name="Precision", items=PRECISION_ITEMS, default=DEFAULTS.precision)
    max_bounces: bounces("max_bounces", "Bounces of a path, 0 for direct light only")
    diffuse_bounces: bounces("diffuse_bounces", "Diffuse bounces of a path")
    glossy_bounces: bounces("glossy_bounces", "Glossy bounces of a path")
    transmission_bounces: bounces("transmission_bounces", "Bounces of a path through glass and the like")
    volume_bounces: bounces("volume_bounces", "Times that volumes may scatter a path again, 0: once")
    transparent_bounces: bounces("transparent_bounces", "Transparent surfaces that a path may cross")
    clamp_direct: FloatProperty(
        name="Direct", description="Limit of a sample's direct light, 0 for none: a bias", min=0.0
    )
    clamp_indirect: FloatProperty(
        name="Indirect", description="Limit of a sample's indirect light, 0 for none: a bias", min=0.0
    )
    filter_width: FloatProperty(
        name="Filter Width",
        description="Width of the Blackman-Harris pixel filter",
        default=DEFAULTS.filter_width,
        min=0.01,
        max=10.0,
        subtype="PIXEL",
    )


class IsophoteViewLayerSettings(bpy.types.PropertyGroup):
    """Passes of a view layer that Blender has no switch for."""

    albedo: layer_pass("Albedo", "Colour of the surfaces")
    sample_count: layer_pass("Sample Count", "Samples of the pixel")
    invalid: layer_pass("Invalid", "Samples of the pixel that were no numbers and count as black")
    error: layer_pass("Error", "One standard deviation of the pixel's statistical error")


class IsophoteObjectSettings(bpy.types.PropertyGroup):
    """Settings of an object."""

    as_sphere: BoolProperty(
        name="Render as Sphere",
        description="Render an exact sphere that fills the bounding box in place of the mesh",
        default=False,
    )


CLASSES = (IsophoteSceneSettings, IsophoteViewLayerSettings, IsophoteObjectSettings)


def attach() -> None:
    bpy.types.Scene.isophote = PointerProperty(type=IsophoteSceneSettings)
    bpy.types.ViewLayer.isophote = PointerProperty(type=IsophoteViewLayerSettings)
    bpy.types.Object.isophote = PointerProperty(type=IsophoteObjectSettings)


def detach() -> None:
    for owner in (bpy.types.Object, bpy.types.ViewLayer, bpy.types.Scene):
        del owner.isophote
