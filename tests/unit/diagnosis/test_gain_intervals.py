"""Intervals of what a model gains: how often they hold, and what they ask of evidence."""

from dataclasses import replace

import numpy as np
import pytest
from evidence_scores import SETTINGS, chi2, score, seen
from scipy.signal import lfilter

from dr_lab.diagnosis.evidence.paired_gain import block_count, paired_gain
from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.diagnosis.evidence.support import supported, supported_in_all_logs, supported_within_logs, worth_a_trial
from dr_lab.errors import ConfigError


def test_four_windows_of_one_log_show_their_scatter() -> None:
    sums = np.array([[400.0, 90.0, 110.0, 100.0], [100.0, 100.0, 100.0, 100.0]])
    worse, better = (
        Score(row.mean() / 100, {}, {}, {}, row, np.full(4, 100.0), np.zeros(4, np.intp), 0) for row in sums
    )
    assert not supported(paired_gain(worse, better, SETTINGS), 1, SETTINGS)


def coloured(logs: int, windows: int, seed: int) -> np.ndarray:
    """Gains of windows of variance 1 and mean 0 of which neighbours in a log correlate by 0.3, shape (w,)."""
    noise = np.random.default_rng(seed).normal(size=(logs, 50 + windows))
    return np.asarray(lfilter([np.sqrt(1 - 0.3**2)], [1.0, -0.3], noise, axis=1))[:, 50:].ravel()


@pytest.mark.slow
@pytest.mark.parametrize(("logs", "windows", "least", "count"), [(1, 12, 4, 4), (2, 12, 8, 8), (1, 90, 8, 30)])
def test_the_interval_holds_the_truth_as_often_as_it_says(logs: int, windows: int, least: int, count: int) -> None:
    settings = replace(SETTINGS, least_blocks=least)
    base = np.full(logs * windows, 50.0)
    assert block_count(score(base, logs=logs).log, settings) == count
    inside = beyond = 0
    for seed in range(150):
        gain = 0.05 * coloured(logs, windows, seed)
        of_share = paired_gain(score(base, logs=logs), score(base * (0.7 - gain), logs=logs), settings)
        inside += of_share.low <= 0.3 <= of_share.high
        beyond += paired_gain(score(base + gain, logs=logs), score(base, logs=logs), settings).total_low > 0
    assert inside >= 0.97 * 150  # of 99 %
    assert beyond <= 0.03 * 150  # of 1 %


@pytest.mark.parametrize(
    ("worse", "better", "holds"),
    [
        ([500.0, 500.0], [90.0, 90.0], True),  # the whole gap
        ([500.0, 500.0], [150.0, 150.0], False),  # most of it, but not down to noise
        ([500.0, 100.0], [90.0, 101.0], False),  # not in every window
        ([115.0, 115.0], [100.0, 100.0], False),  # below the noise floor
    ],
)
def test_without_an_interval_every_window_must_gain_much(
    worse: list[float], better: list[float], *, holds: bool
) -> None:
    gain = paired_gain(score(np.array(worse), logs=1), score(np.array(better), logs=1), SETTINGS)
    assert np.isnan([gain.low, gain.high, gain.total_low]).all()
    assert supported(gain, 1, SETTINGS) == holds


def test_a_wide_interval_does_not_hide_what_every_window_shows() -> None:
    worse, better = np.array([300.0, 500.0, 2000.0, 400.0]), np.full(4, 101.0)
    gain = paired_gain(score(worse, logs=1), score(better, logs=1), SETTINGS)
    assert gain.total_low < 0 < gain.total
    assert supported(gain, 1, SETTINGS)


def test_a_trial_that_asks_for_more_than_certainty_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"trial_confidence is 0\.995, above evidence\.confidence \(0\.99\)"):
        replace(SETTINGS, trial_confidence=0.995)


def test_a_trial_asks_for_less_confidence_and_nothing_else() -> None:
    worse, better = np.array([500.0, 100.0, 2000.0, 400.0] * 4), np.array([300.0, 160.0, 150.0, 410.0] * 4)
    gain = paired_gain(score(worse), score(better), replace(SETTINGS, block=1, least_blocks=1, confidence=0.99999))
    assert gain.total_low < 0 < gain.trial_low < gain.total
    assert worth_a_trial(gain, 1, SETTINGS)
    assert not supported(gain, 1, SETTINGS)
    assert not worth_a_trial(gain, 1 + int(gain.total / SETTINGS.penalty), SETTINGS)
    assert not worth_a_trial(gain, 1, replace(SETTINGS, least_gap=0.99))


def test_what_closes_half_of_a_typical_gap_is_worth_a_trial_whatever_its_interval() -> None:
    settings = replace(SETTINGS, least_named=0.5)
    worse, better = np.array([500.0, 100.0, 2000.0, 400.0] * 4), np.array([300.0, 160.0, 150.0, 410.0] * 4)
    gain = replace(paired_gain(score(worse), score(better), settings), trial_low=-1.0, gap=0.55)
    assert worth_a_trial(gain, 1, settings)
    assert not worth_a_trial(replace(gain, gap=0.45), 1, settings)
    assert not worth_a_trial(replace(gain, total=settings.threshold), 1, settings)


def test_three_blocks_have_an_interval() -> None:
    better = np.full(3, 100.0)
    gain = paired_gain(score(5 * better, logs=1), score(better, logs=1), SETTINGS)
    assert gain.low == pytest.approx(0.8)
    assert supported(gain, 1, SETTINGS)


