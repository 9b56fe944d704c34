"""Sphinx directive that writes down the command lines of usd_tools, each from its own parser: ``.. verbs::``."""

from __future__ import annotations

import argparse
import re
from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.util.docutils import SphinxDirective

import usd_tools
from usd_tools.__main__ import VERBS

_FOLDER = Path(usd_tools.__file__).parent
_WIDTH = 84
_LONGEST = 42
_UNDESCRIBED = (argparse._HelpAction, argparse._SubParsersAction)


def _marked_up(text: str) -> str:
    """Mark options and names of modules in plain text as code, and let the rest be plain."""
    plain = re.sub(r"([\\*`|_])", r"\\\1", text)
    return re.sub(r"(?<![\w-])(--[\w-]+|usd\\_tools\.\w+|'[^']*[=:\[][^']*')", _as_code, plain)


def _as_code(found: re.Match[str]) -> str:
    return f"``{found[0].replace(chr(92), '').strip(chr(39))}``"


def _described(action: argparse.Action, parse: argparse.ArgumentParser) -> Iterator[str]:
    """Yield the lines of reStructuredText for one argument."""
    value = ""
    if action.nargs != 0:
        value = action.metavar or (_choices(action) if action.choices else action.dest)
        value = f"{value} [{value} ...]" if action.nargs == "+" else value
    if action.option_strings:
        yield f".. option:: {', '.join(f'{option} {value}'.strip() for option in action.option_strings)}"
    else:
        yield f".. option:: {value}"
    yield ""
    formatter = parse._get_formatter()
    text = formatter._expand_help(action) if action.help else ""
    yield f"   {_marked_up(text[:1].upper() + text[1:])}."
    if action.choices and action.metavar:
        words = [f"``{word}``" for word in action.choices]
        yield f"   {action.metavar} is {', '.join(words[:-1])} or {words[-1]}."
    yield ""


def _choices(action: argparse.Action) -> str:
    return f"{{{','.join(map(str, action.choices or ()))}}}"


def _shorten(parse: argparse.ArgumentParser) -> None:
    """Name what has too many choices for one line."""
    for action in parse._actions:
        if action.choices and not action.metavar and len(_choices(action)) > _LONGEST:
            action.metavar = action.dest.upper()


class Verbs(SphinxDirective):
    """A section for each command line: what it does, its usage, its arguments."""

    has_content = False

    def run(self) -> list[nodes.Node]:
        """Make the sections."""
        lines = [line for verb in VERBS for line in self._section(verb)]
        node = nodes.section()
        node.document = self.state.document
        self.state.nested_parse(StringList(lines, "verbs"), 0, node, match_titles=1)
        for verb in VERBS:
            self.env.note_dependency(str(_FOLDER / f"{verb}.py"))
        return node.children

    def _section(self, verb: str) -> Iterator[str]:
        parse: argparse.ArgumentParser = import_module(f"usd_tools.{verb}").parser(f"geomstats-anim {verb}")
        yield from self._command(verb, parse, "-")
        for action in parse._actions:
            if isinstance(action, argparse._SubParsersAction):
                for word, each in action.choices.items():
                    yield from self._command(f"{verb} {word}", each, "~")

    def _command(self, verb: str, parse: argparse.ArgumentParser, underline: str) -> Iterator[str]:
        _shorten(parse)
        parse.formatter_class = lambda prog: argparse.HelpFormatter(prog, width=_WIDTH)
        label = verb.replace(" ", "-")
        yield from (f".. _{label}:", "", verb, underline * len(verb), "", f".. program:: {verb}", "")
        yield from (_marked_up(parse.description or ""), "", ".. code-block:: text", "")
        yield from (f"   {line}" for line in parse.format_usage().removeprefix("usage: ").splitlines())
        yield ""
        for group in parse._action_groups:
            actions: Iterable[Any] = [a for a in group._group_actions if not isinstance(a, _UNDESCRIBED)]
            if actions and group.title not in ("positional arguments", "options"):
                yield from (f"**{group.title}.** {_marked_up(group.description or '')}", "")
            for action in actions:
                yield from _described(action, parse)
        yield from (_marked_up(parse.epilog or ""), "")


def setup(app: Any) -> dict[str, bool]:
    """Add the directive."""
    app.add_directive("verbs", Verbs)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
