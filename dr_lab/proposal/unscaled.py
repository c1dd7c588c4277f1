"""Bodies whose forces have no known scale, as of a pendulum that swings freely.

One factor on all masses, springs and brakes of a machine leaves its motion as it is, unless a force is known that does
not take part: a command, a documented spring, a rotor's inertia. Without one the inertial forces of a body are the
balance itself, so that its mass only scales the damping: no period shows it.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from dr_lab.diagnosis.faults.equation_error import actuation, demand, parameter_columns
from dr_lab.diagnosis.faults.smoothed_motion import Motion
from dr_lab.physics.model import Model
from dr_lab.proposal.drives import Command
from dr_lab.proposal.output import Positions
from dr_lab.proposal.per_control import made_up_motion
from dr_lab.proposal.positions import unhindered
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.trajectory import Array

STEP = 0.01  # share of a parameter, for its influence
_SAME = 1e-6  # share of the largest singular value below which columns are the same
_NONE = 1e-9  # share of the largest force that is rounding
_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


@dataclass(frozen=True)
class Unscaled:
    """Bodies that share a scale which nothing fixes.

    Attributes:
        bodies: names.
        heaviest: the one whose mass gives the others their scale.
        dofs: degrees of freedom that move them.
    """

    bodies: tuple[str, ...]
    heaviest: str
    dofs: tuple[int, ...]

    @property
    def mass(self) -> str:
        """The parameter that stays as documented."""
        return f"{self.heaviest}.mass"

    def most(self, model: Model) -> int:
        """How many parameters of the bodies a motion can tell apart at best, once the scale is taken out.

        Args:
            model: whose parameters are all that the bodies have, named after them.
        """
        space = model.space
        mine = [k for k, name in enumerate(space.names) if name.rsplit(".", 1)[0] in self.bodies]
        columns = influence(model, made_up_motion(model.nominal()))[:, self.dofs][..., mine]
        rows = columns.reshape(-1, len(mine))
        size = np.linalg.norm(rows, axis=0)
        return int(np.linalg.matrix_rank(rows / np.where(size > 0, size, 1.0), tol=_SAME)) - 1


def unscaled(
    masses: Model, found: Positions, commands: Sequence[Command], settings: ProposalSettings
) -> tuple[Unscaled, ...]:
    """The bodies whose scale no known force fixes, each set of them by itself.

    Args:
        masses: whose parameters are the masses of the bodies that move, called ``<body>.mass``.
        found: what is known of the motion; where it is not, one is made up.
        commands: what drives the robot.
        settings: which share of the forces a known force must be.
    """
    known = _known(masses, found, commands)
    model, names = masses.nominal(), masses.space.names
    groups = []
    for dofs in _together(model):
        bodies = [
            b for b in dict.fromkeys(model.body(int(model.dof_bodyid[d])).name for d in dofs) if f"{b}.mass" in names
        ]
        if bodies and known[list(dofs)].max() < settings.felt:
            heaviest = max(bodies, key=lambda body: float(model.body(body).mass[0]))
            groups.append(Unscaled(tuple(bodies), heaviest, dofs))
    return tuple(groups)


def influence(model: Model, motion: Motion) -> Array:
    """What a step of each parameter, relative to its reach, changes in the forces, shape (n, nv, parameters)."""
    nominal = model.nominal()
    controls = np.zeros((len(motion), nominal.nu))
    sizes = reach(model)
    columns = parameter_columns(_free(model), model.space.nominal, STEP * sizes, motion, controls)
    return columns * sizes


def reach(model: Model) -> Array:
    """Sizes of the parameters, of which shares are meant: of a centre of mass its distance from the hinge."""
    nominal, sizes = model.nominal(), model.space.nominal.copy()
    for k, name in enumerate(model.space.names):
        body, what = name.rsplit(".", 1)
        if what == "com":
            sizes[k] = np.abs(beside_hinge(nominal, body)).max()
    return sizes


def beside_hinge(model: mujoco.MjModel, body: str) -> Array:
    """From the axis of a body's first hinge straight to its centre of mass, in the body's frame; 0 without a hinge."""
    row = model.body(body)
    for joint in range(int(row.jntadr[0]), int(row.jntadr[0] + row.jntnum[0])):
        if int(model.jnt_type[joint]) == _HINGE:
            offset, axis = row.ipos - model.jnt_pos[joint], model.jnt_axis[joint]
            return np.asarray(offset - (offset @ axis) * axis, np.float64)
    return np.zeros(3)


def _free(model: Model) -> Callable[[Array], mujoco.MjModel]:
    """Compiles without contacts, ends of joints, and brakes, which are free themselves."""

    def compiled(z: Array) -> mujoco.MjModel:
        made = unhindered(model.compile(z))
        made.dof_damping[:], made.dof_frictionloss[:] = 0.0, 0.0
        return made

    return compiled


def _known(masses: Model, found: Positions, commands: Sequence[Command]) -> Array:
    """Known forces that no mass scales, as a share of the inertial and gravitational ones, shape (nv,).

    A command that could not be tried, or asks for a position, counts as large.
    """
    model = _free(masses)(masses.space.nominal)
    motion, project = made_up_motion(model), np.asarray
    if found.trial is not None and found.found is not None:
        motion, project = found.trial.motion(found.found.readings), found.trial.grid.weak.project
    needed, controls = demand(model, motion), np.zeros((len(motion), model.nu))
    known = project(needed.force - actuation(model, motion, controls).force - influence(masses, motion).sum(-1))
    certain = np.zeros(model.nv)
    for command in commands:
        given, dof = command.given, command.drive.dof
        if found.trial is None or given is None or given.stiffness > 0:
            certain[dof] = np.inf
        else:
            series = found.trial.drives[given.series][found.trial.lags.index(given.lag)]
            known[:, dof] -= given.gain * project(series)
    size = np.sqrt((project(needed.inertia) ** 2 + project(needed.gravity) ** 2).mean(0))
    size = np.maximum(size, max(_NONE * size.max(), np.finfo(float).tiny))
    return np.maximum(certain, np.sqrt((_unlike(known, project(motion.qvel)) ** 2).mean(0)) / size)


def _unlike(force: Array, speed: Array) -> Array:
    """What of forces is not proportional to their joints' speeds, as a free damping is."""
    squares = (speed**2).sum(0)
    return force - speed * (force * speed).sum(0) / np.where(squares > 0, squares, 1.0)


def _together(model: mujoco.MjModel) -> list[tuple[int, ...]]:
    """Degrees of freedom that pass forces on to one another: of each tree, or all where loops or tendons join them."""
    if model.neq or model.ntendon:
        return [tuple(range(model.nv))]
    return [tuple(map(int, np.flatnonzero(model.dof_treeid == tree))) for tree in range(model.ntree)]
