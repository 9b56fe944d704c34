"""Tables and counts on stdout: as wide as the terminal, and where there is none, nothing is cut off."""

from __future__ import annotations

import sys
from collections.abc import Sequence


def show(title: str, rows: Sequence[Sequence[str]], header: Sequence[str] = ()) -> None:
    """Print a table.

    Parameters
    ----------
    title : str
    rows : sequence of sequences of str
        Where a row is too long, words go to the next line; only names in the first column, or in the last of a table
        without header, are broken.
    header : sequence of str
        Optional, default: none.
    """
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table

    console = Console(width=None if sys.stdout.isatty() else 10_000, highlight=False)
    console.print(escape(title))
    table = Table(show_header=bool(header))
    n_columns = len(header) or max(map(len, rows), default=0)
    breakable = 0 if header else n_columns - 1
    for i in range(n_columns):
        cells = [*header[i : i + 1], *(row[i] for row in rows if i < len(row))]
        words = [word for cell in cells for word in (cell.split() if header else [cell])]
        least = None if i == breakable else max(map(len, words), default=0)
        table.add_column(escape(header[i]) if header else "", min_width=least, overflow="fold")
    for row in rows:
        table.add_row(*map(escape, row))
    console.print(table)


def counted(number: float, thing: str) -> str:
    """Say how many there are of a thing, whose plural ends in s."""
    return f"{number if isinstance(number, int) else format(number, 'g')} {thing}{'' if number == 1 else 's'}"
