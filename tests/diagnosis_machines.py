"""Machines whose logs have known answers, for the tests of the diagnosis."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cache
from typing import Any

import mujoco
import numpy as np
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.comparison.comparison import Comparison, ComparisonSettings
from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.faults.data_faults import Fault, suspect_faults
from dr_lab.diagnosis.faults.drive_fit import forces_of
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.localise import LocaliseSettings
from dr_lab.diagnosis.next_experiment.settings import ExperimentSettings
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings, WindowSettings
from dr_lab.diagnosis.windows.windows import Windows, cut
from dr_lab.physics.model import Model, from_spec
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise, Signal

NOISE = 1e-3
STEP = 0.002
PENDULUM = f"""<mujoco model="pendulum">
  <compiler angle="radian"/>
  <option timestep="{STEP}" integrator="RK4" gravity="0 0 -9.81"/>
  <worldbody><body name="rod">
    <inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.005 0.005 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="0.05"/>
  </body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator>
</mujoco>"""
PENDULUM_PARAMETERS = {
    "rod.mass": {"target": "body.rod.mass", "unit": "kg", "low": 0.1, "high": 1.5},
    "hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 0.5},
}
# Drag grows with the cube of the speed: with a tenth of its mass the rod is braked so hard that RK4 diverges when fast.
DRAGGED = """<mujoco model="dragged">
  <compiler angle="radian"/><option timestep="0.01" integrator="RK4"/>
  <worldbody><body name="rod"><inertial mass="{mass}" pos="0 0 -0.2" diaginertia="{inertia} {inertia} {inertia}"/>
    <joint name="hinge" axis="0 1 0" damping="0.02 0 0.03"/></body></worldbody>
  <actuator><motor name="drive" joint="hinge"/></actuator>
