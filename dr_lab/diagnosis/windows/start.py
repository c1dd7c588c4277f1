"""First estimates of the windows' initial states, and how far they may be wrong."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.channels import Channel, available, unmeasured_joints
from dr_lab.diagnosis.windows.closed_loops import ClosedLoops, Tangent, following, tangent
from dr_lab.diagnosis.windows.free_start import FreeBody, continuous, free_bodies, turn_between, turning
from dr_lab.measurements.smoothing import LocalFit, local_polynomial
from dr_lab.trajectory import Array, Log, Noise, Signal

_DEGREE = 3  # of the local polynomials
_DEPENDENT = 1e-3  # of a singular value: joints of a closed chain whose motions differ by less move together


@dataclass(frozen=True)
class StartPrior:
    """Gaussian prior of the windows' initial states.

    Attributes:
        qpos: mean positions, shape (w, nq).
        qvel: mean velocities, shape (w, nv).
        qacc: mean accelerations, which tell the state a little earlier or later, shape (w, nv).
        std: prior standard deviations of the unknowns: s of the state, then the k activations that nothing before the
            start tells, then what commands did between their samples, shape (s + k + u,).
        tangent: what the unknowns of the state do where chains are closed; None where they are changes of the positions
            and velocities in the tangent space, s = 2 nv.
    """

    qpos: Array
    qvel: Array
    qacc: Array
    std: Array
    tangent: Tangent | None = None

    @property
    def nstate(self) -> int:
        """Number s of unknowns of the state."""
        return 2 * self.qvel.shape[1] if self.tangent is None else self.tangent.basis.shape[2]

    def pick(self, rows: NDArray[np.intp]) -> "StartPrior":
        """The prior of some windows."""
        kept = self.tangent and self.tangent.pick(rows)
        return StartPrior(self.qpos[rows], self.qvel[rows], self.qacc[rows], self.std, kept)

    def change(self, unknowns: Array, moved: Array) -> Array:
        """Changes of positions and velocities: those of unknowns (…, w, s or more), and others (…, w, 2 nv).

        Of the others only what opens no chain counts.
        """
        of_state = unknowns[..., : self.nstate]
        if self.tangent is None:
            return of_state + moved
        along = of_state + np.einsum("wks,...ws->...wk", self.tangent.inverse, moved)
        return np.einsum("wsk,...wk->...ws", self.tangent.basis, along)

    def unknowns(self, change: Array) -> Array:
        """The unknowns that changes of positions and velocities (…, w, 2 nv) are, as far as they open no chain."""
        return change if self.tangent is None else np.einsum("wks,...ws->...wk", self.tangent.inverse, change)

    def independent(self, dofs: Sequence[int]) -> list[int]:
        """Those of some degrees of freedom that can move while the ones before them rest, in half of the windows."""
        if self.tangent is None:
            return list(dofs)
        kept = list[int]()
        for dof in dofs:
            rows = self.tangent.velocities[:, [*kept, dof]]
            rows = rows / np.maximum(np.linalg.norm(rows, axis=2, keepdims=True), np.finfo(float).tiny)
            if np.median(np.linalg.matrix_rank(rows, rtol=_DEPENDENT)) > len(kept):
                kept.append(dof)
        return kept

    def carried(self, dofs: Sequence[int]) -> Array:
        """Velocities of all joints while one of some degrees of freedom moves by 1, the others resting, (w, nv, n)."""
        if self.tangent is None:
            return np.broadcast_to(np.eye(self.qvel.shape[1])[:, list(dofs)], (*self.qvel.shape, len(dofs)))
        return following(self.tangent.velocities, dofs)

    def slope(self, slopes: Array, change: Array) -> Array:
        """What changes of positions and velocities (w, 2 nv) do to residuals with slopes (w, m, s or more), (w, m)."""
        return np.einsum("wms,ws->wm", slopes[..., : self.nstate], self.unknowns(change))


@dataclass(frozen=True)
class Before:
    """Measured motion in the middle of the p steps before w starts; joints without a channel rest at the model's pose.

    Attributes:
        qpos: shape (w, p, nq).
        qvel: shape (w, p, nv).
        controls: of the steps, in the nominal model's ctrl layout, shape (w, p, nu).
    """

    qpos: Array
    qvel: Array
    controls: Array

    def pick(self, rows: NDArray[np.intp]) -> "Before":
        """The motion before some windows."""
        return Before(self.qpos[rows], self.qvel[rows], self.controls[rows])


def motion_before(
    logs: Sequence[Log], begins: Sequence[Array], model: mujoco.MjModel, controls: Array, smoother: float
) -> Before:
    """Local polynomials through the measured positions before every start; before a log its first sample holds.

    Args:
        logs: the logs.
        begins: s on each log's clock at which its windows start.
        model: compiled nominal model.
        controls: of the p steps before each start, shape (w, p, nu).
        smoother: half-width of the polynomials in s.
    """
    count, steps = controls.shape[:2]
    qpos, qvel = np.tile(model.qpos0, (count, steps, 1)), np.zeros((count, steps, model.nv))
    ago = (np.arange(-steps, 0) + 0.5) * model.opt.timestep
    for name in logs[0].outputs:
        channel = available(model)[name]
        if channel.kind == "position" and steps:
            fits = [
                _path(log.outputs[name], begin[:, None] + ago, smoother)
                for log, begin in zip(logs, begins, strict=True)
            ]
            qpos[..., channel.address] = np.concatenate([value for value, _ in fits])
            qvel[..., channel.dof] = np.concatenate([slope for _, slope in fits])
    return Before(qpos, qvel, controls)


def _path(signal: Signal, times: Array, smoother: float) -> tuple[Array, Array]:
    """Position and velocity at times of shape (w, p); at rest before the log."""
    fit = local_polynomial(signal, np.maximum(times, signal.time[0]).ravel(), smoother, degree=_DEGREE)
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
    by the smoother's half-width), and what the polynomial misses of the motion, told by how much it changes at half
    the width (root mean square over the windows). A joint whose velocity alone is measured takes that; a free body is
    placed by the sensors of its frame. Joints without a channel start where closed chains ask for it, or else at the
    model's reference.

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
            means, wrong = _fits(logs, name, begins, settings)
            qpos[:, channel.address], qvel[:, channel.dof], qacc[:, channel.dof] = means
            std[[channel.dof, nv + channel.dof]] = settings.prior_scale * np.maximum(floor, wrong[:2])
        elif channel.kind == "velocity" and name.removesuffix("velocity") + "position" not in logs[0].outputs:
            means, wrong = _fits(logs, name, begins, settings)
            qvel[:, channel.dof], qacc[:, channel.dof] = means[:2]
            std[nv + channel.dof] = settings.prior_scale * max(floor[0], wrong[0])
    prior = StartPrior(qpos, qvel, qacc, std)
    for body in free_bodies(model, logs[0].outputs):
        _place(prior, body, logs, begins, noise, settings)
    return _closed(prior, model, logs[0].outputs)


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
    directions = tangent(loops, qpos, std)
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


def _place(
    prior: StartPrior,
    body: FreeBody,
    logs: Sequence[Log],
    begins: Sequence[Array],
    noise: Mapping[str, Noise],
    settings: WindowSettings,
) -> None:
    """Write a free body's place, orientation and velocities into the prior, as far as sensors show them."""
    widths, nv = (settings.smoother, settings.smoother / 2), prior.qvel.shape[1]
    for channel, address, dof in (
        (body.position, body.address, body.dof),
        (body.orientation, body.address + 3, body.dof + 3),
    ):
        if channel is None:
            continue
        wide, narrow = (_vectors(logs, channel, begins, width, settings) for width in widths)
        missed, error = wide[0] - narrow[0], noise[channel.name].std
        if channel is body.orientation:
            wide, narrow = turning(*wide), turning(*narrow)
            missed, error = turn_between(narrow[0], wide[0]), 2.0 * error  # a turn by φ moves a unit quaternion by φ/2
        dofs = np.arange(dof, dof + 3)
        prior.qpos[:, address : address + wide[0].shape[1]] = wide[0]
        prior.qvel[:, dofs], prior.qacc[:, dofs] = wide[1:]
        for first, wrong, floor in ((0, missed, error), (nv, wide[1] - narrow[1], error / settings.smoother)):
            prior.std[first + dofs] = settings.prior_scale * np.maximum(floor, np.sqrt((wrong**2).mean(0)))


