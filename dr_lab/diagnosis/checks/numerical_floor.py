"""The integrator's own error: the nominal rollout against the same at a quarter of the time step."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from dr_lab.diagnosis.fit.replay import Mask, Replay
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.errors import ModelError
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log, MeasurementSet

_REFINEMENT = 4


@dataclass(frozen=True)
class NumericalFloor:
    """Error of the time step over the windows.

    Attributes:
        error: root mean square difference by channel, in the channel's unit; NaN where no window holds a sample.
        share: the same in noise standard deviations; above 1 the step hides behind the physics.
        step: the model's time step, s.
        proposed: time step to try next, s; equal to `step` where that is fine enough.
        lost: whether some window diverges at the model's step and not at the finer one.
    """

    error: dict[str, float]
    share: dict[str, float]
    step: float
    proposed: float
    lost: bool = False

    @property
    def worst(self) -> str:
        """The channel that the step moves most."""
        return max(self.share, key=lambda name: np.nan_to_num(self.share[name], nan=-1.0))

    @property
    def largest(self) -> float:
        """Its share; infinite where windows can be simulated with the finer step alone."""
        return np.inf if self.lost else float(np.nan_to_num(self.share[self.worst]))


def numerical_floor(
    model: Model, logs: Sequence[Log], measured: MeasurementSet, settings: WindowSettings, threads: int | None
) -> NumericalFloor:
    """Simulate every window of the logs at the model's step and at a quarter of it, from the same starts.

    Raises:
        ModelError: the model as given diverges in every window.
    """
    replay = _replay(model, logs, measured, settings, threads)
    finely = _replay(in_parts(model, _REFINEMENT), logs, measured, settings, threads)
    finely.begin_like(replay)  # what the steps before a window did to its start is fitted away
    (coarse, diverged), (fine, diverged_finely) = _simulated(replay), _simulated(finely)
    step = replay.windows.step
    if diverged.all():
        raise ModelError(
            f"Model {model.name!r} diverges in every window of the logs at its time step of {step:g} s. Try "
            f"timestep {step / _REFINEMENT:g} in the MJCF, and check units and signs of the logs."
        )
    error, share, both = {}, {}, ~(diverged | diverged_finely)
    for samples, difference in replay.by_channel(coarse - fine):
        used = samples.scored & both[:, None]
        size = float(np.sqrt((difference[used] ** 2).mean())) if used.any() else np.nan
        share[samples.channel.name], error[samples.channel.name] = size, size * samples.std
    lost = bool((diverged & ~diverged_finely).any())
    rough = lost or any(size > 1 for size in share.values())
    return NumericalFloor(error, share, step, step / _REFINEMENT if rough else step, lost)


def moved(
    model: Model,
    other: Model,
    logs: Sequence[Log],
    measured: MeasurementSet,
    settings: WindowSettings,
    threads: int | None,
) -> tuple[float, str]:
    """By how much two models part in the windows of logs, in noise standard deviations, and the channel that does most.

    Both begin where the other model's windows begin. Where one of them diverges in all, that is infinite.
    """
    replay = _replay(other, logs, measured, settings, threads)
    (one, diverged), (two, lost) = _simulated(Replay(model, replay.windows, threads)), _simulated(replay)
    both, found = ~(diverged | lost), {}
    for samples, difference in replay.by_channel(one - two):
        used = samples.scored & both[:, None]
        found[samples.channel.name] = float(np.sqrt((difference[used] ** 2).mean())) if used.any() else np.inf
    worst = max(found, key=found.__getitem__)
    return found[worst], worst


def in_parts(model: Model, parts: int) -> Model:
    """The model with its step divided, and as long a memory of delayed commands and readings."""
    spec = model.spec.copy()
    spec.option.timestep /= parts
    for element in (*spec.actuators, *spec.sensors):
        element.nsample *= parts
    return replace(model, spec=spec)


def _replay(
    model: Model, logs: Sequence[Log], measured: MeasurementSet, settings: WindowSettings, threads: int | None
) -> Replay:
    return Replay(model, cut(logs, measured, model.nominal(), settings), threads)


def _simulated(replay: Replay) -> tuple[Array, Mask]:
    """Residuals of the windows (w, m) at nominal, and which of them diverge (w,)."""
    start = np.zeros((1, len(replay.windows), replay.nstate))
    residuals, infeasible = replay.residuals(replay.model.space.nominal[None], start)
    return residuals[0], infeasible[0]
