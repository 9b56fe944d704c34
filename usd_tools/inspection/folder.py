"""Describe many files: a row per animation, and which of them are takes of the same rig."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from usd_tools.batch.result import FAILED, FileResult
from usd_tools.console.tables import show
from usd_tools.console.text import counted, say
from usd_tools.inspection.describe import inspect_file
from usd_tools.inspection.result import InspectResult
from usd_tools.skel.fault_words import count_kinds

_A_FEW = 4
"""Takes of a rig that are named; JSON has all."""


def inspect_task(
    source: Path, out: None, options: None, progress: None, warn: Callable[[str], None] | None
) -> InspectResult:
    """Describe one file of several; see `batch.run.Verb`."""
    return inspect_file(source, warn, finds_contacts=True)


@dataclass(frozen=True)
class Row:
    """One animation of one file, or a file without any.

    Parameters
    ----------
    file : str
        As seen from the folder that it was found in.
    skeleton, animation : str or None
        Paths of the Skeleton, the first that it drives, and of the SkelAnimation.
    rig : int or None
        Number of its rig, from 1 on: animations of the same joints have the same.
    joints, samples : int or None
    rate, seconds : float or None
        Samples per second, and from the first to the last.
    loop : float or None
        Degrees by which it misses being a loop; None for what is none.
    contacts : float or None
        Share of the time in which something is planted on the ground; None where nothing is.
    planted : int or None
        Number of joints that are at some time.
    faults : str or None
        Their number by kind, "" for none; None for what is not read.
    metric : str or None
        Scheme of the stored metric.
    error : str or None
    """

    file: str
    skeleton: str | None = None
    animation: str | None = None
    rig: int | None = None
    joints: int | None = None
    samples: int | None = None
    rate: float | None = None
    seconds: float | None = None
    loop: float | None = None
    contacts: float | None = None
    planted: int | None = None
    faults: str | None = None
    metric: str | None = None
    error: str | None = None


HEADER = ("file", "rig", "joints", "samples", "rate", "seconds", "loop", "contacts", "faults", "metric")
"""Columns of the table, the last three without what no file has; the CSV has all fields of `Row`."""


_OPTIONAL = ("contacts", "faults", "metric")


@dataclass(frozen=True)
class FolderResult:
    """Content of many files.

    Parameters
    ----------
    files : tuple of FileResult
        With the report of `inspect` on each.
    """

    files: tuple[FileResult, ...]

    @property
    def rigs(self) -> dict[str, int]:
        """Numbers of the rigs, in the order of the files."""
        found = (animation["rig"] for file in self.files for animation in _animations(file) if animation.get("joints"))
        return {rig: number for number, rig in enumerate(dict.fromkeys(found), 1)}

    def rows(self) -> list[Row]:
        """Return a row per animation, at least one per file."""
        rigs, rows = self.rigs, []
        for file in self.files:
            if file.status == FAILED:
                rows.append(Row(file.source, error=file.brief))
                continue
            animations = _animations(file)
            rows += [_row(file.source, animation, rigs) for animation in animations] or [Row(file.source)]
        return rows

    def takes(self) -> list[dict[str, Any]]:
        """Return each rig: its number, its joints, and the files that are takes of it."""
        found: dict[int, dict[str, Any]] = {}
        for row in self.rows():
            if row.rig is not None:
                rig = found.setdefault(row.rig, {"rig": row.rig, "joints": row.joints, "files": []})
                if row.file not in rig["files"]:
                    rig["files"].append(row.file)
        return list(found.values())

    def as_dict(self) -> dict[str, Any]:
        """Return what `--json` prints."""
        files = [
            {"path": file.source, "error": file.brief if file.status == FAILED else None, **(file.report or {})}
            for file in self.files
        ]
        return {"rows": [vars(row) for row in self.rows()], "rigs": self.takes(), "files": files}

    def as_csv(self) -> str:
        """Return what `--csv` prints."""
        text = io.StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(Row.__dataclass_fields__)
        writer.writerows(vars(row).values() for row in self.rows())
        return text.getvalue()

    def print_summary(self) -> None:
        """Print the table, and the rigs of which there are several takes."""
        cells = [_cells(row) for row in self.rows()]
        used = [k for k, name in enumerate(HEADER) if name not in _OPTIONAL or any(row[k] for row in cells)]
        rows, header = [[row[k] for k in used] for row in cells], [HEADER[k] for k in used]
        show(counted(len(self.files), "file"), rows, header)
        for rig in self.takes():
            files = rig["files"]
            if len(files) == 1:
                continue
            more = f" and {len(files) - _A_FEW} more" if len(files) > _A_FEW else ""
            takes = f"{counted(len(files), 'take')}, {', '.join(files[:_A_FEW])}{more}"
            say(f"Rig {rig['rig']}, {counted(rig['joints'], 'joint')}: {takes}.")


def _animations(file: FileResult) -> Sequence[dict[str, Any]]:
    return () if file.report is None else file.report["animations"]


def _row(file: str, animation: dict[str, Any], rigs: dict[str, int]) -> Row:
    skeleton = next(iter(animation["skeletons"]), None)
    if animation["error"] is not None:
        return Row(file, skeleton, animation["prim"], error=animation["error"])
    start, end = animation["seconds"] or (0.0, 0.0)
    metric, contacts = animation["metric"], animation["contacts"]
    return Row(
        file,
        skeleton,
        animation["prim"],
        rigs.get(animation["rig"]),
        animation["joints"],
        animation["samples"] or 0,
        animation["samples_per_second"],
        end - start,
        None if animation["loop"] is None else animation["loop"]["misses_degrees"],
        None if contacts is None else contacts["share"],
        None if contacts is None else len(contacts["joints"]),
        count_kinds(animation["faults"]),
        None if metric is None else metric.get("scheme"),
        None if metric is None else metric["error"],
    )


def _cells(row: Row) -> list[str]:
    if row.samples is None:
        return [row.file, *[""] * (len(HEADER) - 2), row.error or "no skeletal animation"]
    rate = "" if row.rate is None else f"{row.rate:.5g}"
    return [
        row.file,
        "" if row.rig is None else str(row.rig),
        str(row.joints),
        str(row.samples),
        rate,
        f"{row.seconds:.4g}",
        "" if row.loop is None else f"{row.loop:.2g} deg",
        f"{100.0 * row.contacts:.0f} %" if row.contacts else "",
        row.faults or "",
        row.error or row.metric or "",
    ]
