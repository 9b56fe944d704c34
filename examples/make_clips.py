"""Write the five example clips: a 24-joint biped with a skin, 30 samples per second, as UsdSkel."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from pxr import Usd

from usd_tools.example_clips.body import build_skin
from usd_tools.example_clips.motions import MOTIONS
from usd_tools.example_clips.stage import make_stage


def _write(stage: Usd.Stage, path: Path) -> None:
    """Write beside, then rename: nobody ever sees half a file."""
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_text(stage.GetRootLayer().ExportToString(), encoding="utf-8", newline="\n")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def main(argv: list[str] | None = None) -> int:
    """Write the clips and print their paths.

    Parameters
    ----------
    argv : list of str, optional
        The arguments; the command line's unless given.

    Returns
    -------
    status : int
        0, or 1 if a file could not be written.
    """
    parser = argparse.ArgumentParser(prog="make_clips.py", description=__doc__)
    parser.add_argument("-o", "--out", metavar="FOLDER", type=Path, default=Path(__file__).parent / "clips")
    parser.add_argument("--clips", metavar="NAME", nargs="+", choices=list(MOTIONS), default=list(MOTIONS))
    arguments = parser.parse_args(argv)
    skin = build_skin()
    try:
        arguments.out.mkdir(parents=True, exist_ok=True)
        for name in arguments.clips:
            path = arguments.out / f"{name}.usda"
            _write(make_stage(MOTIONS[name](), skin), path)
            print(path)
    except OSError as error:
        print(f"error: cannot write {error.filename}: {error.strerror}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
