from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from dr_lab.diagnosis.evidence.noise_floor import at_floor, noise_floor
from dr_lab.diagnosis.evidence.paired_gain import (
    block_count,
    paired_gain,
    supported,
    supported_within_logs,
    worth_a_trial,
)
from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.diagnosis.law_settings import LawSettings
from dr_lab.diagnosis.peak_settings import PeakSettings
from dr_lab.diagnosis.settings import EvidenceSettings
from dr_lab.errors import ConfigError

SETTINGS = EvidenceSettings(
    most_fits=100,
    least_promise=0.0,
    least_hope=0.5,
    enough_hope=10.0,
    screen_seconds=3.0,
    screen_windows=5,
    confidence=0.99,
    trial_confidence=0.95,
    block=3,
    least_blocks=8,
    least_trusted=3,
    least_clusters=5,
    astray=2.0,
    least_compared=3,
    resamples=2000,
    gain_resamples=20000,
    seed=0,
    threshold=25.0,
    least_gap=0.1,
    least_explained=0.25,
    least_named=0.7,
    growth=2.0,
    penalty=2.0,
    floor=1.1,
    absorbed=1e-3,
    replacement_share=0.2,
    widenings=3,
    rerankings=3,
    peaks=PeakSettings(most=2, near=0.8),
    law=LawSettings(knots=4, factor=2.0, least_closed=0.7),
)


