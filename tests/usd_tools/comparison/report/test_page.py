"""The page: it says what results.json says, needs nothing from elsewhere, and its player plays."""

import json
import re
import shutil
from html.parser import HTMLParser

import pytest
from rigs import make_rig, random_rotations

from usd_tools import compare

BROWSER = shutil.which("chromium")
FLAGS = "--headless --no-sandbox --disable-gpu --no-first-run --disable-background-networking".split()


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A comparison of two small clips."""
    there = tmp_path_factory.mktemp("page")
    for seed, name in enumerate(("walk", "run & jump")):
        make_rig(there / f"{name}.usda", codes=range(24), rotations=random_rotations(24, 3, seed, size=0.5))
    words = ["--rates", ".4", ".2", "--schemes", "constant", "linear", "slerp"]
    clips = [str(there / "walk.usda"), str(there / "run & jump.usda")]
    assert compare.main([*clips, "-o", str(there / "out"), *words]) == 0
    return there / "out"


class Page(HTMLParser):
    """What a page loads, the text of its tables, and its scripts."""

    def __init__(self, text):
        super().__init__()
        self.loads, self.cells, self.scripts, self._inside = [], [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        if tag not in ("meta", "link", "img", "input", "br"):
            self._inside.append(tag)
        self.loads += [value for name, value in attributes if name in ("src", "href", "srcset", "action", "data")]
        if tag == "script":
            self.scripts.append("")

    def handle_endtag(self, tag):
        while self._inside and self._inside.pop() != tag:
            pass

    def handle_data(self, text):
        if "script" in self._inside:
            self.scripts[-1] += text
        elif "td" in self._inside:
            self.cells.append(text.strip())


@pytest.fixture(scope="module")
def page(folder):
    return Page((folder / "index.html").read_text(encoding="utf-8"))


def test_loads_nothing(folder, page):
    assert page.loads and all(value.startswith("data:") for value in page.loads)
    head = (folder / "index.html").read_text(encoding="utf-8").partition("</head>")[0]
    assert "default-src 'none'" in head
    assert not re.search(r"url\(|@import", head)


def test_tables_say_what_the_results_say(folder, page):
    for row in json.loads((folder / "results.json").read_text())["rows"]:
        assert f"{row['q_hyb']:.4g}" in page.cells
        assert f"{row['mean_location_cm']:.4g}" in page.cells
    assert {"walk", "run___jump"} <= set(page.cells)


def test_sentences_have_spaces_between_them(folder):
    text = (folder / "index.html").read_text(encoding="utf-8")
    paragraphs = re.findall(r"<p>(.*?)</p>", text.partition("<script")[0], re.DOTALL)
    assert len(paragraphs) == 3
    assert not [each for each in paragraphs if re.search(r"[.)][A-Z]", each)]


def test_player_has_every_clip_rate_and_scheme(page):
    data = json.loads(page.scripts[0])
    assert [clip["name"] for clip in data["clips"]] == ["walk", "run___jump"]
    for clip in data["clips"]:
        assert [each["rate"] for each in clip["rates"]] == [0.4, 0.2]
        for each in clip["rates"]:
            assert [scheme["word"] for scheme in each["schemes"]] == ["constant", "linear", "slerp"]
            assert all(scheme["errors"][key] == 0.0 for scheme in each["schemes"] for key in each["keys"])


@pytest.fixture
def browser():
    sync_api = pytest.importorskip("playwright.sync_api")
    if BROWSER is None:
        pytest.skip("there is no chromium: apt-get install chromium")
    with sync_api.sync_playwright() as playwright:
        # its own --headless would be another browser, which Debian does not have
        chromium = playwright.chromium.launch(executable_path=BROWSER, headless=False, args=FLAGS)
        yield chromium
        chromium.close()


@pytest.mark.slow
def test_player_plays(folder, browser, tmp_path):
    tab = browser.new_page(viewport={"width": 1280, "height": 900})
    errors, requests = [], []
    tab.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
    tab.on("pageerror", lambda error: errors.append(str(error)))
    tab.on("request", lambda request: requests.append(request.url))
    tab.goto((folder / "index.html").as_uri())
    tab.wait_for_function("document.getElementById('clock').textContent")
    assert tab.evaluate("document.querySelectorAll('#stage canvas').length") > 0

    def points(trace):
        return tab.evaluate(f"Array.from(document.getElementById('stage').data[{trace}].x)")

    # the first trace is the floor, the second the original, then come the schemes
    tab.evaluate("scrubTo = (f) => { const s = document.getElementById('scrub'); s.value = f; "
                 "s.dispatchEvent(new Event('input')) }")  # fmt: skip
    tab.evaluate("scrubTo(0)")
    tab.wait_for_function("document.getElementById('clock').textContent.startsWith('frame 0,')")
    tab.wait_for_timeout(500)
    first = points(1)
    assert points(4) == pytest.approx([x if x is not None else None for x in first], abs=1e-3)
    before = tab.locator("#stage").screenshot()
    tab.click("#play")
    tab.wait_for_timeout(700)
    tab.click("#play")
    tab.wait_for_timeout(300)
    assert points(1) != first
    assert tab.text_content("#play") == "Play"
    assert tab.locator("#stage").screenshot() != before

    tab.click("#rates button >> text=20 %")
    tab.select_option("#clip", "run___jump")
    tab.wait_for_timeout(500)
    assert tab.get_attribute("#rates button >> text=20 %", "aria-pressed") == "true"
    box = tab.locator("#legend input").nth(1)
    box.check()
    tab.wait_for_timeout(300)
    assert tab.evaluate("document.getElementById('stage').data[2].visible") is True
    box.uncheck()
    tab.wait_for_timeout(300)
    assert tab.evaluate("document.getElementById('stage').data[2].visible") is False

    eye = "JSON.stringify(document.getElementById('stage')._fullLayout.scene._scene.getCamera().eye)"
    old_eye = tab.evaluate(eye)
    stage = tab.locator("#stage").bounding_box()
    x, y = stage["x"] + stage["width"] / 2, stage["y"] + stage["height"] / 2
    for step in range(100):  # drag until a frame is drawn: software rendering may take a second for one
        tab.mouse.move(x + 5 * (step % 20), y + step % 20)
        tab.mouse.down()
        tab.wait_for_timeout(100)
        if tab.evaluate(eye) != old_eye:
            break
    tab.mouse.up()
    assert tab.evaluate(eye) != old_eye

    tab.screenshot(path=tmp_path / "page.png", full_page=True)
    assert (tmp_path / "page.png").stat().st_size > 10_000
    assert errors == []
    assert [url for url in requests if not url.startswith(("file:", "data:", "blob:"))] == []
