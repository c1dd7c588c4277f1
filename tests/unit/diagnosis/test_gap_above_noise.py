"""The gap that an effect closes is what lies above the noise, the sensors' white noise or more of the instruments'."""

import numpy as np
import pytest
from diagnosis_machines import evidence_settings

from dr_lab.diagnosis.evidence.paired_gain import largest_gap, paired_gain, sizeable
from dr_lab.diagnosis.evidence.score import ChannelScore, Score

WINDOWS, COUNT = 20, 100.0
SETTINGS = evidence_settings()


def score(level: float, *, instrumental: bool) -> Score:
    """One channel whose χ² is a level in every window."""
    sums, counts = np.full(WINDOWS, level * COUNT), np.full(WINDOWS, COUNT)
    channel = ChannelScore(sums, counts, 1.0, instrumental)
    return Score(level, {}, {}, {}, sums, counts, np.arange(WINDOWS) // 5, 0, {"hinge.position": channel})


@pytest.mark.parametrize(("noise", "gap"), [(False, 1.0 / 19.0), (True, 1.0)])
def test_what_leaves_the_noise_of_instruments_closes_the_whole_gap(gap: float, *, noise: bool) -> None:
    """White noise has a χ² of 1. Low-passed noise, say, has one of 19, of which no effect can take anything away."""
    gain = paired_gain(score(20.0, instrumental=False), score(19.0, instrumental=noise), SETTINGS)
    assert gain.gap == pytest.approx(gap, rel=1e-6)
    assert largest_gap(gain) == pytest.approx(gap, rel=1e-6)
    assert sizeable(gain, 1, SETTINGS) == noise
    assert gain.share == pytest.approx(0.05, rel=0.1)
    assert gain.error == pytest.approx(0.05 if noise else 0.95, rel=0.1)


def test_noise_of_one_channel_is_no_excuse_for_another() -> None:
    one, other = score(19.0, instrumental=True), score(5.0, instrumental=False)
    channels = {"a": one.channels["hinge.position"], "b": other.channels["hinge.position"]}
    sums, counts = (one.window_sum + other.window_sum, one.window_count + other.window_count)
    both = Score(12.0, {}, {}, {}, sums, counts, one.log, 0, channels)
    np.testing.assert_allclose(both.window_noise, (19.0 + 1.0) * COUNT)


@pytest.mark.parametrize("freedom", [2, 8, 30])
def test_scatter_between_windows_makes_no_gap_of_a_trifle(freedom: int) -> None:
    """One channel is instruments' noise, another one comes down from 2 to 1.9: all windows differ by chance."""
    rng = np.random.default_rng(freedom)
    coloured, white = (rng.chisquare(freedom, WINDOWS) / freedom * COUNT for _ in range(2))

    def model(left: float) -> Score:
        sums, counts = np.stack([19 * coloured, left * white]), np.full(WINDOWS, COUNT)
        channels = {n: ChannelScore(s, counts, 1.0, n == "a") for n, s in zip("ab", sums, strict=True)}
        both, log = sums.sum(0), np.arange(WINDOWS) // 5
        return Score(float(both.mean() / 2 / COUNT), {}, {}, {}, both, 2 * counts, log, 0, channels)

    assert paired_gain(model(2.0), model(1.9), SETTINGS).gap < 0.25
    assert paired_gain(model(1.9), model(2.0), SETTINGS).gap <= 0.0
