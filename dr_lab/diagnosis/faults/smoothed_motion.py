"""Measured motion of all joints on one even grid: smoothed positions, velocities and accelerations."""

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import BSpline, make_smoothing_spline

from dr_lab.bounds import Positive, require_bounds
from dr_lab.diagnosis.windows.closed_loops import coupled
from dr_lab.diagnosis.windows.commands import actuator_columns, averages
from dr_lab.errors import ConfigError, DataError
from dr_lab.trajectory import Array, Log, MeasurementSet, Signal

Mask = NDArray[np.bool_]
Index = NDArray[np.intp]
_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
_FEWEST = 8  # samples that a smoothing spline of a joint is worth


@dataclass(frozen=True)
class EquationErrorSettings:
    """How the equation of motion is tested on measured motion.

    Attributes:
        step: s, of the grid on which the motion is evaluated.
        cutoff: Hz, at which the smoother passes half of a motion.
        half_width: s, half of a test function's support.
        hop: s, between the middles of two test functions.

    Raises:
        ConfigError: a number is not above 0, or the grid is too coarse for the test functions.
    """

    step: Positive
    cutoff: Positive
    half_width: float
    hop: Positive

    def __post_init__(self) -> None:
        require_bounds(self, "faults.equation")
        if not self.half_width >= 4 * self.step:
            raise ConfigError(
                f"faults.equation.half_width is {self.half_width:g}; expected at least four steps, {4 * self.step:g}."
            )


@dataclass(frozen=True)
class Motion:
    """Smoothed motion of l logs at n times, log after log.

    Attributes:
        log: index of each time's log, shape (n,).
        time: s on the log's clock, shape (n,).
        qpos: shape (n, nq).
        qvel: shape (n, nv).
        qacc: shape (n, nv).
        known: times at which every joint is measured: in no gap and not at a log's ends, shape (n,).
        step: s, between two times of a log.
    """

    log: Index
    time: Array
    qpos: Array
    qvel: Array
    qacc: Array
    known: Mask
    step: float

    def __len__(self) -> int:
        """Number of times."""
        return len(self.time)


def untestable(model: mujoco.MjModel, measured: MeasurementSet) -> str:
    """Why the equation of motion cannot be tested on these logs, empty if it can.

    Every degree of freedom must be a hinge or slide joint whose position or velocity is measured. No constraint may
    couple joints: what it bears is as large as what the encoders' noise stretches it by.
    """
    outputs = (*measured.fit, *measured.held_out)[0].outputs
    for i in range(model.njnt):
        joint = model.joint(i).name
        if int(model.jnt_type[i]) not in _SCALAR:
            return f"joint {joint} is neither a hinge nor a slide"
        if not {f"{joint}.position", f"{joint}.velocity"} & set(outputs):
            return f"neither position nor velocity of joint {joint} is measured"
    if coupled(model):
        return "an equality constraint couples joints, and no encoder shows its force"
    return "" if model.nv else "the model has no joint"


def smoothed_motion(
    model: mujoco.MjModel, measured: MeasurementSet, logs: Sequence[Log], settings: EquationErrorSettings
) -> Motion:
    """Smooth every joint's samples by a cubic smoothing spline and evaluate it on an even grid.

    The spline minimises Σ_i (y_i − f(t_i))² + λ ∫ f''² dt; samples every Δ s are passed with the gain
    1 / (1 + λ Δ ω⁴), so that λ = 1 / (Δ (2π cutoff)⁴). All derivatives are those of one function: noise that a test
    function averages out of an acceleration is averaged out as if the equation had been integrated by parts. Where the
    velocity of a joint is measured and not its position, that is the integral, from the model's reference on.

    Args:
        model: compiled model; see `untestable`.
        measured: gives the longest waits that are no gaps.
        logs: the logs, a part of `measured`.
        settings: grid and cutoff.

    Raises:
        DataError: no log is long enough.

    Source: Craven and Wahba 1979 for the spline; Silverman 1984 for its gain.
    """
    index, time = _even_times(logs, settings)
    qpos, (qvel, qacc) = np.tile(model.qpos0, (len(time), 1)), np.zeros((2, len(time), model.nv))
    known = np.ones(len(time), bool)
    for i in range(model.njnt):
        joint, adr, dof = model.joint(i).name, int(model.jnt_qposadr[i]), int(model.jnt_dofadr[i])
        integrated = f"{joint}.position" not in logs[0].outputs
        name = f"{joint}.{'velocity' if integrated else 'position'}"
        for k, signal in enumerate(log.outputs[name] for log in logs):
            rows = index == k
            if rows.any():
                path = smooth(signal, settings.cutoff)
                path = path.antiderivative() if integrated else path
                qpos[rows, adr] = path(time[rows]) + (model.qpos0[adr] if integrated else 0.0)
                qvel[rows, dof], qacc[rows, dof] = path(time[rows], 1), path(time[rows], 2)
                known[rows] &= _sampled(signal.time, time[rows], measured.gaps[name])
    return Motion(index, time, qpos, qvel, qacc, known, settings.step)


