"""The self-test: a model must explain logs that it made itself, before anything is blamed on the machine."""

from collections.abc import Mapping
from dataclasses import replace

import mujoco
import numpy as np

from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import differences
from dr_lab.diagnosis.fit.states import StateFit, fit_states
from dr_lab.diagnosis.settings import SolverSettings, WindowSettings
from dr_lab.diagnosis.windows.activations import run_in_of
from dr_lab.diagnosis.windows.blocks import spread
from dr_lab.diagnosis.windows.windows import Windows, window_begins, windows_at
from dr_lab.errors import ModelError
from dr_lab.physics.activations import holders
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log, MeasurementSet, Signal

_NO_PARAMETER = np.zeros(0, np.intp)


def require_own_logs_explained(
    model: Model,
    measured: MeasurementSet,
    windows: WindowSettings,
    solver: SolverSettings,
    check: ModelCheckSettings,
) -> dict[str, float]:
    """Fit the states alone to logs that the model made under the machine's commands.

    From measured states the model, without its effects, goes on by itself for `check.lead`, so that all its hidden
    states are its own. What its sensors then report, with white noise, is cut into windows as real logs are. The fit
    starts at the truth: only what is neither restored nor an unknown of a window can leave more than noise.

    Args:
        model: the model as given.
        measured: the logs.
        windows: how they are cut.
        solver: settings of the fit.
        check: how much is tried.

    Returns:
        χ² per sample by channel; empty where every simulation diverges, or nothing is to be tried.

    Raises:
        ModelError: a channel leaves more than noise; the message names the hidden states.
    """
    bare = replace(model, effects=())
    own = _own_windows(bare, measured, windows, check) if check.windows else None
    if own is None:
        return {}
    replay, fit = _fitted(bare, *own, solver)
    found, limits = {}, {}
    for samples, residuals in replay.by_channel(fit.residuals):
        values = residuals[samples.scored & ~fit.infeasible[:, None]]
        if values.size:
            name = samples.channel.name
            found[name] = float((values**2).mean())
            limits[name] = check.most_chi2(values.size)
    _require(model, replay.compiled, found, limits)
    return found


def _own_windows(
    model: Model, measured: MeasurementSet, windows: WindowSettings, check: ModelCheckSettings
) -> tuple[Windows, Array, Array] | None:
    """Windows of the model's own logs, and the true positions and velocities at their starts.

    None where every stretch diverges, or no log has room for a window.
    """
    compiled, z = model.nominal(), model.space.nominal[None]
    logs, starts, steps = _stretches(measured, compiled, windows, check)
    if not logs:
        return None
    lead = steps * compiled.opt.timestep
    long = windows.of_length(windows.length + lead)
    replay = Replay(model, windows_at(logs, starts, measured, compiled, long), threads=1)
    tape, infeasible = replay.simulate(z, np.zeros((1, len(logs), replay.nstate)))
    kept = [k for k in range(len(logs)) if not infeasible[0, k]]
    if not kept:
        return None
    rng = np.random.default_rng(check.seed)
    shown = {s.channel.name: replay.reading(z, tape, s.channel)(s.time[None])[0] for s in replay.windows.samples}
    for samples in replay.windows.samples:
        value = shown[samples.channel.name]
        value += measured.noise[samples.channel.name].std * rng.normal(size=value.shape)
        if samples.channel.kind == "orientation":
            value /= np.linalg.norm(value, axis=-1, keepdims=True)
    own = [_own_log(logs[k], float(starts[k][0]), k, replay.windows, shown) for k in kept]
    windows_of = windows_at(own, [starts[k] + lead for k in kept], measured, compiled, windows)
    return windows_of, tape.qpos[0][kept, steps], tape.qvel[0][kept, steps]


