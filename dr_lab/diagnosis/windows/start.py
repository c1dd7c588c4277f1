"""First estimates of the windows' initial states, and how far they may be wrong."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_trapezoid

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.channels import Channel, available, unmeasured_joints
from dr_lab.diagnosis.windows.closed_loops import ClosedLoops
from dr_lab.diagnosis.windows.free_start import free_bodies, place_by_sensors
from dr_lab.diagnosis.windows.grounded import grounded
from dr_lab.diagnosis.windows.local_fits import DEGREE, fits
from dr_lab.diagnosis.windows.standing import stand
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.diagnosis.windows.tangent import tangent
from dr_lab.measurements.smoothing import local_polynomial
from dr_lab.trajectory import Array, Log, Noise, Signal


@dataclass(frozen=True)
class Before:
    """Measured motion in the middle of the p steps before w starts; joints without a channel rest at the model's pose.

    What swings for long is told by mean velocities in f longer intervals before these steps.

    Attributes:
        qpos: shape (w, p, nq).
        qvel: shape (w, p, nv).
        controls: of the steps, in the nominal model's ctrl layout, shape (w, p, nu).
        far: mean velocities, shape (w, f, nv).
        interval: s, length of each of the intervals.
    """

    qpos: Array
    qvel: Array
    controls: Array
    far: Array
    interval: float

    def pick(self, rows: NDArray[np.intp]) -> "Before":
        """The motion before some windows."""
        kept = {name: getattr(self, name)[rows] for name in ("qpos", "qvel", "controls", "far")}
        return replace(self, **kept)


def motion_before(
    logs: Sequence[Log], begins: Sequence[Array], model: mujoco.MjModel, controls: Array, settings: WindowSettings
) -> Before:
    """Local polynomials through the measured positions before every start; before a log its first sample holds.

    A joint whose velocity alone is measured comes to the model's pose by the integral of that. Mean velocities are
    differences of interpolated positions: what swings takes the mean of their noise by itself.

    Args:
        logs: the logs.
        begins: s on each log's clock at which its windows start.
        model: compiled nominal model.
        controls: of the p steps before each start, shape (w, p, nu).
        settings: how to cut.
    """
    count, steps = controls.shape[:2]
    edges = _far_edges(steps * model.opt.timestep, settings)
    far = np.zeros((count, max(len(edges) - 1, 0), model.nv))
    qpos, qvel = np.tile(model.qpos0, (count, steps, 1)), np.zeros((count, steps, model.nv))
    ago = (np.arange(-steps, 0) + 0.5) * model.opt.timestep
    for name in logs[0].outputs:
        channel = available(model)[name]
        alone = _is_alone(channel, logs[0].outputs)
        if (channel.kind == "position" or alone) and steps:
            signals = [_travelled(log.outputs[name]) if alone else log.outputs[name] for log in logs]
            pairs = [(signal, begin[:, None]) for signal, begin in zip(signals, begins, strict=True)]
            fits = [_path(signal, begin + ago, settings.smoother) for signal, begin in pairs]
            qpos[..., channel.address] = np.concatenate([value for value, _ in fits])
            qvel[..., channel.dof] = np.concatenate([slope for _, slope in fits])
            if alone:
                ends = np.concatenate([np.interp(begin, signal.time, signal.value) for signal, begin in pairs])
                qpos[..., channel.address] += model.qpos0[channel.address] - ends
            places = [np.interp(begin + edges, signal.time, signal.value) for signal, begin in pairs]
            far[..., channel.dof] = np.diff(np.concatenate(places), axis=1) / settings.interval
    return Before(qpos, qvel, controls, far, settings.interval)


def _is_alone(channel: Channel, measured: Collection[str]) -> bool:
    """Whether a channel is a joint's velocity, and its position is not measured."""
    return channel.kind == "velocity" and channel.name.removesuffix("velocity") + "position" not in measured


def _travelled(velocity: Signal) -> Signal:
    """The integral of a velocity from its first sample on."""
    return replace(velocity, value=cumulative_trapezoid(velocity.value, velocity.time, initial=0.0))


def _far_edges(memory: float, settings: WindowSettings) -> Array:
    """Edges of the intervals that end where the memory begins, s before a start, up to the lookback."""
    count = max(int((settings.lookback - memory) / settings.interval), 0)
    return -memory - settings.interval * np.arange(count, -1, -1, dtype=np.float64)


def _path(signal: Signal, times: Array, smoother: float) -> tuple[Array, Array]:
    """Position and velocity at times of shape (w, p); at rest before the log."""
    fit = local_polynomial(signal, np.maximum(times, signal.time[0]).ravel(), smoother, degree=DEGREE)
    slope = np.where(times < signal.time[0], 0.0, fit.slope.reshape(times.shape))
    return fit.value.reshape(times.shape), slope


