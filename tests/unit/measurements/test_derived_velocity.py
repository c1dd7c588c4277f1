"""Velocities that were made of the logged positions are known from those that were measured."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import butter, lfilter, savgol_filter, sosfilt

from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.derived_velocity import Derived, derived
from dr_lab.measurements.read import read
from dr_lab.trajectory import Array, MeasurementSet, Signal
from tests.unit.measurements.csv_logs import csv

PERIOD, STD, MOST = 0.002, 2e-4, 0.3


def swing(seed: int = 0, jitter: float = 0.0, count: int = 1500) -> tuple[Array, Array, Array]:
    """Times, noisy angles of two sines, and true velocities."""
    rng = np.random.default_rng(seed)
    time = PERIOD * (np.arange(count) + jitter * rng.uniform(-1, 1, count))
    angle = 0.9 * np.sin(5 * time) + 0.2 * np.sin(17 * time)
    return time, angle + STD * rng.standard_normal(count), 4.5 * np.cos(5 * time) + 3.4 * np.cos(17 * time)


def found(time: Array, angle: Array, velocity: Array) -> Derived | None:
    return derived(Signal("q.position", "rad", time, angle), Signal("q.velocity", "rad/s", time, velocity), STD, MOST)


def test_a_low_passed_difference_is_found_with_its_corner_and_delay() -> None:
    time, angle, _ = swing(jitter=0.05)
    kept = np.exp(-2 * np.pi * 30.0 * PERIOD)
    rough = np.append(0.0, np.diff(angle) / np.diff(time))
    made = found(time, angle, np.asarray(lfilter([1 - kept], [1, -kept], rough)))
    assert made is not None
    assert made.share < 1e-3
    assert made.delay == pytest.approx(PERIOD * (0.5 + kept / (1 - kept)), rel=1e-3)
    assert made.corner == pytest.approx(30.0, rel=0.03)  # of a pole at exp(-2 pi 30 Hz T); a sampled filter's is higher
    assert made.period == pytest.approx(PERIOD, rel=0.01)


def test_differences_by_the_usual_period_are_found_though_samples_come_early_and_late() -> None:
    time, angle, _ = swing(jitter=0.1)
    made = found(time, angle, np.append(0.0, np.diff(angle) / np.median(np.diff(time))))
    assert made is not None
    assert made.share < 1e-6
    assert made.delay == pytest.approx(PERIOD / 2, rel=2e-3)  # of the usual period
    assert made.corner == np.inf


@pytest.mark.parametrize("way", ["central", "five apart", "savgol", "second order"])
def test_other_ways_of_making_it_are_found(way: str) -> None:
    time, angle, _ = swing()
    rough = np.append(0.0, np.diff(angle) / PERIOD)
    velocity, delay = {
        "central": (np.gradient(angle, PERIOD), 0.0),
        "five apart": (np.append(np.zeros(5), (angle[5:] - angle[:-5]) / (5 * PERIOD)), 2.5 * PERIOD),
        "savgol": (savgol_filter(angle, 11, 2, deriv=1, delta=PERIOD), 0.0),
        "second order": (np.asarray(sosfilt(butter(2, 40.0, fs=1 / PERIOD, output="sos"), rough)), None),
    }[way]
    made = found(time, angle, velocity)
    assert made is not None
    assert made.share < 0.01
    if delay is not None:
        assert made.delay == pytest.approx(delay, abs=0.01 * PERIOD)


def test_a_velocity_in_coarse_numbers_is_still_that_difference() -> None:
    time, angle, _ = swing()
    rough = np.append(0.0, np.diff(angle) / PERIOD)  # noise of 0.14 rad/s
    made = found(time, angle, 0.024 * np.round(rough / 0.024))
    assert made is not None
    assert made.share == pytest.approx(0.024 / np.sqrt(12) / (np.sqrt(2) * STD / PERIOD), rel=0.1)


def test_a_difference_of_counts_in_whole_rpm_is_found_and_that_of_another_encoder_is_not() -> None:
    """Two samples apart a count is 1.5 rpm, so that rounding is as large as half of the noise."""
    time, rpm, made = 0.005 * np.arange(1400.0), 2 * np.pi / 60, []
    angles = [1.2 * np.sin(5 * time + phase) + 0.2 * np.sin(17 * time) for phase in (0.0, 0.0002)]
    counts = [np.floor(angle / (2 * np.pi) * 4000) for angle in angles]
    for each in counts:
        velocity = np.append([0.0, 0.0], np.round(1.5 * (each[2:] - each[:-2]))) * rpm
        place = Signal("q.position", "rad", time, counts[0] * 2 * np.pi / 4000)
        made.append(derived(place, Signal("q.velocity", "rad/s", time, velocity), 2 * np.pi / 4000 / np.sqrt(12), MOST))
    assert made[0] is not None
    assert made[0].rounded
    assert made[0].delay == pytest.approx(0.005, rel=0.05)
    assert "to within its own rounding" in made[0].note("q.position", "q.velocity").message
    assert made[1] is None


@pytest.mark.parametrize("noise", [0.0, 1e-3, 0.05])
def test_a_velocity_with_noise_of_its_own_or_none_is_kept(noise: float) -> None:
    time, angle, velocity = swing()
    assert found(time, angle, velocity + noise * np.random.default_rng(1).standard_normal(len(time))) is None


def test_a_difference_of_another_encoder_is_kept() -> None:
    time, angle, _ = swing(seed=0)
    other = swing(seed=1)[1]
    kept = np.exp(-2 * np.pi * 30.0 * PERIOD)
    assert (
        found(time, angle, np.asarray(lfilter([1 - kept], [1, -kept], np.append(0.0, np.diff(other)) / PERIOD))) is None
    )


def test_a_pause_in_the_log_hides_nothing() -> None:
    time, angle, _ = swing()
    rough = np.append(0.0, np.diff(angle) / PERIOD)  # by the drive, which saw no pause
    keep = np.ones(len(time), bool)
    keep[700:730] = False
    made = found(time[keep], angle[keep], rough[keep])
    assert made is not None
    assert made.share < 1e-6


def test_stretches_that_are_too_short_say_nothing() -> None:
    time, angle, _ = swing(count=150)
    assert found(time, angle, np.append(0.0, np.diff(angle) / PERIOD)) is None


def logs(folder: Path, contract: DataContract, *, made: bool) -> MeasurementSet:
    """Two logs of a joint whose velocity was made of its positions in the first, and in the second too or not."""
    for k in range(2):
        time, angle, velocity = swing(seed=k)
        rough = np.append(0.0, np.diff(angle) / PERIOD)
        csv(folder / f"log_{k}.csv", time=time, q=angle, v=rough if made or not k else velocity)
    outputs = {"q.position": {"column": "q", "unit": "rad"}, "q.velocity": {"column": "v", "unit": "rad/s"}}
    return read("swing", [str(folder / "*.csv")], outputs, contract, fit=["log_0"], held_out=["log_1"])


def test_reading_leaves_it_out_and_says_so(tmp_path: Path, contract: DataContract) -> None:
    measured = logs(tmp_path, contract, made=True)
    assert set(measured.noise) == set(measured.gaps) == {"q.position"}
    for log in (*measured.fit, *measured.held_out):
        assert set(log.outputs) == {"q.position"}
        (note,) = [note for note in log.notes if note.kind == "derived"]
        assert note.signal == "q.velocity"
        assert "q.velocity is the difference of q.position over samples of 2 ms" in note.message


def test_it_is_kept_where_the_contract_says_so_or_a_log_has_another(tmp_path: Path, contract: DataContract) -> None:
    for changed, made in ((replace(contract, derived=0.0), True), (contract, False)):
        measured = logs(tmp_path, changed, made=made)
        assert set(measured.noise) == {"q.position", "q.velocity"}
        assert not [note for log in measured.fit for note in log.notes if note.kind == "derived"]


def test_a_short_log_beside_a_long_one_hides_nothing(tmp_path: Path, contract: DataContract) -> None:
    for k, count in enumerate((2000, 150)):
        time, angle, _ = swing(count=count, seed=k)
        csv(tmp_path / f"log_{k}.csv", time=time, q=angle, v=np.append(0.0, np.diff(angle) / PERIOD))
    outputs = {"q.position": {"column": "q", "unit": "rad"}, "q.velocity": {"column": "v", "unit": "rad/s"}}
    measured = read("swing", [str(tmp_path / "*.csv")], outputs, contract, fit=["log_0"], held_out=["log_1"])
    assert set(measured.noise) == {"q.position"}
