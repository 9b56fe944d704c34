"""`learn_metric`: the contract, both purposes, and what it refuses."""

import dataclasses
import inspect
import json
import re

import numpy as np
import pytest
from real_files import CLIPS, needs_shared
from wanderings import N_JOINTS, metric, noise, of_vectors, real, tree, wandering

from geomstats_anim import (
    Animation,
    LearnedMetric,
    MetricParameters,
    interpolate,
    learn_metric,
    quality,
    uniform_keyframes,
)
from geomstats_anim.learning.assessment import score

KEYS = uniform_keyframes(41, 0.2)


def test_the_contract():
    names = "animation keyframes search purpose family invariance scheme kind seed".split()
    found = list(inspect.signature(learn_metric).parameters.values())
    assert [one.name for one in found[: len(names)]] == names
    defaults = ["gradient", "reconstruct", "diagonal", "joint", "geodesic-spline", "hyb", 0]
    assert [one.default for one in found[2 : len(names)]] == defaults
    assert all(one.kind is one.KEYWORD_ONLY for one in found[len(names) :])


@pytest.mark.parametrize("kind", ["loc", "rot", "hyb"])
@pytest.mark.parametrize("weights", [None, "depth"])
def test_the_scores_are_the_quality_of_what_is_rebuilt(kind, weights):
    truth = wandering()
    found = learn_metric(truth, KEYS, scheme="geodesic", kind=kind, weights=weights, location_weight=0.3)
    assert (found.joints, found.scheme, found.quality) == (truth.skeleton.joints, "geodesic", kind)
    for name, metric_used in (("score", found), ("slerp_score", None)):
        rebuilt = interpolate(truth.at_frames(KEYS), truth.times, "geodesic", metric_used)
        expected = quality(rebuilt, truth, kind, weights, 0.3)
        assert found.provenance[name] == pytest.approx(expected, rel=1e-9)
    assert found.provenance["score"] < found.provenance["slerp_score"]


@pytest.mark.parametrize("purpose", ["reconstruct", "predict"])
def test_provenance_and_the_same_bytes_twice(purpose):
    one, other = (learn_metric(wandering(), KEYS, purpose=purpose, kind="rot", seed=3) for _ in range(2))
    assert one.to_json() == other.to_json()
    provenance = json.loads(json.dumps(one.provenance))
    assert provenance == one.provenance
    expected = {"search": "gradient", "purpose": purpose, "family": "diagonal", "invariance": "joint", "seed": 3}
    assert {name: provenance[name] for name in expected} == expected
    assert (provenance["frames"], provenance["keys"]) == ([41], [len(KEYS)])
    assert {"version", "evaluations"} <= set(provenance)
    assert LearnedMetric.from_json(one.to_json()).to_json() == one.to_json()
    assert ("shrinkage" in provenance) == (purpose == "predict")


def test_one_clip_alone_and_in_a_list():
    alone, listed = learn_metric(wandering(), KEYS, kind="rot"), learn_metric([wandering()], [KEYS], kind="rot")
    assert alone.to_json() == listed.to_json()


def test_several_clips():
    clips = [wandering(seed) for seed in range(2)]
    found = learn_metric(clips, [KEYS, uniform_keyframes(41, 0.3)], kind="rot")
    assert found.provenance["keys"] == [8, 12]
    assert found.provenance["score"] < found.provenance["slerp_score"]


@pytest.mark.slow
def test_predicting_what_a_metric_made_keeps_the_metric():
    hidden = metric(1, sides="left")
    truth = wandering(1, n_frames=81)
    keys = uniform_keyframes(81, 0.15)
    made = interpolate(truth.at_frames(keys), truth.times, "geodesic", hidden)
    found = learn_metric(made, keys, purpose="predict", scheme="geodesic", kind="rot")
    assert found.provenance["score"] < 0.2 * found.provenance["slerp_score"]
    assert np.mean(found.provenance["shrinkage"]) > 0.5
    assert found.provenance["cross_validated_score"] < found.provenance["cross_validated_slerp_score"]


def test_predicting_noise_gives_the_identity():
    found = learn_metric(noise(n_frames=61), uniform_keyframes(61, 0.3), purpose="predict")
    factors = np.array(found.provenance["shrinkage"])
    assert (factors == 0.0).mean() > 0.8
    np.testing.assert_array_equal(found.parameters.matrices[factors == 0.0] - np.eye(3), 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("scheme", ["geodesic", "geodesic-spline"])
def test_predicting_from_a_fit_is_the_same(scheme):
    fitted = learn_metric(wandering(), KEYS, scheme=scheme, kind="rot")
    one = learn_metric(wandering(), KEYS, scheme=scheme, kind="rot", purpose="predict")
    other = learn_metric(wandering(), KEYS, scheme=scheme, kind="rot", purpose="predict", fitted=fitted)
    assert one.to_json() == other.to_json()


def test_a_spline_is_no_worse_than_slerp_the_plain_spline_and_the_geodesic():
    truth = wandering()
    geodesic = learn_metric(truth, KEYS, scheme="geodesic")
    spline = learn_metric(truth, KEYS).provenance
    assert spline["score"] < min(spline["slerp_score"], spline["plain_score"], geodesic.provenance["score"])


def test_predicting_from_two_segments():
    found = learn_metric(wandering(n_frames=15), [0, 7, 14], purpose="predict")
    assert found.provenance["cross_validated_score"] <= found.provenance["cross_validated_slerp_score"]


def renamed(animation):
    return dataclasses.replace(animation, skeleton=dataclasses.replace(tree(), joints=tuple("abcdef")))


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"search": "grid"}, "There is no search 'grid'; the choices are gradient, tpe, tpe-joint."),
        ({"purpose": "win"}, "There is no purpose 'win'; the choices are reconstruct, predict."),
        ({"scheme": "slerp"}, "There is no scheme 'slerp'; the choices are geodesic, geodesic-spline."),
        ({"family": "full"}, "There is no family 'full'; the families are diagonal, spd, coupled."),
        ({"invariance": "both"}, "There is no invariance 'both'; the choices are left, right, clip, joint."),
        ({"kind": "all"}, "There is no quality 'all'; the kinds are loc, rot, hyb."),
        ({"weights": [1.0]}, "weights has shape (1,), but 6 numbers that are at least 0 are needed."),
        ({"location_weight": 2.0}, "location_weight must be between 0 and 1, but it is 2.0."),
    ],
)
def test_nonsense_words(arguments, sentence):
    with pytest.raises(ValueError, match=f"^{re.escape(sentence)}$"):
        learn_metric(wandering(), KEYS, **arguments)


