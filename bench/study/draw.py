"""The study's figures, and its tables in Markdown, from the rows of measure; the report's own values beside ours."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from bench.study.figure import (
    OURS,
    REPORT,
    SPEED,
    Figure,
    bars,
    curve,
    logarithmic,
    ratio,
    report_points,
    scenes_of,
    select,
    speed_of,
)

# ------------------------------------------------------------------ traversal


def tracing_seconds(row) -> float:
    """Seconds in the kernels that trace, for a million samples."""
    spent = sum(sum(v) for k, v in row["kernel_seconds"].items() if k.startswith(("extend", "connect", "bfs")))
    return spent / samples_of(row)


def samples_of(row) -> float:
    """Millions of samples of the picture."""
    return row["width"] * row["height"] * row["samples_made"] / 1e6


def closest_hits(row):
    """Closest-hit rays of all kinds, billions a second of the kernel's time."""
    spent = [sum(v) for k, v in row["kernel_seconds"].items() if k.startswith("extend_")]
    return 1e-9 * sum(row["alive"]) / sum(spent) if spent and row["alive"] else None


def traversals(rows) -> Figure:
    trees = ["shipping", "stack", "stackless", "wide4", "wide4 nearest", "quantised4", "quantised8"]
    scenes = [s for s in scenes_of(rows) if select(rows, scene=s, label="stack")]
    made = Figure("Traversal: speed of tracing against the shipping BVH2", 2)
    made.head("scene", "triangles", "closest hits, G/s, shipping", "ms tracing / M samples, shipping",
              *[f"{t}: relative speed" for t in trees[1:]])
    relative = {}
    for scene in scenes:
        found = {r["label"]: r for r in select(rows, scene=scene)}
        base = tracing_seconds(found["shipping"])
        relative[scene] = [base / tracing_seconds(found[t]) if t in found else None for t in trees]
        made.line(scene, str(found["shipping"]["triangles"]), closest_hits(found["shipping"]), 1e3 * base,
                  *relative[scene][1:])
    bars(made.axes[0], trees, relative, "shipping = 1", {"stackless": (0.91, 0.95)})
    brute = {r["label"]: r for r in rows if r["scene"] not in scenes and "failed" not in r}
    if {"list", "list_local", "shipping"} <= set(brute):
        base = tracing_seconds(brute["list"])
        bars(made.axes[1], ["list", "list_local", "shipping"],
             {next(iter(brute.values()))["scene"]: [base / tracing_seconds(brute[t]) for t in
                                                    ("list", "list_local", "shipping")]},
             "brute force from global memory = 1", {"list_local": (1.8, 2.0)})
        made.line("brute force", str(brute["list"]["triangles"]), "", f"list {1e3 * base:.3g}",
                  f"list_local {base / tracing_seconds(brute['list_local']):.3g}",
                  f"BVH2 {base / tracing_seconds(brute['shipping']):.3g}", "", "", "")
    return made


def leaves(rows) -> Figure:
    made = Figure("Leaf size: speed against leaves of one triangle")
    made.head("scene, traversal", *[f"{n}" for n in (1, 2, 4, 8, 16, 32)], "as built")
    k = 0
    for scene in scenes_of(rows):
        for label in ("stack", "shipping", "wide4"):
            found = select(rows, scene=scene, label=label)
            if found:
                curve(made.axes[0], found, lambda r, f=found: r[SPEED] / f[0][SPEED], f"{scene}, {label}", k)
                made.line(f"{scene}, {label}", *[r[SPEED] / found[0][SPEED] for r in found],
                          ratio(speed_of(rows, scene=scene, label=f"{label}, builder"), found[0][SPEED]))
                k += 1
    made.axes[0].fill_between([25, 40], 1.5, 1.8, color=REPORT, alpha=0.5, label="report")
    made.axes[0].set_xlabel("triangles in a leaf, at most", fontsize=8)
    logarithmic(made.axes[0])
    return made


