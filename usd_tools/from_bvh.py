"""Convert a BVH file of motion capture to UsdSkel: one character, one animation, every frame a sample.

python -m usd_tools.from_bvh walk.bvh -o walk.usda --scale 0.056444 --skip-first
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from usd_tools.batch.main import Work, run_on_files
from usd_tools.bvh.options import UP_AXES, FromBvhOptions
from usd_tools.bvh.result import FromBvhResult
from usd_tools.console.arguments import add_format, add_inputs, add_several, positive_number
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import ProgressCallback
from usd_tools.console.text import counted, say
from usd_tools.skel.frame_rates import typed_rate

if TYPE_CHECKING:
    from pxr import Usd

__all__ = ["FromBvhOptions", "FromBvhResult", "from_bvh", "from_bvh_stage", "main", "parser"]

PROG = "python -m usd_tools.from_bvh"


def from_bvh(
    source: str | os.PathLike[str],
    out: str | os.PathLike[str],
    options: FromBvhOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> FromBvhResult:
    """Convert a BVH file to a USD file.

    Parameters
    ----------
    source : path-like
        BVH file.
    out : path-like
        USD file to write.
    options : FromBvhOptions
        Optional, default: centimetres, Y up, the rate of the file.
    progress : callable
        Called with the work done, all the work, and a text.
        Optional, default: nobody is told.
    warn : callable
        Called with each warning as it comes; all are in the result.
        Optional, default: nobody is told.

    Returns
    -------
    result : FromBvhResult

    Raises
    ------
    ToolError
        If something is wrong with the file, then with the number of the line, or with the output; nothing is
        written then.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> folder = Path(tempfile.mkdtemp())
    >>> lines = "HIERARCHY", "ROOT Arm {", "OFFSET 0 90 0", "CHANNELS 1 Xrotation", "End Site { OFFSET 0 30 0 } }"
    >>> motion = "MOTION", "Frames: 3", "Frame Time: 0.0333333", "0", "45", "90"
    >>> _ = (folder / "swing.bvh").write_text(chr(10).join(lines + motion))
    >>> result = from_bvh(folder / "swing.bvh", folder / "swing.usda", FromBvhOptions(scale=0.01))
    >>> result.path.name, result.joints, result.frames, result.rate, result.height_metres
    ('swing.usda', 1, 3, 30.0, 0.3)
    """
    from usd_tools.bvh.convert import from_bvh_file

    return from_bvh_file(Path(source), Path(out), options or FromBvhOptions(), progress, warn)


def from_bvh_stage(
    source: str | os.PathLike[str],
    stage: Usd.Stage,
    options: FromBvhOptions | None = None,
    *,
    progress: ProgressCallback | None = None,
    warn: Callable[[str], None] | None = None,
) -> FromBvhResult:
    """Add the character of a BVH file to an open stage, in the layer of its edit target.

    The stage keeps its units, up axis and rate: the character is scaled and turned to fit, and its first frame is at
    time code 0.

    Parameters
    ----------
    source : path-like
        BVH file.
    stage : Usd.Stage
    options : FromBvhOptions
        Optional, default: centimetres, Y up, the rate of the file.
    progress, warn : callable
        See `from_bvh`.

    Returns
    -------
    result : FromBvhResult

    Raises
    ------
    ToolError
        If something is wrong with the file, then with the number of the line, or the edit target cannot hold the
        character; the layer is as it was then.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from pxr import Usd
    >>> folder = Path(tempfile.mkdtemp())
    >>> lines = "HIERARCHY", "ROOT Arm {", "OFFSET 0 90 0", "CHANNELS 1 Xrotation", "End Site { OFFSET 0 30 0 } }"
    >>> motion = "MOTION", "Frames: 3", "Frame Time: 0.0333333", "0", "45", "90"
    >>> _ = (folder / "swing.bvh").write_text(chr(10).join(lines + motion))
    >>> stage = Usd.Stage.CreateInMemory()
    >>> stage.SetTimeCodesPerSecond(60)
    >>> result = from_bvh_stage(folder / "swing.bvh", stage)
    >>> result.prim, stage.GetPrimAtPath("/Character/Animation").GetAttribute("rotations").GetTimeSamples()
    ('/Character', [0.0, 2.0, 4.0])
    """
    from usd_tools.bvh.convert import from_bvh_open_stage

    return from_bvh_open_stage(Path(source), stage, options or FromBvhOptions(), progress, warn)


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Convert a BVH file to UsdSkel. Its numbers stay as they are. BVH has no unit and no up axis: "
        "--scale and --up name them, and are stored beside the numbers.",
    )
    add_inputs(parse, "BVH file")
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, required=True, help="USD file or folder to write")
    parse.add_argument(
        "--scale",
        metavar="METRES_PER_UNIT",
        type=positive_number,
        default=0.01,
        help="metres per unit of IN: 0.01 for centimetres, 0.0254 for inches, 0.056444 for files of CMU; default: "
        "0.01, as in USD",
    )
    parse.add_argument(
        "--fps", metavar="F", type=typed_rate, help="frames per second; default: the Frame Time of IN, not needed then"
    )
    parse.add_argument("--skip-first", action="store_true", help="leave out the first frame, often a rest pose")
    parse.add_argument("--up", choices=UP_AXES, default="Y", help="axis of IN that points up; default: Y")
    add_format(parse)
    parse.add_argument("--report", metavar="FILE", type=Path, help="write a report as JSON")
    add_several(parse)
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    return run_on_files(
        parser(prog), argv, "usd_tools.from_bvh", FromBvhOptions, _work, extensions=(".bvh",), suffix=".usdc"
    )


def _work() -> Work:
    from usd_tools.bvh.convert import from_bvh_file

    return from_bvh_file, _print


def _print(result: FromBvhResult, args: argparse.Namespace) -> None:
    from usd_tools.skel.rate_advice import written_at

    joints, frames = counted(result.joints, "joint"), counted(result.frames, "frame")
    say(f"{args.input[0]}: {joints}, {result.height_metres:.3g} m high at rest; {frames}.")
    say(written_at(args.out, result.rate))


if __name__ == "__main__":
    sys.exit(main())
