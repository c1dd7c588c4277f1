"""`report.html`: one file that opens offline, follows the reader's light or dark theme, and prints well."""

import base64
import gzip
import html
import importlib.resources
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from markdown_it import MarkdownIt

from dr_lab.files import write_text
from dr_lab.html.figure import Plot

# A page fetches nothing, and a text that looks like a link is text.
_MARKDOWN = MarkdownIt("commonmark", {"html": False}).enable("table").disable(["image", "link", "autolink"])
_LIBRARY = "package_data/plotly.min.js"


@dataclass(frozen=True)
class Text:
    """Markdown, in which HTML is no markup but text.

    Attributes:
        markdown: what is said.
        half: whether two stand side by side where there is room.
    """

    markdown: str
    half: bool = False


@dataclass(frozen=True)
class Fold:
    """What is closed until the reader opens it; it is open on paper."""

    title: str
    parts: Sequence["Part"]


Part = Text | Plot | Fold


@dataclass(frozen=True)
class Chapter:
    """Plots and text below one heading; without any part it is left out."""

    title: str
    parts: Sequence[Part]


def write_document(path: Path, title: str, lead: str, chapters: Sequence[Chapter]) -> None:
    """Write the file, atomically. Everything it needs is in it; nothing is fetched.

    Args:
        path: the file, by custom ``report.html``.
        title: its heading.
        lead: Markdown of what a reader wants to know first.
        chapters: what follows.

    Raises:
        DrLabError: the folder cannot be written to.
    """
    write_text(path, document(title, lead, [chapter for chapter in chapters if chapter.parts]))


def document(title: str, lead: str, chapters: Sequence[Chapter]) -> str:
    """The file's text; see `write_document`."""
    named = [(f"part-{index}", chapter) for index, chapter in enumerate(chapters)]
    links = "".join(f'<a href="#{name}">{html.escape(c.title)}</a>' for name, c in named if c.title)
    body = "".join(_chapter(name, chapter) for name, chapter in named)
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n<title>{html.escape(title)}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<style>\n{_resource('page.css')}</style>\n"
        f'<style id="paper" media="print">\n{_resource("paper.css")}</style>\n</head>\n'
        f"<body>\n<header><h1>{html.escape(title)}</h1>\n"
        f'<div class="lead">{_rendered(lead)}</div>\n<nav>{links}</nav></header>\n<main>\n{body}</main>\n'
        "<noscript><p>The plots need JavaScript; text and tables do not.</p></noscript>\n"
        f'<script type="application/gzip" id="library">{_library()}</script>\n'
        f"<script>\n{_resource('page.js')}</script>\n</body>\n</html>\n"
    )


def _chapter(name: str, chapter: Chapter) -> str:
    heading = f"<h2>{html.escape(chapter.title)}</h2>\n" if chapter.title else ""
    return f'<section id="{name}">\n{heading}{_parts(chapter.parts)}</section>\n'


def _parts(parts: Sequence[Part]) -> str:
    return f'<div class="parts">\n{"".join(_part(part) for part in parts)}</div>\n'


def _part(part: Part) -> str:
    match part:
        case Text():
            kind = "text half" if part.half else "text"
            return f'<div class="{kind}">{_rendered(part.markdown)}</div>\n'
        case Fold():
            return f"<details><summary>{html.escape(part.title)}</summary>\n{_parts(part.parts)}</details>\n"
        case Plot():
            return _plot(part)


def _plot(plot: Plot) -> str:
    caption = f"<figcaption>{html.escape(plot.caption)}</figcaption>" if plot.caption else ""
    kind = "plot half" if plot.half else "plot"
    return (
        f'<figure class="{kind}"><div class="canvas" style="height:{plot.height}px"></div>{caption}'
        f'<script type="application/json">{plot.json()}</script></figure>\n'
    )


def _rendered(markdown: str) -> str:
    """HTML in which no line ends between a number and its percent sign."""
    return _MARKDOWN.render(re.sub(r"(?<=\d) %", "\u00a0%", markdown))


def _resource(name: str) -> str:
    return (importlib.resources.files("dr_lab.html") / name).read_text("utf-8")


@cache
def _library() -> str:
    """Plotly's JavaScript, compressed to a third: its bytes are most of the file's."""
    source = (importlib.resources.files("plotly") / _LIBRARY).read_bytes()
    return base64.encodebytes(gzip.compress(source, mtime=0)).decode()
