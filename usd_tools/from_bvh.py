"""Convert a BVH file of motion capture to UsdSkel: one skeleton, one animation, every frame a sample.

python -m usd_tools.from_bvh walk.bvh -o walk.usda --scale 0.056444 --skip-first
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geomstats_anim import Skeleton
from geomstats_anim.rotations import IDENTITY
from usd_tools.bvh.reader import Bvh, read_bvh
from usd_tools.console.arguments import add_format, positive_number
from usd_tools.console.errors import Messages, ToolError, print_warning, run
from usd_tools.console.parser import ArgumentParser
from usd_tools.console.progress import Progress, ProgressBar
from usd_tools.console.text import counted
from usd_tools.files.openusd_errors import openusd_errors
from usd_tools.files.paths import check_usd_output, same_file
from usd_tools.skel import output
from usd_tools.skel.frame_rates import typed_rate
from usd_tools.skel.joint_names import joint_paths, unique
from usd_tools.skel.new_file import Character, Units, new_stage
from usd_tools.skel.writer import made_by, save_layer

TOOL = "usd_tools.from_bvh"

PROG = "python -m usd_tools.from_bvh"


def parser(prog: str = PROG) -> ArgumentParser:
    """Make the parser of the command line."""
    parse = ArgumentParser(
        prog=prog,
        description="Convert a BVH file to UsdSkel. Its numbers stay as they are; what a unit of them is, and which "
        "axis is up, is written beside them, for BVH does not tell.",
    )
    parse.add_argument("input", metavar="IN", type=Path, help="BVH file")
    parse.add_argument("-o", "--out", metavar="OUT", type=Path, required=True, help="USD file to write")
    parse.add_argument(
        "--scale",
        metavar="METRES_PER_UNIT",
        type=positive_number,
        default=0.01,
        help="metres for one unit of IN: 0.01 for centimetres, 0.0254 for inches, 0.056444 for files of CMU; default: "
        "0.01, as it is in USD",
    )
    parse.add_argument("--fps", metavar="F", type=typed_rate, help="play F frames a second, whatever IN says")
    parse.add_argument("--skip-first", action="store_true", help="leave out the first frame, often a pose at rest")
    parse.add_argument("--up", choices=("Y", "Z"), default="Y", help="axis of IN that points up; default: Y")
    add_format(parse)
    return parse


def main(argv: Sequence[str] | None = None, prog: str = PROG) -> int:
    """Run the command and return its exit code."""
    args = parser(prog).parse_args(argv)
    return run(lambda: convert(args))


@openusd_errors()
def convert(args: argparse.Namespace) -> int:
    """Do what the arguments say."""
    check_usd_output(args.out, args.usdFormat)
    if same_file(args.out, [args.input]):
        raise ToolError(f"--out {args.out} is the input itself; choose another name.")
    with ProgressBar() as bar:
        progress = Progress(bar, 3, "Reading")
        bvh = read_bvh(args.input, args.fps, Messages(print_warning).warn)
        character = _character(bvh, args)
        progress.advance(1, "Converting")
        stage = new_stage(character)
        layer = stage.GetRootLayer()
        layer.customLayerData = made_by(TOOL, _settings(args))
        progress.advance(1, "Writing")
        save_layer(layer, args.out, args.usdFormat)
    height = _height(bvh, "XYZ".index(args.up)) * args.scale
    joints, frames = counted(len(bvh.names), "joint"), counted(len(character.rotations), "frame")
    print(f"{args.input}: {joints}, {height:.3g} m high at rest; {frames}.")
    print(output.written(args.out, bvh.rate))
    return 0


def _character(bvh: Bvh, args: argparse.Namespace) -> Character:
    first = 1 if args.skip_first else 0
    if len(bvh.rotations) == first:
        raise ToolError(f"{args.input} has one frame, and --skip-first leaves it out; call it without --skip-first.")
    skeleton = Skeleton(
        tuple(joint_paths(bvh.names, bvh.parents.tolist())),
        bvh.parents,
        bvh.offsets,
        np.tile(IDENTITY, (len(bvh.names), 1)),
        bvh.bone_ends,
    )
    units = Units(args.scale, args.up, bvh.rate)
    return Character(skeleton, unique(bvh.names), bvh.rotations[first:], bvh.translations[first:], units)


def _height(bvh: Bvh, up: int) -> float:
    """From the lowest to the highest point of the skeleton at rest, in the file's unit."""
    heights = bvh.offsets[:, up].copy()
    for joint, parent in enumerate(bvh.parents):
        if parent >= 0:
            heights[joint] += heights[parent]
    return float(np.ptp(np.concatenate([heights, heights + bvh.bone_ends[:, up]])))


def _settings(args: argparse.Namespace) -> dict[str, Any]:
    """Arguments that say what was done, as plain values without paths of this machine."""
    settings = {"scale": args.scale, "up": args.up, "fps": args.fps, "skip-first": args.skip_first or None}
    return {"source": args.input.name} | {name: value for name, value in settings.items() if value is not None}


if __name__ == "__main__":
    sys.exit(main())
