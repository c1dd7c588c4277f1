"""The messages in the source, with … for what is filled in: what the questions of faq.md quote."""

import ast
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

FILLED = "…"
_QUOTED = re.compile(r"^### `(.+)`$", re.MULTILINE)


def quoted(page: Path) -> list[str]:
    """The messages that a page's headings quote.

    Args:
        page: faq.md.
    """
    return _QUOTED.findall(page.read_text(encoding="utf-8"))


def templates(package: Path) -> list[str]:
    """Every text in the source of a package, with `FILLED` where a value goes.

    Args:
        package: its folder.
    """
    trees = (ast.parse(path.read_text(encoding="utf-8")) for path in sorted(package.rglob("*.py")))
    return [text for tree in trees for text in _texts(tree)]


def said(message: str, texts: Iterable[str]) -> bool:
    """Whether the fixed parts of a quoted message stand in one of the texts, in their order.

    Args:
        message: as quoted.
        texts: as `templates` gives them.
    """
    parts = (re.escape(part.strip()) for part in message.split(FILLED))
    pattern = re.compile(".*".join(part for part in parts if part), re.DOTALL)
    return any(pattern.search(text) for text in texts)


def _texts(tree: ast.AST) -> Iterator[str]:
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str):
            yield node.value
        elif isinstance(node, ast.JoinedStr):
            parts = (part.value if isinstance(part, ast.Constant) else FILLED for part in node.values)
            yield "".join(str(part) for part in parts)
