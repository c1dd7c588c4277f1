"""What a report says, on the screen."""

from collections.abc import Iterator
from typing import ClassVar

from rich.console import Console, ConsoleOptions, JustifyMethod, RenderableType, RenderResult
from rich.markdown import Markdown, MarkdownElement, TableDataElement, TableElement
from rich.measure import Measurement
from rich.table import Column, Table
from rich.text import Text

_ENDLESS = 10_000  # characters; no cell is as long
_LEAST = 8  # characters of a column with the space beside it; fewer hold no number


class _WholeCell(TableDataElement):
    """A cell that goes on in the next line where its column is too narrow: a number that is cut is another number."""

    def __init__(self, justify: JustifyMethod) -> None:
        super().__init__(justify)
        self.content = Text("", justify=justify, overflow="fold")


class _ReadableTable(TableElement):
    """A table, or a sentence in place of one that has more columns than the screen has room for.

    Rich narrows the widest column first, and cuts names of effects in two. Here words stay whole where all columns'
    longest ones have room side by side; what is left goes to the columns whose cells take several lines.
    """

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        columns = len(self.header.row.cells) if self.header and self.header.row else 0
        if columns * _LEAST > options.max_width:
            yield Text(f"\nA table of {columns} columns, too wide for this screen: see the report in the run folder.")
            return
        for table in super().__rich_console__(console, options):
            if isinstance(table, Table):
                _keep_words(table, console, options)
            yield table


def _keep_words(table: Table, console: Console, options: ConsoleOptions) -> None:
    """Give a table's columns widths that cut no word, where the screen has room for that."""
    free = options.update_width(_ENDLESS)
    sizes = [[Measurement.get(console, free, cell) for cell in _cells(column)] for column in table.columns]
    least, most = ([max(getattr(size, end) for size in each) for each in sizes] for end in ("minimum", "maximum"))
    room = options.max_width - (Measurement.get(console, free, table).maximum - sum(most)) - sum(least)
    wanted = [long - short for long, short in zip(most, least, strict=True)]
    if not 0 <= room < sum(wanted):
        return
    for column, short, more in zip(table.columns, least, wanted, strict=True):
        column.width = short + room * more // sum(wanted)


def _cells(column: Column) -> Iterator[RenderableType]:
    yield column.header
    yield from column.cells


class ScreenMarkdown(Markdown):
    """Markdown for a terminal, whose tables keep every digit however narrow it is."""

    elements: ClassVar[dict[str, type[MarkdownElement]]] = {
        **Markdown.elements,
        "table_open": _ReadableTable,
        "th_open": _WholeCell,
        "td_open": _WholeCell,
    }
