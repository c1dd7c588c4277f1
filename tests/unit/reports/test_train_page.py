"""What the page of a training run says of it."""

from dataclasses import replace

import pytest
from written_runs import train_report

from dr_lab.reports.plain import from_plain
from dr_lab.reports.train import TrainReport
from dr_lab.reports.train_page import train_page


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.31, "0.3 s"), (9.94, "9.9 s"), (9.96, "10 s"), (64.4, "64 s"), (0.0, "0.0 s")]
)
def test_short_trainings_are_told_in_tenths_of_seconds(seconds: float, said: str) -> None:
    report = replace(from_plain(TrainReport, train_report(12.0, {})), frames=4096, seconds=seconds, iterations=1)
    assert f"Trained for 4096 control steps in {said}, 1 iteration." in train_page(report).lead
