"""What an experiment varies about the OpenCL device: a value, given in code."""

from __future__ import annotations

from dataclasses import dataclass

from isophote.wavefront import GROUP

# TRAVERSAL number and macros of kernels/study/variants.cl; "shipping" is kernels/bvh.h as it is rendered with.
TRAVERSALS = {
    "shipping": (0, {}),
    "list": (1, {}),  # brute force, every work-item for itself
    "list_local": (1, {}),  # brute force through local memory
    "stack": (2, {}),
    "stackless": (3, {}),
    "wide4": (4, {"QUANTISED": 0}),
    "quantised4": (4, {"QUANTISED": 1}),
    "quantised8": (5, {}),
}
SCHEDULES = ("shipping", "megakernel", "pipeline", "groups", "scan", "compact", "regeneration", "breadth_first")
PRECISIONS = ("strict", "fast", "native")  # native: the compiler's relaxed mathematics on top of fast


@dataclass(frozen=True)
class Variant:
    """One way to trace and schedule paths. Every one but another precision gives the shipping device's bits.

    `leaf` joins subtrees of up to so many triangles into leaves (0: as the builder left them); `ordered` and
    `pruned` are of the study's own traversals (four wide, without order only the nearest child is known to be it);
    `sort` ("material", "ray") wants the schedule "compact".
    """

    traversal: str = "shipping"
    schedule: str = "shipping"
    sort: str = ""
    group: int = 0  # work-items of a work-group; 0: 64, or what the shipping schedule takes
    paths: int = 0  # in flight; 0: as many as the shipping device
    leaf: int = 0
    ordered: bool = True
    pruned: bool = True
    stack: int = 96  # entries; a tree that needs more is refused
    precision: str = "strict"

    def __post_init__(self):
        for value, known in ((self.traversal, TRAVERSALS), (self.schedule, SCHEDULES), (self.precision, PRECISIONS),
                             (self.sort, ("", "material", "ray"))):
            if value not in known:
                raise ValueError(f"{value!r}: one of {', '.join(known)}")
        if self.sort and self.schedule != "compact":
            raise ValueError("sorting wants the schedule compact")
        if self.traversal == "list_local" and self.schedule in ("shipping", "megakernel", "breadth_first"):
            raise ValueError("list_local traces in work-groups: it wants a schedule with places")
        if self.schedule == "breadth_first" and self.traversal in ("wide4", "quantised4", "quantised8", "list"):
            raise ValueError("breadth_first walks the BVH2")
        can = {"ordered": ("stack", "stackless", "wide4", "quantised4"), "pruned": ("stack", "stackless")}
        for name, traversals in can.items():
            if not getattr(self, name) and self.traversal not in traversals:
                raise ValueError(f"{self.traversal} is always {name}: only {', '.join(traversals)} can do without")
        if self.group not in (0, 32, 64, 128, 256):
            raise ValueError(f"group {self.group}: 32, 64, 128 or 256")

    def macros(self, triangles: int) -> dict[str, int]:
        """What the kernels are compiled with, for a scene of so many triangles (kernels/study/variants.cl)."""
        number, more = TRAVERSALS[self.traversal]
        made = {"TRAVERSAL": number, "GROUP_SIZE": self.group or GROUP, "STUDY_STACK": self.stack,
                "ORDERED": int(self.ordered), "PRUNED": int(self.pruned),
                "MEGAKERNEL": int(self.schedule == "megakernel"),
                "PLACES": int(self.schedule not in ("shipping", "megakernel")), "SORT": int(bool(self.sort)),
                "BREADTH_FIRST": int(self.schedule == "breadth_first"), **more}
        return made | ({"TRIANGLE_COUNT": triangles} if self.traversal.startswith("list") else {})
