"""A trade report from scene to page: pilots, rounds until the time is over, analysis, files.

The folder holds index.html, pictures/, rows.csv, rows.json, and runs/ with the plan and a file for each finished run.
A report that was interrupted takes what is there and goes on with the plan; what was spent counts.
"""

from __future__ import annotations

import datetime
import shutil
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np

from isophote.device import DeviceError
from isophote.scene import Scene
from isophote.settings import Settings
from isophote.trade import pictures as drawing
from isophote.trade.advice import advise
from isophote.trade.analysis import Measured, Reference, Replicates, make_reference, measure
from isophote.trade.grid import (
    ADAPTIVE,
    FIELDS,
    TRUTH,
    Choice,
    adaptive_choice,
    make_grid,
    plain_settings,
    truth_of,
)
from isophote.trade.page import CHANGE_FULL, NOISE_FULL, About, make_page
from isophote.trade.plan import (
    ADAPTIVE_ROOM,
    FEWEST_ADAPTIVE,
    FEWEST_ROUNDS,
    FLOAT64_WORTH,
    MOST_ROUNDS,
    REFERENCE_SEED,
    REFERENCE_SHARE,
    RESERVE,
    Cost,
    Plan,
    check_same,
    choose_samples,
    drop_slow,
    load_plan,
    save_plan,
    snapshots,
)
from isophote.trade.rows import as_csv, as_json, as_object
from isophote.trade.runs import Cancelled, Renderer, Run, Store, TradeError

PILOTS, PILOT_SAMPLES = 2, 4
PIECE = 4  # a reference piece's samples, over those of a run


@dataclass(frozen=True)
class Job:
    """What a report is of. `base` are the user's settings, `devices` others to try; `seconds` is the time in all.

    `pictures`: png or jpg. `anew`: forget what lies in the folder. `most_rounds` ends a report before its time.
    """

    scene: Scene
    name: str
    full_size: tuple[int, int]
    base: Settings
    folder: Path
    seconds: float
    devices: tuple[str, ...] = ()
    pictures: str = "png"
    anew: bool = False
    most_rounds: int = MOST_ROUNDS


@dataclass(frozen=True)
class Status:
    """Where a report stands: what it does, the seconds spent and those it may spend."""

    doing: str
    spent: float
    seconds: float


@dataclass
class Work:
    """A report under way: what its steps share."""

    job: Job
    renderer: Renderer
    store: Store
    choices: list[Choice]  # the truth first, then the user's settings, then the others
    plan: Plan
    spent: float
    walls: dict[str, list[float]] = field(default_factory=dict)
    done: dict[str, list[int]] = field(default_factory=dict)

    @property
    def truth(self) -> Choice:
        return self.choices[0]


def make_report(job: Job, show: Callable[[Status], None] = lambda status: None,
                cancelled: Callable[[], bool] = lambda: False) -> dict:
    """Make or continue the report; what rows.json holds, with `partial`, comes back.

    Raises TradeError where it cannot be made or continued, or was cancelled before there was enough to say anything;
    DeviceError, SceneError of rendering.
    """
    runs = job.folder / "runs"
    try:
        if job.anew and runs.is_dir():
            shutil.rmtree(runs)
        runs.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise TradeError(f"{job.folder}: cannot be used as the report's folder: {error.strerror}") from error
    renderer = Renderer(job.scene, cancelled)
    try:
        partial = False
        try:
            work = begin(job, renderer, Store(runs, renderer.scene_hash), show)
        except Cancelled:
            raise TradeError("stopped while the pilots ran: nothing was measured yet") from None
        try:
            render_rounds(work, show)
        except Cancelled:
            partial = True
    finally:
        renderer.close()
    show(Status("writing the report", work.spent, job.seconds))
    return write_report(work, partial)


