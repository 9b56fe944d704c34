"""Tables on stdout: as wide as the terminal, and where there is none, one line per row."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from usd_tools.console.text import printable

if TYPE_CHECKING:
    from rich.table import Table

_EDGES = 3
"""Characters that a column takes beside its text: a space on each side and a line; the table takes one more."""


def show(title: str, rows: Sequence[Sequence[str]], header: Sequence[str] = ()) -> None:
    """Print a table in which no word is broken, unless it alone is wider than the terminal.

    Parameters
    ----------
    title : str
    rows : sequence of sequences of str
        Where the terminal is narrow, long cells go on in the next line; where not even the longest words have room,
        a table with a header is printed as one block per row.
    header : sequence of str
        Optional, default: none.
    """
    from rich.console import Console
    from rich.text import Text

    console = Console(width=None if sys.stdout.isatty() else 10_000, highlight=False)
    console.print(Text(printable(title)))
    top = [printable(name) for name in header]
    n_columns = len(top) or max(map(len, rows), default=0)
    cells = [[*map(printable, row), *[""] * (n_columns - len(row))] for row in rows]
    widths = _widths([top, *cells] if top else cells, console.width)
    if top and sum(widths) + _EDGES * n_columns + 1 > console.width:
        console.print(_blocks(cells, top, console.width))
        return
    table = _table(top, widths)
    for row in cells:
        table.add_row(*map(Text, row))
    console.print(table)


def _table(header: Sequence[str], widths: Sequence[int]) -> Table:
    from rich.table import Table
    from rich.text import Text

    table = Table(show_header=bool(header))
    for i, width in enumerate(widths):
        table.add_column(Text(header[i]) if header else "", width=width, overflow="fold")
    return table


def _blocks(rows: Sequence[Sequence[str]], header: Sequence[str], room: int) -> Table:
    """Stand each row upright: a line for each column that has something there."""
    from rich.text import Text

    blocks = [[pair for pair in zip(header, row, strict=True) if pair[1]] for row in rows]
    table = _table((), _widths([pair for block in blocks for pair in block], room))
    for block in blocks:
        for pair in block:
            table.add_row(*map(Text, pair), end_section=pair is block[-1])
    return table


def _widths(rows: Sequence[Sequence[str]], room: int) -> list[int]:
    """Choose the widths of columns: no less than their longest words, and no more than they need."""
    from rich.cells import cell_len

    columns = list(zip(*rows, strict=True))
    least = [max(cell_len(word) for cell in column for word in cell.split() or [""]) for column in columns]
    whole = [max(map(cell_len, column)) for column in columns]
    widths, left = list(least), room - 1 - _EDGES * len(columns) - sum(least)
    if len(columns) == 2 and left < 0:  # names that no line can hold are broken
        return [whole[0], max(1, room - 1 - _EDGES * 2 - whole[0])]
    for n_done, i in enumerate(sorted(range(len(columns)), key=lambda i: whole[i] - least[i])):
        more = max(0, min(whole[i] - least[i], left // (len(columns) - n_done)))
        widths[i] += more
        left -= more
    return widths
