"""Imports go without the collector and numba's search for coverage, and all is as before afterwards."""

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
    assert sys.modules.get(UNUSED, sys) is not None


def test_a_collector_that_was_off_stays_off():
    gc.disable()
    try:
        with lean_imports():
            pass
        assert not gc.isenabled()
    finally:
        gc.enable()


def test_coverage_is_not_found_during_imports_and_is_afterwards(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delitem(sys.modules, UNUSED, raising=False)
    with lean_imports(), pytest.raises(ImportError):
        import_module(UNUSED)
    assert UNUSED not in sys.modules


def test_coverage_that_is_there_already_measures_on(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, UNUSED, sys)
    with lean_imports():
        assert import_module(UNUSED) is sys
    assert sys.modules[UNUSED] is sys


def test_numba_comes_without_coverage():
    program = (
        "import sys\nfrom q2q_model.node.lean_imports import lean_imports\n"
        "with lean_imports():\n    import numba\nprint('coverage' in sys.modules, numba.njit.__name__)"
    )
    told = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert told.stdout.split() == ["False", "njit"]
