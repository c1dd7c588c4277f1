"""A link that is longer or shorter than the model says."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar

import mujoco
import numpy as np

from dr_lab.effects.body_effect import body_of
from dr_lab.effects.effect import Effect, Scales
from dr_lab.errors import ModelError
from dr_lab.physics.effect_parts import SpecEdit, SpecPreparation
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_HINGE = int(mujoco.mjtJoint.mjJNT_HINGE)


@dataclass(frozen=True)
class LinkLength(Effect, SpecPreparation, SpecEdit):
    """The way from a joint's axis to the next body: a drawing that was changed, a tube that was cut by hand.

    p → p + e l/|l|, where p is the body's place in its parent's frame and l the way there from the axis of the parent's
    last hinge, across it. The body moves with everything that hangs on it; the parent's own mass, centre and inertia
    stay.

    Parameters (nominal = absent): excess e [m].
    Limits: bodies whose parent turns about a hinge, beside its axis. An error along the axis is felt by no force where
    axes are parallel. Bodies and joints inside of a <frame> are refused: their places are not their parent's.
    Raises: ModelError for a body or its parent's hinge in a <frame>.
    Source: Denavit and Hartenberg, J. Appl. Mech. 22 (1955) 215 (the length a of a link); MuJoCo body/pos.

    Attributes:
        most: largest |e|, in units of |l|.
        beside: least |l| that counts as beside the axis, in units of the machine's size (statistic/extent).
    """

    most: float
    beside: float

    name: ClassVar[str] = "link_length"
    family: ClassVar[str] = "inertia"
    law: ClassVar[str] = "p -> p + e l/|l|, l across the axis before"
    fingerprint: ClassVar[str] = "coupling of two joints too strong or too weak; force residual turns with both"
    limited: ClassVar[tuple[str, ...]] = ("excess",)
    confused_with: ClassVar[tuple[str, ...]] = ("payload", "centre_of_mass_offset", "inertia_error", "sensor_scale")

    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the bodies with mass on or beyond them that lie beside the last hinge of their parent."""
        least = self.beside * float(model.stat.extent)
        bodies = (model.body(i) for i in range(1, model.nbody))
        return tuple(
            body.name
            for body in bodies
            if body.name and model.body_subtreemass[body.id] > 0 and np.linalg.norm(across(model, body.id)) > least
        )

    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """The excess."""
        del scales
        bound = self.most * float(np.linalg.norm(across(model, model.body(site).id)))
        return (Parameter("excess", "m", 0.0, -bound, bound),)

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Refuse what stands in a frame."""
        body = body_of(spec, site)
        if body.frame is not None or _hinge(body).frame is not None:
            raise ModelError(
                f"Body {site!r} or its parent's hinge stands in a <frame>, where its place is not its parent's. Write "
                "the body and the joint with a pos of their own."
            )

    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Move the body along the link."""
        if values["excess"] == 0:
            return
        body = body_of(spec, site)
        hinge = _hinge(body)
        way = _rejected(np.asarray(body.pos) - np.asarray(hinge.pos), np.asarray(hinge.axis))
        body.pos = np.asarray(body.pos) + values["excess"] / np.linalg.norm(way) * way


def across(model: mujoco.MjModel, body: int) -> Array:
    """Way from the axis of the last hinge of a body's parent to the body, across the axis, m; 0 without a hinge."""
    parent = int(model.body_parentid[body])
    first = int(model.body_jntadr[parent])
    hinges = [j for j in range(first, first + int(model.body_jntnum[parent])) if int(model.jnt_type[j]) == _HINGE]
    if not hinges:
        return np.zeros(3)
    return _rejected(model.body_pos[body] - model.jnt_pos[hinges[-1]], model.jnt_axis[hinges[-1]])


def _hinge(body: mujoco.MjsBody) -> mujoco.MjsJoint:
    """The last hinge of a body's parent."""
    return [joint for joint in body.parent.joints if joint.type == mujoco.mjtJoint.mjJNT_HINGE][-1]


def _rejected(way: Array, axis: Array) -> Array:
    unit = axis / np.linalg.norm(axis)
    return np.asarray(way - unit * (unit @ way), dtype=np.float64)
