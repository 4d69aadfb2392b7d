# SPDX-License-Identifier: GPL-3.0-or-later
"""Stands in for the Blender program where there is only the bpy wheel: reads Blender's own options.

    python addon/scripts/blender_bpy.py -b FILE --addons NAME -E ENGINE -o //out_#### -F PNG -s 1 -e 2 -a

As in Blender, options are carried out in their order, and what stands after `--` belongs to scripts.
Unlike Blender, it exits with 1 when a render reported an error or wrote no picture.
"""

from __future__ import annotations

import os
import runpy
import sys
from collections.abc import Callable

import bpy

USAGE = __doc__


class RunnerError(RuntimeError):
    """An option that cannot be carried out, or a render that failed."""


class Runner:
    """Carries out options one after the other."""

    def __init__(self, arguments: list[str]):
        self.arguments = arguments
        self.loaded = False
        self.options: dict[str, Callable[[], None]] = {
            "-b": self.ignore, "--background": self.ignore,
            "--factory-startup": self.factory, "--python-use-system-env": self.ignore,
            "--addons": self.addons,
            "-E": self.engine, "--engine": self.engine,
            "-o": self.output, "--render-output": self.output,
            "-F": self.file_format, "--render-format": self.file_format,
            "-x": self.extension, "--use-extension": self.extension,
            "-t": self.threads, "--threads": self.threads,
            "-S": self.scene, "--scene": self.scene,
            "-s": self.start, "--frame-start": self.start,
            "-e": self.end, "--frame-end": self.end,
            "-j": self.jump, "--frame-jump": self.jump,
            "-f": self.frames, "--render-frame": self.frames,
            "-a": self.animation, "--render-anim": self.animation,
            "-P": self.script, "--python": self.script,
            "--python-expr": self.expression,
            "--python-exit-code": self.skip,
        }

    def run(self) -> None:
        while self.arguments:
            word = self.arguments.pop(0)
            if word == "--":
                return
            if word in self.options:
                self.options[word]()
            elif word.startswith("-"):
                raise RunnerError(f"unknown option {word}")
            else:
                self.open(word)

    def value(self) -> str:
        if not self.arguments:
            raise RunnerError("the last option wants a value")
        return self.arguments.pop(0)

    def skip(self) -> None:
        self.value()

    def ignore(self) -> None:
        """The module has no window and no environment of its own."""

    def factory(self) -> None:
        bpy.ops.wm.read_factory_settings()

    def open(self, path: str) -> None:
        if not os.path.isfile(path):
            raise RunnerError(f"{path}: no such file")
        try:
            bpy.ops.wm.open_mainfile(filepath=path)
        except RuntimeError as error:
            raise RunnerError(f"{path}: {str(error).strip()}") from None

    def addons(self) -> None:
        import addon_utils

        for name in self.value().split(","):
            if name.startswith("bl_ext."):  # extensions and their wheels are found once this is on
                addon_utils.enable("bl_pkg")
                addon_utils.extensions_refresh()
            if addon_utils.enable(name) is None:
                raise RunnerError(f"add-on {name} cannot be enabled")

    @property
    def render(self):
        return bpy.context.scene.render

    def engine(self) -> None:
        name = self.value()
        try:
            self.render.engine = name
        except TypeError as error:
            raise RunnerError(f"engine {name}: {error}") from None

    def output(self) -> None:
        self.render.filepath = self.value()

    def file_format(self) -> None:
        name = self.value()
        names = {"OPEN_EXR": "OPEN_EXR", "EXR": "OPEN_EXR", "MULTILAYER": "OPEN_EXR_MULTILAYER"}
        settings = self.render.image_settings
        wanted = names.get(name, name)
        if hasattr(settings, "media_type"):  # 5.0 and newer
            settings.media_type = "MULTI_LAYER_IMAGE" if wanted == "OPEN_EXR_MULTILAYER" else "IMAGE"
        settings.file_format = wanted

    def extension(self) -> None:
        self.render.use_file_extension = self.value() == "1"

    def threads(self) -> None:
        count = int(self.value())
        self.render.threads_mode = "FIXED" if count else "AUTO"
        if count:
            self.render.threads = count

    def scene(self) -> None:
        name = self.value()
        if name not in bpy.data.scenes:
            raise RunnerError(f"no scene {name}")
        bpy.context.window.scene = bpy.data.scenes[name]

    def start(self) -> None:
        bpy.context.scene.frame_start = int(self.value())

    def end(self) -> None:
        bpy.context.scene.frame_end = int(self.value())

    def jump(self) -> None:
        bpy.context.scene.frame_step = int(self.value())

    def frames(self) -> None:
        """N, +N and -N (from the start and the end), N,M and N..M."""
        scene = bpy.context.scene
        for part in self.value().split(","):
            first, _, last = part.partition("..")
            for frame in range(frame_number(scene, first), frame_number(scene, last or first) + 1):
                scene.frame_set(frame)
                render_frames(scene, frame, frame)

    def animation(self) -> None:
        scene = bpy.context.scene
        render_frames(scene, scene.frame_start, scene.frame_end)

    def script(self) -> None:
        path = self.value()
        before = sys.argv
        sys.argv = [path, *before[1:]]
        try:
            runpy.run_path(path, run_name="__main__")
        finally:
            sys.argv = before

    def expression(self) -> None:
        exec(compile(self.value(), "<--python-expr>", "exec"), {"__name__": "__main__"})


def frame_number(scene, text: str) -> int:
    if text.startswith("+"):
        return scene.frame_start + int(text[1:])
    if text.startswith("-"):
        return scene.frame_end - int(text[1:])
    return int(text)


def render_frames(scene, first: int, last: int) -> None:
    """Render a range as Blender's -a does. Raises RunnerError where an error was reported or a file is missing."""
    before = scene.frame_start, scene.frame_end
    scene.frame_start, scene.frame_end = first, last
    try:
        bpy.ops.render.render(animation=True, scene=scene.name)
    except RuntimeError as error:
        raise RunnerError(str(error).strip()) from None
    finally:
        scene.frame_start, scene.frame_end = before
    if not scene.render.is_movie_format:
        for frame in range(first, last + 1, scene.frame_step):
            path = scene.render.frame_path(frame=frame)
            if not os.path.isfile(path):
                raise RunnerError(f"{path}: not written")


def main() -> int:
    arguments = sys.argv[1:]
    if not arguments or arguments[0] in {"-h", "--help"}:
        print(USAGE)
        return 0
    try:
        Runner(arguments).run()
    except RunnerError as error:
        print(f"Error: {error}", file=sys.stderr, flush=True)
        return 1
    return 0


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    sys.stderr.flush()
    # The bpy module sometimes hangs while it frees its memory at the end (seen with 4.5.15).
    os._exit(status)
