"""Reading `report.html` in tests: its figures, its text, and whether it is well formed."""

import base64
import html
import json
import re
from html.parser import HTMLParser
from typing import Any

import numpy as np

_VOID = ("meta", "br", "img", "hr", "input", "link")


def figures(page: str) -> list[dict[str, Any]]:
    """Every figure as Plotly gets it."""
    return [json.loads(text) for text in re.findall(r'<script type="application/json">(.*?)</script>', page, re.S)]


def traces(page: str, name: str) -> list[dict[str, Any]]:
    """Every trace of a name, from all figures."""
    return [trace for figure in figures(page) for trace in figure["data"] if trace.get("name") == name]


def values(column: object) -> np.ndarray:
    """A column of a trace, whether it is a list or packed."""
    if not isinstance(column, dict):
        return np.array(column)
    found = np.frombuffer(base64.b64decode(column["bdata"]), dtype=np.dtype(column["dtype"]))
    return found.reshape([int(n) for n in column["shape"].split(",")]) if "shape" in column else found


def text(page: str) -> str:
    """What a reader sees beside the figures."""
    body = re.sub(r"<(script|style)\b.*?</\1>", "", page, flags=re.S)
    return html.unescape(re.sub(r"\s+", " ", re.sub(r"<[^>]+>", " ", body)))


class _Balance(HTMLParser):
    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.names: list[str] = []
        self.sources: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.names.append(tag)
        self.sources += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "data", "action")]
        if tag not in _VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def require_whole(page: str) -> None:
    """Tags are balanced, no script is there but the page's own, and nothing is fetched from anywhere."""
    parser = _Balance()
    parser.feed(page)
    parser.close()
    assert not parser.open
    own = len(re.findall(r'<script type="application/json">', page))
    assert parser.names.count("script") == own + 2  # the library and what draws
    assert all(source.startswith("#") for source in parser.sources)
    assert "://" not in re.sub(r'<script type="application/json">.*?</script>', "", page.replace(_library(page), ""))
    assert "@import" not in page
    assert "url(" not in page


def _library(page: str) -> str:
    return re.findall(r'id="library">(.*?)</script>', page, re.S)[0]
