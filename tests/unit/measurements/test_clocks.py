"""Known offset and drift come back from messages with one-sided delays."""

from pathlib import Path

import numpy as np
import pytest

from dr_lab.errors import DataError
from dr_lab.measurements.clocks import ClockLine, describe, fit_line, pool, require_rate, steps
from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.mcap import McapSource
from dr_lab.measurements.signal_map import channel_map
from dr_lab.recorders.mcap import JointStates, write_mcap
from dr_lab.trajectory import Array

TRUE = ClockLine(offset=0.25, drift=40e-6)


def messages(rng: np.random.Generator, duration: float = 6.0, rate: float = 500.0) -> tuple[Array, Array]:
    """Stamps on the true line, logged after an exponential delay of 0.5 ms on average."""
    elapsed = np.linspace(0.0, duration, int(duration * rate))
    return elapsed, TRUE.to_log(elapsed) + rng.exponential(0.5e-3, len(elapsed))


@pytest.mark.parametrize("seed", range(5))
def test_offset_and_drift_are_those_of_the_lower_envelope(contract: DataContract, seed: int) -> None:
    elapsed, log = messages(np.random.default_rng(seed))
    line = fit_line(elapsed, log, contract)
    assert (line.to_log(elapsed) <= log + 1e-12).all()
    # The mean delay is 500 µs: a least-squares line would be off by that much.
    np.testing.assert_allclose(line.to_log(elapsed), TRUE.to_log(elapsed), atol=10e-6)
    assert line.drift == pytest.approx(TRUE.drift, abs=2e-6)


def test_late_bursts_do_not_move_the_line(contract: DataContract) -> None:
    rng = np.random.default_rng(0)
    elapsed, log = messages(rng)
    log[1000:1600] += rng.uniform(0.0, 0.05, 600)
    line = fit_line(elapsed, log, contract)
    np.testing.assert_allclose(line.to_log(elapsed), TRUE.to_log(elapsed), atol=10e-6)


def test_a_few_stamps_from_the_future_are_left_out(contract: DataContract) -> None:
    elapsed, log = messages(np.random.default_rng(0))
    log[[700, 2100]] -= 0.3
    line = fit_line(elapsed, log, contract)
    np.testing.assert_allclose(line.to_log(elapsed), TRUE.to_log(elapsed), atol=20e-6)


def test_equal_clocks_give_exactly_nothing(contract: DataContract) -> None:
    elapsed = np.linspace(0.0, 10.0, 5000)
    assert fit_line(elapsed, elapsed, contract) == ClockLine(0.0, 0.0)


def test_one_message_gives_an_offset(contract: DataContract) -> None:
    assert fit_line(np.array([0.0]), np.array([3.5]), contract) == ClockLine(3.5, 0.0)


def test_description_is_at_the_first_sample_and_counts_the_clocks_zero(contract: DataContract) -> None:
    elapsed, log = messages(np.random.default_rng(0))
    found = describe("header", elapsed + 2.0, log, ClockLine(TRUE.offset - 2.0, 0.0), zero=100.0)
    assert found.clock == "header"
    assert found.offset == pytest.approx(TRUE.offset - 102.0)
    # Median absolute deviation of an exponential delay of mean 1: 0.4812.
    line = fit_line(elapsed, log, contract)
    assert describe("header", elapsed, log, line, 0.0).jitter == pytest.approx(0.4812 * 0.5e-3, rel=0.05)


def test_topics_of_one_clock_share_a_line_and_others_do_not(contract: DataContract) -> None:
    rng = np.random.default_rng(3)
    fast, slow = messages(rng), messages(rng, rate=50.0)
    slow = slow[0], slow[1] + 0.8e-3
    other = messages(rng)[0], messages(rng)[1] + 7.0
    stamps = {"/fast": fast, "/slow": slow, "/other": other}
    lines = pool({topic: fit_line(*pair, contract) for topic, pair in stamps.items()}, stamps, contract)
    assert lines["/fast"] == lines["/slow"]
    assert lines["/fast"].offset == pytest.approx(TRUE.offset, abs=20e-6)
    assert lines["/other"].offset == pytest.approx(TRUE.offset + 7.0, abs=20e-6)


def test_a_clock_that_was_set_is_reported(contract: DataContract) -> None:
    elapsed, log = messages(np.random.default_rng(0))
    assert steps("/imu", elapsed, log, fit_line(elapsed, log, contract), contract) == []
    log[1500:] += 0.2
    notes = steps("/imu", elapsed, log, fit_line(elapsed, log, contract), contract)
    assert [note.kind for note in notes] == ["clock"]
    assert "/imu leaves a straight line by" in notes[0].message


def test_clocks_of_computers_are_taken_and_set_ones_too(contract: DataContract) -> None:
    elapsed, log = messages(np.random.default_rng(0))
    require_rate("/imu", elapsed, log, contract)
    require_rate("/imu", elapsed, np.where(elapsed > 1.5, log + 2.0, log), contract)
    require_rate("/imu", np.array([0.0]), np.array([3.5]), contract)
    require_rate("/imu", elapsed, np.zeros_like(log), contract)


@pytest.mark.parametrize("seed", range(20))
@pytest.mark.parametrize("bunch", [0.0, 0.1])
def test_late_and_bunched_messages_of_a_short_log_are_taken(contract: DataContract, seed: int, bunch: float) -> None:
    elapsed = np.linspace(0.0, 1.0, 100)
    log = elapsed + np.random.default_rng(seed).exponential(5e-3, len(elapsed))
    require_rate("/imu", elapsed, np.ceil(log / bunch) * bunch if bunch else np.sort(log), contract)


@pytest.mark.parametrize(("rate", "told"), [(0.5, "0.5 times as fast"), (2.0, "2 times as fast"), (-1.0, "backwards")])
def test_stamps_of_another_rate_are_refused(contract: DataContract, rate: float, told: str) -> None:
    elapsed, log = messages(np.random.default_rng(0))
    with pytest.raises(DataError, match=f"header stamps of /imu run {told}.*clock: log"):
        require_rate("/imu", rate * elapsed, log, contract)


def test_a_topic_whose_headers_nobody_set_takes_no_digits_from_the_others(tmp_path: Path) -> None:
    time = 1.7e9 + np.linspace(0.0, 2.0, 500)
    topics = [
        JointStates(topic, ("arm",), stamp, time, np.sin(time)[:, None])
        for topic, stamp in {"/unset": 0.0 * time, "/set": time - 20.0}.items()
    ]
    write_mcap(tmp_path / "a.mcap", topics, {}, {})
    source = McapSource(tmp_path / "a.mcap")
    entries = ({"topic": topic.topic, "field": "position[arm]", "unit": "rad"} for topic in topics)
    _, found = (source.samples(channel_map("arm.position", entry, "")).stamps["header"] for entry in entries)
    assert found.elapsed[0] == 0.0
    assert found.zero == pytest.approx(-20.0, abs=1e-6)
