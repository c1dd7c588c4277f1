"""What the bench records: the truth's spread, clocks, jitter, quantisation, determinism."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.errors import ConfigError
from dr_lab.plants.bench import Bench, Recording
from dr_lab.plants.truth import truth

HIDDEN = sorted(p.stem for p in (Path(__file__).parents[3] / "conf" / "plant" / "hidden").glob("*.yaml"))
COUNT = 2 * np.pi / 2048


def bench(*overrides: str, duration: float = 2.0, logs: int = 1) -> Bench:
    made: Bench = instantiate(compose("record", overrides).plant, _convert_="all")
    return replace(made, duration=duration, peaks=made.peaks[:logs])


def only(made: Bench, seed: int = 1) -> Recording:
    (recording,) = made.recordings(seed)
    return recording


def equal(first: Recording, second: Recording) -> bool:
    return all(np.array_equal(a, vars(second)[name]) for name, a in vars(first).items())


def test_the_seed_decides_everything() -> None:
    made = bench(duration=0.5, logs=2)
    once, again, other = (list(made.recordings(seed)) for seed in (1, 1, 2))
    assert [r.name for r in once] == ["log_1", "log_2"]
    assert all(equal(a, b) for a, b in zip(once, again, strict=True))
    assert not np.array_equal(once[0].command, once[1].command)
    assert not np.array_equal(once[0].command, other[0].command)
    assert truth(made, 1) == truth(made, 1) != truth(made, 2)


def test_a_bench_without_logs_or_samples_is_refused() -> None:
    with pytest.raises(ConfigError, match="peak"):
        bench(logs=0)
    with pytest.raises(ConfigError, match="two samples"):
        bench(duration=0.005)
    with pytest.raises(ConfigError, match="at least 0"):
        only(bench(), seed=-1)


def test_more_logs_do_not_change_the_first() -> None:
    assert equal(only(bench(duration=0.5)), next(bench(duration=0.5, logs=6).recordings(1)))


def test_true_parameters_lie_within_the_spread_and_fill_it() -> None:
    nominal = bench().nominal
    values = np.array([list(nominal.true_values(seed).values()) for seed in range(200)])
    share = values / list(nominal.documented().values()) - 1
    assert np.abs(share).max() <= 0.15
    assert np.ptp(share, axis=0).min() > 0.28
    assert np.abs(np.corrcoef(share.T) - np.eye(4)).max() < 0.25


def test_clock_offset_and_drift_can_be_recovered_from_the_stamps() -> None:
    made = bench(duration=6.0)
    recording, clock = only(made), made.clock(1)
    late = recording.arrival - recording.stamp
    # The smallest delays of the first and the last second span the lower edge of all of them.
    early, final = late[:500], late[-500:]
    at = recording.stamp[[int(early.argmin()), len(late) - 500 + int(final.argmin())]]
    drift = -(final.min() - early.min()) / (at[1] - at[0])
    offset = made.instruments.transport_latency - early.min()
    assert drift == pytest.approx(clock.drift, abs=3e-6)
    assert offset == pytest.approx(clock.offset, abs=1e-5)
    assert 20.0 < clock.offset < 60.0
    assert np.mean(late - late.min()) == pytest.approx(4e-4, rel=0.3)


def test_stamps_and_commands_jitter_as_documented() -> None:
    recording = only(bench(duration=6.0))
    assert np.std(np.diff(recording.stamp)) == pytest.approx(5e-5 * 2**0.5, rel=0.1)
    interval = np.diff(recording.command_time)
    assert 2e-5 < np.std(interval) < 1.2e-4
    assert np.abs(interval - 0.004).max() <= 2.01e-4
    assert (np.diff(recording.arrival) > 0).all()
    assert np.abs(recording.command).max() <= 6.0


def test_encoders_round_to_counts_and_exact_instruments_do_not() -> None:
    rounded, exact = only(bench()), only(bench("plant/instruments=exact"))
    counts = rounded.position / COUNT
    np.testing.assert_allclose(counts, np.rint(counts), rtol=0, atol=1e-9)
    error = rounded.position - exact.position
    assert np.abs(error).max() <= COUNT / 2 * (1 + 1e-9)
    assert np.std(error[200:]) == pytest.approx(COUNT / 12**0.5, rel=0.1)
    np.testing.assert_array_equal(rounded.command_time, exact.command_time)
    np.testing.assert_array_equal(rounded.command, exact.command)
    np.testing.assert_allclose(exact.arrival - exact.stamp, 1e-3, rtol=0, atol=5e-7)


def test_a_late_encoder_reads_the_same_motion_later() -> None:
    late = bench("plant/instruments=exact", "plant/hidden=sensor_time_offset_pole", duration=1.0)
    plain = bench("plant/instruments=exact", duration=1.0)
    read, true = only(late), only(plain)
    np.testing.assert_allclose(read.position[:, 0], true.position[:, 0], rtol=0, atol=1e-9)
    shifted = np.interp(read.stamp - 0.008, true.stamp, true.position[:, 1])
    np.testing.assert_allclose(read.position[10:, 1], shifted[10:], rtol=0, atol=1e-3)
    assert np.abs(read.position - true.position).max() > 0.01


@pytest.mark.parametrize("option", [name for name in HIDDEN if name != "none"])
def test_every_hidden_effect_shows_above_the_encoder_count(option: str) -> None:
    with_it = only(bench("plant/instruments=exact", f"plant/hidden={option}"))
    without = only(bench("plant/instruments=exact"))
    assert np.abs(with_it.position - without.position).max() > COUNT
    label = bench(f"plant/hidden={option}").hidden.label
    effect, _, site = label.partition("@")
    assert option in (effect, f"{effect}_{site}")
    assert site
