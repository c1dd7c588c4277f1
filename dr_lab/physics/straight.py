"""Ways along which bodies change as the equations of motion are linear in them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.physics.context import ContextSpace
from dr_lab.physics.effect_parts import AddedBody
from dr_lab.physics.inertial import BodyInertial
from dr_lab.physics.model import Model
from dr_lab.physics.model_effect import ModelEffect
from dr_lab.physics.pseudo_inertia import Rooted
from dr_lab.trajectory import Array

_STEP = 1e-4  # of a step, for the direction of a way at its beginning


@dataclass(frozen=True)
class _Body:
    """A body whose ten inertial parameters are entries of the context.

    Attributes:
        rows: their places.
        at: the bodies at values of shape (n, 10).
        numbers: back to values of shape (1, 10).
    """

    rows: NDArray[np.intp]
    at: Callable[[Array], Rooted]
    numbers: Callable[[Rooted], Array]

    def target(self, z: Array, step: Array) -> Array:
        """Pseudo-inertia to which the straight way of a step leads, shape (4, 4)."""
        theta = z[self.rows] + np.array([[0.0], [_STEP], [-_STEP]]) * step[self.rows]
        here, ahead, behind = self.at(theta).pseudo
        return here + (ahead - behind) / (2 * _STEP)


@dataclass(frozen=True)
class _Added:
    """A body that an effect adds.

    Attributes:
        body: the body, in its own frame.
        carrier: place of the free body that carries it; None where that is not free as a whole, or seen apart.
        frame: of its frame in the carrier's, as a homogeneous matrix, shape (4, 4).
    """

    body: _Body
    carrier: int | None
    frame: Array


@dataclass(frozen=True)
class Straight:
    """Steps of a context on which bodies change linearly in mass, first and second moments.

    The equations of motion are linear in these (with their forces given), so what the logs cannot tell of bodies that
    share it out is a plane there. In a model's own parameters, such as mass and place of a load, that plane is bent,
    and a fit that follows it in straight steps of these goes in very short ones.

    Source: Atkeson, An and Hollerbach, International Journal of Robotics Research 5 (1986) 101 (linearity).

    Attributes:
        space: the contexts.
        own: bodies of the model that are free as a whole.
        added: bodies that effects add.
    """

    space: ContextSpace
    own: tuple[_Body, ...]
    added: tuple[_Added, ...]

    @classmethod
    def of(cls, model: Model) -> "Straight":
        """The bodies of a model."""
        space = model.space
        own = tuple(_own(body, [space.index(p.name) for p in body.parameters]) for body in model.inertials)
        parts = [(effect, part) for effect, _, part in model.having(AddedBody)]
        compiled = model.nominal() if parts else None
        return cls(space, own, tuple(_added(model, compiled, *each) for each in parts if compiled is not None))

    def apart(self) -> "Straight":
        """The same where an added body and its carrier are seen apart, so that neither makes up for the other."""
        return replace(self, added=tuple(replace(one, carrier=None) for one in self.added))

    @property
    def plain(self) -> bool:
        """Whether there is no such body, so that all goes by the step."""
        return not self.own and not self.added

    def end(self, z: Array, step: Array) -> Array:
        """Where a step from z leads, shape (n,): all else by the step, bodies by their straight way.

        An added body that would become none, or leave its bounds, goes as far as there is one, and what it cannot take
        goes to the body that carries it, as the motion shows their sum alone. A body of the model that would become
        none goes as its parameters do.
        """
        end, more = z + step, np.zeros((len(self.own), 4, 4))
        for one in self.added:
            target = one.body.target(z, step)
            found = Rooted.nearest(target)
            if found is not None:
                end[one.body.rows] = one.body.numbers(found)[0]
            if one.carrier is not None:
                taken = one.body.at(self.space.clip(end)[None, one.body.rows]).pseudo[0]
                more[one.carrier] += one.frame @ (target - taken) @ one.frame.T
        for body, further in zip(self.own, more, strict=True):
            if not (step[body.rows].any() or further.any()):
                continue
            found = Rooted.of(body.target(z, step) + further)
            end[body.rows] = end[body.rows] if found is None else body.numbers(found)[0]
        return end


def _own(body: BodyInertial, rows: Sequence[int]) -> _Body:
    return _Body(np.array(rows), body.shape.rooted, body.shape.numbers)


def _added(model: Model, compiled: mujoco.MjModel, effect: ModelEffect, part: AddedBody) -> _Added:
    names = [p.name for p in effect.parameters]
    short = [name.removeprefix(f"{effect.label}.") for name in names]

    def at(theta: Array) -> Rooted:
        return part.added(dict(zip(short, theta.T, strict=True)))

    def numbers(body: Rooted) -> Array:
        values = part.values_of(body)
        return np.stack([values[name] for name in short], axis=1)

    body, turned, frame = compiled.body(effect.label), np.zeros(9), np.eye(4)
    mujoco.mju_quat2Mat(turned, body.quat)
    frame[:3, :3], frame[:3, 3] = turned.reshape(3, 3), body.pos
    carriers = [each.body for each in model.inertials]
    parent = compiled.body(int(body.parentid[0])).name
    rows = np.array([model.space.index(name) for name in names])
    return _Added(_Body(rows, at, numbers), carriers.index(parent) if parent in carriers else None, frame)
