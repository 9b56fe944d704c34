"""Every name that docs/api.rst promises is there."""

import re
from importlib import import_module

import pytest
from commands import ROOT

from usd_tools.__main__ import VERBS

PAGE = (ROOT / "docs" / "api.rst").read_text("utf-8")
NAMES = re.findall(r"^\.\. auto(?:class|function|data|exception|method):: (\S+)$", PAGE, re.MULTILINE)


def resolve(name):
    """Import the longest part of a dotted name that is a module, and return the attribute after it."""
    words = name.split(".")
    for count in range(len(words) - 1, 0, -1):
        try:
            found = import_module(".".join(words[:count]))
        except ModuleNotFoundError:
            continue
        for word in words[count:]:
            found = getattr(found, word)
        return found
    return getattr(import_module("geomstats_anim"), name)


@pytest.mark.parametrize("name", NAMES)
def test_the_name_is_there_and_documented(name):
    found = resolve(name)
    assert isinstance(found, dict) or found.__doc__


def test_all_public_names_are_promised():
    import geomstats_anim

    assert {name for name in geomstats_anim.__all__ if name != "__version__"} <= {name.split(".")[-1] for name in NAMES}


@pytest.mark.parametrize("verb", VERBS)
def test_all_names_of_the_verbs_are_promised(verb):
    module = import_module(f"usd_tools.{verb}")
    names = {name for name in getattr(module, "__all__", ()) if name not in ("main", "parser")}
    assert {f"usd_tools.{verb}.{name}" for name in names} <= set(NAMES)
