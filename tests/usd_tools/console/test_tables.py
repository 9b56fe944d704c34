"""Tables on a terminal: no wider than it, and no word is lost or broken."""

import re

import pytest
from rich.cells import cell_len

from usd_tools.console.tables import show
from usd_tools.console.text import say, say_command

ROWS = [
    ("Hips/LeftUpLeg", "z (12° off)", "x", "4.25", "1, 1.5, 4.25", "own (left)", "+0.125 of 2.500"),
    ("関節", "y", "z", "1.3", "1, 1, 1.3", "parent (right)", "-0.001 of 0.400"),
    ("20 joints: do not turn",),
]
HEADER = ("joint", "stiff about", "free about", "ratio", "x, y, z", "frame", "gain over slerp")


def words(text):
    return set(re.sub(r"[│┃┏┳┓┡╇┩├┼┤└┴┘┌┬┐━─]|\x1b\[\d*m", " ", text).split())


@pytest.fixture
def printed(capsys, monkeypatch):
    """Print with some width, or without a terminal; give the output."""

    def call(printing, width=None):
        monkeypatch.setenv("COLUMNS", str(width))
        monkeypatch.setattr("sys.stdout.isatty", lambda: width is not None)
        printing()
        return capsys.readouterr().out

    return call


@pytest.mark.parametrize("width", [40, 60, 80, 200])
@pytest.mark.parametrize("header", [HEADER, ()])
def test_every_word_is_there_in_one_piece(printed, width, header):
    rows = ROWS if header else [(row[0], ", ".join(row[1:])) for row in ROWS]
    out = printed(lambda: show("What the metric means", rows, header), width)
    assert words(out) == words(printed(lambda: show("What the metric means", rows, header)))
    assert max(cell_len(re.sub(r"\x1b\[\d*m", "", line)) for line in out.splitlines()) <= width


def test_a_row_becomes_a_block_where_columns_have_no_room(printed):
    lines = printed(lambda: show("", ROWS, HEADER), 50).splitlines()
    assert [line.split("│")[1].strip() for line in lines[2:9]] == list(HEADER)
    assert not any("┃" in line for line in lines)
    assert any("┃" in line for line in printed(lambda: show("", ROWS, HEADER), 100).splitlines())


def test_only_what_no_line_can_hold_is_broken(printed):
    path = "/".join(f"joint{i}" for i in range(20))
    out = printed(lambda: show("", [(path, "1.5")], ("joint", "mean deg")), 60)
    assert path in re.sub(r"[│\s]", "", out)
    assert max(map(len, out.splitlines())) <= 60


def test_one_line_per_row_without_a_terminal(printed):
    assert len(printed(lambda: show("", ROWS, HEADER)).splitlines()) == 1 + len(ROWS) + 4


def test_names_are_neither_markup_nor_emoji_nor_escapes(printed):
    names = ("a:foot:b", "[red]x[/red]", "back\\", "esc\x1b[31m", "line\nend", "\u202e")
    for width in (None, 80):
        out = printed(lambda: show("[bold]:hand:", [(name, "1") for name in names], ("joint", "gain")), width)
        for shown in ("[bold]:hand:", "a:foot:b", "[red]x[/red]", "back\\ ", r"esc\x1b[31m", r"line\nend", r"\u202e"):
            assert shown in out


def test_sentences_break_between_words(printed):
    sentence = "/Rig/Animations/Walk: 14 of 142 samples kept; reconstruct-and-predict " * 3
    out = printed(lambda: say(f"  {sentence}"), 40)
    assert all(len(line) <= 40 and line.startswith("  ") for line in out.splitlines())
    assert out.split() == sentence.split()
    assert printed(lambda: say(sentence)) == f"{sentence}\n"


def test_commands_can_be_pasted(printed):
    command = "python -m usd_tools.upsample '/a folder/walk.usdc' -o BACK.usda --times source"
    assert printed(lambda: say_command(command), 40) == f"  {command}\n"
