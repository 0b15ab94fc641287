"""Let the tests of this folder import the flights and signals that they make."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
