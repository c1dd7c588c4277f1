"""Settings of the diagnosis; their values live in conf/comparison."""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from dr_lab.bounds import Confidence, Count, Natural, NotNegative, Positive, Share, at_least, require_bounds
from dr_lab.diagnosis.law_settings import LawSettings
from dr_lab.diagnosis.peak_settings import PeakSettings
from dr_lab.errors import ConfigError

_ROUNDING = 1e-9


@dataclass(frozen=True)
class WindowSettings:
    """How logs are cut; times in s.

    Attributes:
        length: scored part of a window, and the time between the starts of two windows, so that no sample counts twice.
        longest: the longest length that is tried where a gap remains that shorter windows do not explain.
        longer: factor from one length that is tried to the next.
        most_dropped: share of the logs that may have no room for longer windows, else those are not tried.
        seconds: scored time in all that is taken of the logs that are fitted, and as much of those that score, evenly
            spread over each log; one window of each log at least.
        margin: simulated time before and after the scored part, which delayed outputs may reach into.
        run_in: time before the scored part whose samples alone estimate the start (0: the scored samples do).
        past: time before the start for which a log must hold commands, at least the longest delay that is looked for.
        kept: the same for which they are kept where the log has them, at least `past`; before its first command it
            holds that one. Longer delays and lags than those that are looked for ask for it.
        memory: time before the start of which laws that remember see motion and commands; before the log all rests.
        lookback: time before the start of which laws that swing on for long see the motion, in `interval` s each.
        interval: length of the intervals of which they see mean velocities.
        forgotten: time constants in which an actuator's activation forgets where it began; memory is as much longer.
        longest_run_in: longest memory for that; slower activations, and those that never forget, are fitted.
        smoother: half-width of the local polynomial that gives a start its first estimate.
        most_unlogged: times between samples of commands that changed without being logged, of each window at most, in
            which what they did is estimated.
        prior_scale: standard deviations of the noise that the first estimate may be wrong by.
        unmeasured_position: prior standard deviation of a joint position that is not measured, rad or m.
        unmeasured_velocity: the same of its velocity, rad/s or m/s.
        footing: how far above the ground a foot may seem to be that stands, m.
        lifting: prior standard deviations of a start by which a body may seem to move off the ground that it stays on.
        unknowns: most positions and velocities that are unknown at the starts of all windows together.

    Raises:
        ConfigError: a number is too small.
    """

    length: Positive
    longest: Positive
    longer: Annotated[float, at_least(1.1)]
    most_dropped: Share
    seconds: Positive
    margin: NotNegative
    run_in: NotNegative
    past: NotNegative
    kept: NotNegative
    memory: NotNegative
    lookback: NotNegative
    interval: Positive
    forgotten: Positive
    longest_run_in: NotNegative
    smoother: Positive
    most_unlogged: Count
    prior_scale: Positive
    unmeasured_position: Positive
    unmeasured_velocity: Positive
    footing: Positive
    lifting: Positive
    unknowns: Count

    def __post_init__(self) -> None:
        require_bounds(self, "windows")

    @property
    def lengths(self) -> list[float]:
        """The lengths that may be tried, the shortest first."""
        steps = max(0, int(np.log(max(self.longest / self.length, 1.0)) / np.log(self.longer) + _ROUNDING))
        return [self.length * self.longer**k for k in range(steps + 1)]

    def of_length(self, length: float) -> "WindowSettings":
        """The same with windows of one length alone."""
        return replace(self, length=length, longest=length)

    def of_machine(self, dofs: int) -> "WindowSettings":
        """The same with fewer windows of a machine of many degrees of freedom, which is seen by as many sensors."""
        return replace(self, seconds=min(self.seconds, self.length * max(1, self.unknowns // (2 * dofs))))

    @property
    def most(self) -> int:
        """How many windows are taken of all logs together."""
        return max(1, round(self.seconds / self.length))


def predicted_windows(windows: WindowSettings, length: float, run_in: float) -> WindowSettings:
    """How logs are cut for prediction: as for fits, with the start known only from samples before the scored part.

    Args:
        windows: how logs are cut for fits.
        length: scored part of a window, s.
        run_in: time before the scored part whose samples alone estimate the start, s.

    Raises:
        ConfigError: a number is too small.
    """
    return replace(windows.of_length(length), run_in=run_in)


@dataclass(frozen=True)
class SolverSettings:
    """Levenberg–Marquardt with finite differences.

    Attributes:
        iterations: accepted or rejected steps after which a descent begins anew; not where a fit ends.
        crawl: number of steps in a row after which a fit ends if together they lower the deviance by less than
            `crawl_tolerance`, and move it up and down by less than `crawl_swing` times that.
        crawl_tolerance: see there; a descent that begins anew must gain as much. Where steps meet kinks no certificate
            comes, and a fit could go on for hundreds of steps that no comparison would notice.
        crawl_swing: see there.
        pace: number of steps in a row that tell whether a fit reaches its goal in time.
        tolerance: a fit has converged when a full linear step would lower the deviance n ln(cost) by less than this, n
            residuals being independent.
        state_tolerance: the states of a window alone are found when a step lowers its cost by less than this share.
        rough_tolerance: share of the cost that is enough for fits that only decide which candidates are fitted again.
        refresh: share of the cost that a step must gain for the slopes by the start states to be taken anew.
        foretold: share of the decrease that a linear step foretells above which the slopes, which follow the step
            (`Slopes.secant`), are good for the next one. λ falls faster after such a step if it gained less than this
            share of what one without damping foretells.
        foreseen: share of what a fit gains that a linear step foretells, at least; a fit ends that cannot reach by that
            the cost that is asked for.
        hindered: share of the decrease that a linear step foretells below which states are fitted window by window.
        mended: by how much a linear step must lower the deviance for that to be worth its time.
        damping: first value of λ.
        damping_up: factor on λ after a rejected step.
        damping_down: divisor of λ after an accepted step.
        damping_max: give up when λ exceeds it.
        parameter_step: finite-difference step of a parameter, in widths of its bounds.
        state_step: finite-difference step of an initial state, in prior standard deviations.
        touching: factor on a parameter's where shapes touch one another.
        touching_states: factor on a state's there.
        draws: from how many draws the start of a window is chosen that is stuck among contacts.
        redrawn: how often, at most.
        spread: standard deviation of these draws, in that of the start's prior.
        stuck: times the median window's χ², above which a window is.
        first_part: share of a window by which its start is sought at first where it is stuck without contacts.
        rolling: factor on both where bodies stay on the ground.
        rolling_patience: factor on `start_iterations` there, since contacts let no long step through.
        huber: residuals beyond this many robust standard deviations count linearly.
        prior_spans: standard deviation of the weak prior around a parameter's nominal value, in widths of its bounds.
        plausible: probability below which a window's χ² passes for noise; else its start is sought from the prior, too.
        polish_iterations: steps of windows that are fitted on their own between joint steps.
        start_iterations: steps spent on each further start before the best one goes on.
        restarts: most times that a fit begins anew from its end, because it has not converged, because windows that
            diverged at its start do so no more, or because the states of windows that stray end lower from elsewhere.
        stray: times the median window's cost, above which a window strays.
        batch: most simulations at a time for the columns of a Jacobian, though all windows of one column; it bounds
            the memory.

    Raises:
        ConfigError: a number is too small.
    """

    iterations: Count
    crawl: Count
    crawl_tolerance: NotNegative
    crawl_swing: NotNegative
    pace: Count
    tolerance: NotNegative
    state_tolerance: NotNegative
    rough_tolerance: NotNegative
    refresh: NotNegative
    foretold: NotNegative
    foreseen: Positive
    hindered: NotNegative
    mended: NotNegative
    damping: Positive
    damping_up: Annotated[float, at_least(1.0)]
    damping_down: Annotated[float, at_least(1.0)]
    damping_max: Positive
    parameter_step: Positive
    state_step: Positive
    touching: Annotated[float, at_least(1.0)]
    touching_states: Annotated[float, at_least(1.0)]
    draws: Count
    redrawn: Natural
    spread: Positive
    stuck: Annotated[float, at_least(1.0)]
    first_part: Share
    rolling: Annotated[float, at_least(1.0)]
    rolling_patience: Count
    huber: Positive
    prior_spans: Positive
    plausible: Confidence
    polish_iterations: Count
    start_iterations: Count
    restarts: Natural
    stray: Positive
    batch: Count

    def __post_init__(self) -> None:
        require_bounds(self, "solver")

    @property
    def patient(self) -> "SolverSettings":
        """The same for a fit that is to end lower: it crawls on for twice as many steps."""
        return replace(self, crawl=2 * self.crawl)


@dataclass(frozen=True)
class EvidenceSettings:
    """Which candidates are worth a fit, and when their gain on windows that they did not see counts.

    Attributes:
        most_fits: number of candidates that are fitted at most: the most promising, half of them with one parameter.
            Those that hold the best of these as a special case come on top.
        least_promise: share of the largest gain on the fit windows, first as predicted, then as reached: candidates
            that promise less stay unfitted.
        least_hope: share of `threshold` that a linear step must promise for a candidate to be fitted.
        enough_hope: the same, beyond which what few windows promise is believed; below, all windows are asked.
        screen_seconds: s of fit windows on which candidates are looked at and tried; those that stand there are fitted
            to all.
        screen_windows: how many they are at least.
        confidence: of the intervals of paired gains, and of the lower bound of their evidence.
        trial_confidence: of the bound that an effect's evidence must exceed for the ladder to go on with it on trial
            where nothing is supported at `confidence`.
        block: consecutive windows of a log that are resampled together.
        least_blocks: number of blocks for which fewer windows are resampled together.
        least_trusted: number of blocks, or of logs, below which intervals are said not to be trusted, and of logs below
            which blocks are left out in place of logs where a fit to the others foretells them.
        astray: times the squares that a fit leaves of a log, beyond which a linear step without that log is not
            believed.
        least_clusters: number of logs, fitted ones among them, from which on the scatter between them bounds evidence.
        least_compared: number of blocks of windows below which no interval of a difference is known.
        resamples: number of bootstrap resamples of a fit's parameters.
        gain_resamples: the same of a paired gain, whose interval of few blocks needs rare percentiles.
        seed: of the resampling.
        threshold: least evidence that separates two models, as Δχ² on held-out windows and on fitted ones as others
            foretell them.
        least_gap: share of the worse model's χ² above the noise floor that separates two models.
        least_explained: share of the χ² above the noise floor that an effect must close to be added.
        least_named: the same of all added effects together, for them to be named where they leave more than noise.
        growth: times the χ² that a model leaves in short windows, where that passes for noise, beyond which what it
            leaves in longer ones does not; the same of windows that chose nothing, too few to tell more.
        penalty: Δχ² that each added parameter must earn on top.
        floor: largest χ² per sample that counts as the noise floor, where samples are many.
        absorbed: share of an effect's information below which the free parameters are said to absorb it.
        replacement_share: of the parameters that take an absorbed effect's place those are told that move this share
            of the largest move, in widths of their bounds, or more.
        widenings: times that a bound which the fit of an effect to few windows ran into is doubled, at most; the best
            effect's bounds as often again where it is fitted to all of them.
        rerankings: most times that all candidates are ranked anew, beside a base that became better beyond doubt.
        peaks: where the search for periods lets fits begin.
        law: how the law of a named effect is checked.

    Raises:
        ConfigError: a number is too small, or the confidence is no share.
    """

    most_fits: Count
    least_promise: NotNegative
    least_hope: NotNegative
    enough_hope: NotNegative
    screen_seconds: Positive
    screen_windows: Count
    confidence: Confidence
    trial_confidence: Confidence
    block: Count
    least_blocks: Count
    least_trusted: Count
    least_clusters: Count
    astray: Annotated[float, at_least(1.0)]
    least_compared: Annotated[int, at_least(2)]
    resamples: Count
    gain_resamples: Count
    seed: Natural
    threshold: NotNegative
    least_gap: NotNegative
    least_explained: NotNegative
    least_named: NotNegative
    growth: Positive
    penalty: NotNegative
    floor: Positive
    absorbed: NotNegative
    replacement_share: NotNegative
    widenings: Natural
    rerankings: Natural
    peaks: PeakSettings
    law: LawSettings

    def __post_init__(self) -> None:
        require_bounds(self, "evidence")
        if self.trial_confidence > self.confidence:
            raise ConfigError(
                f"evidence.trial_confidence is {self.trial_confidence:g}, above evidence.confidence "
                f"({self.confidence:g}): a trial is for what is less than certain. Lower it."
            )