def _stretches(
    measured: MeasurementSet, compiled: mujoco.MjModel, windows: WindowSettings, check: ModelCheckSettings
) -> tuple[list[Log], list[Array], int]:
    """Logs, starts and steps of the lead of stretches that end with a window; short logs have a shorter lead, or none.

    A log that has several stretches comes several times, each with one start.
    """
    step = compiled.opt.timestep
    wanted = int(np.ceil(max(check.lead, run_in_of(compiled, windows), windows.memory, windows.past) / step))
    for steps in (wanted, wanted // 2, wanted // 4, 0):
        long = windows.of_length(windows.length + steps * step)
        found = [(log, begin) for log in measured.fit for begin in window_begins(log, measured.gaps, long)]
        if found:
            chosen = spread(len(found), check.windows)
            return [found[k][0] for k in chosen], [np.array([found[k][1]]) for k in chosen], steps
    return [], [], 0


def _own_log(log: Log, start: float, row: int, windows: Windows, shown: Mapping[str, Array]) -> Log:
    """A log up to a stretch, and then what the model's sensors report."""
    outputs = {}
    for samples in windows.samples:
        name, exists = samples.channel.name, samples.fitted[row] | samples.scored[row]
        outputs[name] = _continued(log.outputs[name], start + samples.time[row][exists], shown[name][row][exists])
    return Log(log.name, outputs, log.commands)


def _continued(signal: Signal, time: Array, value: Array) -> Signal:
    """A measured signal up to where the model goes on by itself."""
    before = signal.time < time[0] if len(time) else np.ones(len(signal), bool)
    values = [signal.value[before], value.reshape(len(value), *signal.value.shape[1:])]
    return replace(signal, time=np.concatenate([signal.time[before], time]), value=np.concatenate(values))


def _fitted(model: Model, own: Windows, qpos: Array, qvel: Array, solver: SolverSettings) -> tuple[Replay, StateFit]:
    """States of the own windows, from the true positions and velocities."""
    replay, z = Replay(model, own, threads=1), model.space.nominal
    compiled, nv = replay.compiled, replay.compiled.nv
    tape, _ = replay.simulate(z[None], np.zeros((1, len(own), replay.nstate)))
    change, delta = np.zeros((len(own), 2 * nv)), np.zeros((len(own), replay.nstate))
    for row, true, guess in zip(change, qpos, tape.qpos[0, :, 0], strict=True):
        mujoco.mj_differentiatePos(compiled, row[:nv], 1.0, guess, true)
    change[:, nv:] = qvel - tape.qvel[0, :, 0]
    delta[:, : own.prior.nstate] = own.prior.unknowns(change)
    residuals, infeasible = replay.residuals(z[None], delta[None])
    start = Point(z, delta, residuals[0], np.inf, infeasible[0])
    slopes = differences(replay, solver, start, states=True, columns=_NO_PARAMETER)
    near = StateFit(z, delta, residuals[0], np.inf, infeasible[0], slopes)
    return fit_states(model, z, own, solver, 1, near)


def _require(model: Model, compiled: mujoco.MjModel, found: Mapping[str, float], limits: Mapping[str, float]) -> None:
    missed = {name: value for name, value in found.items() if not value <= limits[name]}
    if not missed:
        return
    worst = max(missed, key=lambda name: missed[name])
    listed = ", ".join(f"{name} {value:.3g}" for name, value in missed.items())
    hidden = "; ".join(_hidden(compiled)) or "none that is known: contacts and constraints alone"
    raise ModelError(
        f"Model {model.name!r} does not explain logs that it made itself: χ² per sample of {listed}, expected at most "
        f"{limits[worst]:.3g}. A window cannot restore a state that {worst} depends on, so that effects would be named "
        f"for it. Hidden states of the model: {hidden}. Take such elements out of the MJCF, or measure what shows "
        "their state (model_check.windows=0 goes on without this test)."
    )


def _hidden(model: mujoco.MjModel) -> list[str]:
    """What a model remembers beside positions and velocities, in words."""
    late = [model.actuator(i).name for i in range(model.nactuator) if model.actuator_history[i, 0]]
    sensors = [model.sensor(i).name for i in range(model.nsensor) if model.sensor_history[i, 0]]
    found = {
        "activation of actuator": list(dict.fromkeys(holders(model))),
        "delay of actuator": late,
        "delay of sensor (an effect such as sensor_time_offset tells it from logs)": sensors,
        "plugin": [model.plugin(i).name or str(i) for i in range(model.nplugin)] if model.npluginstate else [],
        "equality": [model.equality(i).name or str(i) for i in range(model.neq)],
        "tendon": [model.tendon(i).name for i in range(model.ntendon)],
    }
    return [f"{kind} {', '.join(names)}" for kind, names in found.items() if names]
