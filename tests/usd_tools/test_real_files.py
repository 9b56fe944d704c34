"""Every real file goes through inspect and upsample, with the result that is written down here."""

import contextlib
import io
from functools import cache

import numpy as np
import pytest
from pxr import Usd, UsdSkel, UsdUtils, UsdValidation
from rigs import DATA, bits, read

from geomstats_anim import rotations as quat
from usd_tools.resampling import animation_of
from usd_tools.skel_reader import find_animations, read_clip

pytestmark = pytest.mark.skipif(not DATA.is_dir(), reason=f"the real files are not there: {DATA}")

# Samples before and after doubling, for each animation; or how the refusal ends.
NOTHING = "has no skeletal animation."
ANIMATED = {
    "clips/jumping.usda": [(164, 327)],
    "clips/pitching.usda": [(160, 319)],
    "clips/punching.usda": [(36, 71)],
    "clips/rolling.usda": [(195, 389)],
    "clips/sitting.usda": [(35, 69)],
    "usd/bresilla_skel_test_simple.usda": [(3, 5)],
    "usd/mayausd_HIK_Export.usda": [(101, 201)],
    "usd/mayausd_framerate.usda": [(2, 3), (2, 3), (2, 3)],
    "usd/mayausd_skelCube.usda": [(30, 59)],
    "usd/mayausd_skinCluster.usda": [(101, 201)],
    "usd/needle_CesiumMan.glb.openusd.usdz": [(48, 95)],
    "usd/openusd_bake_blendshapes.usda": [(131, 261)],
    "usd/openusd_bake_blendshapesWithNormals.usda": [(9, 17)],
    "usd/openusd_bake_dqs.usda": [(30, 59)],
    "usd/openusd_bake_lbs.usda": [(30, 59)],
    "usd/openusd_imaging_arm.usda": [(2, 3)],
    "usd/openusd_imaging_blendshapes.usda": [(3, 5)],
    "usd/openusd_imaging_dqs.usda": [(5, 9)],
    "usd/openusd_imaging_lbs.usda": [(5, 9)],
    "usd/openusd_imaging_skeleton.usda": [(3, 5)],
    "usd/openusd_root.usda": [(30, 59)],
    "usd/openusd_skinnedArm.usda": [(2, 3)],
    "usd/openusd_usdview_arm.usda": [(2, 3)],
    "usd/openusddotnet_parity-skinned-pennant.usda": [(2, 3)],
    "usd/tinyusdz_blendshape-and-animation-test-001.usda": [(250, 499)],
    "usd/tinyusdz_usdskel-001.usda": [(2, 3)],
    "usd/tinyusdz_usdskel-001.usdc": [(2, 3)],
    "usd/usdwg_CesiumMan.usdz": [(48, 95)],
    "usd/usdwg_ElephantWithMonochord/SoC-ElephantWithMonochord.usdc": [(3023, 6045), (3023, 6045)],
    "usd/usdwg_ElephantWithMonochord/SoC-ElephantWithMonochord_thumbnail.usda": [(3023, 6045), (3023, 6045)],
    "usd/usdwg_RiggedFigure.usdz": [(2, 3)],
    "usd/usdwg_RiggedSimple.usdz": [(50, 99)],
    "usd/usdzstudio_skel.usda": [(2, 3)],
    "usd/usdzstudio_skel.usdz": [(2, 3)],
}
REFUSED = {
    "usd/bresilla_skel.usda": "/World/Rig/Anim has 0.",
    "usd/mayausd_materialAssignment.usda": "/SkelAnimation1 has 0.",
    "usd/mayausd_morpher_box.usd": "/root/Bones/Animations has 0.",  # weights whose number changes
    "usd/mayausd_skelCubeDq.usda": "/Root/Animation has 0.",
    "usd/mayausd_skelStaticTimeSampledMesh.usda": "/group1/joint1/Animation has 0.",
    "usd/openusd_cache_populate.usda": "/AnimBinding/Instance/Anim has 0.",
    "usd/openusd_imaging_twoBends.usda": "/Root/joint1/Animation has 0.",
    "usd/openusd_jointInfluences.usda": "/Anim2 has 0.",
    "usd/openusddotnet_native-usdskel-authored.usda": "/World/Character/Animation has 1.",
    "usd/tinyusdz_FAIL_usdskel-002.usda": NOTHING,
    "usd/tinyusdz_blendshape.usda": "/root/Cube/Skel/Anim has 0.",
    "usd/tinyusdz_simple-blendshape-test-001.usda": NOTHING,
    "usd/tinyusdz_skeleton-purpose-001.usda": NOTHING,
}
CHANNELS = ("rotations", "translations", "scales", "blendShapeWeights")
CLIPS = [name for name in ANIMATED if name.startswith("clips/")] + ["usd/mayausd_HIK_Export.usda"]


