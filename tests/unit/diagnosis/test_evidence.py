from dataclasses import replace

import numpy as np
import pytest
from evidence_scores import SETTINGS, chi2, score, seen

from dr_lab.diagnosis.evidence.noise_floor import at_floor, noise_floor
from dr_lab.diagnosis.evidence.paired_gain import paired_gain
from dr_lab.diagnosis.evidence.score import ChannelScore, Score
from dr_lab.diagnosis.evidence.support import supported


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


def test_what_a_channel_below_its_noise_gains_closes_no_gap_of_another() -> None:
    """A quiet channel gains as much beside a loud one, whose gap stays open, as alone, where no gap is left."""
    before, after, loud = np.full(60, 0.99), np.full(60, 0.96), np.full(60, 1.1)
    count = np.full(60, 100.0)

    def of(*levels: np.ndarray) -> Score:
        channels = {
            name: ChannelScore(level * count, count, 1.0, instrumental=False)
            for name, level in zip("ab", levels, strict=False)
        }
        sums, counts = sum(levels) * count, len(levels) * count
        return Score(
            float(sums.sum() / counts.sum()), {}, {}, {}, sums, counts, np.repeat(np.arange(2), 30), 0, channels
        )

    beside, alone = (
        paired_gain(of(before, loud), of(after, loud), SETTINGS),
        paired_gain(of(before), of(after), SETTINGS),
    )
    assert beside.place == alone.place == "a"
    assert np.isclose([beside.total, alone.total], 60 * 100 * 0.03).all()
    assert supported(alone, 1, SETTINGS)
    assert not supported(beside, 1, replace(SETTINGS, least_gap=0.4))


def test_equal_models_are_not_told_apart() -> None:
    found = [paired_gain(score(chi2(40, 2 * k)), score(chi2(40, 2 * k + 1)), SETTINGS) for k in range(50)]
    assert sum(supported(gain, 1, SETTINGS) for gain in found) <= 1


def test_no_more_than_the_gap_is_closed() -> None:
    noise = chi2(12, 0)
    assert paired_gain(score(1.05 * 100 / noise.mean() * noise), score(0.9 * noise), SETTINGS).gap == 1.0


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
