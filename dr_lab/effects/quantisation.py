"""A sensor that counts in steps."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.effect import Scales
from dr_lab.effects.scalar_sensor_effect import ScalarSensorEffect, measures_position, range_of, unit_of
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class Quantisation(ScalarSensorEffect):
    """A coarse encoder or converter.

    reading = step · round(q/step), for a joint's position or for one sensor.

    Parameters (nominal = absent): step ≥ 0 [rad, slide: m, sensor: unit of the reading].
    Limits: one number (no vector, no orientation), lattice through zero; a counter that rounds down has a
    `sensor_bias` of half a step besides. For steps that are known, as from a data sheet: the reading is piecewise
    constant, so a fit finds no step, though it starts at several. It need not: the noise that measurements are judged
    by holds step/√12 of the values' own lattice, against which rounding is no gap.
    Source: Widrow, Kollár and Liu, IEEE Transactions on Instrumentation and Measurement 45 (1996).

    Attributes:
        factor: largest step, in units of the range read.
        joint_least: smallest range of a joint, for joints that hardly move [rad or m].
        sensor_range: range of a sensor [unit of the reading].
        start_steps: steps of the fits that start away from absent, shares of the largest.
    """

    factor: float
    joint_least: float
    sensor_range: float
    start_steps: tuple[float, ...]

    name: ClassVar[str] = "quantisation"
    family: ClassVar[str] = "sensing"
    law: ClassVar[str] = "reading = step round(q / step)"
    fingerprint: ClassVar[str] = "sawtooth residual of the position, within half a step, quicker where the motion is"
    confused_with: ClassVar[tuple[str, ...]] = ()
    lacks: ClassVar[str] = "the steps of the reading, which belong to the measurement and not to the model"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The step."""
        high = self.factor * range_of(site, scales, self.joint_least, self.sensor_range)
        return (Parameter("step", unit_of(model, site), 0.0, 0.0, high),)

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """Position or sensor, rounded to the lattice; the steps of an absent one are none."""
        del begin
        if not measures_position(channel, site):
            return read
        step = values["step"][..., None]
        lattice = np.where(step > 0, step, 1.0)

        def counted(time: Array) -> Array:
            exact = read(time)
            return np.where(step > 0, lattice * np.rint(exact / lattice), exact)

        return counted

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Several steps: the slope tells nothing of a step that is far off."""
        (step,) = parameters
        return tuple({"step": share * step.high} for share in self.start_steps)
