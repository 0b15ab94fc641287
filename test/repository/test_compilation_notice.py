"""A process that compiles says so before it does, and one that loads what it kept says nothing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("q2q_msgs", reason="the workspace is not built")

from q2q_sim.processes.domain import own_domain

NODE = """
from q2q_model.compiled import compiled
from q2q_model.ros.node.run import run

def half(x):
    return 0.5 * x

def third(x):
    return x / 3.0

def build(node):
    raise ValueError(f"no parameter {compiled(half)(3.0) + compiled(third)(3.0)}")

run("stack", build)
"""
REFUSED = "stack: no parameter 2.5"


def lines_of_a_start(script: Path) -> list[str]:
    """Return what a node prints that keeps its machine code next to its script."""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(script.parent / "numba")}
    command = [sys.executable, str(script)]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    return done.stderr.splitlines()


def test_a_node_says_once_and_before_it_is_built_that_it_compiles(tmp_path: Path) -> None:
    script = tmp_path / "node.py"
    script.write_text(NODE)
    with own_domain():
        notice, *others = lines_of_a_start(script)
        first = "compiling code for its first run on this machine: half a minute for a flight"
        assert notice.startswith(f"stack: {first}")
        assert others == [REFUSED]
        assert lines_of_a_start(script) == [REFUSED]
