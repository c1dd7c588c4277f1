"""Tables on a terminal that is too narrow for them."""

import io
import re
from collections.abc import Sequence

from rich.console import Console

from dr_lab.reports.screen import ScreenMarkdown
from dr_lab.reports.tables import table


def shown(header: Sequence[str], row: Sequence[str], width: int) -> list[str]:
    console = Console(width=width, file=io.StringIO(), record=True)
    console.print(ScreenMarkdown(table(header, [row])))
    lines = console.export_text().splitlines()
    assert all(len(line) <= width for line in lines)
    return lines


def test_a_number_keeps_its_digits_however_narrow_the_screen_is() -> None:
    names = ["median", "arm.mass [kg]", "pole.mass [kg]", "arm.damping [N·m·s/rad]", "pole.damping [N·m·s/rad]"]
    lines = shown(names, ["284.1", "0.1136", "0.03477", "8.642e-5", "0.0009811"], 40)
    below = "".join(lines[next(k for k, line in enumerate(lines) if "─" in line) + 1 :])
    assert "…" not in below
    assert len(re.sub(r"\s", "", below)) == len("284.10.11360.034778.642e-50.0009811")


def test_more_columns_than_the_screen_has_room_for_are_told_in_a_sentence() -> None:
    """A column of one character a line is no table."""
    lines = shown([f"setting {k}" for k in range(22)], ["0.1234"] * 22, 80)
    assert [line.strip() for line in lines if line.strip()] == [
        "A table of 22 columns, too wide for this screen: see the report in the run",
        "folder.",
    ]


def test_a_name_stays_whole_where_the_longest_words_of_all_columns_have_room() -> None:
    header = ["model", "χ²", "predicted RMSE tilt.position [rad]", "predicted RMSE roll.position [m]"]
    row = ["+ load_dependent_friction@tilt", "36.07", "0.00264", "0.00475"]
    lines = shown(header, row, 72)
    assert any("load_dependent_friction@tilt" in line for line in lines)
    assert any("tilt.position" in line for line in lines)
    assert not any("load_dependent_friction@tilt" in line for line in shown(header, row, 40))  # there is no room
