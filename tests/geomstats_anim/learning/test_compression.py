"""Keys and their metric, chosen together: never worse than what each was without the other."""

import numpy as np
import pytest
from swings import swinging

from geomstats_anim import Animation, compress, interpolate, learn_metric, optimal_keyframes, quality, uniform_keyframes
from geomstats_anim.criteria import location_errors
from geomstats_anim.learning import compression


def rebuilt(animation, keys, metric):
    return interpolate(animation.at_frames(keys), animation.times, metric.scheme, metric)


def error(animation, keys, metric):
    return quality(rebuilt(animation, keys, metric), animation)


def largest(animation, keys, metric):
    return location_errors(rebuilt(animation, keys, metric), animation).max()


def standing(n_frames=20):
    one = swinging().at_frames([0])
    return Animation(
        one.skeleton,
        np.arange(float(n_frames)),
        np.tile(one.rotations, (n_frames, 1, 1)),
        np.tile(one.translations, (n_frames, 1, 1)),
    )


@pytest.mark.parametrize("scheme", [pytest.param("geodesic", marks=pytest.mark.slow), "geodesic-spline"])
def test_count_is_kept_and_error_is_less_than_of_either_alone(scheme):
    animation = swinging()
    found = compress([animation], [6], scheme=scheme)
    (keys,) = found.keyframes
    assert len(keys) == 6 and keys[0] == 0 and keys[-1] == 32
    assert found.metric.scheme == scheme
    ours = error(animation, keys, found.metric)
    slerp = optimal_keyframes(animation, 6)
    assert ours < quality(interpolate(animation.at_frames(slerp), animation.times, "slerp"), animation)
    plain = optimal_keyframes(animation, 6, scheme=scheme)
    assert ours < quality(interpolate(animation.at_frames(plain), animation.times, scheme), animation)
    again = compress([animation], [6], scheme=scheme)
    assert again.keyframes[0].tolist() == keys.tolist()
    assert (again.metric.parameters.moments == found.metric.parameters.moments).all()


def test_the_metric_that_made_a_clip_is_found_with_its_keys():
    animation = swinging()
    found = compress([animation], [5], kind="rot", scheme="geodesic")
    assert found.keyframes[0].tolist() == [0, 8, 16, 24, 32]
    assert quality(rebuilt(animation, found.keyframes[0], found.metric), animation, "rot") < 1e-2


@pytest.mark.parametrize("select", ["optimal", "uniform"])
def test_tilted_axes_are_for_counts_unless_told(select):
    animation = swinging()
    tilted = compress([animation], [6], select=select).metric
    straight = compress([animation], [6], select=select, family="diagonal").metric
    within = compress([animation], tolerance=0.05, select=select).metric
    assert tilted.parameters.axes is not None and tilted.provenance["family"] == "spd"
    assert straight.parameters.axes is None and within.parameters.axes is None
    assert tilted.provenance["score"] < straight.provenance["score"]


@pytest.mark.parametrize("select", ["optimal", "uniform"])
@pytest.mark.parametrize("tolerance", [pytest.param(0.01, marks=pytest.mark.slow), 0.05])
def test_tolerance_is_met_with_no_more_keys_than_slerp_needs(tolerance, select):
    animation = swinging()
    found = compress([animation], tolerance=tolerance, select=select)
    (keys,) = found.keyframes
    assert largest(animation, keys, found.metric) <= tolerance
    if select == "optimal":
        assert len(keys) <= len(optimal_keyframes(animation, tolerance=tolerance))


def test_uniform_keys_are_uniform():
    animation = swinging()
    found = compress([animation], [9], select="uniform")
    assert found.keyframes[0].tolist() == uniform_keyframes(33, 9 / 33).tolist()
    assert found.metric.provenance["score"] <= found.metric.provenance["plain_score"]


@pytest.mark.slow
def test_one_metric_serves_several():
    animations = [swinging(seed) for seed in range(3)]
    found = compress(animations, [5, 6, 7])
    assert [len(keys) for keys in found.keyframes] == [5, 6, 7]
    within = compress(animations, tolerance=0.05)
    for animation, keys in zip(animations, within.keyframes, strict=True):
        assert largest(animation, keys, within.metric) <= 0.05


