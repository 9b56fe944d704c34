"""Summary that `study --results` prints."""

from __future__ import annotations

from collections.abc import Sequence

from usd_tools.console.tables import show
from usd_tools.console.text import say
from usd_tools.studies.pairs import QUESTIONS
from usd_tools.studies.result import ENOUGH, Preference, QuestionResult


def print_results(results: Sequence[QuestionResult]) -> None:
    """Print a table for each question, and what it does not show."""
    for result in results:
        rows = [
            [
                scheme,
                f"{each.wins} of {each.answers}",
                f"{100.0 * each.wins / each.answers:.0f} %",
                f"{100.0 * each.low:.0f} to {100.0 * each.high:.0f} %",
                "–" if result.scores is None else f"{result.scores[scheme]:+.2f}",
                _verdict(each),
            ]
            for scheme, each in result.preferences.items()
        ]
        show(QUESTIONS[result.question], rows, ["scheme", "preferred", "share", "95 % interval", "score", "verdict"])
        if result.scores is None:
            say("There are no scores yet: each scheme has to win and to lose, directly or through others.")
    say("Shares are of the pairs that showed a scheme; score is that of Bradley and Terry, 0 on average.")


def _verdict(each: Preference) -> str:
    if each.is_clear:
        return "preferred" if each.low > 0.5 else "not preferred"
    return f"too few answers: fewer than {ENOUGH}" if each.answers < ENOUGH else "too few answers to tell"
