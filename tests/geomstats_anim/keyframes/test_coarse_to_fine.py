"""Keys of clips that are too long for an exact choice: near the optimum, with what must stay, and with progress."""

import numpy as np
import pytest
from test_optimal_keyframes import clip, cost, with_hold

from geomstats_anim import interpolate, optimal_keyframes
from geomstats_anim.keyframes import coarse_to_fine


@pytest.fixture
def coarse(monkeypatch):
    """Choose from coarse to fine however short the clip is."""

    def switch(on):
        monkeypatch.setattr(coarse_to_fine, "_AFFORDABLE", 0.0 if on else np.inf)
        monkeypatch.setattr(coarse_to_fine, "_COARSE", 2e5 if on else np.inf)

    return switch


def smooth(seed):
    """A motion that is sampled as densely as motions are."""
    animation = clip(50, seed, 0.6)
    return interpolate(animation, np.linspace(*animation.times[[0, -1]], 160), "rotation-spline")


@pytest.mark.parametrize("kind", ["loc", "rot", "hyb", "max"])
@pytest.mark.parametrize("count", [3, 5, 9, 16])
@pytest.mark.parametrize("seed", range(3))
def test_it_is_within_two_per_cent_of_the_optimum(coarse, seed, count, kind):
    animation = smooth(seed)
    coarse(False)
    exact = optimal_keyframes(animation, count, kind=kind)
    coarse(True)
    found = optimal_keyframes(animation, count, kind=kind)
    assert len(found) == count and (np.diff(found) > 0).all() and found[0] == 0 and found[-1] == 159
    assert cost(animation, found, kind) <= 1.02 * cost(animation, exact, kind)


def test_what_must_stay_stays(coarse):
    coarse(True)
    animation = with_hold(clip(160), 50, 90)
    keys = optimal_keyframes(animation, 9, keep=[7, 8, 133]).tolist()
    assert len(keys) == 9 and {0, 7, 8, 50, 90, 133, 159} <= set(keys)
    assert not set(keys) & set(range(51, 90))


def test_keys_that_must_stay_are_all_where_no_more_are_wanted(monkeypatch):
    def refuse(*arguments):
        raise AssertionError("there is nothing to choose")

    monkeypatch.setattr("geomstats_anim.keyframes.problem.cheapest_keys", refuse)
    assert optimal_keyframes(clip(160), 2).tolist() == [0, 159]
    assert optimal_keyframes(with_hold(clip(160), 50, 90), 5, keep=[20]).tolist() == [0, 20, 50, 90, 159]


def test_progress_rises_to_the_whole(coarse):
    shares = []
    coarse(True)
    optimal_keyframes(clip(160), 5, progress=shares.append)
    assert len(shares) > 2 and shares[-1] == 1.0
    assert (np.diff(shares) > 0.0).all() and shares[0] > 0.0


def test_a_long_clip_measures_few_segments(monkeypatch):
    """The work of a choice grows with the number of frames, not with its cube."""
    work = []
    kernel = coarse_to_fine.kernel.fill_layers

    def count(start, stop, layers, truth, errors):
        lengths = layers[1:, None, :] - layers[:-1, :, None]
        if start == 0:
            work.append(int(lengths[(lengths > 0) & (layers[:-1, :, None] >= 0)].sum()))
        return kernel(start, stop, layers, truth, errors)

    monkeypatch.setattr(coarse_to_fine.kernel, "fill_layers", count)
    monkeypatch.setattr(coarse_to_fine, "_AFFORDABLE", 1e5)
    monkeypatch.setattr(coarse_to_fine, "_COARSE", 1e5)
    sums = []
    for n_frames in (500, 1000, 2000):
        work.clear()
        assert len(optimal_keyframes(clip(n_frames), 4)) == 4
        sums.append(sum(work))
    assert sums[2] < 10.0 * sums[0]  # the cube of 4 is 64
