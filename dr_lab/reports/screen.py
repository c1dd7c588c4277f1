"""What a report says, on the screen."""

from typing import ClassVar

from rich.console import JustifyMethod
from rich.markdown import Markdown, MarkdownElement, TableDataElement
from rich.text import Text


class _WholeCell(TableDataElement):
    """A cell that goes on in the next line where its column is too narrow: a number that is cut is another number."""

    def __init__(self, justify: JustifyMethod) -> None:
        super().__init__(justify)
        self.content = Text("", justify=justify, overflow="fold")


class ScreenMarkdown(Markdown):
    """Markdown for a terminal, whose tables keep every digit however narrow it is."""

    elements: ClassVar[dict[str, type[MarkdownElement]]] = {
        **Markdown.elements,
        "th_open": _WholeCell,
        "td_open": _WholeCell,
    }
