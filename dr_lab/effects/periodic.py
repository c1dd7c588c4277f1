"""Effects that repeat with a joint's position, so many times in a turn or over so many metres."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import pi
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.joint_effect import slides
from dr_lab.errors import ModelError
from dr_lab.physics.effect_parts import SensorTransform
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

PERIODS = "periods"
_A_TURN = "1/turn"


@dataclass(frozen=True)
class Periodic(Effect):
    """A sin(n q) + B cos(n q) with the amplitudes ``sine`` A and ``cosine`` B, whose n nobody wrote down.

    Of a reading that is the error of what turns n times as fast, and a share 1/n of it shows.

    The error as a function of n has a valley at every harmonic, so a fit stays near the n at which it begins. n is
    therefore searched before anything is fitted (`dr_lab.diagnosis.search.periods`), and the fit begins at what the
    search proposes: n is a parameter that shapes the effect. An n that the user gives is a constant of the effect.

    n is the phase in rad gained over 1 rad or 1 m: the periods in a turn of a hinge, 2π over the pitch of a slide.

    Attributes:
        periods: n [1/turn, slide: rad/m]; None: searched.
        turn: of a hinge the fewest n that are looked for, a usual one, and the most [1/turn].
        metre: the same of a slide [rad/m].
        start: A of the fits that begin away from absent where nothing was searched, share of its bound.
    """

    periods: float | None
    turn: tuple[float, float, float]
    metre: tuple[float, float, float]
    start: float

    shapes: ClassVar[tuple[str, ...]] = (PERIODS,)

    @property
    def read(self) -> bool:
        """Whether it is a reading that repeats; otherwise a force."""
        return isinstance(self, SensorTransform)

    def number(self, model: mujoco.MjModel, site: str, fewest: float, most: float) -> tuple[Parameter, ...]:
        """The parameter n; none where the user gave it.

        Args:
            model: the model.
            site: the joint.
            fewest: n below which the logs cannot tell the effect.
            most: n above which they cannot.

        Raises:
            ModelError: the logs can tell no n of those that are looked for.
        """
        if self.periods is not None:
            return ()
        slide = slides(model, site)
        least, usual, largest = self.metre if slide else self.turn
        low, high, unit = max(least, fewest), min(largest, most), "rad/m" if slide else _A_TURN
        if low >= high:
            raise ModelError(
                f"Of {least:g} to {largest:g} {unit} no number of periods can be told: half a period of {fewest:.3g} "
                f"is the joint's way in the logs, and at {most:.3g} a step of time is too long for its speed. Give "
                f"effects.{self.name}.{PERIODS}, logs in which the joint moves farther, or a finer step."
            )
        return (Parameter(PERIODS, unit, float(np.clip(usual, low, high)), low, high),)

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """The usual n, where the user gives none and nothing was searched."""
        return () if self.periods is not None else ({"sine": self.start * parameters[0].high},)


def half_a_period(site: str, scales: Scales) -> float:
    """The n of which half a period is the joint's way in the logs, 0 where that is not known.

    Within less, a sine is a force as a spring's, or a reading as a scale's and a bias'.
    """
    span = scales.position.get(site, 0.0)
    return pi / span if span > 0 else 0.0


def a_radian_a_step(model: mujoco.MjModel, site: str, scales: Scales) -> float:
    """The n whose phase moves by 1 rad in a step of time at the joint's speed in the logs."""
    speed = scales.speed.get(site, 0.0)
    return 1.0 / (speed * model.opt.timestep) if speed > 0 else np.inf


def tried(number: Parameter, way: float) -> Array:
    """Values of n that are tried within a parameter's bounds.

    What repeats with a turning joint does so a whole number of times in a turn: a motor, a gear. Along a slide two n
    differ by a phase of 2π over the way; a quarter of that is close enough for a fit to find the valley.

    Args:
        number: the parameter.
        way: of the joint in the logs, rad or m.
    """
    if number.unit == _A_TURN:
        return np.arange(np.ceil(number.low), np.floor(number.high) + 1)
    return np.arange(number.low, number.high, 0.5 * pi / way)
