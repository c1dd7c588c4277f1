"""Logs of a model with chosen parameters and effects: a machine whose truth the user sets."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any

import mujoco
import numpy as np
import yaml

from dr_lab.bounds import Positive, above, below, require_bounds
from dr_lab.channel_names import POSITION, VELOCITY
from dr_lab.diagnosis.experiment import readings
from dr_lab.effects.effect import Effect
from dr_lab.effects.named import require_possible, with_named_effects
from dr_lab.errors import ConfigError, ModelError, UnknownNameError
from dr_lab.physics.model import Model
from dr_lab.physics.naming import joints
from dr_lab.plants.excitation import SinesAndSteps
from dr_lab.plants.instruments import Instruments, RobotClock
from dr_lab.recorders.mcap import FloatArrays, JointStates
from dr_lab.seeding import stream
from dr_lab.sources.recorded_map import RecordedMap
from dr_lab.sources.source import NamedLog
from dr_lab.trajectory import Array, Signal

_SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
_NANOSECONDS = 9  # decimals of the stamps of an MCAP file; what happens, happens at the rounded times
_WARNING = "# The truth behind these logs. Whoever looks for what is missing must not read it.\n"


@dataclass(frozen=True)
class ModelSource:
    """Experiments on the machine that a model describes; each log starts at rest, at time 0.

    Hinge and slide joints are recorded and every actuator with a single command is driven; MuJoCo sensors are left out.

    Attributes:
        model: the machine as documented.
        effects: the catalogue from which `context` takes effects.
        context: true values by parameter name, of the model's own parameters (``arm.mass``) and of effects
            (``coulomb_friction@arm.torque``), which are in the machine where they are named; None changes nothing.
        peaks: largest |command| by actuator, in its unit; None, or an actuator not named, takes half of its ctrlrange.
            Commands lie about the middle of the ctrlrange, about 0 without one.
        start: joint positions in rad or m at which a log begins; None, or a joint not named, takes the model's own.
        shares: size of the commands of log_1, log_2 … relative to the peaks; their number is the number of logs.
        duration: length of a log in s.
        excitation: shape of each command.
        instruments: rates, encoders, velocities, clocks and latencies.
        travel: m that a slide moves in one revolution of its encoder.
        joint_topic: topic of the encoder readings, ``sensor_msgs/msg/JointState``; velocities only where the
            instruments report them.
        command_topic: each command goes to ``<command_topic>/<actuator>``, ``std_msgs/msg/Float64MultiArray``.

    Raises:
        ConfigError: no log is asked for, or one too short for a command and a sample; the peak of a command is missing,
            a number is not finite, a parameter lies outside its bounds, or no machine has such values.
        ModelError: there is no joint to record.
        UnknownNameError: a parameter, effect, site, actuator or joint does not exist.
    """

    model: Model
    effects: Mapping[str, Effect]
    context: Mapping[str, float] | None
    peaks: Mapping[str, float] | None
    start: Mapping[str, float] | None
    shares: Sequence[float]
    duration: Annotated[float, above(0.0), below(np.inf)]
    excitation: SinesAndSteps
    instruments: Instruments
    travel: Positive
    joint_topic: str
    command_topic: str

    def __post_init__(self) -> None:
        require_bounds(self, "source")
        for key in ("context", "peaks", "start"):
            _require_finite(key, getattr(self, key) or {})
        _require_finite("shares", dict(enumerate(self.shares)))
        slowest = min(self.instruments.sample_rate, self.instruments.command_rate)
        if not self.shares or self.duration * slowest < 2:
            given = f"{len(self.shares)} shares, {self.duration:g} s"
            raise ConfigError(f"A recording needs a share for each log and two samples in it; got {given}.")
        # What is wrong is said before anything is written.
        self._machine()
        self._ranges()
        self._start()

    def logs(self, seed: int) -> Iterator[NamedLog]:
        """The logs of the machine; the seed draws commands, jitter and the robot's clock.

        Raises:
            ModelError: the true context does not compile, or its simulation diverges.
        """
        machine, z = self._machine()
        for index, share in enumerate(self.shares):
            yield self._record(machine, z, seed, f"log_{index + 1}", share)

    def companions(self, seed: int) -> Mapping[str, bytes]:
        """``truth.yaml``, and under ``measurements`` the configuration that reads the logs."""
        machine, z = self._machine()
        truth = {
            "seed": seed,
            "model": self.model.name,
            "effects": [effect.label for effect in machine.effects],
            "parameters": machine.space.mapping(z),
            "clock": asdict(self._clock(seed)),
            "latency": {
                "transport": self.instruments.transport_latency,
                "actuation": self.instruments.actuation_latency,
            },
        }
        compiled = self.model.nominal()
        slides = {name: _slides(compiled, name) for name in _recorded(compiled)}
        described = RecordedMap(self.model.name, len(self.shares), slides, tuple(self._ranges()))
        text = described.text(self.joint_topic, self.command_topic, self.instruments)
        return {
            "truth.yaml": (_WARNING + yaml.safe_dump(truth, sort_keys=False, allow_unicode=True)).encode(),
            described.file: text.encode(),
        }

    def _machine(self) -> tuple[Model, Array]:
        """The model with the effects that the context names, and the true context."""
        values = self.context or {}
        for parameter in self.model.declared:
            value = values.get(parameter.name, parameter.nominal)
            if not parameter.low <= value <= parameter.high:
                end = "low" if value < parameter.low else "high"
                raise ConfigError(
                    f"context: {parameter.name} is {value:g} {parameter.unit}; expected a value within its bounds, "
                    f"{parameter.low:g} to {parameter.high:g}. Widen them: model.parameters.{parameter.name}.{end}=…"
                )
        machine = with_named_effects(self.model, self.effects, values)
        z = machine.space.vector(values)
        require_possible(machine, z, "context")
        return machine, z

    def _clock(self, seed: int) -> RobotClock:
        return self.instruments.clock(0.0, stream(seed, "clock"))

    def _record(self, machine: Model, z: Array, seed: int, name: str, share: float) -> NamedLog:
        tools, compiled = self.instruments, self.model.nominal()
        issued = tools.command_times(self.duration, stream(seed, name, "command")).round(_NANOSECONDS)
        sampled = tools.sample_times(self.duration, stream(seed, name, "sample")).round(_NANOSECONDS)
        values = {
            actuator: middle + self.excitation.command(issued, share * peak, stream(seed, name, "excitation", actuator))
            for actuator, (middle, peak) in self._ranges().items()
        }
        acting = {a: Signal(a, "", issued + tools.actuation_latency, value) for a, value in values.items()}
        names = _recorded(compiled)
        channels = [f"{joint}.{what}" for what in (POSITION, VELOCITY) for joint in names]
        shown = readings(machine, z, self._start(), acting, channels, sampled)
        position, velocity = np.split(np.concatenate([shown[name] for name in channels], axis=1), 2, axis=1)
        turns = np.array([2 * np.pi / self.travel if _slides(compiled, joint) else 1.0 for joint in names])
        stamp, read = self._clock(seed).read(sampled), tools.read(position, turns, stream(seed, name, "noise"))
        states = JointStates(
            topic=self.joint_topic,
            names=names,
            stamp=stamp,
            log_time=tools.arrival(sampled, stream(seed, name, "transport")),
            position=read,
            velocity=tools.reported(stamp, read, velocity, turns, stream(seed, name, "velocity")),
        )
        every = slice(None, None, tools.logged_every)
        sent = [
            FloatArrays(f"{self.command_topic}/{a}", (a,), issued[every], value[every, None])
            for a, value in values.items()
        ]
        return NamedLog(name, (states, *sent), {"source": "simulated machine"})

    def _ranges(self) -> dict[str, tuple[float, float]]:
        """Middle and peak of each command, by actuator."""
        compiled, given = self.model.nominal(), self.peaks or {}
        rows = {compiled.actuator(i).name: i for i in range(compiled.nactuator) if compiled.actuator_ctrlnum[i] == 1}
        for name in given:
            if name not in rows:
                raise UnknownNameError("actuator", name, rows, f"model {self.model.name!r} (peaks)")
        ranges = {}
        for name, row in rows.items():
            column = int(compiled.actuator_ctrladr[row])
            low, high = compiled.actuator_ctrlrange[column] if compiled.actuator_ctrllimited[column] else (0.0, 0.0)
            if name not in given and low == high:
                raise ConfigError(
                    f"Actuator {name!r} of model {self.model.name!r} has no ctrlrange. Say how large its command gets: "
                    f"peaks={{{name}:NUMBER}}."
                )
            ranges[name] = (float(low + high) / 2, float(given.get(name, (high - low) / 2)))
        return ranges

    def _start(self) -> Array:
        """Start positions, shape (nq,)."""
        compiled = self.model.nominal()
        qpos, names = compiled.qpos0.copy(), _recorded(compiled)
        for name, value in (self.start or {}).items():
            if name not in names:
                raise UnknownNameError("joint", name, names, f"model {self.model.name!r} (start)")
            qpos[compiled.joint(name).qposadr[0]] = value
        return qpos


def _require_finite(key: str, values: Mapping[Any, float]) -> None:
    for name, value in values.items():
        if not np.isfinite(value):
            raise ConfigError(f"{key}: {name} is {value:g}; expected a finite number.")


def _recorded(compiled: mujoco.MjModel) -> tuple[str, ...]:
    """Names of the hinge and slide joints.

    Raises:
        ModelError: there are none.
    """
    names = joints(compiled, _SCALAR)
    if not names:
        raise ModelError("A recording needs a hinge or slide joint; the model has none.")
    return names


def _slides(compiled: mujoco.MjModel, joint: str) -> bool:
    return int(compiled.joint(joint).type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
