"""Two machines, simulated by MuJoCo at a fine step, with model errors that no candidate of the list can express."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from mujoco.batch import Batch

from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Array, Log, Signal
from nulls.noise import NOISES

STEP = 0.005  # s, of the models: RK4 is exact to 1e-7 rad there
PERIOD = 0.002  # s, between samples: 500 Hz
PARTS = 2  # of that period, each a step of the simulated machine
SECONDS = 6.0  # of a log
SPREAD = 0.15  # share by which true parameters differ from the model's
_DRIFT = 0.7  # Hz
_PERIODS = 9.0  # of the harmonic force in a turn
_SLOSH, _SLOSH_DAMPING = 2.5, 0.03  # Hz, ratio
_SINES, _SLOWEST, _FASTEST, _HELD = 3, 0.2, 3.0, 0.3  # of a command: number, Hz, Hz, s between steps

_LINK = '<inertial mass="{mass}" pos="0 0 {place}" diaginertia="{inertia} {inertia} 1e-4"/>'
_HEAD = f'<compiler angle="radian"/><option timestep="{STEP}" integrator="RK4" gravity="0 0 -9.81"/>'


@dataclass(frozen=True)
class Machine:
    """A machine that the script makes logs of.

    Attributes:
        name: of the machine.
        xml: MJCF text.
        parameters: of its model: masses and dampings, whose true values differ from the model's.
        peaks: N·m, largest command of each motor.
        std: rad, noise of the joints' positions.
    """

    name: str
    xml: str
    parameters: Mapping[str, Mapping[str, object]]
    peaks: tuple[float, ...]
    std: float

    def model(self) -> Model:
        """Its model."""
        spec = mujoco.MjSpec.from_string(self.xml)
        return from_spec(spec.modelname, spec, self.parameters)


def _free(target: str, unit: str, low: float, high: float) -> dict[str, object]:
    return {"target": target, "unit": unit, "low": low, "high": high}


PENDULUM = Machine(
    name="pendulum",
    xml=f"""<mujoco model="pendulum">{_HEAD}
  <worldbody><body name="rod">{_LINK.format(mass=0.5, place=-0.3, inertia=0.005)}
    <joint name="hinge" axis="0 1 0" damping="0.05"/></body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator></mujoco>""",
    parameters={
        "rod.mass": _free("body.rod.mass", "kg", 0.1, 1.5),
        "hinge.damping": _free("joint.hinge.damping", "N·m·s/rad", 0.0, 0.5),
    },
    peaks=(1.0,),
    std=1e-3,
)
ARM = Machine(
    name="arm",
    xml=f"""<mujoco model="arm">{_HEAD}
  <worldbody><body name="upper">{_LINK.format(mass=1.0, place=-0.15, inertia=0.01)}
    <joint name="shoulder" axis="0 1 0" damping="0.1"/>
    <body name="fore" pos="0 0 -0.3">{_LINK.format(mass=0.6, place=-0.12, inertia=0.005)}
      <joint name="elbow" axis="0 1 0" damping="0.05"/></body></body></worldbody>
  <actuator><motor name="first" joint="shoulder"/><motor name="second" joint="elbow"/></actuator></mujoco>""",
    parameters={
        "upper.mass": _free("body.upper.mass", "kg", 0.3, 3.0),
        "fore.mass": _free("body.fore.mass", "kg", 0.2, 2.0),
        "shoulder.damping": _free("joint.shoulder.damping", "N·m·s/rad", 0.0, 1.0),
        "elbow.damping": _free("joint.elbow.damping", "N·m·s/rad", 0.0, 0.5),
    },
    peaks=(2.0, 0.7),
    std=1e-3,
)
MACHINES = {machine.name: machine for machine in (PENDULUM, ARM)}

Force = Callable[[float, Array, float], Array]


def _drift(count: int, rng: np.random.Generator) -> Force:
    """A slow sine in time, its phase another one in each of `count` logs."""
    phase = rng.uniform(0.0, 2 * np.pi, count)
    return lambda time, position, step: np.sin(2 * np.pi * _DRIFT * time + phase)


def _harmonic(count: int, rng: np.random.Generator) -> Force:
    """A force with nine periods in a turn of the joint."""
    del count
    phase = rng.uniform(0.0, 2 * np.pi)
    return lambda time, position, step: np.sin(_PERIODS * position + phase)


def _slosh(count: int, rng: np.random.Generator) -> Force:
    """A hidden mass behind a soft and lightly damped spring: ÿ = ω² (q − y) − 2 ζ ω ẏ, and the force is that spring's.

    It starts at rest where the joint starts.
    """
    del rng
    pulse = 2 * np.pi * _SLOSH
    place, speed = np.zeros(count), np.zeros(count)

    def force(time: float, position: Array, step: float) -> Array:
        if time == 0.0:
            place[:] = position
        speed[:] += step * (pulse**2 * (position - place) - 2 * _SLOSH_DAMPING * pulse * speed)
        place[:] += step * speed
        return place - position

    return force


ERRORS: Mapping[str, Callable[[int, np.random.Generator], Force]] = {
    "drift": _drift,
    "harmonic": _harmonic,
    "slosh": _slosh,
}


@dataclass(frozen=True)
class Missing:
    """A model error: what the machine does at its last joint beside its model.

    Attributes:
        kind: of `ERRORS`.
        size: its factor, in N·m, of a slosh in N·m/rad; 0 for none.
    """

    kind: str
    size: float


@dataclass(frozen=True)
class Motions:
    """Noiseless motion of several logs of one machine.

    Attributes:
        machine: the machine.
        commands: N·m, held over each sample, shape (logs, samples, motors).
        positions: rad, shape (logs, samples, joints).
    """

    machine: Machine
    commands: Array
    positions: Array

    def logs(self, noise: str, rng: np.random.Generator) -> list[Log]:
        """The logs as an instrument with a kind of noise of `NOISES` reads them."""
        return [
            self._log(f"log_{k}", command, position, noise, rng)
            for k, (command, position) in enumerate(zip(self.commands, self.positions, strict=True))
        ]

    def _log(self, name: str, command: Array, position: Array, noise: str, rng: np.random.Generator) -> Log:
        compiled, time = self.machine.model().nominal(), np.asarray(PERIOD * np.arange(len(command)), np.float64)
        outputs = [f"{compiled.joint(k).name}.position" for k in range(compiled.njnt)]
        motors = [compiled.actuator(k).name for k in range(compiled.nu)]
        read = [NOISES[noise](column, PERIOD, self.machine.std, rng) for column in position.T]
        return Log(
            name,
            {c: Signal(c, "rad", time, value) for c, value in zip(outputs, read, strict=True)},
            {c: Signal(c, "N·m", time, value) for c, value in zip(motors, command.T, strict=True)},
        )


def move(machine: Machine, count: int, missing: Missing, rng: np.random.Generator) -> Motions:
    """Motion of `count` logs of one machine whose true parameters lie within ±15 % of its model's.

    All logs run side by side, as one batch. A model error acts from step to step, held over a millisecond.
    """
    model = machine.model()
    truth = model.space.nominal * rng.uniform(1 - SPREAD, 1 + SPREAD, len(model.space.nominal))
    compiled = model.compile(truth)
    compiled.opt.timestep = PERIOD / PARTS
    samples = round(SECONDS / PERIOD)
    commands = np.stack([_excitation(peak, count, samples, rng) for peak in machine.peaks], axis=-1)
    force = ERRORS[missing.kind](count, rng)
    batch = Batch(compiled, count, 1, persistent=True)
    position, control, applied = (batch.bind(name) for name in ("qpos", "ctrl", "qfrc_applied"))
    position[:] = rng.uniform(-0.5, 0.5, position.shape)
    positions = np.empty((count, samples, compiled.nq))
    for k in range(samples):
        positions[:, k], control[:] = position, commands[:, k]
        for part in range(PARTS):
            now = PERIOD * (k + part / PARTS)
            applied[:, -1] = missing.size * force(now, position[:, -1], PERIOD / PARTS)
            batch.step()
    return Motions(machine, commands, positions)


def _excitation(peak: float, count: int, samples: int, rng: np.random.Generator) -> Array:
    """Sines of random frequencies and random steps, half of the peak each at most, shape (logs, samples)."""
    time = PERIOD * np.arange(samples)
    frequency = np.exp(rng.uniform(np.log(_SLOWEST), np.log(_FASTEST), (count, _SINES, 1)))
    phase = rng.uniform(0.0, 2 * np.pi, (count, _SINES, 1))
    sines = np.sin(2 * np.pi * frequency * time + phase).mean(1)
    held = rng.uniform(-1.0, 1.0, (count, int(SECONDS / _HELD) + 1))[:, (time / _HELD).astype(int)]
    return 0.5 * peak * (sines + held)


def split(logs: Sequence[Log], fitted: int) -> tuple[tuple[Log, ...], tuple[Log, ...]]:
    """The first so many logs, and the others."""
    return tuple(logs[:fitted]), tuple(logs[fitted:])
