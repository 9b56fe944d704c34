"""Real clips open in a session, and what is seen of them is where OpenUSD has it."""

import numpy as np
import pytest
from pxr import Usd, UsdGeom, UsdSkel
from real_files import CLIPS, real_file

from usd_tools.console.errors import ToolError
from usd_tools.editing import EditSession
from usd_tools.editing.edits import EveryNth, exactly
from usd_tools.upsampling.joint_styles import Style

ELEPHANT = "usd/usdwg_ElephantWithMonochord/SoC-ElephantWithMonochord.usdc"
FILES = [*((name, None) for name in CLIPS), ("usd/usdwg_CesiumMan.usdz", None), ("usd/mayausd_HIK_Export.usda", None)]
FILES += [(ELEPHANT, "/SoC_ElephantWithMonochord/Object/Elefant")]
FILES += [("strangers/root_motion_on_skelroot.usda", None), ("strangers/joint_scale_100.usda", None)]


@pytest.mark.parametrize("name, prim", FILES)
def test_the_original_is_where_openusd_has_it(name, prim):
    session = EditSession.open(real_file(name), prim)
    stage = Usd.Stage.Open(str(session.path))
    skeleton = stage.GetPrimAtPath(session.clip.source.rig[0].GetPath())
    query = UsdSkel.Cache().GetSkelQuery(UsdSkel.Skeleton(skeleton))
    place = {str(joint): i for i, joint in enumerate(query.GetJointOrder())}
    frame = len(session.codes) // 2
    time = Usd.TimeCode(session.codes[frame])
    to_world = UsdGeom.XformCache(time).GetLocalToWorldTransform(skeleton)
    placed = np.array([matrix * to_world for matrix in query.ComputeJointSkelTransforms(time)])
    expected = UsdGeom.GetStageMetersPerUnit(stage) * placed[:, 3, :3]
    joints = [i for i, joint in enumerate(session.skeleton.joints) if joint in place]
    ours = session.poses("original", frames=frame)[joints, :, 3]
    rows = [place[session.skeleton.joints[i]] for i in joints]
    np.testing.assert_allclose(ours, expected[rows], atol=1e-5 * max(1.0, np.abs(expected).max()))


@pytest.mark.parametrize("name, prim", FILES)
def test_an_edit_changes_a_joint_and_what_is_below(name, prim):
    session = EditSession.open(real_file(name), prim)
    session.apply(EveryNth(10))
    before, errors = session.poses().copy(), session.errors()
    moving = session.motion("original").rotations
    joint = int(np.ptp(moving, axis=0).sum(axis=-1).argmax())
    session.apply(Style(exactly(session.skeleton.joints[joint]), alpha=5.0, beta=0.3))
    changed = (session.poses() != before).any(axis=(0, 2, 3))
    is_below = [path.startswith(session.skeleton.joints[joint]) for path in session.skeleton.joints]
    assert changed[joint] and not changed[np.logical_not(is_below)].any()
    assert np.isfinite(errors.centimetres).all() and errors.degrees.max() > 0.0
    session.undo()
    np.testing.assert_array_equal(session.poses(), before)


def test_of_two_characters_one_has_to_be_chosen():
    with pytest.raises(ToolError, match="--prim"):
        EditSession.open(real_file(ELEPHANT))
