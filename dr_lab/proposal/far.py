"""Slides that move much farther than their machine is large, as where millimetres are read as metres."""

from collections.abc import Iterator, Sequence

import mujoco
import numpy as np

from dr_lab.proposal.output import Output, Positions
from dr_lab.proposal.settings import ProposalSettings

_SLIDE = int(mujoco.mjtJoint.mjJNT_SLIDE)


def far_slides(model: mujoco.MjModel, found: Positions, settings: ProposalSettings) -> Iterator[str]:
    """What is unsure about slides that would leave the machine, a sentence each.

    A slide with a range is not judged: that says how far it may move. Neither is one that moves gently, as a vehicle.

    Args:
        model: compiled; its size is that of its bodies and shapes at the reference (`stat.extent`).
        found: what is known of the motion.
        settings: how far and how violently a slide may move.
    """
    if found.trial is None or found.found is None:
        return
    motion = found.trial.motion(found.found.readings)
    for joint in np.flatnonzero((model.jnt_type == _SLIDE) & (model.jnt_limited == 0)):
        name, dof = model.joint(joint).name, int(model.jnt_dofadr[joint])
        way, size = float(np.ptp(motion.qpos[:, model.jnt_qposadr[joint]])), float(model.stat.extent)
        pull = float(np.abs(motion.qacc[:, dof]).max())
        if way > settings.far * size and pull > settings.violent:
            yield (
                f"{name} moves over {way:.3g} m, {way / size:.0f} times the model's size of {size:.2g} m, at up to "
                f"{pull:.0f} m/s². {_remedy(name, found.outputs, way / size)}"
            )


def _remedy(joint: str, outputs: Sequence[Output], ratio: float) -> str:
    unit = next((each.unit for each in outputs if each.channel == f"{joint}.position"), "m")
    if unit != "m":
        return "Correct its unit or the model's lengths."
    return (
        f"Are the numbers millimetres? Then write unit: mm, a factor of 0.001, by which it moves {ratio / 1000:.2g} "
        "times the model's size."
    )