def pruning(rows) -> Figure:
    labels = ["stack", "stack pruned", "stack ordered", "stack ordered pruned", "stackless pruned",
              "stackless ordered pruned"]
    made = Figure("Pruning by distance and ordered children: speed against neither", width=7)
    made.head("scene", *labels)
    relative = {}
    for scene in scenes_of(rows):
        base = speed_of(rows, scene=scene, label="stack")
        relative[scene] = [ratio(speed_of(rows, scene=scene, label=name), base) for name in labels]
        made.line(scene, *relative[scene])
    said = {"stack pruned": (1.05, 1.1), "stack ordered pruned": (0.95, 1.04)}
    bars(made.axes[0], labels, relative, "neither = 1", said)
    return made


# ------------------------------------------------------------------ schedule

REORDERING = {"groups": (1.8, 1.8), "scan": (3.0, 3.0), "regeneration": (1.8, 1.8)}


def schedules(rows) -> Figure:
    labels = list(dict.fromkeys(r["label"] for r in rows if not r["x"]))
    made = Figure("Schedule, with the BVH: speed against the pipeline without reordering", width=8)
    made.head("scene", "pipeline, M samples/s", *[label for label in labels if label != "pipeline"])
    relative = {}
    for scene in scenes_of(select(rows, x=0)):
        base = speed_of(rows, scene=scene, label="pipeline", x=0)
        relative[scene] = [ratio(speed_of(rows, scene=scene, label=name, x=0), base) for name in labels]
        made.line(scene, base, *[r for r, name in zip(relative[scene], labels, strict=True) if name != "pipeline"])
    bars(made.axes[0], labels, relative, "pipeline = 1")
    made.table += ["", "Milliseconds of kernels for a million samples:", ""]
    parts = ("extend", "shade", "connect", "sort")
    made.head("scene", "schedule", *parts, "rest")
    profiled = [r for r in select(rows, x=0) if "kernel_seconds" in r]
    for row in (r for r in profiled if r["label"].startswith(("compact", "shipping", "scan"))):
        total = {name: 1e3 * sum(spent) / samples_of(row) for name, spent in row["kernel_seconds"].items()}
        of = [sum(v for n, v in total.items() if n.startswith(part)) for part in parts]
        made.line(row["scene"], row["label"], *of, sum(total.values()) - sum(of))
    made.table += ["", "Breadth first against depth first, same number of paths in flight:", ""]
    made.head("scene", "breadth_first, M samples/s", "compact, M samples/s", "ratio")
    for scene in scenes_of(rows):
        pair = [speed_of(rows, scene=scene, label=name, x=1) for name in ("breadth_first", "compact")]
        if all(pair):
            made.line(scene, *pair, pair[0] / pair[1])
    return made


def schedules_brute(rows) -> Figure:
    labels = list(dict.fromkeys(r["label"] for r in rows))
    base = speed_of(rows, label="pipeline list_local")
    made = Figure("Schedule, brute force: speed against the pipeline without reordering", width=7)
    values = [ratio(speed_of(rows, label=name), base) for name in labels]
    bars(made.axes[0], labels, {scenes_of(rows)[0]: values}, "pipeline, local memory = 1",
         {f"{name} list_local": values for name, values in REORDERING.items()} | {"pipeline list": (1 / 2, 1 / 1.8)})
    made.head("schedule", "M samples/s", "relative", "report")
    said = {"groups list_local": "1.8", "scan list_local": "3",
            "regeneration list_local": "1.8 alone, a loss with the scan",
            "pipeline list": "0.5 to 0.55", "megakernel list": "about as the pipeline"}
    for name, value in zip(labels, values, strict=True):
        made.line(name, speed_of(rows, label=name), value, said.get(name, ""))
    return made


def group_sizes(rows) -> Figure:
    made = Figure("Size of work-groups: speed against 64")
    made.head("what", "32", "64", "128", "256")
    for k, label in enumerate(dict.fromkeys(r["label"] for r in rows)):
        found = select(rows, label=label)
        base = next((r[SPEED] for r in found if r["x"] == 64), None)
        if base:
            curve(made.axes[0], found, lambda r, b=base: r[SPEED] / b, label, k)
            made.line(label, *[r[SPEED] / base for r in found])
    report_points(made.axes[0], [32, 64, 128, 256], [1 / 3, 1, 1, 1])
    made.line("report, brute force", 1 / 3, "1", "1", "1")
    logarithmic(made.axes[0])
    made.axes[0].set_xlabel("work-items", fontsize=8)
    return made