def test_no_file_is_forgotten():
    found = {str(path.relative_to(DATA)) for folder in ("clips", "usd") for path in (DATA / folder).rglob("*.usd*")}
    assert found == {*ANIMATED, *REFUSED}


@cache
def validator():
    return UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators())


def errors_of(path):
    """Names of the errors of a file; places differ between a source and its override."""
    stage = Usd.Stage.Open(str(path))
    with contextlib.redirect_stderr(io.StringIO()):
        return {
            (error.GetName(), str(error.GetValidator().GetMetadata().name))
            for error in validator().Validate(stage)
            if error.GetType() == UsdValidation.ValidationErrorType.Error
        }


@pytest.mark.parametrize("name", [*ANIMATED, *REFUSED])
def test_inspect(name, run, inspected):
    told = inspected(DATA / name)
    counts = [animation.get("samples") for animation in told["animations"]]
    assert [count for count in counts if count] == [before for before, _ in ANIMATED.get(name, [])]
    code, out, _ = run("inspect", DATA / name)
    assert (code, "…" in out) == (0, False)


@pytest.mark.parametrize("name", REFUSED)
def test_refused(tmp_path, name, run):
    code, _, err = run("upsample", DATA / name, "-o", tmp_path / "out.usda", "--factor", 2)
    assert code == 1
    assert err.splitlines()[-1].startswith("error: ") and err.rstrip().endswith(REFUSED[name])
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("name", ANIMATED)
def test_upsample(tmp_path, name, run):
    source, out = DATA / name, tmp_path / "out.usdc"
    code, text, err = run("upsample", source, "-o", out, "--factor", 2, "--alpha", 4, "--beta", 0.5)
    assert (code, err) == (0, "")
    counts = [f"{before} -> {after} samples" for before, after in ANIMATED[name]]
    assert [count in line for count, line in zip(counts, text.splitlines()[:-1], strict=True)] == [True] * len(counts)
    stage = Usd.Stage.Open(str(source))
    for animation in find_animations(stage):
        for channel in CHANNELS:
            codes, values = read(source, channel, animation.path)
            new_codes, new_values = read(out, channel, animation.path)
            place = {c: i for i, c in enumerate(new_codes)}
            assert bits([new_values[place[c]] for c in codes]) == bits(values)
            if channel == "rotations" and codes:
                norms = np.linalg.norm(np.array(new_values)[1::2].astype(np.float64), axis=-1)
                np.testing.assert_allclose(norms, 1.0, atol=1e-6)
    assert errors_of(out) <= errors_of(source)


@pytest.mark.parametrize("name", CLIPS)
def test_slerp_is_what_usd_shows(tmp_path, name, run):
    out = tmp_path / "out.usda"
    run("upsample", DATA / name, "-o", out, "--factor", 3, "--scheme", "slerp")
    stage, new = Usd.Stage.Open(str(DATA / name)), Usd.Stage.Open(str(out))
    (source,) = find_animations(stage)
    queries = []
    for each in (stage, new):
        skeleton = UsdSkel.Skeleton.Get(each, source.skeletons[0].GetPath())
        queries.append(UsdSkel.Cache().GetSkelQuery(skeleton).GetAnimQuery())
    for code in queries[1].GetJointTransformTimeSamples():
        shown, written = (query.ComputeJointLocalTransformComponents(Usd.TimeCode(code)) for query in queries)
        rotations = [quat.normalize(np.array(each[1], dtype=np.float64)) for each in (shown, written)]
        assert quat.distance(*rotations).max() < 2e-6
        np.testing.assert_allclose(np.array(shown[0]), np.array(written[0]), rtol=1e-5, atol=1e-5)


@pytest.mark.parametrize("name", ["usd/usdwg_CesiumMan.usdz", "usd/usdwg_RiggedFigure.usdz", "clips/sitting.usda"])
@pytest.mark.parametrize("flat", [[], ["--flatten"]])
def test_usdz(tmp_path, name, flat, run):
    out = tmp_path / "out.usdz"
    code, _, err = run("upsample", DATA / name, "-o", out, "--factor", 2, *flat)
    assert (code, err) == (0, "")
    assert errors_of(out) <= errors_of(DATA / name)
    assert UsdUtils.ComputeAllDependencies(str(out))[2] == []


@pytest.mark.parametrize("name", CLIPS)
def test_animation_of_a_clip(name):
    stage = Usd.Stage.Open(str(DATA / name))
    (source,) = find_animations(stage)
    clip = read_clip(source)
    animation = animation_of(clip)
    codes, values = read(DATA / name, prim=source.path)
    np.testing.assert_allclose(animation.times, np.array(codes) / stage.GetTimeCodesPerSecond(), rtol=1e-15)
    given = quat.normalize(np.array(values, dtype=np.float64))
    assert quat.distance(animation.rotations[:, clip.columns], given).max() < 1e-15
    bones = np.linalg.norm(clip.skeleton.rest_translations[1:], axis=-1)
    assert 0.02 < np.median(bones) < 0.5  # metres, whatever the file's units
