"""Closures with their constants, and quadratures over directions that the closures' tests share."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from tests.kernel_lib import instruction


@dataclass(frozen=True)
class Case:
    closure: str
    params: dict = field(default_factory=dict)
    backfacing: int = 0

    @property
    def instruction(self):
        return instruction(self.closure, **self.params)

    @property
    def ior(self) -> float:
        """Index of refraction behind the side that is hit over that in front of it."""
        ior = self.params.get("ior", 1.0)
        return 1 / ior if self.backfacing else ior

    def __str__(self):
        values = ",".join(f"{k}={v:g}" for k, v in self.params.items())
        return f"{self.closure}({values}{',back' if self.backfacing else ''})"


EVERYWHERE = ("diffuse", "translucent", "rough_diffuse", "sheen", "velvet")
METAL = dict(f0_r=0.9, f0_g=0.6, f0_b=0.3, f82_r=0.8, f82_g=0.9, f82_b=1.0)
LEAF = dict(tint_r=0.9, tint_g=1.0, tint_b=0.8, transmission_r=0.9, transmission_g=0.5, transmission_b=0.2)


def reflections(roughness: float, multiscatter: float = 1) -> list[Case]:
    common = dict(roughness=roughness, multiscatter=multiscatter)
    return [Case("glossy", common), Case("metal", common | METAL), Case("conductor", common | SILVER),
            Case("specular", common | dict(ior=1.5, tint_r=0.5))]


def refractions(roughness: float, multiscatter: float = 1, iors=(1.45,)) -> list[Case]:
    cases = []
    for ior in iors:
        for back in (0, 1):
            cases += [Case("refraction", dict(roughness=roughness, ior=ior), back),
                      Case("glass", dict(roughness=roughness, ior=ior, multiscatter=multiscatter), back),
                      Case("principled_glass", dict(roughness=roughness, ior=ior, multiscatter=multiscatter) | LEAF,
                           back),
                      Case("film_glass", dict(roughness=roughness, ior=ior, multiscatter=multiscatter, thickness=300,
                                              film_ior=1.3) | LEAF, back)]
    return cases


def beckmann_glasses(roughness: float, iors=(1.45,)) -> list[Case]:
    return [Case("beckmann_glass", dict(roughness=roughness, ior=ior, reflects=reflects), back)
            for ior in iors for back in (0, 1) for reflects in (0, 1)]


def diffuses() -> list[Case]:
    """Closures that scatter to everywhere, and keep all light where they are white."""
    white = dict(albedo_r=1.0, albedo_g=1.0, albedo_b=1.0)
    rough = [Case("rough_diffuse", dict(roughness=roughness) | white) for roughness in (0, 0.3, 1)]
    return [Case("diffuse"), Case("translucent"), *rough]


def fabrics(roughness: float) -> list[Case]:
    return [Case("sheen", dict(roughness=roughness)), Case("velvet", dict(sigma=roughness))]


TOONS = [Case(name, dict(size=size, smooth=smooth)) for name in ("diffuse_toon", "glossy_toon")
         for size, smooth in ((0.5, 0.05), (0.2, 0.0), (0.0, 1.0), (0.9, 0.8))]
SILVER = dict(n_r=0.15, n_g=0.12, n_b=0.14, k_r=4.8, k_g=3.5, k_b=2.4)


def anisotropic(rough_x: float, rough_y: float, multiscatter: float = 1) -> list[Case]:
    """Closures of a roughness along x and one along y."""
    ends = dict(roughness_x=rough_x, roughness_y=rough_y)
    common = ends | dict(multiscatter=multiscatter)
    return [Case("aniso_glossy", common), Case("aniso_metal", common | METAL), Case("aniso_conductor", common | SILVER),
            Case("aniso_specular", common | dict(ior=1.5, tint_r=0.5)), Case("beckmann", ends),
            Case("film_specular", common | dict(ior=1.5, tint_r=0.5, thickness=400, film_ior=1.8)),
            Case("ashikhmin_shirley", ends)]


def direction(mu: float, azimuth: float = 0.7) -> np.ndarray:
    sine = np.sqrt(1 - mu * mu)
    return np.array([sine * np.cos(azimuth), sine * np.sin(azimuth), mu])


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def random_directions(rng, n: int, lower: bool = False) -> np.ndarray:
    """Unit vectors of the upper hemisphere (of the whole sphere with lower=True), many of them grazing."""
    z = rng.random(n) ** rng.choice([1, 4], n)
    if lower:
        z = z * rng.choice([-1, 1], n)
    phi = rng.uniform(0, 2 * np.pi, n)
    sine = np.sqrt(1 - z * z)
    return np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=1)


def lobe_width(case: Case, mu: float, transmits: bool) -> float:
    """Angle over which a lobe falls off, radians; grazing refraction stretches it."""
    if case.closure in EVERYWHERE:
        return 1.0
    if case.closure.endswith("toon"):
        return np.tan(0.25 * np.pi * min(case.params["size"] + case.params["smooth"], 1))  # the edge is a ring's
    ends = [case.params[name] for name in case.params if name.startswith("roughness")]
    alpha = float(np.prod(ends)) ** (2 / len(ends))
    return max(alpha * (min(abs(1 - 1 / case.ior) / mu, 1) if transmits else 1), 1e-5)


def lobe_axis(case: Case, wo: np.ndarray, transmits: bool) -> np.ndarray:
    """Where a smooth surface sends wo, the horizon at total internal reflection; the normal where wo does not count."""
    if case.closure in EVERYWHERE or case.closure == "diffuse_toon":
        return np.array((0.0, 0.0, -1.0 if transmits else 1.0))
    if not transmits:
        return wo * [-1, -1, 1]
    tangent = -wo[:2] / case.ior
    return unit(np.array([*tangent, -np.sqrt(max(1 - tangent @ tangent, 1e-4))]))


class LobeGrid:
    """Cells of polar coordinates around an axis, the polar angle stretched to a lobe's width.

    The angle is 2 atan(width x/(1 - x)), x uniform over [0, 1]; midpoints of `inner` x `inner`
    sub-cells with their solid angles integrate over each cell.
    """

    def __init__(self, axis: np.ndarray, width: float, rings: int = 20, sectors: int = 16, inner: int = 32):
        self.rings, self.sectors, self.width = rings, sectors, width
        helper = np.eye(3)[np.argmin(np.abs(axis))]
        x = unit(np.cross(axis, helper))
        self.frame = np.stack([x, np.cross(axis, x), axis])
        ring = (np.arange(rings * inner) + 0.5) / (rings * inner)
        sector = (np.arange(sectors * inner) + 0.5) / (sectors * inner)
        ring, sector = (a.ravel() for a in np.meshgrid(ring, sector, indexing="ij"))
        t = width * ring / (1 - ring)  # tangent of half the angle
        sine, cosine = 2 * t / (1 + t * t), (1 - t * t) / (1 + t * t)
        phi = 2 * np.pi * sector
        self.points = np.stack([sine * np.cos(phi), sine * np.sin(phi), cosine], axis=1) @ self.frame
        slope = 2 / (1 + t * t) * width / (1 - ring) ** 2  # d angle / d ring
        self.solid_angles = sine * slope * (2 * np.pi) / (rings * sectors * inner**2)
        self.cells = (ring * rings).astype(int) * sectors + (sector * sectors).astype(int)

    def integrate(self, values: np.ndarray) -> np.ndarray:
        """Integral over each cell of a density given at `points`."""
        return np.bincount(self.cells, values * self.solid_angles, self.rings * self.sectors)

    def count(self, directions: np.ndarray) -> np.ndarray:
        x, y, z = self.frame @ directions.T
        t = np.hypot(x, y) / np.maximum(1 + z, 1e-30)
        ring = np.minimum(t / (t + self.width) * self.rings, self.rings - 1).astype(int)
        sector = (np.arctan2(y, x) / (2 * np.pi) % 1 * self.sectors).astype(int) % self.sectors
        return np.bincount(ring * self.sectors + sector, minlength=self.rings * self.sectors)


def lobe_grids(case: Case, mu: float, inner: int = 32) -> list[tuple[bool, LobeGrid]]:
    """(transmits, grid around that lobe) for both sides of the surface."""
    return [(side, LobeGrid(lobe_axis(case, direction(mu), side), lobe_width(case, mu, side), inner=inner))
            for side in (False, True)]


def integrate_pdf(kernels, case: Case, mu: float, inner: int = 32):
    """[(transmits, grid, probability of each of its cells)] at wo.z = mu."""
    results = []
    for transmits, grid in lobe_grids(case, mu, inner):
        wo = np.broadcast_to(direction(mu), grid.points.shape)
        _, pdf = kernels.eval(case.instruction, wo, grid.points, case.backfacing)
        side = (grid.points[:, 2] < 0) == transmits
        results.append((transmits, grid, grid.integrate(np.where(side, pdf.astype(np.float64), 0))))
    return results


def integrated_albedo(kernels, case: Case, mu: float, inner: int = 48) -> float:
    """Red of the albedo at wo.z = mu, by quadrature over directions instead of sampling."""
    total = 0.0
    for transmits, grid in lobe_grids(case, mu, inner):
        f, _ = kernels.eval(case.instruction, np.broadcast_to(direction(mu), grid.points.shape), grid.points,
                            case.backfacing)
        total += grid.integrate(np.where((grid.points[:, 2] < 0) == transmits, f[:, 0], 0)).sum()
    return total


def sampled_albedo(kernels, case: Case, mu: float, steps: int = 160) -> np.ndarray:
    """Albedo (RGB) at wo.z = mu: f/pdf averaged over a lattice of random numbers."""
    i = np.arange(steps * steps)
    u = np.stack([(i * 0.6180339887498949) % 1, (i % steps + 0.5) / steps, (i // steps + 0.5) / steps], axis=1)
    wo = np.tile(direction(mu), (len(u), 1))
    wi, f, flags = kernels.sample(case.instruction, wo, u, case.backfacing)
    delta, _, valid = flags.T
    value, pdf = kernels.eval(case.instruction, wo, wi, case.backfacing)
    rough = np.divide(value, pdf[:, None], out=np.zeros_like(value), where=pdf[:, None] > 0)
    return np.mean(np.where(delta[:, None] == 1, f, rough) * (valid[:, None] == 1), axis=0, dtype=np.float64)