def test_what_helps_logs_unequally_is_supported() -> None:
    worse, better = np.full(24, 750.0), np.repeat([300.0, 600.0], 12)
    assert supported(paired_gain(score(worse), score(better), SETTINGS), 1, SETTINGS)


def test_a_log_that_hardly_gains_widens_the_scatter_between_logs_alone() -> None:
    """Sums of five logs as of a friction that falls with speed, which is told by slow motion only."""
    gained = np.tile([1.5, 0.5], 25) * np.repeat([194.0, 4.0, 115.0, 274.0, 39.0], 10) / 10
    gain = paired_gain(score(90 + gained, logs=5), score(np.full(50, 90.0), logs=5), SETTINGS)
    assert gain.logs_low < 0 < gain.blocks_low < gain.total
    assert supported_within_logs(gain, 2, SETTINGS)
    assert not supported_in_all_logs(gain, 2, SETTINGS)


def noise_fitted(parameters: int, seed: int) -> tuple[Score, Score, float]:
    """A model beside one whose further parameters are fitted to noise, and what it truly gains over these windows.

    Its error e, the mean of the gradients s of the fitted windows, changes Δχ² of another window by 2 e·s − e·e.
    """
    gradients = np.random.default_rng(seed).normal(size=(3, 8, parameters))  # held out, then two fitted logs
    fitted = gradients[1:].reshape(16, parameters)
    logs = np.repeat([0, 1], 8)
    others = np.array([fitted[logs != log].mean(0) for log in logs])
    error = fitted.mean(0)

    def foretold(gradient: np.ndarray, by: np.ndarray) -> Score:
        gained = 2 * (gradient * by).sum(-1) - (by**2).sum(-1)
        return replace(score(90 - gained, logs=len(gained) // 8), parameters=parameters)

    held_out = foretold(gradients[0], np.broadcast_to(error, (8, parameters)))
    plain = replace(score(np.full(8, 90.0), logs=1), foretold=score(np.full(16, 90.0)))
    return plain, replace(held_out, foretold=foretold(fitted, others)), -24 * float(error @ error)


@pytest.mark.parametrize("parameters", [pytest.param(count, marks=pytest.mark.slow) for count in (1, 3)])
def test_the_bound_holds_what_the_fit_at_hand_costs(parameters: int) -> None:
    found = [noise_fitted(parameters, seed) for seed in range(400)]
    held = [paired_gain(plain, better, SETTINGS).total_low <= truth for plain, better, truth in found]
    scatter = [
        paired_gain(plain, replace(better, parameters=0), SETTINGS).total_low <= truth for plain, better, truth in found
    ]
    assert np.mean(held) >= SETTINGS.confidence - 2 * np.sqrt(0.01 * 0.99 / 400)
    assert np.mean(scatter) < np.mean(held)


def test_evidence_alone_does_not_name_what_a_typical_window_may_lose() -> None:
    """So a factor on all drives was named that closed 46 % (−14 … 74 %) where dry friction was hidden."""
    gain = paired_gain(*seen(4 * chi2(24, 1), chi2(24, 0)), SETTINGS)
    assert supported(gain, 1, SETTINGS)
    assert supported(replace(gain, low=np.nan), 1, SETTINGS)
    assert not supported(replace(gain, low=-0.14), 1, SETTINGS)


def test_logs_that_gain_unequally_are_asked_of_unless_the_instruments_noise_alone_is_left() -> None:
    """Six logs, of which the two in which the machine moves fast gain ten times as much: no error, but the cause."""
    count, log = np.full(60, 20.0), np.repeat(np.arange(6), 10)
    closed = np.where(log < 2, 12.0, 1.2) + 0.2 * np.random.default_rng(0).standard_normal(60)

    def of(levels: np.ndarray, *, instrumental: bool) -> Score:
        channel = ChannelScore(levels * count, count, 1.0, instrumental=instrumental)
        return Score(levels.mean(), {}, {}, {}, levels * count, count, log, 0, {"a": channel})

    base, left = of(14.0 + closed, instrumental=False), np.full(60, 14.0)
    force, noise = (paired_gain(base, of(left, instrumental=own), SETTINGS) for own in (False, True))
    assert np.isclose(force.total, noise.total)
    assert force.total_low < 0 < force.blocks_low == noise.total_low
    assert not supported(force, 1, SETTINGS)
    assert supported(noise, 1, SETTINGS)
    both = paired_gain(of(14.0 + closed, instrumental=True), of(left, instrumental=True), SETTINGS)
    assert both.total_low == noise.total_low  # what a drag adds to coloured noise may look like it


def test_logs_that_gain_unequally_are_not_asked_where_most_of_a_gap_closes_down_to_noise() -> None:
    """A gap of 0.15 beside the noise of 1, of which an effect closes nearly all, or a fifth."""
    count, log = np.full(60, 200.0), np.repeat(np.arange(6), 10)
    noise = 1.0 + 0.01 * np.random.default_rng(0).standard_normal(60)
    gap = np.where(log < 2, 0.4, 0.04)

    def of(levels: np.ndarray) -> Score:
        channel = ChannelScore(levels * count, count, 1.0, instrumental=False)
        return Score(levels.mean(), {}, {}, {}, levels * count, count, log, 0, {"a": channel})

    most, little = (paired_gain(of(noise + gap), of(noise + left * gap), SETTINGS) for left in (0.1, 0.8))
    assert supported(most, 1, SETTINGS)
    assert little.total > SETTINGS.threshold
    assert little.total_low < 0 < little.blocks_low
    assert not supported(little, 1, replace(SETTINGS, least_gap=0.0))
