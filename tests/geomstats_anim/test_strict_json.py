"""JSON from strangers: parsed as it is, or refused in a sentence."""

import json
from pathlib import Path

import pytest

from geomstats_anim.strict_json import DEEPEST, dump_json, parse_json, read_text


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


@pytest.mark.parametrize("text", ["[" * 1000, "[" * (DEEPEST + 1), '["[",' + "[" * DEEPEST])
def test_depth_of_what_does_not_end(text):
    with pytest.raises(ValueError, match="nested more than 32 levels deep"):
        parse_json(text)


@pytest.mark.parametrize("text", ["[" * DEEPEST, '["' + "[" * 100 + r'\"[[",', "[]" * 40])
def test_what_does_not_end_and_is_not_deep(text):
    with pytest.raises(ValueError, match="This is not JSON: "):
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


def test_what_is_written_is_read_back():
    document = {"a": [1, 2.0, None, True, "x", 2**63 - 1, -(2**63)], "b": {"c": []}}
    assert parse_json(dump_json(document)) == document
    assert dump_json(document, indent=2) == json.dumps(document, indent=2)
    nested = 1
    for _ in range(DEEPEST):
        nested = [nested]
    assert parse_json(dump_json(nested)) == nested
    with pytest.raises(ValueError, match="nested more than 32 levels deep"):
        dump_json([nested])


@pytest.mark.parametrize("value", [2**63, -(2**63) - 1, 10**4000, float("nan"), float("inf"), {1, 2}, b"x", object()])
def test_what_cannot_be_written(value):
    with pytest.raises(ValueError):
        dump_json({"a": [value]})


def test_files(tmp_path, monkeypatch):
    (tmp_path / "a.json").write_bytes("é".encode())
    assert read_text(tmp_path / "a.json") == "é"
    (tmp_path / "b.json").write_bytes(b"\xff")
    with pytest.raises(ValueError, match="This file is not UTF-8 text."):
        read_text(tmp_path / "b.json")
    monkeypatch.setattr("geomstats_anim.strict_json.LARGEST", 10)
    for path in (tmp_path / "c.json", Path("/dev/zero")):
        (tmp_path / "c.json").write_bytes(b"x" * 11)
        if path.exists():
            with pytest.raises(ValueError, match="more than 10 bytes"):
                read_text(path)