def starts_known(signal: Signal, begins: Array, settings: WindowSettings) -> NDArray[np.bool_]:
    """Which starts have enough samples that they may know of."""
    if settings.run_in <= 0:
        return np.full(len(begins), len(signal) > _DEGREE)
    return np.searchsorted(signal.time, begins + (settings.margin + settings.run_in)) > _DEGREE


def _fits(logs: Sequence[Log], name: str, begins: Sequence[Array], settings: WindowSettings) -> tuple[Array, Array]:
    """Value, slope and curvature at each start, shape (3, w), and what the polynomial misses of each, shape (3,)."""
    signals = [log.outputs[name] for log in logs]
    wide, narrow = (
        np.stack(_local(signals, begins, width, settings)) for width in (settings.smoother, settings.smoother / 2)
    )
    return wide, np.sqrt(((wide - narrow) ** 2).mean(1))


def _vectors(
    logs: Sequence[Log], channel: Channel, begins: Sequence[Array], width: float, settings: WindowSettings
) -> tuple[Array, Array, Array]:
    """Value, slope and curvature of a vector channel at each start, shape (w, size) each."""
    signals = [log.outputs[channel.name] for log in logs]
    if channel.kind == "orientation":
        signals = [replace(signal, value=continuous(signal.value)) for signal in signals]
    return _local(signals, begins, width, settings)


def _local(
    signals: Sequence[Signal], begins: Sequence[Array], width: float, settings: WindowSettings
) -> tuple[Array, Array, Array]:
    """Value, slope and curvature at each start, from samples that it may know of, shape (w,) or (w, size) each."""
    lead = settings.margin + settings.run_in
    fits = []
    for signal, begin in zip(signals, begins, strict=True):
        # A sample at the end of the run-in belongs to the scored part.
        known = np.nextafter(begin + lead, -np.inf) if settings.run_in > 0 else np.inf
        fits.append(local_polynomial(signal, begin, width, until=known, degree=_DEGREE))
    value, slope, curvature = (np.concatenate([getattr(f, part) for f in fits]) for part in LocalFit._fields[:3])
    return value, slope, curvature