def test_nothing_to_learn_from_is_no_error():
    moving, still = swinging(), standing()
    assert compress([still], tolerance=0.01).keyframes[0].tolist() == [0, 19]
    assert [len(keys) for keys in compress([moving, still], [6, 2]).keyframes] == [6, 2]
    pair = moving.at_frames([0, 7])
    assert compress([pair], [2]).keyframes[0].tolist() == [0, 1]
    assert compress([moving], [33]).keyframes[0].tolist() == list(range(33))


@pytest.mark.parametrize("scheme", ["slerp", "linear", "squad"])
def test_schemes_without_a_metric(scheme):
    animation = swinging()
    found = compress([animation], tolerance=0.05, scheme=scheme)
    assert found.metric.scheme == scheme
    assert largest(animation, found.keyframes[0], found.metric) <= 0.05


@pytest.mark.slow
def test_what_is_to_stay_stays():
    animation = swinging()
    assert {3, 4} <= set(compress([animation], [7], keep=[[3, 4]]).keyframes[0].tolist())
    assert {3, 4} <= set(compress([animation], tolerance=0.05, keep=[[3, 4]]).keyframes[0].tolist())


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        ({"counts": [6], "scheme": "nurbs"}, "no scheme 'nurbs'"),
        ({"counts": [6], "select": "random"}, "no selection 'random'; the choices are optimal, uniform"),
        ({"counts": [6], "select": "uniform", "keep": [[3]]}, "need select to be optimal"),
        ({"counts": [6], "tolerance": 0.1}, "Either count or tolerance"),
        ({}, "Either count or tolerance"),
        ({"counts": [1]}, "count is 1"),
        ({"counts": [6], "family": "full"}, "no family 'full'"),
    ],
)
def test_refusals(arguments, sentence):
    with pytest.raises(ValueError, match=sentence):
        compress([swinging()], **arguments)


def test_one_count_for_each_of_one_rig():
    with pytest.raises(ValueError, match="1 animations and 2 counts"):
        compress([swinging()], [5, 6])
    with pytest.raises(ValueError, match="0 animations"):
        compress([], tolerance=0.1)
    with pytest.raises(ValueError, match="different joints"):
        compress([swinging(), swinging(n_joints=2)], [5, 5])


def test_a_metric_for_few_keys_is_learned_from_some_of_the_frames_and_as_good(monkeypatch):
    keyed = swinging()
    animation = interpolate(keyed.at_frames(np.arange(0, 33, 8)), np.linspace(0.0, 32.0, 641), "geodesic-spline")
    seen = []

    def learned(animations, keyframes, **words):
        seen.append(animations[0].n_frames)
        assert np.isin(animations[0].times[keyframes[0]], animation.times).all()
        return learn_metric(animations, keyframes, **words)

    monkeypatch.setattr(compression, "learn_metric", learned)
    errors = {}
    for most in (compression._FRAMES_BETWEEN_KEYS, 10_000):
        monkeypatch.setattr(compression, "_FRAMES_BETWEEN_KEYS", most)
        found = compress([animation], [4], select="uniform")
        errors[most] = error(animation, found.keyframes[0], found.metric)
        assert found.keyframes[0].tolist() == uniform_keyframes(641, 4 / 641).tolist()
    assert 128 <= seen[0] < 170 and seen[1] == 641
    assert errors[32] <= 1.01 * errors[10_000]


def test_the_choice_of_keys_of_a_long_clip_reports_its_share(monkeypatch):
    from geomstats_anim.keyframes import coarse_to_fine

    shares = []
    compress([swinging()], [6], choosing=shares.append)
    assert shares == []  # short enough for an exact choice, at once
    monkeypatch.setattr(coarse_to_fine, "_AFFORDABLE", 0.0)
    monkeypatch.setattr(coarse_to_fine, "_COARSE", 0.0)
    compress([swinging(n_frames=129)], [5], choosing=shares.append)
    assert len(shares) >= 2 and shares == sorted(shares) and 0.0 < shares[0] and shares[-1] == 1.0
