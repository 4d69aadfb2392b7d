"""A trade report from scene to page: pilots, rounds until the time is over, analysis, files.

The folder holds index.html, pictures/, rows.csv, rows.json, and runs/ with the plan and a file for each finished run.
A report that was interrupted takes what is there and goes on with the plan; what was spent counts.
"""

from __future__ import annotations

import datetime
import random
import shutil
from collections.abc import Callable
from dataclasses import asdict, dataclass, field

import numpy as np

from isophote.trade import pictures as drawing
from isophote.trade.advice import advise
from isophote.trade.analysis import Measured, Reference, Replicates, make_reference, measure
from isophote.trade.grid import ADAPTIVE, TRUTH, Choice, adaptive_choice, make_grid, plain_settings
from isophote.trade.job import Job, Status
from isophote.trade.page import CHANGE_FULL, NOISE_FULL, About, make_page
from isophote.trade.pilots import make_plan, truth_choice
from isophote.trade.plan import (
    ADAPTIVE_ROOM,
    FEWEST_ROUNDS,
    MOST_ROUNDS,
    REFERENCE_SEED,
    REFERENCE_SHARE,
    RESERVE,
    Plan,
    check_same,
    load_plan,
    save_plan,
)
from isophote.trade.rows import as_csv, as_json, as_object
from isophote.trade.runs import Cancelled, Renderer, Run, Store, TradeError


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


def render_rounds(work: Work, show: Callable[[Status], None]) -> None:
    """Runs, and between them pieces of the reference, until the time or the rounds are over. Raises Cancelled."""
    limit = (1.0 - RESERVE) * work.job.seconds
    for seed in range(1, work.job.most_rounds + 1):
        for choice in shuffled(work.choices, seed):
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


def shuffled(choices: list[Choice], seed: int) -> list[Choice]:
    """The order of a round: another for each, so that who is whose neighbour has no say in the times."""
    return random.Random(seed).sample(choices, len(choices))


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
    measured = measure(base, others, truth, reference, tests=len(work.choices) - 1)
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

