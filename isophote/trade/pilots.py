"""Pilots: short renders that tell how quick each choice is, and the plan that follows from them."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict

import numpy as np

from isophote.device import DeviceError
from isophote.settings import Settings
from isophote.trade.grid import FIELDS, TRUTH, Choice, truth_of
from isophote.trade.job import Job, Status
from isophote.trade.plan import (
    FEWEST_ADAPTIVE,
    FLOAT64_WORTH,
    RESERVE,
    Cost,
    Plan,
    choose_samples,
    drop_slow,
    snapshots,
)
from isophote.trade.runs import Renderer

PILOTS, PILOT_SAMPLES = 2, 4
PIECE = 4  # a reference piece's samples, over those of a run


def truth_choice(base: Settings, precision: str) -> Choice:
    return Choice(TRUTH, "Nothing left out", "Nothing left out", truth_of(base, precision))


def make_plan(job: Job, renderer: Renderer, grid: list[Choice], base: Settings, size: tuple[int, int],
              show: Callable[[Status], None]) -> Plan:
    """Measure each choice's speed by short renders, and decide what fits the time."""
    started = time.perf_counter()
    precisions = ("strict", "reference") if base.device == "openmp" else (base.precision,)
    truths = [truth_choice(base, precision) for precision in precisions]
    costs, pictures, notes = run_pilots(job, renderer, [*grid, *truths], show)
    truth, cost = truths[0], costs[truths[0].settings]
    float64 = costs.get(truths[-1].settings)
    if float64 and float64.sample <= FLOAT64_WORTH * cost.sample:
        truth, cost = truths[-1], float64
    elif float64:
        slower = float64.sample / cost.sample
        notes.append({"name": "64-bit reference", "what": f"would take {slower:.1f} times as long: the reference is in "
                      f"{truth.settings.precision} precision"})
    grid = [choice for choice in grid if choice.settings in costs]
    kept = []
    for choice in grid:
        if choice.can_be_idle and np.array_equal(pictures[choice.settings], pictures[base]):
            paths = PILOT_SAMPLES * size[0] * size[1]
            notes.append({"name": choice.label, "what": f"changed not one of {paths:,} paths: left out"})
        else:
            kept.append(choice)
    kept, slow = drop_slow(kept, [costs[choice.settings] for choice in kept])
    left = (1.0 - RESERVE) * job.seconds - (time.perf_counter() - started)
    samples = choose_samples([cost, *(costs[choice.settings] for choice in kept)], left)
    target, too_short = adaptive_target(renderer, base, samples)
    chosen = {choice.key: asdict(choice.settings) for choice in [*kept, truth]}
    return Plan(renderer.scene_hash, size, chosen, snapshots(samples), PIECE * samples, time.perf_counter() - started,
                target, notes + slow + too_short)


def adaptive_target(renderer: Renderer, base: Settings, samples: int) -> tuple[float, list[dict]]:
    """The error to which adaptive sampling is to render: that of a run without it; 0 and why where it is not tried."""
    if "adaptive" not in FIELDS:
        return 0.0, []
    if samples < FEWEST_ADAPTIVE:
        what = f"begins at {FEWEST_ADAPTIVE} samples, and the time allows runs of {samples}: left out"
        return 0.0, [{"name": "Adaptive sampling", "what": what}]
    return float(f"{renderer.render(base, 0, [samples]).info['error_95'] or 0.0:.3g}"), []


def run_pilots(job: Job, renderer: Renderer, choices: list[Choice],
               show: Callable[[Status], None]) -> tuple[dict[Settings, Cost], dict[Settings, np.ndarray], list[dict]]:
    """Cost and picture of each choice, by settings, and notes on those that cannot be rendered here.

    Of PILOTS renders the quickest counts, for others use the machine too. Raises DeviceError for the first choice.
    """
    started, notes = time.perf_counter(), []
    failed: dict[tuple, str] = {}
    for choice in choices:
        kind = choice.settings.device, choice.settings.precision
        try:
            if kind not in failed:
                renderer.render(choice.settings, 0, [1])  # what the first render waits for (kernels) is nobody's
                failed[kind] = ""
        except DeviceError as error:
            if choice is choices[0]:
                raise
            failed[kind] = str(error)
        if failed[kind] and choice.key != TRUTH:
            notes.append({"name": choice.label, "what": f"cannot be rendered here: {failed[kind]}"})
    costs, pictures = {}, {}
    usable = [choice for choice in choices if not failed[choice.settings.device, choice.settings.precision]]
    for _ in range(PILOTS):
        for choice in usable:
            show(Status(f"pilot: {choice.label}", time.perf_counter() - started, job.seconds))
            run = renderer.render(choice.settings, 0, [PILOT_SAMPLES])
            pictures[choice.settings] = run.pictures
            cost = Cost(run.seconds[-1] / PILOT_SAMPLES, run.wall - run.seconds[-1])
            costs[choice.settings] = min(cost, costs.get(choice.settings, cost), key=lambda c: c.sample)
    return costs, pictures, notes
