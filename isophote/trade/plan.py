"""The plan: how many samples, seeds and how long a reference fit the time that the user gives.

Short pilots measure what a sample of each choice costs. Then all choices get the same seeds and numbers of samples:
with the same random numbers two choices differ by what the setting does and by little else, so biases far below the
noise show (paired replicates, common random numbers). A round is one run of each choice with one seed; rounds go
on until the time is over. REFERENCE_SHARE of it goes to the reference, whose seeds nobody else has.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path

from isophote.files import replacing
from isophote.trade.grid import Choice
from isophote.trade.runs import TradeError

REFERENCE_SHARE = 0.25
RESERVE = 0.04  # of the time, for analysis and page
WANTED_ROUNDS, FEWEST_ROUNDS, MOST_ROUNDS = 8, 3, 16
FEWEST_SAMPLES, MOST_SAMPLES = 4, 4096
SNAPSHOTS = 4  # pictures a run, each at four times the samples of the one before
TOO_SLOW = 8.0  # times the seconds of the user's settings: such choices are named and left out
FLOAT64_WORTH = 1.5  # times the seconds of strict: up to there the truth is rendered in float64
FEWEST_ADAPTIVE, ADAPTIVE_ROOM = 128, 16  # samples a run from which it is worth a try; times those it may take
REFERENCE_SEED = 1_000_000  # of the first piece of the reference
LONGEST = 256  # pixels, of the longer side where no size is given


@dataclass(frozen=True)
class Cost:
    """Seconds of a sample a pixel of one choice, and of a run's beginning."""

    sample: float
    setup: float

    def run(self, samples: int) -> float:
        return self.setup + self.sample * samples


@dataclass(frozen=True)
class Plan:
    """What was decided when the report began; continuing keeps to it. `choices` are settings by key, the truth's too.

    `notes` are what was left out and why, dicts {"name", "what"}.
    """

    scene_hash: str
    size: tuple[int, int]
    choices: dict[str, dict]
    counts: list[int]
    piece: int  # samples of a piece of the reference
    pilot_seconds: float
    target: float = 0.0  # the error to which adaptive sampling renders, 0: it is not tried
    notes: list[dict] = field(default_factory=list)


def reduced(size: tuple[int, int], longest: int = LONGEST) -> tuple[int, int]:
    """The size shrunk until its longer side is at most `longest`."""
    scale = min(1.0, longest / max(size))
    return max(1, round(size[0] * scale)), max(1, round(size[1] * scale))


def snapshots(samples: int) -> list[int]:
    """The numbers of samples at which a run's pictures are kept: samples / 64, / 16, / 4 and samples, whole ones."""
    return [samples >> 2 * k for k in reversed(range(SNAPSHOTS)) if samples >> 2 * k >= 1]


def drop_slow(choices: list[Choice], costs: list[Cost]) -> tuple[list[Choice], list[dict]]:
    """The choices that can be afforded (the first, the user's settings, always), and notes on the others."""
    kept, notes = [], []
    for choice, cost in zip(choices, costs, strict=True):
        slower = cost.sample / costs[0].sample
        if slower <= TOO_SLOW:
            kept.append(choice)
        else:
            notes.append({"name": choice.label, "what": f"{slower:.0f} times as slow as your settings: left out"})
    return kept, notes


def choose_samples(costs: list[Cost], seconds: float) -> int:
    """Samples a run so that WANTED_ROUNDS of all fit into the seconds beside the reference; a power of two.

    Where not even FEWEST_ROUNDS of FEWEST_SAMPLES fit, raises TradeError with the time that would do.
    """
    def needed(samples: int, rounds: int) -> float:
        return rounds * sum(cost.run(samples) for cost in costs) / (1.0 - REFERENCE_SHARE)

    if needed(FEWEST_SAMPLES, FEWEST_ROUNDS) > seconds:
        least = needed(FEWEST_SAMPLES, FEWEST_ROUNDS) / (1.0 - RESERVE)
        raise TradeError(f"the time is too short: {least:.0f} s more than the pilots would do for this size; "
                         "give more --time or a smaller --size")
    samples = FEWEST_SAMPLES
    while samples < MOST_SAMPLES and needed(2 * samples, WANTED_ROUNDS) <= seconds:
        samples *= 2
    return samples


def save_plan(plan: Plan, path: Path) -> None:
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(asdict(plan), indent=1))


def load_plan(path: Path) -> Plan | None:
    """The plan of a report that was begun, None where there is none. Raises TradeError for a file that is no plan."""
    try:
        text = path.read_text()
    except FileNotFoundError:
        return None
    except OSError as error:
        raise TradeError(f"{path}: {error.strerror}") from error
    try:
        read = Plan(**json.loads(text))
        return Plan(**{**vars(read), "size": tuple(read.size)})
    except (TypeError, ValueError) as error:
        raise TradeError(f"{path}: no plan of a trade report ({error}); --anew begins again") from None


def check_same(plan: Plan, scene_hash: str, size: tuple[int, int], choices: dict[str, dict]) -> None:
    """Raise TradeError naming what is not as when the report began."""
    changed = []
    if tuple(plan.size) != tuple(size):
        changed.append("the size was {}x{}, now {}x{}".format(*plan.size, *size))
    elif plan.scene_hash != scene_hash:
        changed.append("the scene was another")
    for key in (key for key in choices if key in plan.choices):
        before, now = plan.choices[key], json.loads(json.dumps(choices[key]))
        changed += [f"{name} was {before.get(name)}, now {now[name]} ({key})" for name in now
                    if before.get(name) != now[name]]
    if changed:
        more = f" and {len(changed) - 3} more" if len(changed) > 3 else ""
        raise TradeError(f"the report there is of something else: {'; '.join(changed[:3])}{more}; "
                         "--anew begins again, another folder keeps both")