def score(sums: np.ndarray, count: float = 100.0, logs: int = 2) -> Score:
    counts = np.full(len(sums), count)
    log = np.repeat(np.arange(logs), len(sums) // logs)
    return Score(float(sums.sum() / counts.sum()), {}, {}, {}, sums, counts, log, 0)


def chi2(windows: int, seed: int) -> np.ndarray:
    return np.random.default_rng(seed).chisquare(100, windows)


def test_fitted_windows_count_as_fits_to_the_others_foretell_them() -> None:
    better, worse = chi2(8, 0), 4 * chi2(8, 1)
    few, more = paired_gain(score(worse), score(better), SETTINGS), paired_gain(*seen(worse, better), SETTINGS)
    assert more.total == pytest.approx(2 * few.total)
    assert more.gap == few.gap
    assert more.low > few.low  # twice the windows tell more
    assert more.share == pytest.approx(few.share)


def test_what_others_do_not_foretell_counts_against_a_model() -> None:
    better, worse = chi2(8, 0), 4 * chi2(8, 1)
    astray = replace(score(better), foretold=score(100 * better))
    gain = paired_gain(replace(score(worse), foretold=score(worse)), astray, SETTINGS)
    assert gain.total < 0
    assert not supported(gain, 1, SETTINGS)


def test_two_windows_that_gain_do_not_outweigh_fitted_ones_that_gain_nothing_typically() -> None:
    """So a curve of the commands was named on two windows, while what the logs foretell of one another got worse."""
    before, after = (score(np.array(sums)) for sums in ([400.0, 440.0], [95.0, 105.0]))
    steady, torn = np.full(12, 400.0), np.tile([90.0, 1600.0], 6)
    gain = paired_gain(replace(before, foretold=score(steady)), replace(after, foretold=score(torn)), SETTINGS)
    alone = paired_gain(before, after, SETTINGS)
    assert gain.clear
    assert gain.total > SETTINGS.threshold
    assert gain.low < 0
    assert not supported(gain, 1, SETTINGS)
    assert supported(alone, 1, SETTINGS)


def test_a_fitted_window_that_diverges_counts_against_a_model() -> None:
    before, after = score(np.full(24, 400.0)), score(np.full(24, 100.0))
    first = np.arange(24) == 0
    lost = replace(after, window_count=np.where(first, 0.0, 100.0), window_sum=np.where(first, 0.0, 100.0))
    worse = replace(before, foretold=before)
    assert supported(paired_gain(worse, replace(after, foretold=after), SETTINGS), 1, SETTINGS)
    gain = paired_gain(worse, replace(after, foretold=lost), SETTINGS)
    assert gain.total > 0
    assert gain.total_low == -np.inf
    assert not gain.clear
    assert not supported(gain, 1, SETTINGS)


def test_one_block_led_astray_does_not_decide_the_share() -> None:
    better, worse = np.full(30, 100.0), np.full(30, 400.0)
    wild = np.append(better[1:], 1e8)
    gain = paired_gain(
        replace(score(worse), foretold=score(worse)), replace(score(better), foretold=score(wild)), SETTINGS
    )
    assert gain.share > 0.5


def seen(worse: np.ndarray, better: np.ndarray) -> tuple[Score, Score]:
    """Scores whose fitted windows look like those that score."""
    first, second = (replace(score(sums), foretold=score(sums)) for sums in (worse, better))
    return first, second


def test_a_constant_share_is_known_exactly() -> None:
    better = np.full(30, 100.0)
    gain = paired_gain(score(4 * better), score(better), SETTINGS)
    assert np.allclose([gain.share, gain.low, gain.high], 0.75)
    assert gain.error == pytest.approx(0.75)  # of a χ² of 4, so that it explains all of it
    assert gain.wins == 1
    assert supported(gain, 1, SETTINGS)


@pytest.mark.parametrize(("freedom", "floor"), [(1.0, 6.635), (30.0, 50.892 / 30), (1e6, SETTINGS.floor), (0.0, 1.1)])
def test_few_samples_scatter_above_the_noise_floor(freedom: float, floor: float) -> None:
    assert noise_floor(freedom, SETTINGS) == pytest.approx(floor, abs=1e-3)  # upper 1 % points of χ², by table


@pytest.mark.parametrize(
    ("quiet", "loud", "expected"), [(0.6, 1.3, False), (1.0, 1.15, True), (0.6, 1.0, True), (0.6, 0.9, True)]
)
def test_a_channel_below_its_noise_makes_up_for_no_other(quiet: float, loud: float, *, expected: bool) -> None:
    """Both have 2 400 residuals, of which the floor is 1.1: the mean of 1 and 1.3 is above it, of 0.6 and 1.3 below."""
    count = np.full(240, 10.0)
    channels = {
        name: ChannelScore(chi2 * count, count, 1.0, instrumental=False) for name, chi2 in (("a", quiet), ("b", loud))
    }
    both = sum(channel.window_sum for channel in channels.values())
    pooled = replace(score(np.asarray(both), 20.0), channels=channels)
    assert pooled.chi2 < SETTINGS.floor
    assert at_floor(pooled, SETTINGS) == expected


def test_evidence_near_the_noise_floor_is_the_difference_of_chi2() -> None:
    better = np.full(30, 100.0)
    gain = paired_gain(score(better + 2), score(better), SETTINGS)
    assert np.isclose(gain.total, 60, rtol=0.01)
    below = paired_gain(score(better), score(better - 2), SETTINGS)
    assert np.isclose(below.total, 60, rtol=1e-9)  # exactly where all that is left is noise


def test_evidence_far_above_the_floor_does_not_depend_on_the_noise() -> None:
    better = 1e6 * chi2(30, 1)
    one, other = (paired_gain(score(2 * k * better), score(k * better), SETTINGS).total for k in (1, 1000))
    assert np.isclose(one, other, rtol=1e-4)
    assert np.isclose(one, 30 * 100 * np.log(2), rtol=1e-4)  # −2 ln of the likelihoods' ratio, each error unknown


def test_a_wild_window_that_both_share_hides_nothing() -> None:
    better = 10 * chi2(30, 6)
    worse = 3 * better
    better[4] = worse[4] = 1e9
    assert supported(paired_gain(score(worse), score(better), SETTINGS), 1, SETTINGS)


def test_an_effect_that_closes_a_trifle_of_the_gap_does_not_count() -> None:
    better = 100 * chi2(30, 7)
    assert not supported(paired_gain(score(1.05 * better), score(better), SETTINGS), 1, SETTINGS)


def test_a_trifle_of_one_channel_does_not_count_where_another_one_is_below_its_noise() -> None:
    """All channels together are then at the floor, where there is no gap that could close."""
    count, log, level = np.full(240, 30.0), np.repeat(np.arange(6), 40), np.random.default_rng(0).random(240)

    def of(gap: float) -> Score:
        quiet, loud = (
            ChannelScore(s * count, count, 1.0, instrumental=False) for s in (np.full(240, 0.5), gap + 0.02 * level)
        )
        sums = quiet.window_sum + loud.window_sum
        channels = {"a.position": quiet, "b.position": loud}
        return Score(float(sums.sum() / (2 * count.sum())), {}, {}, {}, sums, 2 * count, log, 0, channels)

    gain = paired_gain(of(1.45), of(1.43), SETTINGS)
    assert gain.total > SETTINGS.threshold
    assert gain.total_low > 0
    assert (gain.place, gain.gap) == ("b.position", gain.channels["b.position"])
    assert gain.gap < SETTINGS.least_gap
    assert not supported(gain, 1, SETTINGS)


def test_equal_models_are_not_told_apart() -> None:
    found = [paired_gain(score(chi2(40, 2 * k)), score(chi2(40, 2 * k + 1)), SETTINGS) for k in range(50)]
    assert sum(supported(gain, 1, SETTINGS) for gain in found) <= 1


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


def test_no_more_than_the_gap_is_closed() -> None:
    noise = chi2(12, 0)
    assert paired_gain(score(1.05 * 100 / noise.mean() * noise), score(0.9 * noise), SETTINGS).gap == 1.0


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
    assert gain.total_low < 0 < gain.blocks_low < gain.total
    assert supported_within_logs(gain, 2, SETTINGS)
    assert not supported(gain, 2, SETTINGS)


def test_an_unmodelled_remainder_weakens_the_evidence() -> None:
    better = chi2(30, 3)
    near_floor = paired_gain(score(better + 2), score(better), SETTINGS)
    far_above = paired_gain(score(40 * better + 2), score(40 * better), SETTINGS)
    assert supported(near_floor, 1, SETTINGS)
    assert not supported(far_above, 1, SETTINGS)


def test_every_parameter_must_earn_its_penalty() -> None:
    better = chi2(30, 4)
    gain = paired_gain(score(better + 1), score(better), SETTINGS)
    assert supported(gain, 1, SETTINGS)
    assert not supported(gain, 5, SETTINGS)


def test_one_lucky_window_is_not_support() -> None:
    better = chi2(30, 5)
    worse = better.copy()
    worse[7] += 500
    gain = paired_gain(score(worse), score(better), SETTINGS)
    assert gain.share > 0
    assert not supported(gain, 1, SETTINGS)


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
