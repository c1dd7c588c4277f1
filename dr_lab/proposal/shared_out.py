"""One series for each joint at most, where names leave it open whose it is."""

from collections import defaultdict
from collections.abc import Sequence

import mujoco
import numpy as np

from dr_lab.proposal.lengths import joints_may_be
from dr_lab.proposal.poses import poses
from dr_lab.proposal.survey import Series

_WEIGHTLESS = 1e-6  # share of the largest weight at a joint


def shared_out(
    model: mujoco.MjModel, joints: Sequence[str], series: Sequence[Series]
) -> tuple[dict[str, int], list[str]]:
    """The series of each joint that has just one; and what is unsure, a sentence each.

    A series that may be that of several joints goes to the first of them, from the world on, that gravity moves: such a
    joint is measured more often than a wheel.

    Args:
        model: compiled.
        joints: names of hinges and slides, in the model's order.
        series: candidates; the result holds their places.
    """
    claims: dict[int, list[str]] = defaultdict(list)
    for joint, places in zip(joints, joints_may_be(model, joints, series), strict=True):
        if len(places) == 1:
            claims[places[0]].append(joint)
    found, doubts = dict[str, int](), list[str]()
    for place, claiming in claims.items():
        owner = claiming[0] if len(claiming) == 1 else _first_moved(model, claiming)
        found[owner] = place
        if others := [joint for joint in claiming if joint != owner]:
            doubts.append(
                f"{series[place].place} is read as that of {owner}; by its name it may as well be that of "
                f"{' or '.join(others)}. Name columns after the joints."
            )
    return found, doubts


def _first_moved(model: mujoco.MjModel, joints: Sequence[str]) -> str:
    """The first joint that gravity moves; the first where it moves none."""
    dofs = [int(model.joint(joint).dofadr[0]) for joint in joints]
    largest = np.abs([data.qfrc_bias[dofs] for data in poses(model)]).max(0)
    moved = np.flatnonzero(largest > _WEIGHTLESS * largest.max())
    return joints[int(moved[0])] if len(moved) else joints[0]
