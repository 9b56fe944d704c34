"""Measure the pages of `compare` in a headless browser that draws without a graphics card.

    python benchmarks/bench_player.py FILE ...

For each clip: what the page's data takes, how many pictures per second are drawn while the original and two rebuilt
motions play side by side, and what one costs all processes of the browser, in the best of three rounds. It needs
Playwright with Debian's chromium, as the tests do, and a machine that does nothing else: pictures are dropped, not
delayed, when it is busy.
"""

from __future__ import annotations

import os
import sys
import tempfile
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "tests"))

from chromium import opened  # noqa: E402

from usd_tools.compare import CompareOptions, compare  # noqa: E402

SECONDS, ROUNDS = 5.0, 3
_PLAY = """async (seconds) => {
  const stage = document.getElementById("stage"), watch = new MutationObserver(() => drawn++);
  let drawn = 0;
  watch.observe(stage, { attributes: true, attributeFilter: ["data-frame"] });
  document.getElementById("play").click();
  await new Promise((done) => setTimeout(done, 1000 * seconds));
  document.getElementById("play").click();
  const data = JSON.parse(document.getElementById("data").textContent);
  const { character, frames } = data.clips[0], { joints, times } = character;
  const body = await Body.of(character.bodies.skin || character.bodies.bones);
  return { drawn, joints, points: body.points, rate: (frames.length - 1) / times.at(-1),
           bytes: document.getElementById("data").textContent.length };
}"""


def processor_seconds() -> float:
    """Return the seconds of processor of all processes below this one that still run."""
    parents, used = {}, {}
    for status in Path("/proc").glob("[0-9]*/stat"):
        try:
            words = status.read_text().rpartition(")")[2].split()
        except OSError:  # it has ended meanwhile
            continue
        number = int(status.parent.name)
        parents[number], used[number] = int(words[1]), (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")
    own = os.getpid()

    def is_below(number: int) -> bool:
        while number in parents and number != own:
            number = parents[number]
        return number == own

    return sum(seconds for number, seconds in used.items() if number != own and is_below(number))


def play(clip: Path, folder: Path) -> dict[str, Any]:
    """Play the page of a clip."""
    options = CompareOptions(rates=(0.1,), schemes=("slerp", "geodesic-spline:plain"))  # type: ignore[arg-type]
    compare([clip], folder / clip.stem, options)
    page = folder / clip.stem / "index.html"
    with opened(page.as_uri(), 1280, 1000) as (tab, _):
        tab.wait_for_timeout(3000)
        rounds = []
        for _ in range(ROUNDS):
            before = processor_seconds()
            played = tab.evaluate(_PLAY, SECONDS)
            rounds.append({**played, "cost": (processor_seconds() - before) / max(1, played["drawn"])})
    best = min(rounds, key=lambda each: each["cost"])
    return {**best, "clip": clip.name, "page": page.stat().st_size}


def main() -> None:
    """Print a row for each clip."""
    print(f"{'clip':28} joints  points  page, kB  its data, kB  of samples per s, drawn  ms of processor a picture")
    with tempfile.TemporaryDirectory() as folder:
        for clip in map(Path, sys.argv[1:]):
            row = play(clip, Path(folder))
            cost = 1e3 * row["cost"]
            print(
                f"{row['clip']:28} {row['joints']:6} {row['points']:7} {row['page'] / 1e3:9.0f} "
                f"{row['bytes'] / 1e3:13.0f} {row['rate']:17.1f} {row['drawn'] / SECONDS:6.1f} {cost:26.0f}"
            )


if __name__ == "__main__":
    main()
