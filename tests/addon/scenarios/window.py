# SPDX-License-Identifier: GPL-3.0-or-later
"""In a window: choose the engine, press F12, let the picture come, cancel with Esc what would take hours.

    blender ... --python window.py -- FOLDER

A timer drives it, a step at a time; screenshots are asked for by writing a file's name to stdout.
"""

import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy

FOLDER = Path(sys.argv[sys.argv.index("--") + 1])
GIVE_UP = 60.0  # seconds
finished, cancelled = [], []


def screenshot(name):
    subprocess.run(["import", "-window", "root", str(FOLDER / name)], check=True)


def context():
    window = bpy.context.window_manager.windows[0]
    return {"window": window, "screen": window.screen}


def properties_editor(tab):
    """Show a tab of the properties editor, large enough to see its panels."""
    area = next(a for a in bpy.context.window_manager.windows[0].screen.areas if a.type == "PROPERTIES")
    area.spaces[0].context = tab


def steps():
    """What is done, one step a tick of the timer; yields while it waits."""
    begin = time.perf_counter()
    scene = bpy.context.scene
    scene.render.engine = "ISOPHOTE"
    render = scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 480, 270, 100
    scene.isophote.samples = 64
    for tab in ("RENDER", "VIEW_LAYER", "MATERIAL", "WORLD"):
        properties_editor(tab)
        yield 0.5
        screenshot(f"panels_{tab.lower()}.png")
    bpy.app.handlers.render_complete.append(lambda *_: finished.append(time.perf_counter()))
    bpy.app.handlers.render_cancel.append(lambda *_: cancelled.append(time.perf_counter()))
    with bpy.context.temp_override(**context()):
        bpy.ops.render.render("INVOKE_DEFAULT")
    while not finished:
        assert time.perf_counter() - begin < GIVE_UP, "F12 did not come to its end"
        yield 0.2
    yield 1.0
    screenshot("f12.png")
    scene.isophote.samples = 1 << 24
    with bpy.context.temp_override(**context()):
        bpy.ops.render.render("INVOKE_DEFAULT")
    yield 4.0
    screenshot("progress.png")
    pressed = time.perf_counter()
    # A real key: Blender looks for Esc where events come from the window system, not for simulated ones.
    subprocess.run(["xdotool", "mousemove", "500", "400", "key", "Escape"], check=True)
    while not cancelled:
        assert time.perf_counter() - begin < GIVE_UP, "Esc did not stop the render"
        yield 0.02
    seconds = cancelled[0] - pressed
    yield 1.0
    screenshot("cancelled.png")
    settings = render.image_settings
    settings.file_format = "OPEN_EXR"
    bpy.data.images["Render Result"].save_render(str(FOLDER / "cancelled.exr"), scene=scene)
    print(f'SCENARIO {{"seconds": {seconds}}}', flush=True)


view = bpy.context.preferences.view
view.show_splash = False  # it would take the Esc
view.render_display_type = "AREA"
todo = steps()


def tick():
    try:
        return next(todo)
    except StopIteration:
        pass
    except Exception:
        traceback.print_exc()
    bpy.ops.wm.quit_blender()
    return None


bpy.app.timers.register(tick, first_interval=2.0)
