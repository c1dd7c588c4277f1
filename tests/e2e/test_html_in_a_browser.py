"""`report.html` in a real browser: every figure is drawn, and nothing is complained of."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import plotly.graph_objects as go
import pytest
from html_pages import figures

from dr_lab.html.document import Chapter, Fold, Text, write_document
from dr_lab.html.figure import Plot, chart
from dr_lab.html.gap_page import write_gap_page
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import Overlay
from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import from_plain
from dr_lab.reports.tables import table

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


_PRINTS = """<script>
addEventListener("load", () => setTimeout(() => {
  const told = document.body.dataset, main = document.querySelector("main");
  const canvases = [...document.querySelectorAll(".canvas")], folds = [...document.querySelectorAll("details")];
  const wide = () => canvases.filter((each) => each.scrollWidth > each.clientWidth).length;
  dispatchEvent(new Event("beforeprint"));
  told.paper = [main.clientWidth, main.scrollWidth, folds.filter((each) => !each.open).length, wide()];
  told.ink = getComputedStyle(document.body).color;
  told.tallest = Math.max(...canvases.map((each) => each.getBoundingClientRect().height));
  dispatchEvent(new Event("afterprint"));
  setTimeout(() => {
    told.screen = [canvases.filter((each) => each.style.getPropertyValue("--scale")).length, wide()];
    told.folded = folds.filter((each) => !each.open).length;
  }, 3000);
}, 3000));
</script>"""


def browse(path: Path, *options: str) -> subprocess.CompletedProcess[str]:
    """A page in the browser, twenty seconds later as it takes them."""
    command = [str(CHROMIUM), "--headless=new", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr"]
    command += [f"--user-data-dir={path.parent / 'profile'}", "--virtual-time-budget=20000", *options, path.as_uri()]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)


def drawn(height: int, *, half: bool = False) -> Plot:
    """A figure of a height, px."""
    figure = chart()
    figure.add_trace(go.Scatter(x=[0.0, 1.0], y=[0.0, 1.0], name="line"))
    return Plot(figure, height, "What is seen.", half=half)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_every_figure_is_drawn_and_nothing_is_complained_of(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, look: Look
) -> None:
    path = tmp_path / "report.html"
    close_report["ladder"][1]["effects"] = ["<b>effect</b>@arm"]
    write_gap_page(path, from_plain(GapReport, close_report), [overlay], look)
    done = browse(path, "--window-size=1200,9000", "--dump-dom")
    assert "CONSOLE" not in done.stderr
    canvases = re.findall(r'<div class="canvas js-plotly-plot"', done.stdout)
    assert len(canvases) == len(figures(path.read_text("utf-8"))) > 4
    assert "&lt;b&gt;effect&lt;/b&gt;@arm" in done.stdout  # of the axis, as it was typed


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
@pytest.mark.parametrize("width", [420, 1280])
def test_on_paper_all_is_open_and_fits_and_afterwards_the_screen_is_as_before(tmp_path: Path, width: int) -> None:
    path = tmp_path / "report.html"
    wide = table([f"recording_{k}" for k in range(20)], [[f"0.0012{k}" for k in range(20)]])
    halves = [drawn(300, half=True), drawn(300, half=True)]
    folds = [Fold("Folded", [Fold("Folded twice", [drawn(300), *halves])])]
    write_document(path, "Title", "", [Chapter("First", [drawn(3000), Text(wide), *folds])])
    path.write_text(path.read_text("utf-8").replace("</body>", f"{_PRINTS}</body>"), "utf-8")
    done = browse(path, f"--window-size={width},900", "--dump-dom")
    told = dict(re.findall(r'data-(paper|ink|tallest|screen|folded)="([^"]*)"', done.stdout))
    assert told["paper"] == "686,686,0,0"  # as wide as the sheet, nothing wider, no fold closed, no figure cut
    assert told["ink"] == "rgb(0, 0, 0)"
    assert float(told["tallest"]) < 1032  # px between the margins of A4
    assert told["screen"] == "0,0"
    assert told["folded"] == "2"


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_a_report_takes_few_pages_of_a4(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, look: Look
) -> None:
    path = tmp_path / "report.html"
    write_gap_page(path, from_plain(GapReport, close_report), [overlay], look)
    browse(path, "--no-pdf-header-footer", f"--print-to-pdf={tmp_path / 'report.pdf'}")
    pages = re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", (tmp_path / "report.pdf").read_bytes())
    assert {(round(float(x)), round(float(y))) for x, y in pages} == {(595, 842)}
    assert 2 < len(pages) < 7
