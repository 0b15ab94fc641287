"""A waypoint file; tests of this folder may import its other modules."""

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parent))


@pytest.fixture
def crossing(tmp_path: Path) -> Path:
    """Return a waypoint file of the paper's section 4.1."""
    from section_4_1 import WRITTEN

    path = tmp_path / "crossing.yaml"
    path.write_text(WRITTEN)
    return path