def precision(rows) -> Figure:
    labels = ["strict", "fast", "native"]
    made = Figure("Arithmetic: speed against strict")
    made.head("scene", *labels)
    relative = {}
    for scene in scenes_of(rows):
        base = speed_of(rows, scene=scene, label="strict")
        relative[scene] = [ratio(speed_of(rows, scene=scene, label=name), base) for name in labels]
        made.line(scene, *relative[scene])
    bars(made.axes[0], labels, relative, "strict = 1", {"native": (1.10, 1.12)})
    return made


def chunks(rows) -> Figure:
    made = Figure("Samples in flight: eight a pixel, or as many as the device takes")
    made.head("pixels a side", "eight, M samples/s", "adapted", "ratio")
    for k, label in enumerate(("eight", "adapted")):
        curve(made.axes[0], select(rows, label=label), lambda r: r[SPEED], label, k)
    for r in select(rows, label="eight"):
        other = speed_of(rows, label="adapted", x=r["x"])
        made.line(r["x"], r[SPEED], other, ratio(other, r[SPEED]))
    logarithmic(made.axes[0])
    made.axes[0].set_xlabel("pixels a side", fontsize=8)
    made.axes[0].set_ylabel("M samples/s", fontsize=8)
    return made


# ------------------------------------------------------------------ sweeps


def sweep(rows, title: str, xlabel: str, report_tree=None, report_brute=None) -> Figure:
    """OpenCL over OpenMP, with a tree and without, and the speeds themselves."""
    made = Figure(title, 3, 4.2)
    names = ("opencl", "openmp", "opencl brute", "openmp brute")
    for k, name in enumerate(names):
        curve(made.axes[0], select(rows, label=name), lambda r: r[SPEED], name, k)
    logarithmic(made.axes[0], y=True)
    made.axes[0].set_ylabel("M samples/s", fontsize=8)
    for axes, suffix, report in ((made.axes[1], "", report_tree), (made.axes[2], " brute", report_brute)):
        cpu = {r["x"]: r[SPEED] for r in select(rows, label=f"openmp{suffix}")}
        found = [r for r in select(rows, label=f"opencl{suffix}") if r["x"] in cpu]
        curve(axes, found, lambda r, c=cpu: r[SPEED] / c[r["x"]], "ours", 0)
        if report:
            report_points(axes, *report)
        logarithmic(axes)
        axes.set_ylabel(f"OpenCL / OpenMP,{suffix or ' BVH'}", fontsize=8)
        axes.set_ylim(bottom=0)
    made.head(xlabel, *[f"{name}, M samples/s" for name in names], "ratio, BVH", "ratio, brute")
    for x in sorted({r["x"] for r in rows}):
        speeds = [speed_of(rows, label=name, x=x) for name in names]
        made.line(f"{x:g}", *speeds, ratio(speeds[0], speeds[1]), ratio(speeds[2], speeds[3]))
    for axes in made.axes:
        axes.set_xlabel(xlabel, fontsize=8)
    return made


def depth(rows) -> Figure:
    return sweep(rows, "Depth of paths", "depth", ([1, 16], [2.6, 0.96]), ([1, 16], [64, 57]))


def image_size(rows) -> Figure:
    return sweep(rows, "Image size", "pixels a side")


def samples(rows) -> Figure:
    return sweep(rows, "Samples a pixel", "samples a pixel")


def primitives(rows) -> Figure:
    return sweep(rows, "Number of triangles", "triangles")


