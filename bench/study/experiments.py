"""The founding report's experiments, and its next steps, as groups of cases; a group is timed side by side."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from bench.study.measure import Case
from bench.study.variant import TRAVERSALS, Variant

BEST = Variant()
BRUTE = Variant("list_local", schedule="compact", group=256)  # as the report's final version, with our queues


@dataclass(frozen=True)
class Scale:
    """How large pictures are: a GPU wants some millions of paths, PoCL on two cores does not."""

    size: int
    brute_size: int
    sizes: tuple[int, ...]
    samples: tuple[int, ...]
    triangles: tuple[int, ...]
    pool: int  # paths of path regeneration
    scenes: tuple[str, ...]
    brute: str  # the scene without a tree
    threads: tuple[int, ...]
    triangles_scene: str = "room:1000000"


def gpu_scale(threads: tuple[int, ...]) -> Scale:
    return Scale(512, 256, (64, 128, 256, 512, 1024), (8, 32, 128, 512),
                 (32, 128, 512, 2048, 8192, 32768, 131072, 524288, 2097152), 1 << 20,
                 ("cornell_box", "torus_box", "monkey_box"), "room:1000", threads)


def cpu_scale(threads: tuple[int, ...]) -> Scale:
    return Scale(64, 32, (32, 64, 128), (8, 16, 32), (32, 128, 512, 2048, 8192, 32768), 1 << 12,
                 ("cornell_box", "torus_box"), "room:200", threads, "room:30000")


Experiment = Callable[[Scale], list[list[Case]]]


def traversals(s: Scale):
    """Which tree, and how a ray goes down it; brute force where it can end."""
    trees = [name for name in TRAVERSALS if not name.startswith("list")]
    variants = {name: Variant(name, "compact") for name in trees}
    variants["wide4 nearest"] = Variant("wide4", "compact", ordered=False)
    groups = [[Case(name, scene, variant=v, size=s.size, profile=True) for name, v in variants.items()]
              for scene in (s.triangles_scene, *reversed(s.scenes), "instances")]
    brute = [Case(name, s.brute, variant=replace(BRUTE, traversal=name), size=s.brute_size, profile=True)
             for name in ("shipping", "list", "list_local")]
    return [brute, *groups]


def schedules(s: Scale):
    """Megakernel, pipeline, reordering, regeneration, queues, sorting, breadth first; with the shipping tree."""
    variants = [Variant(schedule=name) for name in ("megakernel", "pipeline", "groups", "scan", "compact", "shipping")]
    variants += [Variant(schedule="regeneration", paths=s.pool)]
    variants += [Variant(schedule="compact", sort=sort, group=256) for sort in ("material", "ray")]
    made = [[Case(f"{v.schedule} {v.sort}".strip(), scene, variant=v, size=s.size, samples=64, profile=True)
             for v in variants] for scene in (s.triangles_scene, *s.scenes)]
    few = min(s.pool, 1 << 18)
    beside = [Case(name, scene, variant=Variant(schedule=name, paths=few), size=s.brute_size, samples=16, x=1)
              for scene in s.scenes[-1:] for name in ("breadth_first", "compact")]
    return [beside, *made]


def schedules_brute(s: Scale):
    """The same without a tree, as in most of the report."""
    variants = [Variant("list", schedule="megakernel", group=256), Variant("list", schedule="pipeline", group=256)]
    variants += [Variant("list_local", schedule=name, group=256) for name in ("pipeline", "groups", "scan", "compact")]
    variants += [Variant("list_local", schedule="regeneration", group=256, paths=s.pool // 16)]
    return [[Case(f"{v.schedule} {v.traversal}", s.brute, variant=v, size=s.brute_size, samples=16) for v in variants]]


def leaves(s: Scale):
    """Leaves of 1 to 32 triangles, and those that the builder made."""
    def cases(scene, name):
        made = [Case(name, scene, variant=Variant(name, leaf=n), size=s.size, x=n) for n in (1, 2, 4, 8, 16, 32)]
        return [*made, Case(f"{name}, builder", scene, variant=Variant(name), size=s.size)]

    return [cases(scene, name) for scene in s.scenes[1:] for name in ("stack", "shipping", "wide4")]


def pruning(s: Scale):
    """Skipping what lies behind a hit, and the nearer child first."""
    def labelled(v):
        return f"{v.traversal}{' ordered' if v.ordered else ''}{' pruned' if v.pruned else ''}"

    made = [Variant("stack", ordered=o, pruned=p) for o in (False, True) for p in (False, True)]
    made += [Variant("stackless", ordered=o) for o in (False, True)]
    return [[Case(labelled(v), scene, variant=v, size=s.size) for v in made] for scene in s.scenes]


def group_sizes(s: Scale):
    """Work-groups of 32 to 256."""
    sizes = (32, 64, 128, 256)
    return [[Case("shipping", s.scenes[-1], variant=Variant(group=g), size=s.size, x=g) for g in sizes],
            [Case("scan", s.scenes[-1], variant=Variant(schedule="scan", group=g), size=s.size, x=g) for g in sizes],
            [Case("list_local scan", s.brute, variant=Variant("list_local", schedule="scan", group=g),
                  size=s.brute_size, x=g) for g in sizes]]


def precision(s: Scale):
    """Strict arithmetic, contraction, and the driver's relaxed mathematics."""
    return [[Case(p, scene, variant=Variant(precision=p), size=s.size) for p in ("strict", "fast", "native")]
            for scene in s.scenes]


