"""Every loop over paths runs 8 (AVX2) or 16 (AVX-512) paths at once, by the compiler's own word."""

import hashlib
import os
import re
import shutil
import subprocess
from collections import Counter
from pathlib import Path

import pytest

from isophote.values import operations
from tests.conftest import missing

ROOT = Path(__file__).parents[2]
NATIVE = ROOT / "native"
OLDEST = 16  # clang 14 gives up on these loops
WIDTHS = {3: 8, 4: 16}
COMPILERS = ("clang++-19", "clang++-18", "clang++-17", "clang++-16", "clang++")


def clang() -> str:
    for name in filter(None, (os.environ.get("CXX"), *COMPILERS)):
        if shutil.which(name):
            said = subprocess.run([name, "--version"], capture_output=True, text=True).stdout
            version = re.search(r"clang version (\d+)", said)
            if version and int(version.group(1)) >= OLDEST:
                return name
    return missing(f"no clang++ {OLDEST} or newer")


def flags_of(level: int) -> list[str]:
    """Those of cmake/variants.cmake that decide what may be vectorised."""
    text = (ROOT / "cmake" / "variants.cmake").read_text()
    strict = re.search(r"set\(strict_flags ([^)]*)\)", text).group(1).split()
    wide = re.findall(r'if\(level STREQUAL "4"\)\s*target_compile_options\(\$\{target\} PRIVATE (\S+)\)', text)
    assert len(wide) == 1
    widest = wide if level == 4 else []
    return ["-std=gnu++20", "-O3", "-fPIC", "-fopenmp", f"-march=x86-64-v{level}", *strict, *widest]


def remarks(level: int) -> str:
    """What clang says about the loops; kept until a source or the compiler changes, as this takes half a minute."""
    compiler = clang()
    sources = sorted([*(ROOT / "kernels").rglob("*.h"), *NATIVE.glob("*.h"), NATIVE / "openmp_loops.cpp"])
    command = [compiler, *flags_of(level), f"-DISOPHOTE_VARIANT=strict_v{level}", f"-I{ROOT / 'kernels'}",
               f"-I{NATIVE}", "-Rpass=loop-vectorize", "-c", str(NATIVE / "openmp_loops.cpp"), "-o", os.devnull]
    version = subprocess.run([compiler, "--version"], capture_output=True).stdout
    key = hashlib.sha256(repr(command).encode() + version + b"".join(path.read_bytes() for path in sources)).hexdigest()
    kept = ROOT / "build" / "test_kernels" / f"vectorised_{key[:16]}.txt"
    if not kept.exists():
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode and "omp.h" in done.stderr:
            missing(f"{compiler} has no OpenMP")
        assert done.returncode == 0, done.stderr[-3000:]
        kept.parent.mkdir(parents=True, exist_ok=True)
        kept.write_text(done.stderr)
    return kept.read_text()


def listed(name: str) -> int:
    """How many loops a list gives for each that is marked: its entries, of kernels/bsdf/bsdf.h twice, for parameters
    that are constant and for those that vary."""
    return len(operations()) if name == "VALUES" else 2 * entries(name)


def entries(name: str) -> int:
    """Entries of one of the lists in kernels/bsdf/bsdf.h."""
    text = (ROOT / "kernels" / "bsdf" / "bsdf.h").read_text()
    body = re.search(rf"#define {name}\(X\)((?:.*\\\n)*.*)", text).group(1)
    return len(re.findall(r"\bX\(", body))


def marked_loops() -> dict[tuple[str, int], int]:
    """(file, line) -> how many loops start there; those inside a macro start where it is expanded."""
    found: dict[tuple[str, int], int] = Counter()
    files = ("shade_loops.h", "light_loops.h", "value_loops.h", "walk_loops.h", "openmp_loops.cpp")
    for path in (NATIVE / name for name in files):
        lines, macro, inside = path.read_text().splitlines(), None, Counter()
        for number, line in enumerate(lines, 1):
            if defined := re.match(r"\s*#define (\w+)\(", line):
                macro = defined.group(1)
            if re.search(r"\bFOR_PATHS\(|#pragma omp simd", line):
                if macro:
                    inside[macro] += 1
                else:
                    found[path.name, number] += 1
            if expanded := re.match(r"(CLOSURES|LAYERS|VALUES)\((\w+)\)", line):
                found[path.name, number] += inside[expanded.group(2)] * listed(expanded.group(1))
            if macro and not line.endswith("\\"):
                macro = None
    return found


def test_there_are_loops():
    loops = marked_loops()
    assert entries("CLOSURES") >= 8 and entries("LAYERS") >= 1 and listed("VALUES") >= 60
    assert sum(loops.values()) >= 3 * listed("CLOSURES") + listed("LAYERS") + listed("VALUES") + 10
    assert "FOR_PATHS" not in (NATIVE / "batch.h").read_text().replace("#define FOR_PATHS", "")


@pytest.mark.slow
@pytest.mark.parametrize("level", WIDTHS)
def test_loops_are_vectorised(level):
    """Each marked loop, in each of its copies, with the full width."""
    vectorised = Counter()
    pattern = r"(\w+\.(?:h|cpp)):(\d+):\d+: remark: vectorized loop \(vectorization width: (\d+)"
    for name, line, width in re.findall(pattern, remarks(level)):
        if int(width) >= WIDTHS[level]:
            vectorised[name, int(line)] += 1
    # A pragma's loop is on the next line.
    slow = {place: (vectorised[place] + vectorised[place[0], place[1] + 1], wanted)
            for place, wanted in marked_loops().items()
            if vectorised[place] + vectorised[place[0], place[1] + 1] < wanted}
    assert not slow, f"(file, line): (vectorised, wanted) {slow}"