</mujoco>"""


@cache
def _settings() -> Any:  # noqa: ANN401 (Hydra's configuration)
    return compose("diagnose", ["effect=spring"])  # of the catalogue nothing is asked


def windows_settings(**changes: float) -> WindowSettings:
    """The default cutting, with changes."""
    return replace(instantiate(_settings().windows), **changes)


def predicted_settings(**changes: float) -> WindowSettings:
    """The default cutting of predicted windows, with changes."""
    return replace(instantiate(_settings().predicted), **changes)


def solver_settings(**changes: float) -> SolverSettings:
    """The default solver, with changes."""
    return replace(instantiate(_settings().solver), **changes)


def evidence_settings(**changes: float) -> EvidenceSettings:
    """The default rules of evidence, with changes."""
    return replace(instantiate(_settings().evidence), **changes)


def localise_settings(**changes: float) -> LocaliseSettings:
    """The default search for the place of failure, with changes."""
    return replace(instantiate(_settings().localise), **changes)


def model_check_settings(**changes: float) -> ModelCheckSettings:
    """The default check of a model, with changes."""
    return replace(instantiate(_settings().model_check), **changes)


def fault_settings() -> FaultSettings:
    """The default rules for faulty logs."""
    return instantiate(_settings().faults, _convert_="all")


def suspected(model: Model, measured: MeasurementSet, settings: FaultSettings) -> tuple[Fault, ...]:
    """Faults of logs that a model shows."""
    return suspect_faults(forces_of(model, measured, settings), measured)


def experiment_settings(**changes: Any) -> ExperimentSettings:  # noqa: ANN401 (of whichever setting)
    """The default search for the next experiment, with changes."""
    return replace(instantiate(_settings().next_experiment, _convert_="all"), **changes)


def comparison_settings(**changes: Any) -> ComparisonSettings:  # noqa: ANN401 (of whichever setting)
    """The default settings of a comparison on one thread, with changes."""
    return replace(instantiate(_settings().comparison.settings, _convert_="all", threads=1), **changes)


def short_comparison(model: Model, measurements: MeasurementSet, **changes: Any) -> Comparison:  # noqa: ANN401
    """A model beside a few seconds of logs, with the default settings and changes."""
    short = {"windows": windows_settings(seconds=2.4), "predicted": predicted_settings(seconds=2.4)}
    return Comparison(model, measurements, comparison_settings(**short | changes))


def model_of(xml: str, parameters: Mapping[str, Mapping[str, object]] | None = None) -> Model:
    """A model from MJCF text."""
    spec = mujoco.MjSpec.from_string(xml)
    return from_spec(spec.modelname, spec, parameters or {})


def pendulum() -> Model:
    """A damped pendulum with a motor; its mass and damping are free."""
    return model_of(PENDULUM, PENDULUM_PARAMETERS)


def steps_command(name: str, peak: float, seconds: float, seed: int, period: float = 0.1) -> Signal:
    """Random steps within ±peak, held for `period` s."""
    time = np.arange(0.0, seconds, period)
    return Signal(name, "N·m", time, np.random.default_rng(seed).uniform(-peak, peak, len(time)))


def clock(count: int, step: float = STEP) -> Array:
    """Even times from 0 on."""
    return np.asarray(step * np.arange(count), np.float64)


def no_force(data: mujoco.MjData) -> None:
    """Nothing beyond the model."""
    del data


def simulated(
    compiled: mujoco.MjModel,
    command: Signal | None,
    seconds: float,
    qpos: Sequence[float] | None = None,
    force: Callable[[mujoco.MjData], None] = no_force,
    refine: int = 1,
) -> dict[str, Array]:
    """MuJoCo's own motion: time, qpos, qvel at every step, and the sensors before it.

    Args:
        compiled: the machine.
        command: command of its first actuator, held; edges fall on steps.
        seconds: duration.
        qpos: start, at rest; None is the reference.
        force: called before every step, to write `qfrc_applied`.
        refine: steps per time step of the model.
    """
    compiled.opt.timestep /= refine
    data = mujoco.MjData(compiled)
    if qpos is not None:
        data.qpos[:] = qpos
    count = round(seconds / compiled.opt.timestep)
    rows: dict[str, list[Array]] = {"time": [], "qpos": [], "qvel": [], "sensordata": []}
    for k in range(count):
        now = k * compiled.opt.timestep
        if command is not None:
            data.ctrl[0] = command.value[np.searchsorted(command.time, now + 1e-9, side="right") - 1]
        force(data)
        rows["time"].append(np.array(now))
        rows["qpos"].append(data.qpos.copy())
        rows["qvel"].append(data.qvel.copy())
        mujoco.mj_step(compiled, data)
        rows["sensordata"].append(data.sensordata.copy())  # of the step's beginning
    compiled.opt.timestep *= refine
    return {name: np.array(values)[::refine] for name, values in rows.items()}


def log_of(name: str, outputs: Mapping[str, tuple[Array, Array]], command: Signal | None = None) -> Log:
    """A log from channel → (time, value)."""
    signals = {channel: Signal(channel, "", time, value) for channel, (time, value) in outputs.items()}
    return Log(name, signals, {} if command is None else {command.name: command})


def swinging(
    name: str,
    compiled: mujoco.MjModel,
    seed: int,
    *,
    seconds: float = 3.0,
    noise: float = NOISE,
    force: Callable[[mujoco.MjData], None] = no_force,
) -> Log:
    """A noisy log of a one-joint machine with joint `hinge` and motor `drive` under random steps of torque."""
    command = steps_command("drive", 1.0, seconds, seed)
    motion = simulated(compiled, command, seconds, qpos=[0.8], force=force)
    reading = motion["qpos"][:, 0] + noise * np.random.default_rng(1000 + seed).normal(size=len(motion["time"]))
    return log_of(name, {"hinge.position": (motion["time"], reading)}, command)


def dragged(mass: float, high: float = 2.0) -> Model:
    """A pendulum under drag with a free mass up to `high`; it is 1 kg in `slow_then_fast`."""
    free = {"rod.mass": {"target": "body.rod.mass", "unit": "kg", "low": 0.002, "high": high}}
    return model_of(DRAGGED.format(mass=mass, inertia=0.01 * mass), free)


def slow_then_fast(name: str, seed: int) -> Log:
    """A noisy log of the pendulum under drag, slow for 2 s and fast for another 2 s."""
    steps = steps_command("drive", 4.0, 4.0, seed, period=0.2)
    command = replace(steps, value=np.where(steps.time < 2.0, 0.0125, 1.0) * steps.value)
    motion = simulated(dragged(1.0).nominal(), command, 4.0)
    reading = motion["qpos"][:, 0] + NOISE * np.random.default_rng(1000 + seed).normal(size=len(motion["time"]))
    return log_of(name, {"hinge.position": (motion["time"], reading)}, command)


def measured(fit: Sequence[Log], held_out: Sequence[Log] = (), noise: float | None = None) -> MeasurementSet:
    """Logs with one noise for all channels, and gaps beyond 0.1 s."""
    channels = fit[0].outputs
    std = NOISE if noise is None else noise
    return MeasurementSet(
        name="test",
        fit=tuple(fit),
        held_out=tuple(held_out),
        noise={c: Noise(std, "", "given") for c in channels},
        gaps=dict.fromkeys(channels, 0.1),
    )


def windows_of(
    model: Model, logs: Sequence[Log], settings: WindowSettings | None = None, noise: float = NOISE
) -> Windows:
    """Windows of logs under the default cutting."""
    return cut(logs, measured(logs, noise=noise), model.nominal(), settings or windows_settings())


def true_starts(replay: Replay, z: Array, motion: Mapping[str, Array]) -> Array:
    """State corrections with which every window of one log starts in the log's own motion, shape (w, 2 nv)."""
    windows, nv = replay.windows, replay.compiled.nv
    tape, _ = replay.simulate(z[None], np.zeros((1, len(windows), replay.nstate)))
    step = np.rint(windows.begin / windows.step).astype(int)
    np.testing.assert_allclose(windows.begin, step * windows.step, atol=1e-9)
    delta = np.zeros((len(windows), 2 * nv))
    for row, k, guess in zip(delta, step, tape.qpos[0, :, 0], strict=True):
        mujoco.mj_differentiatePos(replay.compiled, row[:nv], 1.0, guess, motion["qpos"][k])
    delta[:, nv:] = motion["qvel"][step] - tape.qvel[0, :, 0]
    return delta


def formal_std(model: Model, fit: Fit) -> Array:
    """Standard deviations of a fitted context by the fit's information and prior alone, shape (n,)."""
    information = fit.equations.reduced.information + np.diag(fit.equations.prior)
    return np.sqrt(np.diag(np.linalg.inv(information))) * model.space.span
