"""Spikes go, physics stays."""

import numpy as np
import pytest

from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.glitches import drop_glitches
from dr_lab.measurements.noise import estimate_noise
from dr_lab.trajectory import Array, Signal

COUNT = 2 * np.pi / 2048


def braked_pendulum(rate: float, impact: bool = False) -> tuple[Array, Array, Array]:
    """A pendulum under Coulomb friction (its acceleration jumps at every reversal), integrated in steps of 0.1 ms.

    With `impact` it bounces at 0.4 rad.
    """
    step, every = 1e-4, round(1e4 / rate)
    angle, speed = 1.5, 0.0
    rows = []
    for i in range(60_000):
        if i % every == 0:
            rows.append((i * step, angle, speed))
        driven = speed - 60 * np.sin(angle) * step
        speed = float(np.sign(driven)) * max(abs(driven) - 6.0 * step, 0.0)
        angle += step * speed
        if impact and angle < 0.4 and speed < 0:
            speed = -0.7 * speed
    time, angles, speeds = np.array(rows).T
    return time, angles, speeds


def removed(time: Array, value: Array, contract: DataContract) -> set[int]:
    noise = estimate_noise([Signal("q", "rad", time, value)], 0.05, contract)
    kept = drop_glitches("q", time, value, noise.std, 0.05, contract).time
    return set(np.flatnonzero(~np.isin(time, kept)).tolist())


@pytest.mark.parametrize("seed", range(5))
def test_spikes_of_twenty_sigma_go_and_nothing_else(contract: DataContract, seed: int) -> None:
    rng = np.random.default_rng(seed)
    time, angle, speed = braked_pendulum(500.0)
    for value, std in ((angle, 2e-3), (speed, 2e-2)):
        spiked = value + std * rng.normal(size=len(time))
        places = 5 + 8 * rng.choice(len(time) // 8 - 2, 20, replace=False)
        spiked[places] += 20 * std * rng.choice([-1, 1], 20)
        assert removed(time, spiked, contract) == set(places.tolist())


def test_neighbouring_spikes_go(contract: DataContract) -> None:
    time, angle, _ = braked_pendulum(500.0)
    spiked = angle + 1e-3 * np.random.default_rng(0).normal(size=len(time))
    spiked[[1000, 1003]] += 0.1
    spiked[[2000, 2002]] -= [0.1, 0.2]
    assert removed(time, spiked, contract) == {1000, 1003, 2000, 2002}


@pytest.mark.parametrize("impact", [False, True])
@pytest.mark.parametrize("rate", [100.0, 250.0, 500.0, 1000.0])
def test_clean_encoders_reversals_and_impacts_stay(contract: DataContract, rate: float, impact: bool) -> None:
    time, angle, speed = braked_pendulum(rate, impact)
    rng = np.random.default_rng(0)
    encoder = COUNT * np.round(angle / COUNT)
    clean = {
        "encoder": encoder,
        "difference of an encoder": np.gradient(encoder, time),
        "position": angle + 1e-5 * rng.normal(size=len(time)),
        "velocity": speed + 1e-3 * rng.normal(size=len(time)),
        "noisy velocity": speed + 1e-2 * rng.normal(size=len(time)),
    }
    assert {name: removed(time, value, contract) for name, value in clean.items()} == {name: set() for name in clean}


def test_notes_count_and_place_them(contract: DataContract) -> None:
    time, angle, _ = braked_pendulum(500.0)
    angle[[500, 900]] += 0.5
    (note,) = drop_glitches("arm.position", time, angle, 1e-3, 0.05, contract).notes
    assert (note.kind, note.signal, note.count) == ("glitches", "arm.position", 2)
    assert note.message == "arm.position: 2 glitches were removed, the first at 1 s."


def test_too_many_are_reported_and_left(contract: DataContract) -> None:
    time, angle, _ = braked_pendulum(500.0)
    angle[10::50] += 0.5
    cleaned = drop_glitches("q", time, angle, 1e-3, 0.05, contract)
    assert len(cleaned.time) == len(time)
    assert "too many to be accidents; none was removed" in cleaned.notes[0].message


def test_short_signals_pass(contract: DataContract) -> None:
    time = np.arange(4.0)
    assert len(drop_glitches("q", time, np.array([0.0, 9.0, 0.0, 9.0]), 1e-3, 5.0, contract).time) == 4
