"""Tests of this folder may import its other modules."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
