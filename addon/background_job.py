# SPDX-License-Identifier: GPL-3.0-or-later
"""What modules share that another Blender runs for this one (background.py).

They print lines of MARK and a JSON object: {"doing", "share"} now and then, at the end what they made or {"error"}.
A line on stdin, or its end, stops them in good order: so nothing goes on when the Blender that asked has gone.
"""

from __future__ import annotations

import json
import os
import sys
import threading
from collections.abc import Callable

from isophote.device import DeviceError
from isophote.images import ImageError
from isophote.scene import SceneError
from isophote.settings import Settings
from isophote.trade.runs import TradeError

from .settings import device_of, own_values

MARK = "ISOPHOTE-SAYS "
EXPECTED = (DeviceError, ImageError, SceneError, TradeError, MemoryError, OSError, ValueError)


def say(**values) -> None:
    print(MARK + json.dumps(values), flush=True)


def say_doing(what: str, share: float) -> None:
    """What is done now, and the share of all that is done; 0 where nobody knows."""
    say(doing=what, share=min(1.0, share))


def settings_of(blender_scene) -> Settings:
    """The panel's settings, for a picture without a region."""
    own, render = blender_scene.isophote, blender_scene.render
    return Settings(**own_values(own), device=device_of(own), threads=render.threads,
                    film_transparent=render.film_transparent)


def run(work: Callable[[list[str], Callable[[], bool]], dict]) -> None:
    """Say what work(arguments, stopped) makes, or why it failed, and end the process. Arguments stand behind `--`."""
    stop = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.readline(), stop.set()), daemon=True).start()
    status = 0
    try:
        say(**work(sys.argv[sys.argv.index("--") + 1:], stop.is_set))
    except EXPECTED as error:
        say(error=str(error) or type(error).__name__)
        status = 1
    sys.stdout.flush()
    os._exit(status)  # Blender would wait for the thread that reads stdin
