"""Commands in README.md and the documentation are accepted by the programs."""

import pytest
from commands import PAGES, blocks, calls, parser_of

CALLS = [(path.name, *call) for path in PAGES for call in calls(path)]


def test_pages_have_commands():
    assert {verb for _, verb, _ in CALLS} >= {"upsample", "learn", "downsample", "compare", "inspect", "from_bvh"}


@pytest.mark.parametrize(("page", "verb", "arguments"), CALLS, ids=[f"{page}-{verb}" for page, verb, _ in CALLS])
def test_parsers_take_it(page, verb, arguments):
    parser_of(verb).parse_args(arguments)


def test_python_of_the_readme_runs():
    (example,) = blocks(PAGES[0], "python")
    found = {}
    exec(compile(example, "README.md", "exec"), found)
    assert found["middle"].shape == (1, 24, 3, 3)
    assert found["length"] > 0.0
