"""The walls of the design: what may be named where."""

import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
TEXT = {".py", ".h", ".cpp", ".cl", ".md", ".toml", ".txt", ".sh", ".cmake", ".in", ".lock", ""}
LONGEST = 500
# What runs inside Blender; tests may name everything.
BPY_FOLDERS = ("addon/", "tests/", "bench/", "blend_scenes/")


def sources() -> dict[str, str]:
    """Text files of the project by path: those that git knows or would not ignore."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, text=True)
    names = listed.stdout.split("\n") if listed.returncode == 0 else []
    found = {}
    for name in filter(None, names):
        path = ROOT / name
        if path.suffix in TEXT and path.is_file() and not path.is_symlink():
            found[name] = path.read_text(encoding="utf-8", errors="replace")
    return found


@pytest.fixture(scope="module")
def files():
    found = sources()
    if not found:  # an unpacked archive without git
        skipped = {"build", "dist", ".venv", ".venv-bpy50", ".git"}
        found = {str(p.relative_to(ROOT)): p.read_text(encoding="utf-8", errors="replace") for p in ROOT.rglob("*")
                 if p.is_file() and p.suffix in TEXT and not skipped & set(p.relative_to(ROOT).parts)}
    assert len(found) > 100
    return found


def matching(files, pattern, folders=("",), suffixes=(".py", ".h", ".cpp", ".cl")):
    expression = re.compile(pattern, re.M)
    return {name for name, text in files.items()
            if name.startswith(tuple(folders)) and name.endswith(suffixes) and expression.search(text)}


def imports(module):
    return rf"^\s*(import|from)\s+{module}\b|import_module\(\s*[\"']{module}[\"']"


def test_bpy_stays_where_blender_is(files):
    using = matching(files, imports("(bpy|bmesh|mathutils|bl_ui|gpu|nodeitems_utils)"))
    assert using and {name for name in using if not name.startswith(BPY_FOLDERS)} == set()


def test_pyopencl_stays_in_the_device(files):
    using = matching(files, imports("pyopencl"))
    assert {name for name in using if not name.startswith(("tests/", "bench/"))} == {"isophote/opencl.py"}


def test_the_binding_library_stays_in_the_binding(files):
    library = "nano[b]ind"  # so that who looks for the name does not find this pattern
    using = matching(files, rf"#\s*include\s*[<\"]{library}|namespace nb\b|\b{library}::", suffixes=(".h", ".cpp"))
    assert using == {"native/bind.cpp"}


def test_only_portable_h_asks_which_compiler_reads_it(files):
    asks = r"__OPENCL_(?:C_)?VERSION__|__cplusplus"
    kernels = matching(files, asks, ("kernels/", "native/", "isophote/"))
    assert kernels == {"kernels/portable.h"}


def test_kernels_use_no_library_function_whose_bits_differ(files):
    """Own elementary functions: a plain call of the C library's would give other bits on each device.

    portable.h names two of them for tests of boxes, which may err.
    """
    names = "sin|cos|tan|exp|exp2|log|log2|pow|acos|asin|atan|atan2|fmin|fmax|rsqrt"
    calls = rf"(?<![\w.])({names}|native_\w+|half_\w+)\s*\("
    for name, text in files.items():
        if name.startswith("kernels/") and name != "kernels/portable.h":
            code = re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S)
            assert not re.search(calls, code), (name, re.search(calls, code).group())


def test_kernels_hold_no_float64(files):
    """Every literal is REAL(...), or has an f: a bare 0.5 would turn strict's arithmetic into double."""
    for name, text in files.items():
        if not name.startswith("kernels/"):
            continue
        code = re.sub(r"/\*.*?\*/|//[^\n]*", " ", text, flags=re.S)
        assert not re.search(r"\b(double|long|bool|size_t)\b", code.replace("typedef double real;", "").replace(
            "(double)", "")), name
        in_double = re.sub(r"#if(def)? (REAL_IS_DOUBLE|ISOPHOTE_REFERENCE).*?#(else|endif)", " ", code, flags=re.S)
        literals = re.findall(r"REAL\([^)]*\)|(?<![\w.])(\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)(?!\w|\.)", in_double)
        assert not list(filter(None, literals)), (name, literals)


def test_the_build_asks_for_strict_floats(files):
    text = files["cmake/variants.cmake"]
    for flag in ("-ffp-contract=off", "-Wdouble-promotion", "-Werror", "-Werror=pass-failed"):
        assert flag in text
    assert "-ffast-math" not in text and "-Ofast" not in text


def test_no_file_is_too_long(files):
    long = {name: text.count("\n") for name, text in files.items()
            if text.count("\n") > LONGEST and not name.endswith((".lock", "LICENSE"))}
    assert long == {}


def test_no_paths_of_a_machine(files):
    """/tmp and /usr may be meant; homes and this project's own workplace may not."""
    found = {name: match.group() for name, text in files.items()
             if (match := re.search(r"/(home|Users|root|work)/\w[\w./-]*|[A-Z]:\\\\Users", text)) and name != OWN}
    assert found == {}


OWN = str(Path(__file__).relative_to(ROOT))


def test_settings_and_passes_stand_once(files):
    """Lists that must not be kept twice: the scene's arrays, the parameters, the planes."""
    homes = {r"#define SCENE_BUFFERS\(X\)": "kernels/scene_buffers.h", r"#define PARAMS\(X\)": "kernels/params.h",
             r"#define PATH_REALS\(X\)": "kernels/path.h", r"#define CLOSURES\(X\)": "kernels/bsdf/bsdf.h",
             r"^PASSES\b": "isophote/passes.py", r"^OPERATIONS\b": "isophote/materials.py"}
    for pattern, home in homes.items():
        assert matching(files, pattern, ("kernels/", "native/", "isophote/", "addon/")) == {home}
