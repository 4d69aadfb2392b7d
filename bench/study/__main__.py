"""The founding report's study, run again.

    python -m bench.study measure -o ROWS [--scenes FOLDER] [--experiments traversals,schedules] [--budget 30]
                                  [--device opencl:0] [--jobs 12]
    python -m bench.study draw ROWS -o docs/study

`measure` writes a file of JSON rows for each experiment; rows that are there are kept, so that it goes on where it
was stopped. FOLDER holds exported scenes (cornell_box.npz, torus_box.npz, monkey_box.npz, instances.npz). `draw`
makes the report's figures of them and wants matplotlib.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

from bench.study.experiments import EXPERIMENTS, cpu_scale, gpu_scale
from bench.study.measure import compile_all, run_experiment
from isophote.opencl import import_pyopencl, opencl_devices


def thread_counts() -> tuple[int, ...]:
    """1, 2, 4, ... and all cores."""
    cores = os.cpu_count() or 1
    return tuple(sorted({n for n in (1, 2, 4, 8, 16, 32, 64) if n <= cores} | {cores}))


def measure(arguments) -> None:
    cl = import_pyopencl()
    number = int(arguments.device.partition(":")[2] or 0)
    is_gpu = bool(opencl_devices()[number].type & cl.device_type.GPU)
    scale = (gpu_scale if is_gpu else cpu_scale)(thread_counts())
    arguments.out.mkdir(parents=True, exist_ok=True)
    chosen = {name: EXPERIMENTS[name](scale) for name in arguments.experiments.split(",")}
    if arguments.jobs:
        cases = [case for groups in chosen.values() for group in groups for case in group]
        compile_all(cases, arguments.scenes, f"opencl:{number}", arguments.jobs)
    for name, groups in chosen.items():
        run_experiment(name, groups, arguments.scenes, arguments.out, f"opencl:{number}", arguments.target,
                       arguments.budget)


def draw(arguments) -> None:
    from bench.study.draw import draw_all  # matplotlib is not where GPUs are

    draw_all(arguments.rows, arguments.out)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    commands = parser.add_subparsers(required=True)
    measuring = commands.add_parser("measure", help="time the experiments")
    measuring.set_defaults(run=measure)
    measuring.add_argument("-o", "--out", type=Path, required=True, help="folder of the rows")
    measuring.add_argument("--scenes", type=Path, default=Path("."), help="folder of .npz scenes")
    measuring.add_argument("--experiments", default=",".join(EXPERIMENTS), help="else all")
    measuring.add_argument("--device", default="opencl:0")
    measuring.add_argument("--budget", type=float, default=30.0, help="seconds for each experiment")
    measuring.add_argument("--jobs", type=int, default=0, help="processes that compile all kernels first, where the "
                           "driver keeps them on disk (NVIDIA)")
    measuring.add_argument("--target", type=float, default=0.1, help="seconds that a round of a case shall last")
    drawing = commands.add_parser("draw", help="make the figures")
    drawing.set_defaults(run=draw)
    drawing.add_argument("rows", type=Path)
    drawing.add_argument("-o", "--out", type=Path, required=True)
    arguments = parser.parse_args()
    arguments.run(arguments)


if __name__ == "__main__":
    main()
