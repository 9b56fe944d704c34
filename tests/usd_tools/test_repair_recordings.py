"""What `repair` finds in recordings that are damaged, as the benchmark measures it, and what it leaves alone."""

import tempfile
from pathlib import Path

import bench_repair
import numpy as np
import pytest
from real_files import SHARED, needs_shared

from usd_tools.repair import RepairOptions, repair


@needs_shared
@pytest.mark.slow
def test_damaged_recordings(tmp_path):
    sources = [path for path in bench_repair.clips(tmp_path)][::4]
    scores = [bench_repair.score(path, Path(tempfile.mkdtemp(dir=tmp_path)), seed) for seed, path in enumerate(sources)]
    scores = [each for each in scores if each is not None]
    made, found = (sum(sum(getattr(each, name).values()) for each in scores) for name in ("made", "found"))
    reported, wrong = sum(each.reported for each in scores), sum(each.wrong for each in scores)
    assert made > 300 and found >= 0.95 * made and wrong <= 0.05 * reported
    spikes = [sum(getattr(each, name)["spike"] for each in scores) for name in ("made", "found")]
    assert spikes[1] >= 0.95 * spikes[0]
    assert max(each.off_spline for each in scores) < 3e-7  # single precision
    errors, slerped = (np.concatenate([getattr(each, name) for each in scores]) for name in ("errors", "slerped"))
    assert errors.mean() < slerped.mean()


@pytest.mark.slow
def test_example_clips_that_are_damaged(tmp_path, monkeypatch):
    monkeypatch.setattr(bench_repair, "LIBRARY", tmp_path / "nowhere")
    sources = list(bench_repair.clips(tmp_path))[:1]
    (score,) = (bench_repair.score(path, Path(tempfile.mkdtemp(dir=tmp_path)), 2) for path in sources)
    assert sum(score.found.values()) >= 0.95 * sum(score.made.values()) > 0 == score.wrong
    assert score.off_spline < 3e-7


@needs_shared
@pytest.mark.slow
def test_recordings_are_hardly_touched():
    """Fast motion, hand-keyed clips and holds of 112 walks, dashes and bows, and of a fight."""
    clips = [*sorted((SHARED / "library" / "bandai").glob("*.usdc"))[::3], SHARED / "usd" / "mayausd_HIK_Export.usda"]
    faults = [fault for path in clips for fault in repair(path, None, RepairOptions(dry_run=True)).faults]
    assert len([fault for fault in faults if fault["kind"] != "sign flip"]) <= 1
