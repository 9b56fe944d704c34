"""Blender, in a process of its own: it brings a USD library that must not meet ours."""

import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

TESTS = Path(__file__).resolve().parents[1]
PYTHONS = [os.environ.get("BLENDER_PYTHON"), TESTS.parent / ".venv-blender" / "bin" / "python", sys.executable]
"""Pythons that may have bpy: it wants an older NumPy than the project has, so that a second environment is best."""


@cache
def python_with_blender():
    """The first of the Pythons that can import bpy, or None."""
    for python in PYTHONS:
        if python and Path(python).exists() and not _call(python, "-c", "import bpy").returncode:
            return python
    return None


def _call(*command):
    return subprocess.run([*map(str, command)], capture_output=True, text=True, check=False)


def call_blender(script, *arguments, wrapper=()):
    """Run a script in a Python that has bpy, and return how it ended. Skip where there is none.

    The wrapper is a command that runs another, such as xvfb-run.
    """
    python = python_with_blender()
    if python is None:
        pytest.skip("Blender is not there: pip install -e '.[blender]', or name a Python with bpy in BLENDER_PYTHON")
    return _call(*wrapper, python, script, *arguments)


def blender(script, source, out, *arguments):
    """Run a script of tests/blender; return the path that it wrote, or the arrays in it. Skip where there is no bpy."""
    done = call_blender(TESTS / "blender" / script, source, out, *arguments)
    assert done.returncode == 0 and out.exists(), done.stdout + done.stderr
    return dict(np.load(out)) if out.suffix == ".npz" else out
