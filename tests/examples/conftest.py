"""The generator is a folder of scripts, not a package: put it where its modules find each other."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2] / "examples"))
