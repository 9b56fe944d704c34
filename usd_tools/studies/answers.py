"""Answers that people gave on the page: files of JSON, from strangers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geomstats_anim.strict_json import parse_json, read_text
from usd_tools.console.errors import ToolError
from usd_tools.studies.pairs import QUESTIONS

FORMAT, VERSION = "geomstatsAnimAnswers", 1


@dataclass(frozen=True)
class Answer:
    """One answer.

    Parameters
    ----------
    clip, question : str
    preferred, other : str
        Schemes.
    """

    clip: str
    question: str
    preferred: str
    other: str


def read_answers(paths: Sequence[Path]) -> list[Answer]:
    """Read files of answers.

    Parameters
    ----------
    paths : sequence of Path
        All of one study; a file that was given twice counts once.

    Returns
    -------
    answers : list of Answer

    Raises
    ------
    ToolError
        If a file cannot be read, or the files are of several studies.
    """
    documents = {path: _document(path) for path in paths}
    studies = {document["study"]: path for path, document in documents.items()}
    if len(studies) > 1:
        first, second = list(studies.values())[:2]
        raise ToolError(f"{first} and {second} are answers to different studies; name those of one.")
    by_person = {document["person"]: (path, document["answers"]) for path, document in documents.items()}
    return [_answer(path, value) for path, values in by_person.values() for value in values]


def _document(path: Path) -> dict[str, Any]:
    try:
        document = parse_json(read_text(path))
    except (OSError, ValueError) as error:
        raise ToolError(f"{path} cannot be read as answers: {error}") from error
    if not isinstance(document, dict) or document.get("format") != FORMAT or document.get("version") != VERSION:
        raise ToolError(f'{path} has no answers; its "format" is not "{FORMAT}", or its version is another.')
    words, answers = [document.get("study"), document.get("person")], document.get("answers")
    if not isinstance(answers, list) or not all(isinstance(word, str) for word in words):
        raise ToolError(f"{path} has no list of answers, or does not name its study.")
    return document


def _answer(path: Path, value: Any) -> Answer:
    words = [
        value.get(name) if isinstance(value, dict) else None for name in ("clip", "question", "preferred", "other")
    ]
    if not all(isinstance(word, str) for word in words) or words[1] not in QUESTIONS or words[2] == words[3]:
        raise ToolError(f"{path} has an answer that does not name a clip, a question and two schemes.")
    return Answer(*map(str, words))
