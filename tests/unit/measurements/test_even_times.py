"""Stamps that scatter about an even clock: the motion tells whether the samples did."""

from dataclasses import replace

import numpy as np
import pytest

from dr_lab.measurements.contract import DataContract
from dr_lab.measurements.even_times import on_even_times, straightened
from dr_lab.measurements.noise import estimate_noise
from dr_lab.trajectory import Array, Log, Signal

PERIOD, COUNT, NOISE, LATE = 0.005, 2000, 1e-4, 3e-4  # s, samples, rad, s


def moving(time: Array) -> Array:
    """A swing of up to 6 rad/s, by which 0.3 ms are 18 times the noise."""
    return np.sin(6.0 * time)


def log(seed: int, *, sampled_evenly: bool) -> Log:
    rng = np.random.default_rng(seed)
    even = PERIOD * np.arange(float(COUNT))
    stamps = even + LATE * rng.standard_normal(COUNT)
    taken = even if sampled_evenly else stamps
    hinge = Signal("hinge.position", "rad", stamps, moving(taken) + NOISE * rng.standard_normal(COUNT))
    every_other = Signal("drive", "N·m", stamps[::2], np.sign(moving(even[::2])))
    elsewhere = Signal("clamp", "N·m", even + 0.3 * PERIOD, np.zeros(COUNT))
    return Log(f"log_{seed}", {"hinge.position": hinge}, {"drive": every_other, "clamp": elsewhere})


def test_even_samples_are_read_on_even_times_with_all_that_stands_in_their_rows(contract: DataContract) -> None:
    logs = [log(seed, sampled_evenly=True) for seed in (1, 2)]
    found = on_even_times(logs, contract)
    even = PERIOD * np.arange(COUNT)
    for before, after in zip(logs, found, strict=True):
        assert np.std(after.outputs["hinge.position"].time - even) < LATE / 5
        assert np.array_equal(after.commands["drive"].time, after.outputs["hinge.position"].time[::2])
        assert after.commands["clamp"] is before.commands["clamp"]
        (note,) = after.notes
        assert note.kind == "jitter"
        assert "scatter by 0.3 ms" in note.message
    noise = estimate_noise([each.outputs["hinge.position"] for each in found], np.inf, contract)
    assert noise.std == pytest.approx(NOISE, rel=0.15)


def test_samples_that_were_taken_when_they_were_stamped_stay(contract: DataContract) -> None:
    logs = [log(seed, sampled_evenly=False) for seed in (1, 2)]
    assert on_even_times(logs, contract) == tuple(logs)


def test_whoever_believes_the_stamps_keeps_them(contract: DataContract) -> None:
    logs = [log(1, sampled_evenly=True)]
    assert on_even_times(logs, replace(contract, jitter=np.inf)) == tuple(logs)


def test_stamps_of_a_clock_that_drifts_or_pauses_are_straightened_in_between(contract: DataContract) -> None:
    even = PERIOD * np.arange(COUNT) * (1.0 + 1e-4 * np.arange(COUNT) / COUNT)
    even[COUNT // 2 :] += 1.0
    even = np.delete(even, [300, 301, 900])
    stamps = even + LATE * np.random.default_rng(0).standard_normal(len(even))
    assert np.std(straightened(stamps, contract) - even) < LATE / 4


@pytest.mark.parametrize("stamps", [PERIOD * np.arange(100.0), np.cumsum([0.01, 0.001] * 50), PERIOD * np.arange(20.0)])
def test_exact_uneven_and_few_stamps_stay(stamps: Array, contract: DataContract) -> None:
    assert straightened(stamps, contract) is stamps or np.array_equal(straightened(stamps, contract), stamps)
