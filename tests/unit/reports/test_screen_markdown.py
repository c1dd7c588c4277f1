"""Tables on a terminal that is too narrow for them."""

import io
import re

from rich.console import Console

from dr_lab.reports.screen import ScreenMarkdown
from dr_lab.reports.tables import table


def test_a_number_keeps_its_digits_however_narrow_the_screen_is() -> None:
    names = ["median", "arm.mass [kg]", "pole.mass [kg]", "arm.damping [N·m·s/rad]", "pole.damping [N·m·s/rad]"]
    console = Console(width=40, file=io.StringIO(), record=True)
    console.print(ScreenMarkdown(table(names, [["284.1", "0.1136", "0.03477", "8.642e-5", "0.0009811"]])))
    lines = console.export_text().splitlines()
    assert all(len(line) <= 40 for line in lines)
    below = "".join(lines[next(k for k, line in enumerate(lines) if "─" in line) + 1 :])
    assert "…" not in below
    assert len(re.sub(r"\s", "", below)) == len("284.10.11360.034778.642e-50.0009811")
