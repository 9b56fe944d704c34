"""Scores of planted points, beside those of all points."""

from dataclasses import replace

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from walk_files import write_walk

from geomstats_anim import SCHEMES, uniform_keyframes
from geomstats_anim.contacts import find_contacts
from geomstats_anim.markers import joint_matrices
from usd_tools.comparison.options import SchemeChoice
from usd_tools.comparison.trials import Trial, measure
from usd_tools.learning.clips import training_clip
from usd_tools.learning.options import LearnOptions
from usd_tools.learning.train import learn_and_assess
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.new_file import ROOT

UP = np.array([0.0, 0.0, 1.0])


def clip_of(path, edit=lambda stage: None):
    write_walk(path, step=1, up="Z", metres=0.01)
    stage = Usd.Stage.Open(str(path))
    edit(stage)
    return stage, training_clip(path, read_clip(find_animations(stage)[0]))


def row_of(take, scheme="slerp", unseen=False):
    return measure(Trial("walk", 0.1, SchemeChoice.parse(scheme), None, unseen), take, "hyb").row


def test_planted_points_slide_as_an_independent_count_says(tmp_path):
    _, take = clip_of(tmp_path / "walk.usda")
    row = row_of(take)
    (original,) = take.placed
    keys = original.at_frames(uniform_keyframes(original.n_frames, 0.1))
    rebuilt = replace(SCHEMES["slerp"](keys)(original.times), world=original.world)
    found = find_contacts(original, UP)
    way, height, seconds = 0.0, 0.0, 0.0
    new, old = (joint_matrices(each)[..., 3][:, found.joints] for each in (rebuilt, original))
    for gap, point in np.argwhere(found.planted):
        way += np.linalg.norm((new[gap + 1, point] - new[gap, point])[:2])
        height += (
            abs(new[gap, point, 2] - old[gap, point, 2]) + abs(new[gap + 1, point, 2] - old[gap + 1, point, 2])
        ) / 2
        seconds += 1.0
    assert row.skate_cm_per_second == pytest.approx(100.0 * 60.0 * way / seconds, rel=1e-9)
    assert row.floating_cm == pytest.approx(100.0 * height / seconds, rel=1e-9)
    assert row.skate_cm_per_second > 5.0
    assert row_of(take, unseen=True).skate_cm_per_second > 5.0


def test_transforms_that_move_a_character_move_its_feet(tmp_path):
    def slide(stage):
        op = UsdGeom.Xformable(stage.GetPrimAtPath(ROOT)).AddTranslateOp()
        for code in (0.0, 144.0):
            op.Set(Gf.Vec3d(3.0 * code, 0.0, 0.0), code)

    _, take = clip_of(tmp_path / "walk.usda", slide)
    assert row_of(take).skate_cm_per_second is None  # no foot rests in the world
    assert row_of(clip_of(tmp_path / "there.usda")[1]).skate_cm_per_second is not None


@pytest.mark.slow
def test_learning_says_how_planted_points_skate(tmp_path):
    _, take = clip_of(tmp_path / "walk.usda")
    assessed = learn_and_assess([take], LearnOptions(rate=0.1))
    assert list(assessed.skating) == ["learned", "plain", "slerp"]
    assert assessed.skating["slerp"].skate == pytest.approx(row_of(take).skate_cm_per_second, rel=1e-9)
    assert assessed.skating["plain"].skate == pytest.approx(row_of(take, "geodesic-spline:plain").skate_cm_per_second)
