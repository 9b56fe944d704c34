"""Wherever bytes stand beside those of ACL, it is said that it does something else: single poses, in nanoseconds."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").glob("*.rst"))]
PROGRAMS = sorted((ROOT / "benchmarks").glob("bench_*.py"))
HEADING = re.compile(r"^(?:#+ .*|- (?=[`A-Z]).*|[^\n]+\n[-=~]{3,})$", re.MULTILINE)


def sections(path):
    """Part a page at its headings, the list of changes at its entries; a program is one section."""
    text = path.read_text()
    starts = [] if path.suffix == ".py" else [match.start() for match in HEADING.finditer(text)]
    return [text[a:b] for a, b in zip([0, *starts], [*starts, len(text)], strict=True)]


@pytest.mark.parametrize("path", PAGES + PROGRAMS, ids=lambda path: path.name)
def test_sections_that_name_acl_say_what_it_is_for(path):
    unsaid = [section for section in sections(path) if re.search(r"\bACL\b", section) and "nanoseconds" not in section]
    assert unsaid == []


def test_sections_are_found():
    named = [section for path in PAGES for section in sections(path) if "nanoseconds" in section]
    assert len(named) >= 6 and all(len(section) < 5000 for section in named)