def begin(job: Job, renderer: Renderer, store: Store, show: Callable[[Status], None]) -> Work:
    """The plan: that of the folder where it fits, else made from pilots."""
    base = plain_settings(job.base)
    grid = make_grid(base, job.devices)
    size = tuple(int(n) for n in job.scene.resolution)
    plan = load_plan(store.folder / "plan.json")
    if plan is None:
        plan = make_plan(job, renderer, grid, base, size, show)
        save_plan(plan, store.folder / "plan.json")
    else:
        wanted = [*grid, truth_choice(base, plan.choices[TRUTH]["precision"])]
        check_same(plan, store.scene_hash, size, {choice.key: asdict(choice.settings) for choice in wanted})
    choices = [truth_choice(base, plan.choices[TRUTH]["precision"]), *(c for c in grid if c.key in plan.choices)]
    if plan.target:
        choices.append(adaptive_choice(base, plan.target))
    work = Work(job, renderer, store, choices, plan, plan.pilot_seconds)
    for choice in choices:
        counts = {seed: counts_of(plan, choice) for seed in range(1, MOST_ROUNDS + 1)}
        if choice.key == TRUTH:
            counts |= {REFERENCE_SEED + k: [plan.piece] for k in range(found_pieces(store, choice))}
        for seed, of_seed in counts.items():
            if store.path(choice, seed).exists() and (run := store.load(choice, seed, of_seed)) is not None:
                note_run(work, choice, seed, run)
    return work


def counts_of(plan: Plan, choice: Choice) -> list[int]:
    """The numbers of samples of a choice's runs; adaptive sampling stops by itself."""
    return [ADAPTIVE_ROOM * plan.counts[-1]] if choice.key == ADAPTIVE else plan.counts


def truth_choice(base: Settings, precision: str) -> Choice:
    return Choice(TRUTH, "Nothing left out", "Nothing left out", truth_of(base, precision))


def found_pieces(store: Store, truth: Choice) -> int:
    count = 0
    while store.path(truth, REFERENCE_SEED + count).exists():
        count += 1
    return count


def note_run(work: Work, choice: Choice, seed: int, run: Run) -> None:
    kind = "reference" if seed >= REFERENCE_SEED else choice.key
    work.done.setdefault(kind, []).append(seed)
    work.walls.setdefault(kind, []).append(run.wall)
    work.spent += run.wall


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
    samples, target = choose_samples([cost, *(costs[choice.settings] for choice in kept)], left), 0.0
    if "adaptive" in FIELDS and samples >= FEWEST_ADAPTIVE:
        target = float(f"{renderer.render(base, 0, [samples]).info['error_95'] or 0.0:.3g}")
    elif "adaptive" in FIELDS:
        notes.append({"name": "Adaptive sampling", "what": f"begins at {FEWEST_ADAPTIVE} samples, and the time allows "
                      f"runs of {samples}: left out"})
    chosen = {choice.key: asdict(choice.settings) for choice in [*kept, truth]}
    return Plan(renderer.scene_hash, size, chosen, snapshots(samples), PIECE * samples, time.perf_counter() - started,
                target, notes + slow)


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


def render_rounds(work: Work, show: Callable[[Status], None]) -> None:
    """Runs, and between them pieces of the reference, until the time or the rounds are over. Raises Cancelled."""
    limit = (1.0 - RESERVE) * work.job.seconds
    for seed in range(1, work.job.most_rounds + 1):
        for choice in work.choices:
            if seed in work.done.get(choice.key, ()):
                continue
            if work.spent + predicted(work, choice.key) > limit:
                return
            show(Status(f"round {seed}: {choice.label}", work.spent, work.job.seconds))
            finish_run(work, choice, seed, counts_of(work.plan, choice))
            while reference_is_due(work) and work.spent + predicted(work, "reference") <= limit:
                show(Status("the reference", work.spent, work.job.seconds))
                number = len(work.done.get("reference", ()))
                finish_run(work, work.truth, REFERENCE_SEED + number, [work.plan.piece])


def reference_is_due(work: Work) -> bool:
    """The reference has less than its share of the time, or has not two pieces."""
    pieces = sum(work.walls.get("reference", ()))
    return len(work.done.get("reference", ())) < 2 or pieces < REFERENCE_SHARE * (work.spent - work.plan.pilot_seconds)


def predicted(work: Work, kind: str) -> float:
    walls = work.walls.get(kind, ())
    return sum(walls) / len(walls) if walls else 0.0


