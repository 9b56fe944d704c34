"""Bytes against largest error: within the tolerance by every method, on the page, and in results.json."""

import json
from pathlib import Path

import numpy as np
import pytest
from rigs import make_rig, random_rotations
from scipy.spatial.transform import Rotation

from geomstats_anim import Animation, Skeleton
from geomstats_anim.codec import pack
from usd_tools.comparison.acl import ACL, SOURCE
from usd_tools.comparison.distortion import METHODS, rate_distortion

CLIP = Path(__file__).parents[2] / "data" / "sitting.usdc"
N = 40
TOLERANCES = (0.2, 1.0, 5.0)


@pytest.fixture(scope="module")
def stretches():
    skeleton = Skeleton(
        ["a", "a/b", "a/b/c"], [-1, 0, 1], np.tile([0.0, 0.3, 0.0], (3, 1)), np.tile([0.0, 0.0, 0.0, 1.0], (3, 1))
    )
    phases = np.random.default_rng(0).uniform(0.0, 6.0, (3, 3))
    turns = 0.6 * np.sin(np.arange(N)[:, None, None] / 12.0 + phases)
    rotations = Rotation.from_rotvec(turns.reshape(-1, 3)).as_quat().reshape(N, 3, 4)
    translations = np.tile(skeleton.rest_translations, (N, 1, 1))
    translations[:, 0, 0] += np.arange(N) / 50.0
    whole = Animation(skeleton, np.arange(N) / 30.0, rotations, translations)
    return [whole.at_frames(slice(0, 15)), whole.at_frames(slice(15, N))]


@pytest.mark.parametrize("method", METHODS)
def test_every_method_keeps_the_tolerance_with_fewer_bytes_for_more_error(stretches, method):
    points = [rate_distortion("clip", method, stretches, tolerance) for tolerance in TOLERANCES]
    assert all(point.largest_cm <= point.tolerance_cm for point in points)
    assert all(0.0 <= point.mean_cm <= point.largest_cm for point in points)
    sizes = [point.bytes for point in points]
    assert sizes == sorted(sizes, reverse=True) and sizes[0] > sizes[-1] > 0
    assert all(point.share == pytest.approx(point.bytes / points[0].bytes * points[0].share) for point in points)


def test_packed_bytes_are_those_of_the_streams(stretches):
    point = rate_distortion("clip", "pack", stretches, 1.0)
    assert point.bytes == sum(len(pack(each, 0.01)) for each in stretches)


def test_compare_tells_bytes_in_tables_figures_and_results(tmp_path, run):
    make_rig(tmp_path / "in.usda", codes=range(30), rotations=random_rotations(30, 3))
    words = ["--rates", 0.3, "--schemes", "slerp", "--tolerances", 1, 3]
    code, text, err = run("compare", tmp_path / "in.usda", "-o", tmp_path / "out", *words)
    assert (code, err) == (0, "")
    told = json.loads((tmp_path / "out" / "results.json").read_text())
    assert told["settings"]["tolerances"] == [1.0, 3.0]
    points = {(point["method"], point["tolerance_cm"]): point["bytes"] for point in told["rate_distortion"]}
    assert set(points) == {(method, tolerance) for method in METHODS for tolerance in (1.0, 3.0)}
    page = (tmp_path / "out" / "index.html").read_text()
    for (method, _), size in points.items():
        assert method in text and str(size) in text
        assert f"<td>{size}</td>" in page
    assert "nanoseconds" in text and "nanoseconds" in page
    assert (tmp_path / "out" / "figures" / "bytes.png").stat().st_size > 10_000


@pytest.mark.slow
def test_compare_tells_the_bytes_of_acl_beside_its_source(tmp_path, run):
    words = ["--rates", 0.3, "--schemes", "slerp", "--tolerances", 1, 2]
    code, text, _ = run("compare", CLIP, "-o", tmp_path / "out", *words)
    assert code == 0
    told = json.loads((tmp_path / "out" / "results.json").read_text())["rate_distortion"]
    (known,) = [point for point in told if point["method"] == ACL]
    assert (known["bytes"], known["tolerance_cm"], known["largest_cm"]) == (2221, 1.0, None)
    page = (tmp_path / "out" / "index.html").read_text()
    for shown in (" ".join(text.split()), page):
        assert ACL in shown and "2221" in shown and SOURCE in shown and "nanoseconds" in shown
