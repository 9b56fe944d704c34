"""What answers say: exact intervals, and the strengths of Bradley and Terry."""

import numpy as np
import pytest
from scipy.stats import beta

from usd_tools.studies.answers import Answer
from usd_tools.studies.pairs import QUESTIONS, all_pairs
from usd_tools.studies.result import ENOUGH, Preference
from usd_tools.studies.statistics import bradley_terry, count_wins, evaluate


@pytest.mark.parametrize(("wins", "answers"), [(0, 5), (3, 7), (18, 20), (20, 20), (150, 200)])
def test_intervals_are_those_of_clopper_and_pearson(wins, answers):
    found = Preference.of(wins, answers)
    low = 0.0 if wins == 0 else beta.ppf(0.025, wins, answers - wins + 1)
    high = 1.0 if wins == answers else beta.ppf(0.975, wins + 1, answers - wins)
    np.testing.assert_allclose([found.low, found.high], [low, high], atol=1e-9)


def test_few_answers_are_no_preference():
    assert not Preference.of(ENOUGH - 1, ENOUGH - 1).is_clear
    assert Preference.of(ENOUGH, ENOUGH).is_clear and not Preference.of(12, 20).is_clear


def test_two_schemes_have_the_odds_as_scores():
    scores = bradley_terry(np.array([[0, 30], [10, 0]]))
    np.testing.assert_allclose(scores[0] - scores[1], np.log(3.0), atol=1e-10)
    np.testing.assert_allclose(scores.sum(), 0.0, atol=1e-12)


def test_strengths_are_found_again_and_solve_the_likelihood():
    truth = np.array([0.8, 0.1, -0.2, -0.7])
    chances = 1.0 / (1.0 + np.exp(truth[None] - truth[:, None]))
    wins = np.round(1000 * chances).astype(int)
    np.fill_diagonal(wins, 0)
    scores = bradley_terry(wins)
    np.testing.assert_allclose(scores, truth, atol=2e-3)
    expected = 1.0 / (1.0 + np.exp(scores[None] - scores[:, None]))
    np.testing.assert_allclose(wins.sum(axis=1), ((wins + wins.T) * expected).sum(axis=1), rtol=1e-9)


def test_who_never_lost_has_no_score():
    assert bradley_terry(np.array([[0, 5, 5], [0, 0, 3], [0, 2, 0]])) is None


def test_every_pair_is_asked_once_in_both_ways_of_sides():
    schemes = {"a": ("slerp", "ours", "plain"), "b": ("slerp", "ours")}
    pairs = all_pairs(schemes, 3)
    assert len(pairs) == 2 * (3 + 1) and len(set(pairs)) == len(pairs)
    kinds = {(pair.clip, pair.question, frozenset((pair.left, pair.right))) for pair in pairs}
    assert len(kinds) == len(pairs) and {pair.question for pair in pairs} == set(QUESTIONS)
    assert pairs == all_pairs(schemes, 3) != all_pairs(schemes, 4)
    sides = [pair.left == "slerp" for seed in range(200) for pair in all_pairs({"b": ("slerp", "ours")}, seed)]
    assert 150 < sum(sides) < 250


def test_answers_are_counted_by_question():
    answers = [Answer("a", "nearer", "ours", "slerp")] * 24 + [Answer("b", "nearer", "slerp", "ours")] * 6
    answers += [Answer("a", "natural", "plain", "ours")]
    nearer, natural = evaluate(answers)
    assert list(nearer.preferences) == ["ours", "slerp"]
    assert (nearer.preferences["ours"].wins, nearer.preferences["ours"].answers) == (24, 30)
    np.testing.assert_allclose(nearer.scores["ours"] - nearer.scores["slerp"], np.log(4.0), atol=1e-9)
    assert natural.scores is None and not natural.preferences["plain"].is_clear
    wins = count_wins(["ours", "slerp"], [(each.preferred, each.other) for each in answers[:30]])
    assert wins.tolist() == [[0, 24], [6, 0]]