def finish_run(work: Work, choice: Choice, seed: int, counts: list[int]) -> None:
    run = work.renderer.render(choice.settings, seed, counts)
    work.store.save(choice, seed, counts, run)
    note_run(work, choice, seed, run)


def gather(work: Work, choice: Choice) -> Replicates | None:
    """A choice's finished runs; None with fewer than two that the truth has, too."""
    seeds = sorted(seed for seed in work.done.get(choice.key, ()) if seed in work.done.get(TRUTH, ()))
    runs = [work.store.load(choice, seed, counts_of(work.plan, choice)) for seed in seeds]
    if len(runs) < 2 or None in runs:
        return None
    setup = float(np.median([run.setup for run in runs]))
    counts = np.mean([run.counts for run in runs], axis=0)
    return Replicates(choice, seeds, np.stack([run.pictures for run in runs]), counts,
                      np.stack([run.seconds for run in runs]), setup, runs[0].info)


def write_report(work: Work, partial: bool) -> dict:
    """Analyse what is there and write page, pictures and rows. Raises TradeError where there is too little."""
    truth, base = (gather(work, choice) for choice in work.choices[:2])
    pieces = [work.store.load(work.truth, seed, [work.plan.piece]) for seed in work.done.get("reference", ())]
    if not (truth and base and len(pieces) > 1):
        raise TradeError(f"too little was rendered for a report; {work.job.folder / 'runs'} keeps it, "
                         "and the same command goes on (perhaps with more --time)")
    reference = make_reference(np.stack([piece.pictures[-1] for piece in pieces]), work.plan.piece)
    others = filter(None, (gather(work, choice) for choice in work.choices[2:]))  # one in memory at a time
    # Each is compared with the truth and with the user's settings.
    measured = measure(base, others, truth, reference, tests=2 * (len(work.choices) - 1))
    advice, about = advise(measured), make_about(work, base, partial)
    try:
        paths = write_pictures(work.job, measured, reference)
        made = as_object(measured, reference, advice, {**asdict(about), "partial": partial})
        (work.job.folder / "rows.json").write_text(as_json(made), encoding="utf-8")
        (work.job.folder / "rows.csv").write_text(as_csv(made["rows"]), encoding="utf-8")
        (work.job.folder / "index.html").write_text(make_page(about, measured, reference, advice, paths),
                                                    encoding="utf-8")
    except OSError as error:
        raise TradeError(f"{work.job.folder}: the report cannot be written: {error}") from error
    return {**made, "page": str(work.job.folder / "index.html")}


def make_about(work: Work, base: Replicates, partial: bool) -> About:
    job, notes = work.job, list(work.plan.notes)
    if len(base.seeds) < FEWEST_ROUNDS:
        notes.append({"name": "few rounds", "what": f"{len(base.seeds)} seeds only: most intervals are not known"})
    now = datetime.datetime.now().astimezone().strftime("%Y-%m-%d %H:%M")
    return About(job.name, job.full_size, work.plan.size, str(base.info.get("device", "")), work.plan.scene_hash, now,
                 work.spent, job.seconds, len(base.seeds), partial, notes, job.scene.notes)


def write_pictures(job: Job, measured: list[Measured], reference: Reference) -> dict:
    """The pictures' paths, relative to the page, by choice and kind."""
    folder = job.folder / "pictures"
    folder.mkdir(exist_ok=True)
    exposure = drawing.exposure_of(reference.picture)
    written = {}

    def put(key: str, kind: str, pixels: np.ndarray) -> None:
        name = f"{key.replace(':', '_')}.{kind}.{job.pictures}"
        drawing.write_picture(folder / name, pixels)
        written.setdefault(key, {})[kind] = f"pictures/{name}"

    put("reference", "picture", drawing.shown(reference.picture, exposure))
    for one in measured:
        key = one.choice.key
        put(key, "picture", drawing.shown(one.picture, exposure))
        put(key, "noise", drawing.difference(one.picture - reference.picture, reference.picture, NOISE_FULL))
        put(key, "change", drawing.difference(one.change, reference.picture, CHANGE_FULL))
    return written

