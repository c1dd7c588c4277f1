"""How well a model at a context explains windows: χ² against the noise floor and errors in the signals' units."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from dr_lab.diagnosis.evidence.colour import instrumental
from dr_lab.diagnosis.fit.correlation import autocorrelation, by_component, correlation_time
from dr_lab.diagnosis.fit.point import Mask
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.solved import solved
from dr_lab.diagnosis.fit.states import StateFit
from dr_lab.diagnosis.windows.windows import WindowSamples
from dr_lab.trajectory import Array

# How many times a force is integrated in what a channel of this kind reports.
_INTEGRALS = {"position": 2, "velocity": 1}


@dataclass(frozen=True)
class ChannelScore:
    """What one channel's residuals say, window by window.

    Attributes:
        window_sum: Σ residual² of each window, shape (w,).
        window_count: degrees of freedom of each window, shape (w,).
        colour: residuals that tell as much as one independent one does, at least 1.
        instrumental: whether they are rougher than any force makes them, and the same whatever the machine does.
    """

    window_sum: Array
    window_count: Array
    colour: float
    instrumental: bool

    @property
    def chi2(self) -> float:
        """Σ residual² over the degrees of freedom; 0 where there are none."""
        return float(self.window_sum.sum() / max(self.window_count.sum(), 1.0))


@dataclass(frozen=True)
class Score:
    """Errors of one model over w windows whose parameters were not fitted on them.

    Attributes:
        chi2: Σ residual² over the degrees of freedom, residuals in noise standard deviations; 1 is the noise floor,
            infinite where every simulation diverges.
        rmse: root mean square error by channel, in the channel's unit.
        nrmse: rmse over the standard deviation of the measured samples, by channel.
        fit_percent: 100 (1 − ‖y − ŷ‖/‖y − ȳ‖), by channel.
        window_sum: Σ residual² of each window, shape (w,).
        window_count: degrees of freedom of each window, its scored residuals less what its fitted state takes of them,
            shape (w,).
        log: index of each window's log, shape (w,).
        infeasible: number of windows left out because their simulation diverges.
        channels: the same by channel.
        parameters: number of the model's parameters.
        foretold: the same model's score on the windows that it was fitted to, where these are others, each block as a
            fit to the other blocks foretells it (`left_out`), which flatters it no more than windows held out.
    """

    chi2: float
    rmse: dict[str, float]
    nrmse: dict[str, float]
    fit_percent: dict[str, float]
    window_sum: Array
    window_count: Array
    log: NDArray[np.intp]
    infeasible: int
    channels: Mapping[str, ChannelScore] = field(default_factory=dict)
    parameters: int = 0
    foretold: "Score | None" = None

    @property
    def colour(self) -> float:
        """Residuals that tell as much as one independent one does, over all channels."""
        independent = sum(float(c.window_count.sum()) / c.colour for c in self.channels.values())
        return self.freedom / independent if independent > 0 else 1.0

    @property
    def freedom(self) -> float:
        """Degrees of freedom in all."""
        return float(self.window_count.sum())


def score_of(replay: Replay, fit: StateFit) -> Score:
    """Score of a fit on the scored samples of its own windows."""
    used = replay.scored & ~fit.infeasible[:, None]
    squared = np.where(used, fit.residuals**2, 0.0)
    taken = taken_by_states(replay, fit, used)
    count = used.sum(1) - taken.sum(1)
    rmse, nrmse, percent = _channel_errors(replay, squared, ~fit.infeasible)
    return Score(
        chi2=float(squared.sum() / count.sum()) if count.any() else np.inf,
        rmse=rmse,
        nrmse=nrmse,
        fit_percent=percent,
        window_sum=squared.sum(1),
        window_count=count,
        log=replay.windows.log,
        infeasible=int(fit.infeasible.sum()),
        channels=_channels(replay, fit, used, taken),
        parameters=len(replay.model.space.parameters),
    )


def _channels(replay: Replay, fit: StateFit, used: Mask, taken: Array) -> dict[str, ChannelScore]:
    found = {}
    parts = zip(*(replay.by_channel(rows) for rows in (fit.residuals, used.astype(float), taken)), strict=True)
    for (samples, residual), (_, mask), (_, less) in parts:
        name, kind = samples.channel.name, samples.channel.kind
        rows, exists = by_component(residual), by_component(mask > 0)
        own = kind in _INTEGRALS and instrumental(rows[exists.any(1)], exists[exists.any(1)], _INTEGRALS[kind])
        found[name] = ChannelScore(
            window_sum=(mask * residual**2).sum((1, 2)),
            window_count=mask.sum((1, 2)) - less.sum((1, 2)),
            colour=correlation_time(autocorrelation(rows, exists)),
            instrumental=own,
        )
    return found


def taken_by_states(replay: Replay, fit: StateFit, used: NDArray[np.bool_]) -> Array:
    """Degrees of freedom that a window's fitted unknowns take of each of its scored residuals, shape (w, m).

    diag(A) with A = Jₛ H⁻¹ J_fᵀ and H = J_fᵀJ_f + P, J_f the slopes of fitted residuals and Jₛ those of the ones that
    are fitted and scored, P the precision of the prior. If the unknowns scatter as their prior says, the residuals'
    covariance before the fit is I + J P⁻¹ Jᵀ = (I − A)⁻¹, and after it I − A. Unknowns nearer to the prior's mean leave
    less (for all at the mean diag(2 A − A Aᵀ) would count): χ² is then a little low.

    Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), section 2.7 (explicit basis
    functions with a Gaussian prior).
    """
    fitted, both = (np.where(mask[..., None], fit.slopes, 0.0) for mask in (replay.fitted, replay.fitted & used))
    hessian = fitted.transpose(0, 2, 1) @ fitted + np.diag(replay.windows.prior.std**-2.0)
    return np.einsum("wms,wsm->wm", both, solved(hessian, both.transpose(0, 2, 1)))


def _channel_errors(
    replay: Replay, squared: Array, feasible: NDArray[np.bool_]
) -> tuple[dict[str, float], dict[str, float], dict[str, float]]:
    rmse, nrmse, percent = {}, {}, {}
    for samples, part in replay.by_channel(squared):
        scored = samples.scored & feasible[:, None]
        total = float(part.sum()) * samples.std**2
        count = int(scored.sum()) * samples.channel.size
        variance = _spread(samples, scored)
        name = samples.channel.name
        rmse[name] = float(np.sqrt(total / count)) if count else float("nan")
        ratio = float(np.sqrt(total / variance)) if variance > 0 else float("nan")
        nrmse[name], percent[name] = ratio, 100 * (1 - ratio)
    return rmse, nrmse, percent


def _spread(samples: WindowSamples, scored: NDArray[np.bool_]) -> float:
    """Σ squared distance of the measured samples from their mean, as residuals measure it."""
    value = samples.value[scored]
    if not len(value):
        return 0.0
    if samples.channel.kind == "orientation":
        value = Rotation.from_quat(value, scalar_first=True)
        return float(((value.mean().inv() * value).magnitude() ** 2).sum())
    return float(((value - value.mean(0)) ** 2).sum())
