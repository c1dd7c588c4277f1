"""Each defect, put in by hand, is repaired and counted."""

import numpy as np
import pytest

from dr_lab.errors import DataError
from dr_lab.measurements.cleaning import (
    drop_not_finite,
    drop_unordered,
    find_gaps,
    find_wraps,
    longest_wait,
    period,
    unwrap,
)
from dr_lab.measurements.contract import DataContract


def test_nan_rows_go_with_a_count() -> None:
    time = np.array([0.0, 1.0, np.nan, 3.0, 4.0])
    value = np.array([[1.0, 1.0], [np.nan, 1.0], [1.0, 1.0], [1.0, np.inf], [2.0, 2.0]])
    cleaned = drop_not_finite("sensor.gyro", time, value)
    np.testing.assert_array_equal(cleaned.time, [0.0, 4.0])
    assert [(note.kind, note.count) for note in cleaned.notes] == [("nan", 3)]


def test_all_nan_is_an_error() -> None:
    with pytest.raises(DataError, match=r"Channel 'arm.position': all 3 samples are NaN"):
        drop_not_finite("arm.position", np.arange(3.0), np.full(3, np.nan))


def test_a_clock_that_was_set_back_loses_what_it_repeats() -> None:
    time = np.concatenate([np.arange(100.0), np.arange(60.0, 200.0)])
    cleaned = drop_unordered("q", time, np.arange(240.0))
    np.testing.assert_array_equal(cleaned.time, np.arange(200.0))
    np.testing.assert_array_equal(cleaned.value, np.concatenate([np.arange(100.0), np.arange(140.0, 240.0)]))
    assert [(note.kind, note.count) for note in cleaned.notes] == [("back_steps", 39), ("duplicates", 1)]
    assert "goes back by up to 39 s" in cleaned.notes[0].message


def test_a_few_samples_out_of_order_are_sorted_and_duplicates_go() -> None:
    time = np.array([0.0, 1.0, 1.0, 2.0, 1.5, 1.8, 3.0])
    cleaned = drop_unordered("q", time, np.arange(7.0))
    np.testing.assert_array_equal(cleaned.time, [0.0, 1.0, 1.5, 1.8, 2.0, 3.0])
    np.testing.assert_array_equal(cleaned.value, [0.0, 1.0, 4.0, 5.0, 3.0, 6.0])
    assert [(note.kind, note.count) for note in cleaned.notes] == [("reordered", 3), ("duplicates", 1)]


def test_of_values_that_hold_the_last_at_one_time_counts() -> None:
    """Stairs of a command whose edges are written as two rows, once with a third; a row that came late among them."""
    time = np.array([0.0, 1.0, 1.0, 2.0, 2.0, 1.5, 2.0, 3.0])
    value = np.array([0.0, 0.0, 5.0, 5.0, 7.0, 6.0, -5.0, -5.0])
    cleaned = drop_unordered("motor", time, value, held=True)
    np.testing.assert_array_equal(cleaned.time, [0.0, 1.0, 1.5, 2.0, 3.0])
    np.testing.assert_array_equal(cleaned.value, [0.0, 5.0, 6.0, -5.0, -5.0])
    duplicates = next(note for note in cleaned.notes if note.kind == "duplicates")
    assert duplicates.message == "motor: 3 samples are followed by another at the same time and were dropped."
    np.testing.assert_array_equal(drop_unordered("q", time, value).value, [0.0, 0.0, 6.0, 5.0, -5.0])


def test_clean_samples_pass_untouched() -> None:
    time = np.arange(5.0)
    assert drop_not_finite("q", time, time).notes == ()
    assert drop_unordered("q", time, time).notes == ()


def test_no_samples_are_in_order() -> None:
    for held in (False, True):
        cleaned = drop_unordered("q", np.empty(0), np.empty((0, 2)), held=held)
        assert (len(cleaned.time), cleaned.value.shape, cleaned.notes) == (0, (0, 2), ())


def test_many_gaps_ask_for_a_steady_rate(contract: DataContract) -> None:
    steady = np.arange(0.0, 10.0, 0.01)
    (rare,) = find_gaps("q", np.concatenate([steady, steady + 20.0]), contract)
    (often,) = find_gaps("q", (np.arange(30)[:, None] + 0.01 * np.arange(20)).ravel(), contract)
    assert "steady rate" not in rare.message
    assert often.message.endswith("If it is published only when it changes, have it published at a steady rate.")


def test_gaps_are_counted_in_usual_periods(contract: DataContract) -> None:
    time = np.linspace(0.0, 2.0, 1000, endpoint=False)
    time[400:] += 0.5
    time[700:] += 0.2
    (note,) = find_gaps("q", time, contract)
    assert (note.kind, note.count) == ("gap", 2)
    assert "the longest is 0.502 s at 0.798 s" in note.message


def test_bursts_do_not_shorten_the_period(contract: DataContract) -> None:
    """A network that delivers four messages at a time, every 20 ms."""
    time = (np.arange(200)[:, None] * 0.02 + np.arange(4) * 1e-5).ravel()
    assert period(time) == pytest.approx(0.005)
    assert find_gaps("q", time, contract) == ()


def test_longest_wait_takes_the_slowest_log(contract: DataContract) -> None:
    times = [np.linspace(0.0, 0.2, 101), np.linspace(0.0, 1.0, 101)]
    assert longest_wait(times, contract, on_change=False) == pytest.approx(contract.gap * 0.01)


def test_commands_sent_on_change_have_no_gaps(contract: DataContract) -> None:
    time = np.cumsum(np.random.default_rng(0).choice([0.01, 2.0], 400, p=[0.95, 0.05]))
    assert longest_wait([time], contract, on_change=True) == np.inf
    assert longest_wait([time], contract, on_change=False) < np.inf
    assert longest_wait([np.array([0.0])], contract, on_change=True) == np.inf


def test_wraps_are_undone_where_asked_and_reported_elsewhere(contract: DataContract) -> None:
    angle = np.linspace(0.0, 20.0, 500)
    wrapped = np.mod(angle + np.pi, 2 * np.pi) - np.pi
    cleaned = unwrap("pole.position", wrapped, 2 * np.pi)
    np.testing.assert_allclose(cleaned.value, angle, atol=1e-12)
    assert [(note.kind, note.count) for note in cleaned.notes] == [("wrapped", 3)]
    (note,) = find_wraps("pole.position", wrapped, contract)
    assert (note.kind, note.count) == ("wrap", 3)
    assert "set wrap: true" in note.message
    assert find_wraps("pole.position", angle, contract) == ()
    assert unwrap("pole.position", angle, 2 * np.pi).notes == ()


def test_an_angle_behind_a_gear_jumps_by_less_than_a_turn() -> None:
    angle = np.linspace(0.0, 2.0, 500)
    wrapped = np.mod(angle, 0.2 * np.pi)
    cleaned = unwrap("arm.position", wrapped, 0.2 * np.pi)
    np.testing.assert_allclose(cleaned.value, angle, atol=1e-12)
    assert [note.kind for note in cleaned.notes] == ["wrapped"]
    (note,) = unwrap("arm.position", wrapped, 2 * np.pi).notes
    assert "nothing jumps by a full turn" in note.message
    assert "wrap: JUMP" in note.message
