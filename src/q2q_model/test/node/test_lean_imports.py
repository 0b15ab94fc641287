"""Imports go without the collector and the search for unused modules, and all is as before afterwards."""

import gc
import subprocess
import sys
from importlib import import_module

import pytest

from q2q_model.node.lean_imports import UNUSED, lean_imports


def test_the_collector_rests_while_modules_are_imported_and_works_again_afterwards():
    with lean_imports():
        assert not gc.isenabled()
    assert gc.isenabled()


def test_an_import_that_fails_leaves_the_collector_working_and_coverage_to_be_found():
    with pytest.raises(ImportError), lean_imports():
        import_module("there_is_no_such_module")
    assert gc.isenabled()
    assert all(sys.modules.get(name, sys) is not None for name in UNUSED)


def test_a_collector_that_was_off_stays_off():
    gc.disable()
    try:
        with lean_imports():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


@pytest.mark.parametrize("name", UNUSED)
def test_what_is_unused_is_not_found_during_imports_and_is_afterwards(
    name: str, monkeypatch: pytest.MonkeyPatch
):
    monkeypatch.delitem(sys.modules, name, raising=False)
    with lean_imports(), pytest.raises(ImportError):
        import_module(name)
    assert name not in sys.modules


def test_coverage_that_is_there_already_measures_on(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "coverage", sys)
    with lean_imports():
        assert import_module("coverage") is sys
    assert sys.modules["coverage"] is sys


def test_nodes_come_without_what_they_do_not_use():
    program = f"""
import sys
from q2q_model.node.lean_imports import lean_imports
with lean_imports():
    import numba, rclpy
from std_msgs.msg import String
String.__class__.__import_type_support__()
print(numba.njit(lambda x: 2.0 * x)(3.0), [name for name in {UNUSED} if name in sys.modules])
"""
    output = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert output.stdout == "6.0 []\n"
