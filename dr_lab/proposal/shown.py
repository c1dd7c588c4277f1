"""Which parameters the motion shows, each apart from the others and from what brakes."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np

from dr_lab.physics.model import Model
from dr_lab.proposal.output import Positions
from dr_lab.proposal.settings import ProposalSettings
from dr_lab.proposal.trial import SLOW
from dr_lab.proposal.unscaled import Unscaled, influence
from dr_lab.trajectory import Array


class Shown(NamedTuple):
    """What the motion shows of parameters.

    Attributes:
        seen: the parameters that it shows.
        faint: those from which hardly a force follows.
        notes: which masses stay as documented and why, a sentence each.
    """

    seen: set[str]
    faint: set[str]
    notes: tuple[str, ...]


def shown(
    model: Model, found: Positions, undriven: Sequence[tuple[Unscaled, int]], settings: ProposalSettings
) -> Shown:
    """Which parameters the motion shows.

    Args:
        model: whose parameters may be free.
        found: the motion.
        undriven: bodies that no known force drives, with how many of their parameters may be free.
        settings: thresholds.
    """
    assert found.trial is not None
    assert found.found is not None
    if not model.space.names:
        return Shown(set(), set(), ())
    motion, weak, outcome = found.trial.motion(found.found.readings), found.trial.grid.weak, found.found.outcome
    size = np.sqrt((outcome.need**2).mean(0))
    for each, _ in undriven:  # what they need is what their forces leave of one another
        size[list(each.dofs)] = np.sqrt(outcome.size[list(each.dofs)] / len(weak))
    size[size == 0.0] = 1.0
    moved = (weak.project(influence(model, motion)) / size[:, None]).reshape(-1, len(model.space.names))
    brakes = _brakes(weak.project(motion.qvel), weak.project(np.tanh(motion.qvel / _slow(motion.qvel))))
    rooms = {body: k for k, (each, _) in enumerate(undriven) for body in each.bodies}
    room_of = {name: rooms[body] for name in model.space.names if (body := name.rsplit(".", 1)[0]) in rooms}
    return _chosen(model.space.names, moved, brakes, room_of, [most for _, most in undriven], settings)


def _chosen(
    names: tuple[str, ...],
    moved: Array,
    brakes: Array,
    room_of: Mapping[str, int],
    most: list[int],
    settings: ProposalSettings,
) -> Shown:
    felt = np.sqrt((moved**2).mean(0))
    basis, room = np.linalg.qr(brakes)[0], [*most]
    seen, weak, alike = set(), [], []
    for k in np.argsort(-felt):
        rest = moved[:, k] - basis @ (basis.T @ moved[:, k])
        full = names[k] in room_of and room[room_of[names[k]]] <= 0
        if felt[k] < settings.felt:
            weak.append(names[k])
        elif full or np.linalg.norm(rest) < settings.distinct * np.linalg.norm(moved[:, k]):
            alike.append(names[k])
        else:
            seen.add(names[k])
            basis = np.column_stack([basis, rest / np.linalg.norm(rest)])
            if names[k] in room_of:
                room[room_of[names[k]]] -= 1
    return Shown(seen, {*weak}, tuple(_notes(weak, alike, settings)))


def _notes(weak: list[str], alike: list[str], settings: ProposalSettings) -> Iterator[str]:
    if hidden := [name for name in weak if name.endswith(".mass")]:
        yield f"{_stay(hidden)} as documented: less than {settings.felt:.0%} of the forces follow from it."
    if replaced := [name for name in alike if name.endswith(".mass")]:
        yield f"{_stay(replaced)} as documented: in these logs the other free parameters do what it would."


def _stay(names: list[str]) -> str:
    return f"{', '.join(names)} {'stays' if len(names) == 1 else 'each stay'}"


def _brakes(speed: Array, direction: Array) -> Array:
    """Columns of each joint's own viscous and dry friction, rows as those of the parameters."""
    count, nv = speed.shape
    columns = np.zeros((count, nv, 2 * nv))
    for j in range(nv):
        columns[:, j, j], columns[:, j, nv + j] = speed[:, j], direction[:, j]
    return columns.reshape(count * nv, 2 * nv)


def _slow(speed: Array) -> Array:
    usual = SLOW * np.sqrt((speed**2).mean(0))
    return np.where(usual > 0, usual, 1.0)