def controls_at(model: mujoco.MjModel, logs: Sequence[Log], motion: Motion, *, straight: bool = False) -> Array:
    """Controls of the grid's times, each the mean over one step around it, shape (n, nu).

    Delays that the model has compiled in are part of them.

    Args:
        model: compiled model.
        logs: the logs of the motion.
        motion: gives the times.
        straight: whether commands go straight from sample to sample instead of holding.
    """
    columns, controls = actuator_columns(model, logs), np.zeros((len(motion), model.nu))
    delays = {model.actuator(i).name: float(model.actuator_delay[i]) for i in range(model.nactuator)}
    for k, log in enumerate(logs):
        rows = motion.log == k
        for name, signal in log.commands.items() if rows.any() else ():
            time = motion.time[rows] - delays[name]
            if straight:
                controls[rows, columns[name]] = np.interp(time, signal.time, signal.value)
                continue
            edges = np.append(time, time[-1] + motion.step) - 0.5 * motion.step
            controls[rows, columns[name]] = averages({name: signal}, {name: 0}, 1, edges[None])[0, :, 0]
    return controls


def _even_times(logs: Sequence[Log], settings: EquationErrorSettings) -> tuple[Index, Array]:
    """The grid: places of the logs, and their times, log after log."""
    grids = [_grid(log, settings) for log in logs]
    if not sum(map(len, grids)):
        raise DataError(f"No log is longer than two periods of the smoother's cutoff ({2 / settings.cutoff:g} s).")
    return np.repeat(np.arange(len(logs)), [len(grid) for grid in grids]), np.concatenate(grids)


def _grid(log: Log, settings: EquationErrorSettings) -> Array:
    """Even times that all outputs of a log cover, without the ends, where a spline has no neighbours."""
    edge = 0.5 / settings.cutoff
    first = max(signal.time[0] for signal in log.outputs.values()) + edge
    last = min(signal.time[-1] for signal in log.outputs.values()) - edge
    enough = all(len(signal) >= _FEWEST for signal in log.outputs.values())
    return np.arange(first, last, settings.step) if enough and last - first > edge else np.empty(0)


def smooth(signal: Signal, cutoff: float) -> BSpline:
    """The smoothing spline of a signal whose gain falls to a half at a frequency in Hz; see `smoothed_motion`."""
    spacing = float(np.ptp(signal.time)) / (len(signal) - 1)
    # In units of the spacing and of the range, so that the penalty stays well conditioned whatever the units.
    size = float(np.ptp(signal.value)) or 1.0
    path = make_smoothing_spline(
        (signal.time - signal.time[0]) / spacing,
        (signal.value - signal.value[0]) / size,
        lam=(2 * np.pi * cutoff * spacing) ** -4,
    )
    return BSpline(path.t * spacing + signal.time[0], path.c * size + signal.value[0], path.k)


def _sampled(samples: Array, time: Array, gap: float) -> Mask:
    """Which times lie between two samples that no gap parts."""
    after = np.clip(np.searchsorted(samples, time), 1, len(samples) - 1)
    return samples[after] - samples[after - 1] <= gap
