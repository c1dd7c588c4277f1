"""Commands that act late where all of them are known ahead."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.actuator_effect import ActuatorEffect, actuator_of
from dr_lab.effects.effect import Scales
from dr_lab.errors import ModelError
from dr_lab.physics.effect_parts import CommandFilter, SpecPreparation
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

LINEAR = 1  # MuJoCo's code of an interpolation between commands


@dataclass(frozen=True)
class RecordedDelay(ActuatorEffect, SpecPreparation, CommandFilter):
    """`ActuatorDelay` of recorded commands.

    u(t − delay) by Catmull-Rom splines through the steps' averages: an edge keeps its impulse, its instant, and how
    sharp it is, so that positions err by the third power of the step. Straight lines, as MuJoCo has them, blur it by up
    to half a step either way. Every delay from 0 on acts, and is held through each step, also with RK4.

    Splines go up to 7 % beyond an edge. Where a command goes up to the end of its range, which would cut that off,
    straight lines keep the impulse.

    Source: Catmull and Rom, A class of local interpolating splines, Computer Aided Geometric Design (1974).

    Attributes:
        longest: upper bound of the delay [s].
        low: where the narrowest control range of its actuators cuts commands off.
        high: likewise.
    """

    longest: float
    low: float = -np.inf
    high: float = np.inf

    name: ClassVar[str] = "actuator_delay"
    family: ClassVar[str] = "actuator"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The delay."""
        del model, site, scales
        return (Parameter("delay", "s", 0.0, 0.0, self.longest),)

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Refuse an actuator that could not have the delay in a file."""
        require_readable(spec, site)

    @property
    def memory(self) -> float:
        """The longest delay."""
        return self.longest

    def filtered(self, values: Mapping[str, Array], series: Array, option: mujoco.MjOption) -> Array:
        """Commands late by m + f steps, each of the steps k + 1 − m to k − 2 − m with its weight of the spline."""
        delay = values["delay"] / option.timestep
        if not delay.any():
            return series
        whole, share = np.divmod(delay, 1.0)
        every = np.broadcast_to(series, np.broadcast_shapes(series.shape, delay.shape))
        newest = np.arange(series.shape[2]) - whole.astype(int) + 1
        late = (
            weight * np.take_along_axis(every, np.clip(newest - k, 0, series.shape[2] - 1), axis=2)
            for k, weight in enumerate((_line if self._is_cut_off(series) else _spline)(share))
        )
        return sum(late, np.zeros(1))

    def _is_cut_off(self, series: Array) -> bool:
        """Whether commands go up to the end of a range."""
        return bool(series.min() <= self.low or series.max() >= self.high)


def require_readable(spec: mujoco.MjSpec, site: str) -> None:
    """Refuse an actuator whose commands MuJoCo keeps and does not read linearly.

    Raises:
        ModelError: it is one.
    """
    actuator = actuator_of(spec, site)
    if actuator.nsample and actuator.interp != LINEAR:
        raise ModelError(
            f"Actuator {site!r} already keeps {actuator.nsample} commands. Take its delay out of the MJCF, or let "
            'it read between them (interp="linear"), or make no actuator_delay effect of it.'
        )


def _line(share: Array) -> tuple[Array, ...]:
    """The weights of a straight line, as of `_spline`."""
    return 0.0 * share, 1.0 - share, share, 0.0 * share


def _spline(share: Array) -> tuple[Array, ...]:
    """Catmull-Rom weights, latest first, of the four commands about a place that a share of a step is behind one."""
    rest = 1.0 - share
    return (
        -0.5 * share * rest**2,
        1.0 - 2.5 * share**2 + 1.5 * share**3,
        1.0 - 2.5 * rest**2 + 1.5 * rest**3,
        -0.5 * rest * share**2,
    )
