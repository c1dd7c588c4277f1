"""What a report says, on the screen."""

from typing import ClassVar

from rich.console import Console, ConsoleOptions, JustifyMethod, RenderResult
from rich.markdown import Markdown, MarkdownElement, TableDataElement, TableElement
from rich.text import Text

_LEAST = 8  # characters of a column with the space beside it; fewer hold no number


class _WholeCell(TableDataElement):
    """A cell that goes on in the next line where its column is too narrow: a number that is cut is another number."""

    def __init__(self, justify: JustifyMethod) -> None:
        super().__init__(justify)
        self.content = Text("", justify=justify, overflow="fold")


class _ReadableTable(TableElement):
    """A table, or a sentence in place of one that has more columns than the screen has room for."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        columns = len(self.header.row.cells) if self.header and self.header.row else 0
        if columns * _LEAST <= options.max_width:
            yield from super().__rich_console__(console, options)
        else:
            yield Text(f"\nA table of {columns} columns, too wide for this screen: see the report in the run folder.")


class ScreenMarkdown(Markdown):
    """Markdown for a terminal, whose tables keep every digit however narrow it is."""

    elements: ClassVar[dict[str, type[MarkdownElement]]] = {
        **Markdown.elements,
        "table_open": _ReadableTable,
        "th_open": _WholeCell,
        "td_open": _WholeCell,
    }