def estimate_starts(
    logs: Sequence[Log],
    begins: Sequence[Array],
    model: mujoco.MjModel,
    noise: Mapping[str, Noise],
    settings: WindowSettings,
) -> StartPrior:
    """Local polynomials through the measured positions give every window's initial state.

    The prior's standard deviation is `prior_scale` times the larger of two errors: the noise (for a velocity divided
    by the smoother's half-width), and what the polynomial misses of the motion, told by how much it changes when it is
    narrower (root mean square over the windows; `local_fits.reaches`). A joint whose velocity alone is measured takes
    that; a free body is placed by the sensors of its frame, and on the ground if it stays there. Joints without a
    channel start where closed chains ask for it, or else at the model's reference.

    Returns:
        The prior of all windows, in the order of `begins`.
    """
    count = sum(len(b) for b in begins)
    qpos, (qvel, qacc) = np.tile(model.qpos0, (count, 1)), np.zeros((2, count, model.nv))
    std = np.concatenate(
        [np.full(model.nv, settings.unmeasured_position), np.full(model.nv, settings.unmeasured_velocity)]
    )
    for name in logs[0].outputs:
        channel, nv = available(model)[name], model.nv
        floor = noise[name].std * np.array([1.0, 1 / settings.smoother])
        if channel.kind == "position":
            means, wrong = fits(logs, name, begins, settings)
            qpos[:, channel.address], qvel[:, channel.dof], qacc[:, channel.dof] = means
            std[[channel.dof, nv + channel.dof]] = settings.prior_scale * np.maximum(floor, wrong[:2])
        elif _is_alone(channel, logs[0].outputs):
            means, wrong = fits(logs, name, begins, settings)
            qvel[:, channel.dof], qacc[:, channel.dof] = means[:2]
            std[nv + channel.dof] = settings.prior_scale * max(floor[0], wrong[0])
    prior = StartPrior(qpos, qvel, qacc, std)
    bodies = free_bodies(model, logs[0].outputs)
    for body in bodies:
        place_by_sensors(prior, body, logs, begins, noise, settings)
        if not body.position:
            stand(prior, body, model, settings)
    return grounded(_closed(prior, model, logs[0].outputs), bodies, model, settings)


def _closed(prior: StartPrior, model: mujoco.MjModel, measured: Collection[str]) -> StartPrior:
    """The prior in which unmeasured joints of closed chains are where the measured ones take them, if there are any."""
    if not model.neq:
        return prior
    loops, nv = ClosedLoops(model, placed(model, measured)), model.nv
    if not (loops.tells() or (loops.closes() and loops.firm())):
        return prior
    found = [loops.closed(*state) for state in zip(prior.qpos, prior.qvel, prior.qacc, strict=True)]
    slopes, free = (np.stack([getattr(each, name) for each in found]) for name in ("slopes", "free"))
    variance = prior.std.reshape(2, nv) ** 2
    told = np.einsum("wij,kj->kwi", slopes**2, variance) + free**2 * variance[:, None]
    std = np.sqrt(told.mean(1)).ravel()
    qpos, qvel, qacc = (np.stack([getattr(each, name) for each in found]) for name in ("qpos", "qvel", "qacc"))
    if not loops.firm():
        return StartPrior(qpos, qvel, qacc, std)
    nearest = [loops.nearest(q, v, std) for q, v in zip(qpos, qvel, strict=True)]
    qpos, qvel = (np.stack(each) for each in zip(*nearest, strict=True))
    directions = tangent([loops.constraints(q)[1] for q in qpos], std)
    return StartPrior(qpos, qvel, qacc, np.ones(directions.basis.shape[2]), directions)


def untold_joints(model: mujoco.MjModel, measured: Collection[str]) -> tuple[str, ...]:
    """Hinge and slide joints that neither measured channels show nor closed chains tell."""
    joints, loops = unmeasured_joints(model, tuple(measured)), ClosedLoops(model, placed(model, measured))
    if not joints or not loops.tells():
        return joints
    told = loops.told()
    return tuple(name for name in joints if not told[model.joint(name).dofadr[0]])


def placed(model: mujoco.MjModel, measured: Collection[str]) -> NDArray[np.bool_]:
    """Degrees of freedom whose position measured channels show, shape (nv,)."""
    known = np.zeros(model.nv, bool)
    channels = (available(model)[name] for name in measured)
    known[[channel.dof for channel in channels if channel.kind == "position"]] = True
    for body in free_bodies(model, measured):
        known[body.dof : body.dof + 3] = body.position is not None
        known[body.dof + 3 : body.dof + 6] = body.orientation is not None
    return known
