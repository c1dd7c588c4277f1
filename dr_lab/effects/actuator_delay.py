"""Commands that act late."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar

import mujoco

from dr_lab.effects.actuator_effect import ActuatorEffect, actuator_of
from dr_lab.effects.effect import Effect, Scales
from dr_lab.effects.force_range import acts
from dr_lab.effects.recorded_delay import LINEAR, RecordedDelay, require_readable
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.parameter import Parameter


@dataclass(frozen=True)
class ActuatorDelay(ActuatorEffect, SpecEdit):
    """Bus, driver and controller latency between a command's stamp and its force.

    force(t) computed from u(t − delay).

    Commands that are all known ahead are shifted by `RecordedDelay`. Where they come while the simulation runs, and in
    exported files, MuJoCo keeps those of the last steps and interpolates them linearly:

    1. First-order integrators read at the start of a step. What they read is exactly the step's average of the late
       command.
    2. RK4 also reads in the middle and at the end, as if the step's command had been given at its start and not held
       through it. On average that is half a step early, for which the compiled delay makes up.
    3. MuJoCo cannot read the command of the running step. A delay below one step (one and a half with RK4) is none.

    A history of the same length is compiled in at every value.

    Parameters (nominal = absent): delay [s], within [0, longest].
    Limits: actuators with one command, which read linearly between commands if they have a delay of their own; an
    exported MJCF file lacks the short delays.
    Raises: ModelError if the actuator already has a delay and holds commands.
    Source: MuJoCo 4.0, modeling chapter ("Delays").

    Attributes:
        longest: upper bound of the delay [s].
        start_delays: delays of the fits that start away from absent [s].
    """

    longest: float
    start_delays: tuple[float, ...]

    name: ClassVar[str] = "actuator_delay"
    family: ClassVar[str] = "actuator"
    law: ClassVar[str] = "tau(t) from u(t - delay)"
    fingerprint: ClassVar[str] = "residual proportional to the rate of the command; passes for damping, or for its lack"
    confused_with: ClassVar[tuple[str, ...]] = ("sensor_time_offset", "viscous_friction", "joint_elasticity")
    sizeless: ClassVar[bool] = True
    lacks: ClassVar[str] = "a delay below one physics step (one and a half with RK4)"

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The delay."""
        del model, site, scales
        return (Parameter("delay", "s", 0.0, 0.0, self.longest),)

    def limit(self, name: str, kept: float, margin: float) -> float:
        """Most of the commands that are kept, so that each reading finds one."""
        del name, margin
        return 0.9 * kept

    def within(self, parameters: tuple[Parameter, ...]) -> "ActuatorDelay":
        """The delay whose history is as long as its bound."""
        return replace(self, longest=parameters[0].high)

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Compile the history in, and the delay where it is at least one step, beside one that is there."""
        require_readable(spec, site)
        actuator = actuator_of(spec, site)
        early = _read_early(spec.option)
        actuator.nsample += math.ceil((self.longest + early) / spec.option.timestep) + 1
        actuator.interp = LINEAR
        if values["delay"] >= _shortest(spec.option):
            actuator.delay = (actuator.delay or early) + values["delay"]

    def expressible(self, values: Mapping[str, float], option: mujoco.MjOption) -> bool:
        """Whether there is no delay, or none that is too short for MuJoCo."""
        return not 0 < values["delay"] < _shortest(option)

    def replayed(self, spec: mujoco.MjSpec, elements: Sequence[str]) -> Effect:
        """The same of commands that are known ahead."""
        own = [spec.actuator(name) for name in elements]
        ranges = [each.ctrlrange for each in own if acts(spec, each.ctrllimited, each.ctrlrange)]
        low, high = (max((r[0] for r in ranges), default=-math.inf), min((r[1] for r in ranges), default=math.inf))
        return RecordedDelay(self.longest, float(low), float(high))

    def lacking(self, site: str, values: Mapping[str, float], option: mujoco.MjOption) -> str:
        """A delay that is too short for MuJoCo."""
        return "" if self.expressible(values, option) else f"commands of {site} act {values['delay']:.6g} s late"

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Several delays: a long one has another best damping, hence local minima."""
        del parameters
        return tuple({"delay": delay} for delay in self.start_delays)


def _read_early(option: mujoco.MjOption) -> float:
    """Time in s by which the integrator reads commands too early, averaged over a step."""
    return option.timestep / 2 if option.integrator == mujoco.mjtIntegrator.mjINT_RK4 else 0.0


def _shortest(option: mujoco.MjOption) -> float:
    """Shortest delay in s whose every reading lies at or before the last completed step."""
    return option.timestep + _read_early(option)
