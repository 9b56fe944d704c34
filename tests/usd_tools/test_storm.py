"""Storm, the renderer of usdview, shows the poses that upsampling has computed: their silhouettes are compared."""

import shutil
from dataclasses import replace

import numpy as np
import pytest
from blender import TESTS, call_blender
from matplotlib.image import imread
from PIL import Image, ImageDraw
from pxr import Gf, Usd, UsdGeom
from real_files import SHARED

from geomstats_anim import MetricParameters, interpolate
from geomstats_anim.markers import joint_matrices
from usd_tools.characters.body import bounds, skin
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.resampling import animation_of

CESIUM = SHARED / "usd" / "needle_CesiumMan.glb.openusd.usdz"
WIDTH, FINE, MARGIN = 480, 5, 1.3
"""Pixels, parts of a pixel, and the window by the character's size."""

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not CESIUM.exists(), reason=f"the real files are not there: {CESIUM}"),
    pytest.mark.skipif(shutil.which("xvfb-run") is None, reason="there is no xvfb-run: apt-get install xvfb"),
]


def only_clip(path):
    (source,) = find_animations(Usd.Stage.Open(str(path)))
    return read_clip(source)


def silhouette(body, animation, window):
    """The pixels that a body covers in the first frame of an animation, seen along -z, shape=[WIDTH, WIDTH]."""
    corner, size = window
    fine = FINE * WIDTH
    image = Image.new("L", (fine, fine))
    draw = ImageDraw.Draw(image)
    for part, points in zip(body.parts, body.points(joint_matrices(animation)[0]), strict=True):
        pixels = (points[:, :2] - corner) / size * fine - 0.5
        pixels[:, 1] = fine - 1.0 - pixels[:, 1]
        for triangle in pixels[part.faces]:
            draw.polygon([tuple(each) for each in triangle], fill=255)
    return np.array(image)[FINE // 2 :: FINE, FINE // 2 :: FINE] > 127


def looking_along_z(path, scene, window, depth):
    """Write a stage with a camera that sees a square window of a scene, metres, without perspective."""
    stage = Usd.Stage.CreateNew(str(path))
    stage.GetRootLayer().subLayerPaths.append(str(scene))
    source = Usd.Stage.Open(str(scene))
    stage.SetTimeCodesPerSecond(source.GetTimeCodesPerSecond())
    UsdGeom.SetStageUpAxis(stage, UsdGeom.GetStageUpAxis(source))
    metres = UsdGeom.GetStageMetersPerUnit(source)
    UsdGeom.SetStageMetersPerUnit(stage, metres)
    corner, size = window
    camera = UsdGeom.Camera.Define(stage, "/camera")
    place = np.append(corner + 0.5 * size, depth) / metres
    camera.AddTranslateOp().Set(Gf.Vec3d(*place.tolist()))
    camera.CreateProjectionAttr("orthographic")
    for aperture in (camera.CreateHorizontalApertureAttr, camera.CreateVerticalApertureAttr):
        aperture(float(10.0 * size / metres))  # in tenths of a unit
    camera.CreateClippingRangeAttr(Gf.Vec2f(1e-3, float(10.0 * depth / metres)))
    stage.Save()


def overlap(one, other):
    """Share of the pixels of both that both have."""
    return (one & other).sum() / (one | other).sum()


def test_an_in_between_is_rendered_in_its_pose(tmp_path, run):
    assert run("downsample", CESIUM, "-o", tmp_path / "sparse.usda", "--keys", 6, "--select", "uniform")[0] == 0
    bent = ["--factor", 8, "--metric", "identity", "--alpha", 4, "--beta", 0.3]
    assert run("upsample", tmp_path / "sparse.usda", "-o", tmp_path / "up.usda", *bent)[0] == 0
    sparse, dense = only_clip(tmp_path / "sparse.usda"), only_clip(tmp_path / "up.usda")
    keys, body = animation_of(sparse), skin(sparse)
    assert body.n_points > 1000
    code = dense.codes[12]
    assert np.abs(keys.times * sparse.codes_per_second - code).min() > 0.1
    n = keys.n_joints

    def pose(scheme, metric=None):
        shown = interpolate(keys, [code / sparse.codes_per_second], scheme, metric)
        return replace(shown, world=sparse.placements(np.array([code])))

    expected = pose("geodesic-spline", MetricParameters(np.full(n, 4.0), np.full(n, 0.3)))
    low, high = bounds(body, expected)
    size = MARGIN * (high - low).max()
    window = (0.5 * (low + high)[:2] - 0.5 * size, size)
    looking_along_z(tmp_path / "seen.usda", tmp_path / "up.usda", window, 10.0 * size)
    out = tmp_path / "frame.png"
    command = [TESTS / "blender" / "render_storm.py", tmp_path / "seen.usda", "/camera", code, WIDTH, out]
    call_blender(*command, wrapper=("xvfb-run", "-a"))
    rendered = imread(out)[..., 3] > 0.5
    assert rendered.shape == (WIDTH, WIDTH)
    assert overlap(rendered, silhouette(body, expected, window)) > 0.985
    assert overlap(rendered, silhouette(body, pose("slerp"), window)) < 0.8
