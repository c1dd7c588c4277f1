"""Windows that choose nothing: the last third of every log, or whole logs of a window or two."""

from typing import cast

import numpy as np
import pytest
from diagnosis_machines import pendulum, swinging, windows_of, windows_settings

from dr_lab.diagnosis.windows.folds import folds
from dr_lab.diagnosis.windows.windows import Windows


class Places:
    """Windows of which only the log and the place are known."""

    def __init__(self, log: list[int], place: np.ndarray | None = None) -> None:
        self.log = np.array(log, np.intp)
        self.place = np.arange(len(log)) if place is None else place

    def __len__(self) -> int:
        return len(self.log)

    def pick(self, rows: np.ndarray) -> "Places":
        return Places(self.log[rows].tolist(), self.place[rows])


def places(log: list[int]) -> tuple[list[int], list[int]]:
    chooses, confirms = folds(cast(Windows, Places(log)))
    told = [[] if part is None else cast(Places, part).place.tolist() for part in (chooses, confirms)]
    return told[0], told[1]


def test_the_last_third_of_every_log_chooses_nothing() -> None:
    assert places([0] * 6 + [1] * 3) == ([0, 1, 2, 3, 6, 7], [4, 5, 8])


@pytest.mark.parametrize(("log", "kept"), [([0, 1, 2, 3, 4, 5], [2, 5]), ([0, 0, 1, 1, 2], [4])])
def test_of_logs_with_a_window_or_two_every_third_chooses_nothing(log: list[int], kept: list[int]) -> None:
    assert places(log)[1] == kept


def test_two_short_logs_leave_none_to_confirm() -> None:
    assert places([0, 1]) == ([0, 1], [])


def test_both_parts_together_are_all_windows_in_their_order() -> None:
    model = pendulum()
    windows = windows_of(model, [swinging("a", model.nominal(), 0)], windows_settings())
    chooses, confirms = folds(windows)
    assert confirms is not None
    assert chooses.begin.max() < confirms.begin.min()
    np.testing.assert_array_equal(np.concatenate([chooses.begin, confirms.begin]), windows.begin)
