"""Names from files on a terminal: shown, never obeyed."""

import unicodedata

import pytest

from usd_tools.console.text import did_you_mean, listed, printable


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("hips\x1b[31m", r"hips\x1b[31m"),
        ("a\nb\rc\td", r"a\nb\rc\td"),
        ("\x9b1m\x7f\x00", r"\x9b1m\x7f\x00"),  # the C1 controls too: terminals take \x9b for ESC [
        ("\u202egnp.exe", r"\u202egnp.exe"),
        ("\u2066a\u2069\u200f", r"\u2066a\u2069\u200f"),
        ("a\u2028b\u2029", r"a\u2028b\u2029"),
        ("\udcff", r"\udcff"),  # how Python reads a file name that is not UTF-8
        ("\U000e0041", r"\U000e0041"),
    ],
)
def test_what_a_terminal_would_obey_is_escaped(text, shown):
    assert printable(text) == shown
    assert printable(shown) == shown


def test_every_letter_stays():
    for text in ("Gelenk_Hüfte", "関節　腰", "می\u200cخواهم", "क्\u200dष", "👩\u200d🚀", "a b", "", r"C:\new"):
        assert printable(text) == text


def test_no_control_and_no_direction_is_left_of_all_characters():
    every = "".join(map(chr, range(0x110000)))
    left = set(map(unicodedata.category, set(printable(every)) - set("\u200c\u200d")))
    assert not left & {"Cc", "Cf", "Cs", "Zl", "Zp"}
    printable(every).encode()


def test_suggestions():
    schemes = ("slerp", "squad", "geodesic", "geodesic-spline")
    assert did_you_mean("geodsic", schemes) == "; did you mean geodesic?"
    assert did_you_mean("Geodesic-Spline", schemes) == "; did you mean geodesic-spline?"
    assert did_you_mean("bezier", schemes) == ""
    assert did_you_mean("hipps", ("Hips", "Spine")) == "; did you mean Hips?"


def test_alternatives():
    assert [listed(words) for words in (["a"], ["a", "b"], ["a", "b", "c"])] == ["a", "a or b", "a, b or c"]
