"""`report.html` in a real browser: every figure is drawn, and nothing is complained of."""

import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from html_pages import figures

from dr_lab.html.gap_page import write_gap_page
from dr_lab.recorders.look import Look
from dr_lab.recorders.overlay import Overlay
from dr_lab.reports.gap import GapReport
from dr_lab.reports.plain import from_plain

CHROMIUM = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium is installed")
def test_every_figure_is_drawn_and_nothing_is_complained_of(
    tmp_path: Path, close_report: dict[str, Any], overlay: Overlay, look: Look
) -> None:
    path = tmp_path / "report.html"
    close_report["ladder"][1]["effects"] = ["<b>effect</b>@arm"]
    write_gap_page(path, from_plain(GapReport, close_report), [overlay], look)
    options = ["--headless=new", "--no-sandbox", "--disable-gpu", "--enable-logging=stderr", "--window-size=1200,9000"]
    command = [str(CHROMIUM), *options, f"--user-data-dir={tmp_path / 'profile'}", "--virtual-time-budget=20000"]
    done = subprocess.run(
        [*command, "--dump-dom", path.as_uri()], capture_output=True, text=True, timeout=120, check=True
    )
    assert "CONSOLE" not in done.stderr
    drawn = re.findall(r'<div class="canvas js-plotly-plot"', done.stdout)
    assert len(drawn) == len(figures(path.read_text("utf-8"))) > 4
    assert "&lt;b&gt;effect&lt;/b&gt;@arm" in done.stdout  # of the axis, as it was typed
