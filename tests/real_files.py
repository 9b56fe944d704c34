"""Find the real files: two clips beside the tests, the others beside the repository, if they are there."""

from pathlib import Path

import pytest

SHARED = Path(__file__).resolve().parents[2] / "shared" / "data"
SHIPPED = Path(__file__).resolve().parent / "data"
CLIPS = tuple(f"clips/{name}.usda" for name in ("jumping", "pitching", "punching", "rolling", "sitting"))

needs_shared = pytest.mark.skipif(not SHARED.is_dir(), reason=f"the real files are not there: {SHARED}")


def real_file(name):
    """Return the path of a real file, or skip the test: the shipped copy where there is one, the shared file else."""
    shipped = SHIPPED / Path(name).with_suffix(".usdc").name
    if name in CLIPS and shipped.is_file():
        return shipped
    if not SHARED.is_dir():
        pytest.skip(f"the real files are not there: {SHARED}")
    return SHARED / name