@pytest.mark.parametrize("keys", [[], [0], [0, 20], [1, 20, 40], [0, 20, 20, 40], [0, 30, 20, 40], [0, 20, 41]])
def test_keys_that_do_not_fit(keys):
    with pytest.raises(ValueError, match="^The keys of animation 0 must increase from frame 0 to frame 40[.]$"):
        learn_metric(wandering(), keys)


def test_nothing_to_learn_from():
    clip = wandering()
    one_segment = "^There is only one segment between keys, which cannot tell how to predict; keep more keys[.]$"
    with pytest.raises(ValueError, match=one_segment):
        learn_metric(clip, [0, 40], purpose="predict")
    with pytest.raises(ValueError, match="^Every frame is a key, so there is nothing to rebuild; keep fewer keys[.]$"):
        learn_metric(clip, np.arange(41))
    still = of_vectors(np.full((41, N_JOINTS, 3), 0.3))
    with pytest.raises(ValueError, match="^No joint turns, so there is nothing to learn[.]$"):
        learn_metric(still, KEYS)
    with pytest.raises(ValueError, match="^No joint turns, so there is nothing to learn[.]$"):
        learn_metric([still, still], [KEYS, KEYS])


def test_several_clips_that_do_not_fit():
    clip = wandering()
    unequal = (([], [], "0 animations and keys for 0"), ([clip, clip], [KEYS], "2 animations and keys for 1"))
    for clips, keys, numbers in unequal:
        with pytest.raises(ValueError, match=f"^There are {numbers}; one set for each is needed[.]$"):
            learn_metric(clips, keys)
    with pytest.raises(ValueError, match="^Animation 1 has other joints than the first[.]$"):
        learn_metric([clip, renamed(clip)], [KEYS, KEYS])
    with pytest.raises(ValueError, match="^The keys of animation 1 must increase from frame 0 to frame 40[.]$"):
        learn_metric([clip, clip], [KEYS, [0, 1]])


@pytest.mark.parametrize("scheme", ["geodesic", "geodesic-spline"])
def test_one_segment_can_be_rebuilt(scheme):
    found = learn_metric(wandering(), [0, 40], scheme=scheme)
    assert found.provenance["score"] < found.provenance["slerp_score"]


def test_clips_of_one_segment_each_are_enough_together():
    clips = [wandering(seed, 9) for seed in range(3)]
    found = learn_metric(clips, [[0, 8]] * 3, kind="rot")
    assert found.provenance["score"] <= found.provenance["slerp_score"]


def test_slerp_is_not_lost_to_when_there_is_nothing_to_gain():
    truth = wandering()
    slerped = interpolate(truth.at_frames(KEYS), truth.times, "slerp")
    for purpose in ("reconstruct", "predict"):
        found = learn_metric(slerped, KEYS, purpose=purpose)
        assert found.provenance["score"] < 1e-9
        assert np.isfinite(found.parameters.matrices).all()


def test_one_joint():
    vectors = wandering()
    one = Animation(
        dataclasses.replace(
            tree(),
            joints=("arm",),
            parents=[-1],
            rest_translations=np.zeros((1, 3)),
            rest_rotations=[[0, 0, 0, 1.0]],
            bone_ends=[[0.0, 1.0, 0.0]],
        ),
        vectors.times,
        vectors.rotations[:, :1],
        vectors.translations[:, :1],
    )
    found = learn_metric(one, KEYS)
    assert isinstance(found.parameters, MetricParameters)
    assert found.provenance["score"] < found.provenance["slerp_score"]


@needs_shared
@pytest.mark.slow
def test_predicting_the_second_half_of_real_clips_loses_nothing_on_average():
    losses = []
    for name in CLIPS:
        clip = real(name)
        n = clip.n_frames
        first, second = clip.at_frames(slice(0, n // 2 + 1)), clip.at_frames(slice(n // 2, n))
        for rate in (0.3, 0.1):
            keys = uniform_keyframes(first.n_frames, rate)
            if len(keys) < 3:
                continue
            found = learn_metric(first, keys, purpose="predict", scheme="geodesic")
            result = score(name, False, second, uniform_keyframes(second.n_frames, rate), found)
            losses.append(result.learned / result.slerp - 1.0)
            print(f"{name} {rate}: {result.gain:+.2%}, {np.mean(found.provenance['shrinkage']):.2f}")
    assert len(losses) >= 8
    assert np.mean(losses) <= 0.005
