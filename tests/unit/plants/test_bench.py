"""What the bench records: the truth's spread, clocks, jitter, quantisation, determinism."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.cli.compose import compose
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.rig import Rig, RigRecording
from dr_lab.plants.truth import truth

FOLDER = Path(__file__).parents[3] / "conf" / "plant" / "hidden"
EVERY = sorted({str(p.relative_to(FOLDER).with_suffix("")) for p in FOLDER.rglob("*.yaml")} - {"none"})
HIDDEN = [option for option in EVERY if not option.startswith("general/")]  # those leave site and size to the user
COUNT = 2 * np.pi / 2048


def bench(*overrides: str, duration: float = 2.0, logs: int = 1) -> Rig:
    made: Rig = instantiate(compose("record", overrides).plant, _convert_="all")
    return replace(made, duration=duration, peaks=made.peaks[:logs])


def only(made: Rig, seed: int = 1) -> RigRecording:
    (recording,) = made.recordings(seed)
    return recording


def equal(first: RigRecording, second: RigRecording) -> bool:
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


def test_a_slide_is_counted_along_its_way() -> None:
    cart = only(bench("plant=cartpole", duration=0.5)).position[:, 0] / (0.0932 / 2048)
    np.testing.assert_allclose(cart, np.rint(cart), rtol=0, atol=1e-9)
    assert np.ptp(cart) > 10


def test_names_that_the_machine_does_not_have_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="pole"):
        replace(bench(), start={"pol": 1.0})
    with pytest.raises(UnknownNameError, match="motor"):
        replace(bench(), shares={"pole": 1.0})


def test_a_biased_encoder_reads_beside_the_truth() -> None:
    made, motion = plain("pendulum")
    read = only(replace(made, hidden=hidden("pendulum/sensor_bias")))
    np.testing.assert_allclose(read.position - motion.position, 0.04, rtol=0, atol=1e-12)


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
    late = bench("plant/instruments=exact", "plant/hidden=furuta/sensor_time_offset_pole", duration=1.0)
    plain = bench("plant/instruments=exact", duration=1.0)
    read, true = only(late), only(plain)
    np.testing.assert_allclose(read.position[:, 0], true.position[:, 0], rtol=0, atol=1e-9)
    shifted = np.interp(read.stamp - 0.008, true.stamp, true.position[:, 1])
    np.testing.assert_allclose(read.position[10:, 1], shifted[10:], rtol=0, atol=1e-3)
    assert np.abs(read.position - true.position).max() > 0.01


def settings(option: str) -> dict[str, Any]:
    """What Hydra makes of an option, without composing all else around it."""
    node: Any = OmegaConf.to_container(OmegaConf.load(FOLDER / f"{option}.yaml"))
    parts = {key: part for entry in node.pop("defaults", []) for key, part in entry.items()}
    return node | {key.rpartition("@")[2]: settings(part) for key, part in parts.items()}


def hidden(option: str) -> HiddenEffect:
    return instantiate(settings(option), _convert_="all")


@cache
def plain(machine: str) -> tuple[Rig, RigRecording]:
    made = bench(f"plant={machine}", "plant/instruments=exact", duration=0.6)
    return made, only(made)


@pytest.mark.parametrize("option", HIDDEN)
def test_every_hidden_effect_shows_above_the_encoder_count(option: str) -> None:
    without, motion = plain(option.partition("/")[0])
    made = replace(without, hidden=hidden(option))
    counts = np.array([made.travel.get(joint, 2 * np.pi) / 2048 for joint in made.joints])
    assert (np.abs(only(made).position - motion.position) / counts).max() > 1
    sites = {*made.joints, *made.actuators, *made.documented.bodies, "world"}
    named = []
    for label in made.hidden.label.split(" + "):
        effect, _, site = label.partition("@")
        assert site in sites
        named.append((effect, f"{effect}_{site}"))
    for part, names in zip(option.rpartition("/")[2].split("_and_"), named, strict=True):
        assert part in names
