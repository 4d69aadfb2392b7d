"""What the tests of pictures ask of the machine: a Python with a bpy wheel, which contains Cycles."""

import pytest

from bench.cycles_process import find_python
from tests.conftest import missing


@pytest.fixture(autouse=True, scope="session")
def cycles():
    if find_python() is None:
        missing("no Python with a bpy module: set ISOPHOTE_BPY_PYTHONS")
