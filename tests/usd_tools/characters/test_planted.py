"""Laws of contacts that a sparse file stores."""

import numpy as np
import pytest
from pxr import Gf, Usd, UsdGeom
from walk_files import RATE, write_walk
from walker import FEET

from geomstats_anim.contacts import find_contacts
from geomstats_anim.markers import joint_matrices
from usd_tools.characters.placement import placed
from usd_tools.characters.planted import contacts_to_store, found_plants, stored_plants
from usd_tools.skel.clip import read_clip
from usd_tools.skel.find import find_animations
from usd_tools.skel.new_file import ANIMATION, ROOT
from usd_tools.skel.resampling import animation_of
from usd_tools.skel.stored_contacts import PLACES, SPANS
from usd_tools.skel.vertical import up_in_world


def clip_at(path):
    stage = Usd.Stage.Open(str(path))
    return stage, read_clip(find_animations(stage)[0])


def skate_of(path, original):
    """Return how fast the points that are planted in the original slide, at the same times, metres per second."""
    up = np.array([0.0, 1.0, 0.0])
    found = find_contacts(original, up)
    _, clip = clip_at(path)
    places = joint_matrices(placed(clip, animation_of(clip)))[..., 3][:, found.joints]
    return np.linalg.norm(np.diff(places, axis=0), axis=-1)[found.planted].mean() * RATE


@pytest.fixture
def sparse(tmp_path, run):
    original = write_walk(tmp_path / "walk.usda", step=1)
    for name, options in (("plain", ()), ("feet", ("--contacts",))):
        arguments = ("downsample", tmp_path / "walk.usda", "-o", tmp_path / f"{name}.usda", "--scheme", "slerp")
        assert run(*arguments, "--rate", 0.06, "--select", "uniform", *options)[0] == 0
    return tmp_path, original


def test_what_is_stored_is_what_was_found(sparse):
    tmp_path, _ = sparse
    _, dense = clip_at(tmp_path / "walk.usda")
    expected = found_plants(dense, animation_of(dense))
    _, clip = clip_at(tmp_path / "feet.usda")
    plants = stored_plants(clip)
    assert sorted(set(plants.joints)) == sorted(FEET)
    np.testing.assert_array_equal(plants.joints, expected.joints)
    np.testing.assert_allclose(plants.starts, expected.starts, atol=1e-9)
    np.testing.assert_allclose(plants.ends, expected.ends, atol=1e-9)
    np.testing.assert_allclose(plants.start_places, expected.start_places, atol=1e-6)
    _, plain = clip_at(tmp_path / "plain.usda")
    assert stored_plants(plain) is None


def test_feet_stay_where_they_are_between_samples_too(sparse, run):
    tmp_path, original = sparse
    skates = []
    for name, options in (("plain", ()), ("plain", ("--contacts",)), ("feet", ("--contacts",))):
        arguments = ("upsample", tmp_path / f"{name}.usda", "-o", tmp_path / "back.usda", "--times", "source")
        assert run(*arguments, "--scheme", "geodesic-spline", *options)[0] == 0
        skates.append(skate_of(tmp_path / "back.usda", original))
    assert skates[2] < 0.1 * skates[0]
    assert skates[2] < 0.3 * skates[1]


def test_they_are_found_in_units_and_axes_of_any_file(tmp_path, run):
    write_walk(tmp_path / "walk.usda", step=1, up="Z", metres=0.01)
    stage = Usd.Stage.Open(str(tmp_path / "walk.usda"))
    UsdGeom.Xformable(stage.GetPrimAtPath(ROOT)).AddTranslateOp().Set(Gf.Vec3d(100.0, 20.0, 3.0))
    stage.Save()
    _, clip = clip_at(tmp_path / "walk.usda")
    motion = animation_of(clip)
    stored = contacts_to_store(clip, [motion])
    assert {joint.rsplit("/", 1)[-1] for joint in stored.joints} == {"foot_l", "foot_r", "toe_l", "toe_r"}
    plants = found_plants(clip, motion)
    assert (plants.start_places @ up_in_world(clip)).min() == pytest.approx(0.03 + 0.03, abs=1e-3)
    # in centimetres, in the space of the Skeleton, which is 3 lower
    np.testing.assert_allclose(stored.places + [100.0, 20.0, 3.0], 100.0 * plants.start_places, atol=1e-4)


def test_a_file_that_is_made_sparse_anew_forgets_them(sparse, run):
    tmp_path, _ = sparse
    arguments = ("downsample", tmp_path / "feet.usda", "-o", tmp_path / "again.usda", "--scheme", "slerp")
    assert run(*arguments, "--keys", 5, "--select", "uniform")[0] == 0
    assert stored_plants(clip_at(tmp_path / "again.usda")[1]) is None


@pytest.mark.invalid_output("the input is broken on purpose")
def test_broken_contacts_are_refused_in_a_sentence(sparse, run):
    tmp_path, _ = sparse
    stage = Usd.Stage.Open(str(tmp_path / "feet.usda"))
    spans, places = (stage.GetAttributeAtPath(ANIMATION.AppendProperty(name)) for name in (SPANS, PLACES))
    whole, where = spans.Get(), places.Get()
    for attribute, value in (
        (spans, [(9, 0, 5), *whole[1:]]),
        (spans, [(0, 5, 5), *whole[1:]]),
        (spans, [(0, 0, 5000), *whole[1:]]),
        (spans, [(-1, 0, 5), *whole[1:]]),
        (places, where[1:]),
        (places, [(np.nan, 0, 0), *where[1:]]),
    ):
        spans.Set(whole)
        places.Set(where)
        attribute.Set(value)
        stage.Save()
        arguments = ("upsample", tmp_path / "feet.usda", "-o", tmp_path / "back.usda", "--factor", 2, "--contacts")
        code, _, err = run(*arguments)
        assert code == 1
        assert "do not fit together" in " ".join(err.split())
        assert not (tmp_path / "back.usda").exists()
