"""Small pieces of Markdown: plain text, tables and code."""

import re
from collections.abc import Iterable, Sequence

_CODE = re.compile(r"(``?[^`]+``?)")


def plain(text: str) -> str:
    """Text whose signs mean themselves, apart from code between backticks.

    Args:
        text: as docstrings and comments have it.
    """
    parts = _CODE.split(text)
    return "".join(part if part.startswith("`") else re.sub(r"([<*\\$\[\]{}])", r"\\\1", part) for part in parts)


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> list[str]:
    """A table, or nothing where it has no row.

    Args:
        head: title of each column.
        rows: cells, in Markdown.
    """
    body = ["| " + " | ".join(cell.replace("|", r"\|") for cell in row) + " |" for row in rows]
    return ["| " + " | ".join(head) + " |", "|" + " --- |" * len(head), *body, ""] if body else []


def code(text: str, language: str = "text") -> list[str]:
    """A block of code.

    Args:
        text: its lines.
        language: for the colours.
    """
    return [f"````{language}", text.rstrip(), "````", ""]


def literal(text: str) -> str:
    """Code within a line; nothing stays nothing."""
    return f"`` {text} ``" if "`" in text else f"`{text}`" if text else ""
