"""The journal of a TPE search: what a resumed run reads of its folder, and all that it reads."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from geomstats_anim.learning.tune.tpe import Point, Space
from geomstats_anim.strict_json import parse_json, read_text

JOURNAL = "trials.jsonl"
"""Name of the file in the results folder."""

METRIC = "quality"
"""Name of a trial's value."""


def point_key(point: Mapping[str, Any]) -> str:
    """Return a point as text, the same for the same point."""
    return json.dumps(point, sort_keys=True)


class Journal:
    """The finished trials of a search, one line per trial: a file that only grows.

    Parameters
    ----------
    path : Path

    Attributes
    ----------
    values : dict
        Value of each point, which is written as JSON.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.values: dict[str, float] = {}

    def begin(self, space: Space, seed: int, resume: bool) -> None:
        """Open a new journal, or the one that is there.

        Parameters
        ----------
        space : Space
        seed : int
        resume : bool
            Whether one is there.

        Raises
        ------
        ValueError
            If there is one but should not be, or the other way round, or it is that of another search or of none.
        """
        header, folder = {"labels": list(space.identity), "seed": seed}, self.path.parent
        if not resume:
            if self.path.exists():
                raise ValueError(f"{folder} holds the results of a search; resume it, or name another folder.")
            folder.mkdir(parents=True, exist_ok=True)
            self.path.write_text(json.dumps(header) + "\n")
            return
        if not self.path.exists():
            raise ValueError(f"{folder} holds no search to resume: there is no {self.path.name} in it.")
        if self.read() != header:
            raise ValueError(f"The search in {folder} has other joints, another family, invariance or seed.")
        if not all(space.holds(json.loads(point)) for point in self.values):
            raise ValueError(f"{self.path} has a trial that this search cannot make; begin the search anew.")

    def read(self) -> dict[str, Any]:
        """Read all lines, and return the first."""
        self.values = {}
        try:
            # a line that a kill has cut short ends without a newline
            lines = read_text(self.path).split("\n")[:-1]
            for line in lines[1:]:
                trial = parse_json(line)
                self.values[point_key(trial["point"])] = float(trial[METRIC])
            return dict(parse_json(lines[0])) if lines else {}
        except (KeyError, OverflowError, TypeError, ValueError) as error:
            raise ValueError(f"{self.path} is not the journal of a search: {error}") from error

    def add(self, point: Point, value: float) -> bool:
        """Write a trial down, unless it is there."""
        key = point_key(point)
        if key in self.values:
            return False
        self.values[key] = value
        with self.path.open("a") as file:
            file.write(json.dumps({"point": point, METRIC: value}) + "\n")
        return True

    def __getstate__(self) -> Path:
        """Travel as a path: what is in the file is newer."""
        return self.path

    def __setstate__(self, path: Path) -> None:
        """Read the file."""
        self.__init__(path)  # type: ignore[misc]
        if path.exists():
            self.read()
