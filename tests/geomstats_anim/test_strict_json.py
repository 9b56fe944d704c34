"""JSON from strangers: parsed as it is, or refused in a sentence."""

import json

import pytest

from geomstats_anim.strict_json import DEEPEST, parse_json


@pytest.mark.parametrize("document", [None, True, 0, -1.5, 10**30, "x", [], {}, {"a": [1, {"b": None}]}, [[[1.0]]]])
def test_plain_values(document):
    assert parse_json(json.dumps(document)) == document


def test_depth():
    for text in ("[" * DEEPEST + "1" + "]" * DEEPEST, '{"a":' * DEEPEST + "1" + "}" * DEEPEST):
        assert parse_json(text) is not None
    for n in (DEEPEST + 1, 500, 100_000):
        for text in ("[" * n + "]" * n, '{"a":' * n + "1" + "}" * n):
            with pytest.raises(ValueError, match="nested more than 32 levels deep"):
                parse_json(text)


@pytest.mark.parametrize("text", ["NaN", "[Infinity]", '{"a": -Infinity}', "1e999", "[-1e400]"])
def test_numbers_that_are_not_finite(text):
    with pytest.raises(ValueError, match="which is not a finite number"):
        parse_json(text)


@pytest.mark.parametrize("text", ["", "{", "[1,]", "{'a': 1}", "\x00", "tru"])
def test_what_is_no_json(text):
    with pytest.raises(ValueError, match="This is not JSON: "):
        parse_json(text)


def test_size(monkeypatch):
    monkeypatch.setattr("geomstats_anim.strict_json.LARGEST", 10)
    assert parse_json("[1, 2, 3 ]") == [1, 2, 3]
    with pytest.raises(ValueError, match="has 11 characters; at most 10 are read"):
        parse_json("[1, 2, 3  ]")


def test_integers_with_too_many_digits():
    with pytest.raises(ValueError):
        parse_json("9" * 10_000)
