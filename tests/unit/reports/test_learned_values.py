"""Parameters of a report whose last model has a learned force."""

from copy import deepcopy
from typing import Any

import pytest

from dr_lab.reports.gap import GapReport
from dr_lab.reports.markdown import report_markdown
from dr_lab.reports.plain import from_plain


@pytest.mark.parametrize("learned", [True, False])
def test_values_are_those_of_the_model_that_is_named(close_report: dict[str, Any], *, learned: bool) -> None:
    """Beside a learned force the named effects give a part of what they do to it."""
    last = close_report["ladder"][-1]
    (name,) = (each for each in last["parameters"] if "@" in each)
    beside = deepcopy(last) | {"effects": [*last["effects"], "residual_force@arm"], "learned": True}
    last["parameters"][name]["value"], beside["parameters"][name]["value"] = 0.0123, 0.0456
    ladder = [*close_report["ladder"], *([beside] if learned else [])]
    told = report_markdown(from_plain(GapReport, close_report | {"ladder": ladder}))
    section = told.split("## Parameters")[1].split("##")[0]
    assert "0.0123" in section
    assert "0.0456" not in section
    assert ("Beside `residual_force@arm`, as model=from_run has it, they have other values" in section) == learned
