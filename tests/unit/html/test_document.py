from pathlib import Path

import plotly.graph_objects as go
import pytest
from html_pages import figures, require_whole, text

from dr_lab.errors import DrLabError
from dr_lab.html.document import Chapter, Fold, Text, document, write_document
from dr_lab.html.figure import Plot, chart

EVIL = '<script>alert("x")</script></script><img src=x onerror=alert(1)> [go](javascript:alert(1))'


def plot(name: str) -> Plot:
    figure = chart(titles=[name])
    figure.add_trace(go.Scatter(x=[1.0, 2.0], y=[name, "b"], text=[name, ""], name=name))
    return Plot(figure, 200, caption=name)


def test_nothing_of_a_user_becomes_markup() -> None:
    page = document(
        EVIL, EVIL, [Chapter(EVIL, [Text(EVIL), plot(EVIL), Fold(EVIL, [Text(f"| a |\n|--|\n| {EVIL} |")])])]
    )
    require_whole(page)
    for tag in ("<img", "onerror=alert(1)>", "alert(1)</a>"):
        assert tag not in page
    assert 'alert("x")' in text(page)
    (figure,) = figures(page)
    assert "<" not in str(figure["data"])
    assert figure["data"][0]["name"].startswith("&lt;script&gt;")  # Plotly shows it as it was typed


def test_a_page_holds_its_parts_in_order_and_links_to_its_chapters() -> None:
    chapters = [Chapter("First", [Text("**one**")]), Chapter("", [Text("two")]), Chapter("Last", [plot("three")])]
    page = document("Title", "The answer.", chapters)
    require_whole(page)
    places = [page.index(part) for part in ("<h1>Title</h1>", "The answer.", "<strong>one</strong>", "two", "three")]
    assert places == sorted(places)
    assert '<a href="#part-0">First</a><a href="#part-2">Last</a>' in page
    assert 'id="part-2"' in page


def test_a_page_is_written_whole_and_without_empty_chapters(tmp_path: Path) -> None:
    write_document(tmp_path / "run" / "report.html", "Title", "", [Chapter("Empty", []), Chapter("Full", [Text("x")])])
    page = (tmp_path / "run" / "report.html").read_text("utf-8")
    assert "Empty" not in page
    assert "Full" in page
    (tmp_path / "file").touch()
    with pytest.raises(DrLabError, match="Cannot write"):
        write_document(tmp_path / "file" / "report.html", "Title", "", [])
