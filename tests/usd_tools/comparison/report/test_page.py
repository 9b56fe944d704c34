"""The page: it says what results.json says, needs nothing from elsewhere, and its player plays."""

import json
import re
from html.parser import HTMLParser

import pytest
from chromium import opened
from real_files import real_file
from rigs import make_rig, random_rotations

from usd_tools import compare


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
    """Return what a page loads, the text of its tables, and its scripts."""

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


def until(tab, condition, seconds=20.0):
    """Wait by asking, for the page allows no script that is text."""
    for _ in range(int(10 * seconds)):
        if tab.evaluate(condition):
            return
        tab.wait_for_timeout(100)
    raise AssertionError(f"never: {condition}")


def scrub(tab, frame):
    tab.evaluate(
        f"{{ const s = document.getElementById('scrub'); s.value = {frame}; s.dispatchEvent(new Event('input')) }}"
    )
    until(tab, f"document.getElementById('stage').dataset.frame === '{frame}'")


def names(tab):
    return tab.locator("#names span").all_text_contents()


@pytest.mark.slow
def test_player_plays(folder, tmp_path):
    with opened((folder / "index.html").as_uri(), 1280, 1000) as (tab, problems):
        until(tab, "document.getElementById('stage').dataset.frame")
        stage = tab.locator("#stage")
        tab.uncheck("#follow")
        scrub(tab, 0)
        assert tab.text_content("#clock").startswith("frame 0,")
        assert names(tab) == ["original", "linear", "slerp"]
        assert tab.locator("#legend output").all_text_contents() == ["", "0.0 cm", "0.0 cm", "0.0 cm"]
        assert tab.locator("#errors polyline").count() == 2
        before = stage.screenshot()
        tab.click("#play")
        until(tab, "Number(document.getElementById('stage').dataset.frame) > 2")
        tab.click("#play")
        assert tab.text_content("#play") == "Play"
        scrub(tab, 5)
        assert stage.screenshot() != before
        scrub(tab, 0)
        assert stage.screenshot() == before

        tab.click("#rates button >> text=20 %")
        tab.select_option("#clip", "run___jump")
        until(tab, "document.querySelectorAll('#keys b').length === 5")
        assert tab.get_attribute("#rates button >> text=20 %", "aria-pressed") == "true"
        box = tab.locator("#legend input").nth(1)
        box.check()
        until(tab, "document.getElementById('names').dataset.words === 'original,constant,linear,slerp'")
        assert tab.locator("#errors polyline").count() == 3
        box.uncheck()
        until(tab, "document.getElementById('names').dataset.words === 'original,linear,slerp'")
        for each in tab.locator("#legend input").all():
            each.uncheck()
        until(tab, "document.getElementById('names').dataset.words === ''")
        assert tab.locator("#errors polyline").count() == 0
        tab.locator("#legend input").nth(0).check()
        tab.locator("#legend input").nth(3).check()
        until(tab, "document.getElementById('names').dataset.words === 'original,slerp'")
        tab.select_option("#layout", "overlaid")
        until(tab, "document.getElementById('names').dataset.words === ''")

        curves = tab.locator("#errors svg").bounding_box()
        tab.mouse.click(curves["x"] + 0.5 * curves["width"], curves["y"] + 20)
        until(tab, "['11', '12'].includes(document.getElementById('stage').dataset.frame)")
        assert "slerp" in tab.text_content("#errors output") and "constant" not in tab.text_content("#errors output")

        before, place = stage.screenshot(), stage.bounding_box()
        x, y = place["x"] + place["width"] / 2, place["y"] + place["height"] / 2
        tab.mouse.move(x, y)
        tab.mouse.down()
        tab.mouse.move(x + 120, y + 20, steps=5)
        tab.mouse.up()
        tab.wait_for_timeout(500)
        assert stage.screenshot() != before

        tab.screenshot(path=tmp_path / "page.png", full_page=True)
        assert (tmp_path / "page.png").stat().st_size > 10_000
        assert problems == []


@pytest.mark.slow
def test_a_skin_is_shown_in_its_colours_or_as_bones(tmp_path):
    clip = real_file("usd/mayausd_HIK_Export.usda")
    words = ["--rates", ".1", "--schemes", "slerp"]
    assert compare.main([str(clip), "-o", str(tmp_path / "out"), *words]) == 0
    page = tmp_path / "out" / "index.html"
    assert page.stat().st_size < 1_500_000
    with opened(page.as_uri(), 1280, 1000) as (tab, problems):
        until(tab, "document.getElementById('stage').dataset.frame")
        stage, seen = tab.locator("#stage"), set()
        for colors, body in (("file", "skin"), ("schemes", "skin"), ("schemes", "bones")):
            tab.select_option("#colors", colors)
            tab.select_option("#body", body)
            tab.wait_for_timeout(500)
            seen.add(stage.screenshot())
        assert len(seen) == 3
        assert problems == []
