"""The generalised force a model lacks, from how short windows bend away from the measurements."""

from dataclasses import dataclass

import mujoco
import numpy as np
from scipy.integrate import cumulative_trapezoid

from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.slopes import differences
from dr_lab.diagnosis.fit.states import StateFit
from dr_lab.diagnosis.settings import SolverSettings
from dr_lab.diagnosis.windows.channels import Tape
from dr_lab.diagnosis.windows.closed_loops import ClosedLoops
from dr_lab.trajectory import Array


@dataclass(frozen=True)
class ResidualForce:
    """Missing force at one joint over w windows.

    Attributes:
        position: joint position in the middle of each window, rad or m, shape (w,).
        velocity: mean joint velocity of each window, rad/s or m/s, shape (w,).
        force: force that would remove the error, N·m or N, NaN where the simulation diverges, shape (w,).
        noise: standard deviation that the measurements' noise alone gives the force, N·m or N, shape (w,).
    """

    position: Array
    velocity: Array
    force: Array
    noise: Array


def residual_forces(
    replay: Replay, fit: StateFit, solver: SolverSettings, tape: Tape | None = None
) -> dict[str, ResidualForce]:
    """Missing forces by joint whose position is measured, taken as constant within a window.

    An acceleration Δa that is missing from a window's start on shows as r(t) = S(t) δ + Δa ∫₀ᵗ S_v(τ) dτ, where S are
    the slopes by the start state, S_v those by the joint's velocity (a constant push is a train of velocity steps), and
    δ is how far the fitted start gave way to it. Least squares over all samples of the window give Δa of the joints
    whose position is measured, and F = M(q) Δa with the model's mass matrix at the window's middle. White noise of the
    samples goes the same way: Δa = G r has the covariance G Gᵀ, and F that of M G.

    Of joints that a closed chain moves together the first one stands for all of them: the others follow its push, and
    their masses count in M.

    Args:
        replay: short windows.
        fit: fit of their starts.
        solver: sizes of the steps by which slopes are taken.
        tape: what the model does from the fitted starts, if that is known.
    """
    model = replay.model.compile(fit.z)
    if tape is None:
        tape, _ = replay.simulate(fit.z[None], fit.delta[None])
    positions = [s.channel for s in replay.windows.samples if s.channel.kind == "position"]
    prior = replay.windows.prior
    dofs = prior.independent([channel.dof for channel in positions])
    measured = [channel for channel in positions if channel.dof in dofs]
    if not measured:
        return {}
    slopes = differences(replay, solver, fit, states=True, columns=np.zeros(0, np.intp))
    accelerations, covariance = _accelerations(replay, fit, slopes, dofs)
    middle = tape.qpos[0][:, tape.qpos.shape[2] // 2]
    chained = prior.tangent is not None and not prior.grounded
    mass = _masses(model, middle, dofs, ClosedLoops(model, np.ones(model.nv, bool)) if chained else None)
    forces = np.einsum("wij,wj->wi", mass, accelerations)
    forces[fit.infeasible] = np.nan
    noise = np.sqrt(np.einsum("wij,wjk,wik->wi", mass, covariance, mass))
    velocity = tape.qvel[0].mean(1)
    return {
        channel.name.removesuffix(".position"): ResidualForce(
            middle[:, channel.address], velocity[:, channel.dof], forces[:, k], noise[:, k]
        )
        for k, channel in enumerate(measured)
    }


def _accelerations(replay: Replay, fit: StateFit, slopes: Array, dofs: list[int]) -> tuple[Array, Array]:
    """Missing accelerations of n degrees of freedom, shape (w, n), and their covariance by noise, shape (w, n, n)."""
    used = (replay.fitted | replay.scored) & ~fit.infeasible[:, None]
    prior, nv, states = replay.windows.prior, replay.compiled.nv, slopes.shape[2]
    changes = np.zeros((len(dofs), len(slopes), 2 * nv))
    changes[..., nv:] = prior.carried(dofs).transpose(2, 0, 1)
    pushes = np.stack([_integral(replay, prior.slope(slopes, change)) for change in changes], axis=2)
    basis = np.where(used[..., None], np.concatenate([slopes, pushes], axis=2), 0.0)
    residuals = np.where(used, fit.residuals, 0.0)
    # In units of the columns' own size; what no sample shows stays 0, and the states' prior decides what few show.
    size = np.sqrt((basis**2).sum(1))
    size = np.where(size > 0, size, 1.0)
    basis = basis / size[:, None]
    prior = np.concatenate([replay.windows.prior.std**-2.0, np.zeros(len(dofs))]) / size**2
    ridge = (prior + np.finfo(float).eps)[:, :, None] * np.eye(size.shape[1])
    squares = basis.transpose(0, 2, 1) @ basis
    towards = np.linalg.solve(squares + ridge, basis.transpose(0, 2, 1))[:, states:] / size[:, states:, None]
    return -(towards @ residuals[..., None])[..., 0], towards @ towards.transpose(0, 2, 1)


def _integral(replay: Replay, slope: Array) -> Array:
    """∫₀ᵗ of a slope that starts at 0, channel by channel, shape (w, m) as the residuals."""
    parts = []
    for samples, part in replay.by_channel(slope):
        time = np.maximum.accumulate(samples.time, axis=1)  # padding behind the last sample adds nothing
        first = 0.5 * time[:, :1, None] * part[:, :1]
        rest = cumulative_trapezoid(part, time[..., None], axis=1, initial=0.0)
        parts.append((first + rest).reshape(len(part), -1))
    return np.concatenate(parts, axis=1)


def _masses(model: mujoco.MjModel, qpos: Array, dofs: list[int], loops: ClosedLoops | None) -> Array:
    """Mass matrix GᵀMG of n degrees of freedom at each position, shape (w, n, n); closed chains carry others along."""
    data, masses, full = (
        mujoco.MjData(model),
        np.empty((len(qpos), len(dofs), len(dofs))),
        np.empty((model.nv, model.nv)),
    )
    for q, mass in zip(qpos, masses, strict=True):
        data.qpos[:] = q
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fullM(model, data, full)
        carried = np.eye(model.nv)[:, dofs] if loops is None else loops.carried(q, dofs)
        mass[:] = carried.T @ full @ carried
    return masses
