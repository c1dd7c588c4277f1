"""`episodes.mcap`: episodes of a policy with their context z, for any MCAP tool."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np

from dr_lab.recorders.episode import Episode
from dr_lab.recorders.joint_labels import LABELS, commanded, joint_name
from dr_lab.recorders.mcap import FloatArrays, JointStates, write_mcap

_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


def write_episodes(
    path: Path, episodes: Sequence[Episode], attachments: Mapping[str, bytes], metadata: Mapping[str, str]
) -> None:
    """Write whole episodes side by side, each with topics of its own that begin at time 0.

    Topics, below ``/<episode>``: ``joint_states`` (hinges and slides: position, velocity), ``<joint>/position`` and
    ``<joint>/velocity`` of free and ball joints as MuJoCo has them (orientations wxyz, linear velocity in the world,
    angular velocity in the body), ``observation`` (what the policy sees), ``action`` (held until the next), ``reward``
    (of the control step that ends then) and ``context`` (z, once, labelled with the parameters). The metadata hold each
    episode's return, end, and z with units.

    Args:
        path: the file.
        episodes: what happened.
        attachments: files to embed, e.g. ``model.xml``.
        metadata: what describes the run.

    Raises:
        DrLabError: the file cannot be written.
    """
    described = dict(metadata)
    for episode in episodes:
        described[f"{episode.name}.return"] = f"{episode.undiscounted:.17g}"
        described[f"{episode.name}.ended"] = episode.ended
        described |= {f"{episode.name}.{name}": f"{z:.17g} {unit}" for name, (z, unit) in episode.context.items()}
    write_mcap(path, [topic for episode in episodes for topic in _topics(episode)], attachments, described)


def _topics(episode: Episode) -> list[JointStates | FloatArrays]:
    model, place = episode.geometry, f"/{episode.name}"
    seen = tuple(f"observation_{i}" for i in range(episode.observation.shape[1]))
    actuators = tuple(model.actuator(row).name or f"action_{i}" for i, row in enumerate(commanded(model)))
    topics = [
        *_scalar_joints(episode, place),
        *_other_joints(episode, place),
        FloatArrays(f"{place}/observation", seen, episode.time, episode.observation),
        FloatArrays(f"{place}/action", actuators, episode.time[:-1], episode.action),
        FloatArrays(f"{place}/reward", ("reward",), episode.time[1:], episode.reward[:, None]),
    ]
    if episode.context:
        z = np.array([[value for value, _ in episode.context.values()]])
        topics.append(FloatArrays(f"{place}/context", tuple(episode.context), episode.time[:1], z))
    return topics


def _scalar_joints(episode: Episode, place: str) -> list[JointStates]:
    model = episode.geometry
    rows = np.flatnonzero(np.isin(model.jnt_type, _SCALAR))
    if not len(rows):
        return []
    names = tuple(joint_name(model, row) for row in rows.tolist())
    position, velocity = episode.qpos[:, model.jnt_qposadr[rows]], episode.qvel[:, model.jnt_dofadr[rows]]
    return [JointStates(f"{place}/joint_states", names, episode.time, episode.time, position, velocity)]


def _other_joints(episode: Episode, place: str) -> list[FloatArrays]:
    model, topics = episode.geometry, list[FloatArrays]()
    for row in np.flatnonzero(~np.isin(model.jnt_type, _SCALAR)).tolist():
        sources = {"position": (episode.qpos, model.jnt_qposadr), "velocity": (episode.qvel, model.jnt_dofadr)}
        for (kind, (values, address)), labels in zip(sources.items(), LABELS[int(model.jnt_type[row])], strict=True):
            columns = values[:, address[row] : address[row] + len(labels)]
            topics.append(FloatArrays(f"{place}/{joint_name(model, row)}/{kind}", labels, episode.time, columns))
    return topics
