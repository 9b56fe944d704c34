"""Results of `study`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

ENOUGH = 20
"""Fewer answers than these show no preference, whatever the interval: coins fall alike five times, too."""


@dataclass(frozen=True)
class Preference:
    """Preference for one over another, or over all others.

    Parameters
    ----------
    wins, answers : int
    low, high : float
        Exact 95 % interval of its share (Clopper and Pearson, 1934).
    """

    wins: int
    answers: int
    low: float
    high: float

    @classmethod
    def of(cls, wins: int, answers: int) -> Preference:
        """Find the interval of a share."""
        from scipy.stats import binomtest

        interval = binomtest(wins, answers).proportion_ci(0.95, "exact")
        return cls(wins, answers, float(interval.low), float(interval.high))

    @property
    def is_clear(self) -> bool:
        """True if there are enough answers, and they are not what a fair coin gives."""
        return self.answers >= ENOUGH and not self.low <= 0.5 <= self.high


@dataclass(frozen=True)
class StudyResult:
    """Page that was written.

    Parameters
    ----------
    path : Path
        Folder.
    page : Path
    clips : tuple of str
    schemes : tuple of str
    questions : int
        How many there are on the page.
    warnings : tuple of str
    """

    path: Path
    page: Path
    clips: tuple[str, ...]
    schemes: tuple[str, ...]
    questions: int
    warnings: tuple[str, ...]


@dataclass(frozen=True)
class QuestionResult:
    """Answers to one question.

    Parameters
    ----------
    question : str
        A word of `QUESTIONS`.
    preferences : dict of str to Preference
        Of each scheme to all others that it was shown with, the most preferred first.
    scores : dict of str to float, or None
        Of Bradley and Terry, see `bradley_terry`.
    """

    question: str
    preferences: dict[str, Preference]
    scores: dict[str, float] | None
