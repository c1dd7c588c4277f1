"""Thresholds of the data contract: what counts as a gap, a glitch, a wrap or a wrong unit."""

from dataclasses import dataclass


@dataclass(frozen=True)
class DataContract:
    """Thresholds applied to every measured channel; their values live in conf/data_contract.

    Attributes:
        minimum_samples: fewest samples a measured channel may have.
        longest_period: s, samples that usually lie farther apart have times in another unit.
        shortest_period: s, samples that usually lie closer together, too.
        longest_mean_wait: s, a channel whose samples lie farther apart on average has stamps from another epoch.
        gap: a time between two samples that is longer than this many usual periods is a gap.
        event_share: a command with more gaps than this share of its samples is sent on change; it has no gaps.
        glitch: a glitch lies further than this many noise standard deviations from its neighbours' curve …
        glitch_contrast: … and this many times further than those neighbours scatter about it.
        glitch_share: with more glitches than this share of the samples nothing is removed, only said.
        wrap_tolerance: a jump within this share of a full turn is an angle that wrapped.
        clock_outlier: a stamp is suspect if it lies this many robust standard deviations below the usual delay …
        clock_outlier_share: … and is left out of the clock fit if at most this share of the stamps is suspect.
        clock_step: s, a clock that leaves its straight line by more than this is reported.
        clock_drift: header clocks that gain or lose a larger share of the time count another, such as simulated time.
        same_clock: s, header clocks of two topics that agree to this are one clock and share one fit.
        unit_ratio: share by which a ratio may differ from 180/π and still raise the suspicion of degrees.
        velocity_ratio: share by which a velocity may differ from its position's derivative before it is reported.
        unit_quantum: the same as unit_ratio for the number of encoder steps in a full turn; 0 switches that test off.
        speed_limit: rad/s, no joint turns faster; faster data are suspected to be in degrees.
        noise_settled: the order of differencing is high enough when the next changes the noise by less than this share.
        noise_floor: smallest noise standard deviation, as a share of the channel's range.
        fast: rounding errors of a quantised signal are random where it moves by this many steps a sample.
        quantised: there the residual is rounding alone up to this factor …
        staircase: … and in a slower staircase up to this one.
        dithered: above this factor noise makes rounding random at any speed, and slow parts tell of the noise, too.
        derived: a velocity that is a filter of the logged position to within this share of the position's noise behind
            that filter tells nothing beside it and is left out; 0 keeps all.
        jitter: times as noisy as on even times that a channel is by its stamps, from which on these are not believed.
        frozen: s, equal samples over a longer time are suspected to be frozen …
        frozen_rest: … if no others outlast a share of it; the factor by which it is longer than those.
        frozen_stop: usual changes of a sample in the braking distance that a motion leaves out …
        frozen_jump: … or in the jump that follows.
        copied: samples in a row that two logs share only if one is a copy.
        copied_for: s that they last then; two falls from the same rest look alike to a coarse encoder for a while.
        resting: s, nothing moves for so long while commands go on, and the machine is said to be off.
        resting_share: of its usual movement that a joint at rest makes at most.
        resting_drive: of their usual range and scatter that commands have in that time at least.
    """

    minimum_samples: int
    longest_period: float
    shortest_period: float
    longest_mean_wait: float
    gap: float
    event_share: float
    glitch: float
    glitch_contrast: float
    glitch_share: float
    wrap_tolerance: float
    clock_outlier: float
    clock_outlier_share: float
    clock_step: float
    clock_drift: float
    same_clock: float
    unit_ratio: float
    velocity_ratio: float
    unit_quantum: float
    speed_limit: float
    noise_settled: float
    noise_floor: float
    fast: float
    quantised: float
    staircase: float
    dithered: float
    derived: float
    jitter: float
    frozen: float
    frozen_rest: float
    frozen_stop: float
    frozen_jump: float
    copied: int
    copied_for: float
    resting: float
    resting_share: float
    resting_drive: float
