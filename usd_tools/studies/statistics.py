"""Statistics of answers: how often each scheme is preferred, and how strong it is, with what can be known of it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np

from usd_tools.studies.answers import Answer
from usd_tools.studies.pairs import QUESTIONS
from usd_tools.studies.result import Preference, QuestionResult


def count_wins(schemes: Sequence[str], answers: Iterable[tuple[str, str]]) -> np.ndarray:
    """Count answers.

    Parameters
    ----------
    schemes : sequence of str, shape=[S]
    answers : iterable of (str, str)
        The one that was preferred, and the other.

    Returns
    -------
    wins : array-like of int, shape=[S, S]
        How often the first was preferred to the second.
    """
    place = {scheme: i for i, scheme in enumerate(schemes)}
    wins = np.zeros((len(schemes), len(schemes)), dtype=int)
    for winner, loser in answers:
        wins[place[winner], place[loser]] += 1
    return wins


def bradley_terry(wins: np.ndarray) -> np.ndarray | None:
    """Estimate strengths, so that i is preferred to j with probability p_i / (p_i + p_j).

    The iteration of Hunter (2004), "MM algorithms for generalized Bradley-Terry models".

    Parameters
    ----------
    wins : array-like of int, shape=[S, S]
        See `count_wins`.

    Returns
    -------
    scores : array-like, shape=[S]
        log p, with mean 0; None where answers do not determine them, since some schemes never lost to the others.
    """
    from scipy.sparse.csgraph import connected_components

    if connected_components(wins > 0, directed=True, connection="strong")[0] > 1:
        return None
    played, total = wins + wins.T, wins.sum(axis=1)
    p = np.ones(len(wins))
    for _ in range(100_000):
        better = total / (played / (p[:, None] + p)).sum(axis=1)
        better /= np.exp(np.log(better).mean())
        if np.abs(np.log(better / p)).max() < 1e-12:
            break
        p = better
    return np.log(better) - np.log(better).mean()


def evaluate(answers: Sequence[Answer]) -> tuple[QuestionResult, ...]:
    """Count the answers to each question that was answered."""
    results = []
    for question in QUESTIONS:
        own = [(each.preferred, each.other) for each in answers if each.question == question]
        if not own:
            continue
        schemes = sorted({scheme for pair in own for scheme in pair})
        wins = count_wins(schemes, own)
        shares = {
            scheme: Preference.of(int(wins[i].sum()), int(wins[i].sum() + wins[:, i].sum()))
            for i, scheme in enumerate(schemes)
        }
        order = sorted(schemes, key=lambda scheme: -shares[scheme].wins / shares[scheme].answers)
        scores = bradley_terry(wins)
        results.append(
            QuestionResult(
                question,
                {scheme: shares[scheme] for scheme in order},
                None if scores is None else dict(zip(schemes, scores.tolist(), strict=True)),
            )
        )
    return tuple(results)
