"""What all tests share."""

import os

import pytest

# Tests leave the user's cache alone: each compiles what it runs, or has a cache of its own.
os.environ["ISOPHOTE_KERNEL_CACHE"] = "off"


def missing(what: str) -> None:
    """Skip a test that lacks a part of the machine; fail where CI=true, which wants every test to run."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what}, and CI=true wants every test to run")
    pytest.skip(what)