def chunks(s: Scale):
    """Eight samples a pixel in flight, as in the report, against as many paths as the device has use for."""
    return [[Case("eight", s.scenes[1], variant=Variant(paths=8 * n * n), size=n, samples=64, x=n),
             Case("adapted", s.scenes[1], size=n, samples=64, x=n)] for n in s.sizes]


def both(s: Scale, brute: bool = True, **changes) -> list[Case]:
    """OpenCL and OpenMP on all cores, with a tree and without."""
    made = [Case("opencl", s.scenes[1], size=s.size), Case("openmp", s.scenes[1], "openmp", size=s.size)]
    if brute:
        made += [Case("opencl brute", s.brute, variant=BRUTE, size=s.brute_size),
                 Case("openmp brute", s.brute, "openmp", Variant("list"), size=s.brute_size)]
    return [replace(case, **changes) for case in made]


def depth(s: Scale):
    """1 to 16 bounces; the report's depth 1 is direct light only."""
    return [both(s, bounces=n - 1, x=n) for n in (1, 2, 4, 8, 16)]


def image_size(s: Scale):
    """Pictures of several sizes, 64 samples a pixel."""
    return [[replace(case, size=n, samples=0 if "openmp" in case.label else 64, x=n) for case in both(s, False)] +
            [replace(case, size=n, x=n) for case in both(s)[2:] if n <= s.sizes[-2]] for n in s.sizes]


def samples(s: Scale):
    """More and more samples a pixel, on small pictures."""
    return [[replace(case, size=s.size // 4, samples=n, x=n) for case in both(s, False)] for n in s.samples]


def primitives(s: Scale):
    """Rooms of more and more triangles; brute force up to a few thousand."""
    def cases(n):
        made = both(s, brute=n <= 10000)
        return [replace(case, scene=f"room:{n}", x=n) for case in made]

    return [cases(n) for n in s.triangles]


def bounces(s: Scale):
    """Paths alive, and the time of each kernel, bounce by bounce."""
    common = dict(samples=8, bounces=16, profile=True)
    made = [[Case("compact", scene, variant=Variant(schedule="compact"), size=s.size, **common)]
            for scene in (*s.scenes, s.triangles_scene)]
    return [*made, [Case("brute", s.brute, variant=BRUTE, size=s.brute_size, **common)]]


def threads(s: Scale):
    """OpenMP from one thread to all: over pixels, shared out dynamically, and over samples, shared out in advance."""
    size = 3 * s.size // 16
    return [[Case(over, scene, "openmp", size=size, samples=64 * n, threads=n, over=over, x=n)
             for over in ("pixels", "samples")] for scene in s.scenes[1:2] for n in s.threads]


EXPERIMENTS: dict[str, Experiment] = {e.__name__: e for e in (
    traversals, schedules, schedules_brute, leaves, pruning, group_sizes, precision, chunks, depth, image_size, samples,
    primitives, bounces, threads)}