def bounces(rows) -> Figure:
    made = Figure("Bounce by bounce", 3, 4.2)
    made.head("scene", "mean length of paths", *[f"alive at {b}" for b in (1, 2, 4, 8)], "extend, ms: bounces 0 to 4")
    for k, row in enumerate(r for r in rows if "failed" not in r):
        alive = np.array(row["alive"][:17]) / row["alive"][0]
        made.axes[0].plot(alive, "o-", ms=3, label=row["scene"], color=OURS[k % len(OURS)])
        kernels = row["kernel_seconds"]
        name = next(n for n in kernels if n.startswith("extend"))
        counts = np.maximum(np.array(row["alive"][:len(kernels[name])]), 1)
        nanoseconds = 1e9 * np.array(kernels[name])[:len(counts)] / counts
        enough = counts > 0.02 * counts[0]  # below, launching is what takes the time
        made.axes[1].plot(nanoseconds[enough] / nanoseconds[0], "o-", ms=3, color=OURS[k % len(OURS)])
        total = {n: sum(v) for n, v in kernels.items()}
        left, whole = 0.0, sum(total.values())
        for part, colour in (("extend", 0), ("connect", 2), ("shade", 1), ("", 5)):
            share = sum(v for n, v in total.items() if n.startswith(part)) / whole if part else 1 - left
            made.axes[2].barh(row["scene"], share, left=left, color=OURS[colour],
                              label=(part or "rest") if k == 0 else None)
            left += share
        times = ", ".join(f"{1e3 * t:.3g}" for t in kernels[name][:5])
        made.line(row["scene"], sum(row["alive"]) / row["alive"][0],
                  *[float(alive[b]) if b < len(alive) else 0.0 for b in (1, 2, 4, 8)], times)
    made.axes[0].plot([4], [0.1], "s", color=REPORT, label="report")
    made.axes[2].set_xlim(0, 1.35)  # room for the legend
    made.axes[1].plot(range(5), np.array([1.9, 12.5, 14.5, 18, 20]) / 1.9, "s--", color=REPORT, ms=4,
                      label="report, time of kernels, BVH")
    labels = ("share of paths alive", "time a ray, bounce 0 = 1", "share of time")
    for axes, label in zip(made.axes, labels, strict=True):
        axes.set_ylabel(label, fontsize=8)
    made.axes[0].set_yscale("log")
    made.line("report (bunny_box)", "", "", "", "0.1", "", "1.9, 12.5, 14.5, 18, 20 (all tracing)")
    return made


def threads(rows) -> Figure:
    made = Figure("OpenMP: threads")
    made.head("threads", "over pixels, M samples/s", "over samples", "speed-up over pixels", "over samples")
    base = {over: speed_of(rows, label=over, x=1) for over in ("pixels", "samples")}
    for k, over in enumerate(base):
        curve(made.axes[0], select(rows, label=over), lambda r, b=base[over]: r[SPEED] / b, f"over {over}", k)
    most = max(r["x"] for r in rows)
    made.axes[0].plot([1, most], [1, most], ":", color="grey", lw=1)
    made.axes[0].plot([16], [10.5], "s", color=REPORT, label="report")
    made.axes[0].set_xlabel("threads", fontsize=8)
    made.axes[0].set_ylabel("speed-up", fontsize=8)
    for x in sorted({r["x"] for r in rows}):
        speeds = [speed_of(rows, label=over, x=x) for over in base]
        made.line(f"{x:g}", *speeds, *[ratio(s, b) for s, b in zip(speeds, base.values(), strict=True)])
    return made


FIGURES = {f.__name__: f for f in (traversals, leaves, pruning, schedules, schedules_brute, group_sizes, precision,
                                   chunks, depth, image_size, samples, primitives, bounces, threads)}


def draw_all(folder: Path, out: Path) -> None:
    """A picture NAME.png for each file NAME.jsonl of rows, and tables.md with the numbers behind them."""
    out.mkdir(parents=True, exist_ok=True)
    text = ["Made by `python -m bench.study draw`.", ""]
    for name, make in FIGURES.items():
        path = folder / f"{name}.jsonl"
        if not path.is_file():
            continue
        rows = [json.loads(line) for line in path.read_text().splitlines()]
        figure = make(rows)
        figure.save(out / f"{name}.png")
        devices = " / ".join(dict.fromkeys(r["name"] for r in rows if "failed" not in r))
        failed = [f"- {r['scene']} {r['label']}: {r['failed']}" for r in rows if "failed" in r]
        text += [f"## {name}", "", devices, "", *figure.table, "", *failed, ""]
    (out / "tables.md").write_text("\n".join(text))
