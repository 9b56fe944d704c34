"""Choice of the pairs of motions that are shown, of their order and sides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

QUESTIONS = {"nearer": "Which is nearer to the original?", "natural": "Which looks more natural?"}
"""Questions that are asked of every pair; the original is shown with the first question only."""


@dataclass(frozen=True)
class Pair:
    """One question.

    Parameters
    ----------
    clip : str
    question : str
        A word of `QUESTIONS`.
    left, right : str
        Schemes.
    """

    clip: str
    question: str
    left: str
    right: str


def all_pairs(schemes: Mapping[str, Sequence[str]], seed: int) -> list[Pair]:
    """Make every pair of schemes a question of each kind, in random order and on random sides.

    Parameters
    ----------
    schemes : mapping of str to sequence of str
        Schemes that there are of each clip.
    seed : int

    Returns
    -------
    pairs : list of Pair
        The same for the same seed.
    """
    rng = np.random.default_rng(seed)
    pairs = []
    for question in QUESTIONS:
        for clip, words in schemes.items():
            for pair in combinations(words, 2):
                left, right = rng.permutation(pair).tolist()
                pairs.append(Pair(clip, question, left, right))
    return [pairs[i] for i in rng.permutation(len(pairs))]
