import numpy as np
import pytest
from diagnosis_machines import evidence_settings
from scipy.stats import t as student

from dr_lab.diagnosis.evidence.intervals import interval, least_between_logs, resampled

SETTINGS = evidence_settings()


def test_of_equal_logs_the_bound_is_that_of_students_mean() -> None:
    sums = np.array([3.0, 5.0, 4.0, 8.0])
    values, log = np.repeat(sums / 5, 5), np.repeat(np.arange(4), 5)
    half = float(student.isf(0.01, 3)) * sums.std(ddof=1) / np.sqrt(4)
    assert least_between_logs(values, log, 0.01, SETTINGS) == pytest.approx(4 * (sums.mean() - half))


def test_logs_that_gain_alike_in_each_window_scatter_not_at_all_however_long_they_are() -> None:
    log = np.repeat([0, 1, 2], [2, 5, 9])
    assert least_between_logs(np.full(16, 2.0), log, 0.01, SETTINGS) == pytest.approx(32.0)


def test_two_logs_show_no_scatter() -> None:
    assert least_between_logs(np.arange(4.0), np.array([0, 0, 1, 1]), 0.01, SETTINGS) == np.inf


def test_bounds_hold_where_errors_are_alike_all_over_a_log() -> None:
    rng, trials, logs, windows = np.random.default_rng(3), 400, 6, 12
    log = np.repeat(np.arange(logs), windows)
    apart, within = 0, 0
    for _ in range(trials):
        values = rng.normal(size=logs)[log] + rng.normal(size=logs * windows)  # 0 is to be expected
        apart += least_between_logs(values, log, 0.01, SETTINGS) <= 0
        drawn = resampled(values[None], log, SETTINGS)[0]
        within += interval(float(values.sum()), drawn, logs * 4, 0.01, SETTINGS)[0] <= 0
    assert apart / trials >= 0.98
    assert within / trials < 0.95  # blocks alone claim too much
