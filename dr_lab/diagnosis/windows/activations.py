"""Activations at a window's start: told by the commands and the motion before, or unknowns of the window."""

from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from mujoco.batch import Batch
from numpy.typing import NDArray

from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.commands import actuator_columns, averages
from dr_lab.diagnosis.windows.start import Before, motion_before
from dr_lab.diagnosis.windows.start_prior import StartPrior
from dr_lab.physics.activations import holders, resting, time_constants
from dr_lab.physics.follow import follow
from dr_lab.trajectory import Array, Log

_LONGEST_RUN = 5000  # steps of a run along whole logs, which becomes coarser beyond


@dataclass(frozen=True)
class Activations:
    """Where activations begin the run-in before w windows, and which the run-in does not tell.

    Attributes:
        begin: activations before the first remembered step, shape (w, na).
        unknown: entries that do not forget where they began, and are fitted in every window, shape (k,).
        std: how far those may be off at the window's start, in their own units, shape (k,).
    """

    begin: Array
    unknown: NDArray[np.intp]
    std: Array

    def pick(self, rows: NDArray[np.intp]) -> "Activations":
        """The activations of some windows."""
        return replace(self, begin=self.begin[rows])


def run_in_of(model: mujoco.MjModel, settings: WindowSettings) -> float:
    """Time in s before a window's start in which its activations forget; those that take too long are left out."""
    return settings.forgotten * float(time_constants(model)[~_lasting(model, settings)].max(initial=0.0))


def activations(
    logs: Sequence[Log],
    begins: Sequence[Array],
    model: mujoco.MjModel,
    before: Before,
    prior: StartPrior,
    settings: WindowSettings,
) -> Activations | None:
    """What is known of the activations of windows; None where the model has none.

    Those that forget within `longest_run_in` begin the run-in at rest under the command of then. For the others the
    model's actuators are taken along the measured motion from each log's first sample on, at rest before it. How far
    that may be off: as far as they change in a log, or as they must to give the actuators' typical force.

    Args:
        logs: the logs.
        begins: s on each log's clock at which its windows start.
        model: compiled nominal model.
        before: motion and controls that are remembered.
        prior: of the windows' starts.
        settings: how windows are cut.
    """
    if not model.na:
        return None
    unknown = np.flatnonzero(_lasting(model, settings))
    steps = before.qpos.shape[1]
    start = resting(model, before.qpos[:, 0], before.controls[:, 0]) if steps else np.zeros((len(prior.qpos), model.na))
    if not len(unknown):
        return Activations(start, unknown, np.zeros(0))
    known, spread = _along(logs, begins, model, steps * model.opt.timestep, settings)
    start[:, unknown] = known[:, unknown]
    std = np.fmax(spread, _needed(model, prior, start))[unknown]
    return Activations(start, unknown, np.where(std > 0, std, 1.0))


def _lasting(model: mujoco.MjModel, settings: WindowSettings) -> NDArray[np.bool_]:
    """Activations that a run-in does not tell: those that forget too slowly, and what they drive, shape (na,).

    A motor's current follows its controller's integral, so that all activations of one actuator go together.
    """
    slow = time_constants(model) > settings.longest_run_in / settings.forgotten
    owners = np.array(holders(model))
    return np.isin(owners, owners[slow])


def _along(
    logs: Sequence[Log], begins: Sequence[Array], model: mujoco.MjModel, before: float, settings: WindowSettings
) -> tuple[Array, Array]:
    """Activations `before` s before every window, shape (w, na), and how far they spread in a log, shape (na,)."""
    first = [min(s.time[0] for s in (*log.outputs.values(), *log.commands.values())) for log in logs]
    last = [float(begin[-1]) for begin in begins]
    longest = max(b - a for a, b in zip(first, last, strict=True))
    coarse = copy(model)
    coarse.opt.timestep = step = max(model.opt.timestep, longest / _LONGEST_RUN)
    count = int(np.ceil(longest / step)) + 1
    edges, columns = step * np.arange(-count, 1), actuator_columns(model, logs)
    ends = [np.array([end]) for end in last]
    controls = np.concatenate(
        [averages(log.commands, columns, model.nu, end[:, None] + edges) for log, end in zip(logs, ends, strict=True)]
    )
    motion = motion_before(logs, ends, coarse, controls, settings)
    batch = Batch(coarse, len(logs), 1)
    run = follow(batch, motion.qpos, motion.qvel, controls, resting(coarse, motion.qpos[:, 0], controls[:, 0]))
    run = np.nan_to_num(run.transpose(1, 0, 2), posinf=0.0, neginf=0.0)
    at = [
        run[k, np.clip(np.floor((begin - before - end) / step).astype(int) + count - 1, 0, count - 1)]
        for k, (begin, end) in enumerate(zip(begins, last, strict=True))
    ]
    return np.concatenate(at), np.ptp(run, axis=1).max(0)


def _needed(model: mujoco.MjModel, prior: StartPrior, act: Array) -> Array:
    """Root mean square over the windows of how much of each activation the measured motion asks for, shape (na,).

    By inverse dynamics τ, and with the slope g = ∂τ/∂a of the actuators' forces, a = gᵀτ / gᵀg; zero where an
    activation pushes nothing at once.
    """
    data, found = mujoco.MjData(model), np.zeros((len(act), model.na))
    for row, q, v, a, w in zip(found, prior.qpos, prior.qvel, prior.qacc, act, strict=True):
        data.qpos[:], data.qvel[:], data.act[:], data.qacc[:] = q, v, w, a
        mujoco.mj_inverse(model, data)
        asked = data.qfrc_inverse.copy()
        mujoco.mj_forward(model, data)
        given = data.qfrc_actuator.copy()
        for i in range(model.na):
            data.act[i] += 1.0
            mujoco.mj_forward(model, data)
            slope = data.qfrc_actuator - given
            data.act[i] -= 1.0
            row[i] = slope @ asked / (slope @ slope) if slope.any() else 0.0
    return np.sqrt((np.nan_to_num(found, posinf=0.0, neginf=0.0) ** 2).mean(0))
