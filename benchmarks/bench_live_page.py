"""Measure the page of `live`: how many pictures per second a server pushes, and what one costs.

python benchmarks/bench_live_page.py [FILE ...]

Every message is counted where viser queues it, and serialised as for one browser; no browser takes part.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import numpy as np

from usd_tools.editing.session import EditSession
from usd_tools.example_clips.body import build_skin
from usd_tools.example_clips.motions import MOTIONS
from usd_tools.example_clips.stage import make_stage
from usd_tools.viewer.page import LivePage
from usd_tools.viewer.scene import OURS, SLERP
from usd_tools.viewer.server import serving

PICTURES = 240


def pushes(path: Path) -> dict[str, Any]:
    """Push pictures of two characters as fast as can be."""
    start = time.perf_counter()
    session = EditSession.open(path)
    with tempfile.TemporaryDirectory() as folder, serving("127.0.0.1", 0) as server:
        page = LivePage(server, session, Path(folder) / "out.usda", Path(folder) / "presets")
        page.view.show(0, None)
        opened = time.perf_counter() - start
        for name, box in page.controls.shown.items():
            box.value = name in (OURS, SLERP)
        sent: list[Any] = []
        plain = server.scene._websock_interface.queue_message

        def queue(message: Any) -> None:
            sent.append(message)
            plain(message)

        server.scene._websock_interface.queue_message = queue  # type: ignore[method-assign]
        frames = np.arange(PICTURES) % len(session.times)
        wall, processor = time.perf_counter(), time.process_time()
        for frame in frames.tolist():
            with server.atomic():
                page.view.show(frame, None)
        for message in sent:
            message.as_serializable_dict([])
        wall, processor = time.perf_counter() - wall, time.process_time() - processor
    return {
        "clip": path.stem,
        "joints": session.skeleton.n_joints,
        "frames": len(session.times),
        "points": sum(body.n_points for body in page.view.scene.bodies.values()) // 3 * 2,
        "opened": opened,
        "messages": len(sent) / PICTURES,
        "milliseconds": 1e3 * processor / PICTURES,
        "pictures": PICTURES / wall,
    }


def main() -> None:
    """Print a row for each clip."""
    with tempfile.TemporaryDirectory() as folder:
        clip = Path(folder) / "pitching.usda"
        stage = make_stage(MOTIONS["pitching"](), build_skin())
        stage.GetRootLayer().Export(str(clip))
        print(f"{'clip':24} joints frames points x 2  opens, s  messages  ms of processor  pictures per second")
        for path in [clip, *map(Path, sys.argv[1:])]:
            row = pushes(path)
            print(
                f"{row['clip']:24} {row['joints']:6} {row['frames']:6} {row['points']:10} {row['opened']:9.2f} "
                f"{row['messages']:9.1f} {row['milliseconds']:16.2f} {row['pictures']:20.0f}"
            )


if __name__ == "__main__":
    main()
