"""What the page of a training run says of it."""

from dataclasses import replace

import pytest
from written_runs import train_report

from dr_lab.reports.plain import from_plain
from dr_lab.reports.train import ChoiceEntry, SnapshotEntry, TrainReport
from dr_lab.reports.train_page import train_page


@pytest.mark.parametrize(
    ("seconds", "said"), [(0.31, "0.3 s"), (9.94, "9.9 s"), (9.96, "10 s"), (64.4, "64 s"), (0.0, "0.0 s")]
)
def test_short_trainings_are_told_in_tenths_of_seconds(seconds: float, said: str) -> None:
    report = replace(from_plain(TrainReport, train_report(12.0, {})), frames=4096, seconds=seconds, iterations=1)
    assert f"Trained for 4096 control steps in {said}, 1 iteration." in train_page(report).lead


def test_the_first_sentence_names_the_policy_even_where_its_return_is_unknown() -> None:
    choice = ChoiceEntry((SnapshotEntry(320, None),), 320, 1600, "policy.pt")
    report = replace(from_plain(TrainReport, train_report(12.0, {})), choice=choice, deployed_return=None)
    assert train_page(report).lead.startswith("The deployed policy is that of control step 320. The episodes that")


def test_the_return_of_the_best_of_several_is_said_to_be_flattered() -> None:
    choice = ChoiceEntry((SnapshotEntry(100, 3.0), SnapshotEntry(200, 9.0)), 200, 3200, "policy.pt")
    report = replace(from_plain(TrainReport, train_report(12.0, {})), choice=choice, deployed_return=9.0)
    assert (
        "3200 control steps in all, are no part of the training, and make the best of 2 seem somewhat better"
        in train_page(report).lead
    )
