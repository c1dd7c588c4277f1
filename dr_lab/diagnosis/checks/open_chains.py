"""Measured joints that contradict a closed chain: a zero, a direction or a length that is not the machine's."""

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.windows.channels import Channel, available
from dr_lab.diagnosis.windows.closed_loops import SINGULAR, ClosedLoops, Mask
from dr_lab.diagnosis.windows.start import placed
from dr_lab.trajectory import Array, Log, Noise

_ROUNDING = 1e-8  # m or rad: chains that the unmeasured joints alone can close are open by no more


class Mending(NamedTuple):
    """How the positions of a channel would have to be read for the chains to close: sign · position + offset.

    Attributes:
        channel: ``<joint>.position``.
        sign: +1 or −1.
        offset: rad or m.
        left: root mean square of what the others tell of the joint, less that reading, rad or m.
    """

    channel: str
    sign: int
    offset: float
    left: float


class OpenChain(NamedTuple):
    """Closed chains that are open in the logs.

    Attributes:
        gap: median over positions of the logs by how much the constraints are violated, m or rad.
        noise: how much of that the channels' noise makes.
        mending: the reading of one channel that closes them; None where there is none.
    """

    gap: float
    noise: float
    mending: Mending | None

    @property
    def message(self) -> str:
        """What is wrong, and what can be done."""
        told = (
            f"The measured joints contradict the model's closed chains: these are open by {self.gap:.2g} (m or rad) in "
            f"half of the positions, where noise opens them by {self.noise:.2g}."
        )
        if self.mending is None:
            return (
                f"{told} A zero, direction or unit of a channel is wrong, or a length of the model; or a chain gives "
                "way, as a belt that stretches."
            )
        turned = ", and sign turned" if self.mending.sign < 0 else ""
        return (
            f"{told} {self.mending.channel} closes them with offset {self.mending.offset:.6g} (rad or m) added{turned}."
        )


def open_chain(
    model: mujoco.MjModel, logs: Sequence[Log], noise: Mapping[str, Noise], check: ModelCheckSettings
) -> OpenChain | None:
    """Whether closed chains are open in some logs beyond noise, and which channel's zero or direction would close them.

    Args:
        model: compiled model.
        logs: the logs.
        noise: of each channel.
        check: when a gap counts.
    """
    channels = [c for name in logs[0].outputs if (c := available(model)[name]).kind == "position"]
    known = placed(model, logs[0].outputs)
    if not model.neq or model.nq != model.nv or known.sum() != len(channels):
        return None  # a body that flies, which channels of joints do not place
    loops, qpos = ClosedLoops(model, known), _positions(model, logs, channels, check.chain_positions)
    std = np.zeros(model.nv)
    std[[c.dof for c in channels]] = [noise[c.name].std for c in channels]
    found = np.array([_opening(loops, known, q, std) for q in qpos])
    if not found.any():
        return None
    gap, expected = np.median(found, axis=0)
    if gap <= max(check.chain_gap * expected, _ROUNDING):
        return None
    mendings = list(_mendings(model, known, channels, qpos))
    best = min(mendings, key=lambda each: each[1], default=None)
    mended = best[0] if best is not None and best[1] <= check.chain_mended else None
    return OpenChain(float(gap), float(expected), mended)


def _positions(model: mujoco.MjModel, logs: Sequence[Log], channels: Sequence[Channel], count: int) -> Array:
    """Measured positions, evenly spread over each log, shape (n, nq)."""
    parts = []
    for log in logs:
        signals = [log.outputs[c.name] for c in channels]
        first, last = max(s.time[0] for s in signals), min(s.time[-1] for s in signals)
        time, qpos = np.linspace(first, last, count), np.tile(model.qpos0, (count, 1))
        for channel, signal in zip(channels, signals, strict=True):
            qpos[:, channel.address] = np.interp(time, signal.time, signal.value.ravel())
        parts.append(qpos)
    return np.concatenate(parts)


def _opening(loops: ClosedLoops, known: Mask, qpos: Array, std: Array) -> tuple[float, float]:
    """Norm of the violation that unmeasured joints leave, and its expectation from noise."""
    rest = np.zeros(len(known))
    gap, jacobian = loops.constraints(loops.closed(qpos, rest, rest).qpos)
    taken_up = jacobian[:, ~known] @ np.linalg.pinv(jacobian[:, ~known], rcond=SINGULAR)
    left = (jacobian - taken_up @ jacobian) * std
    return float(np.linalg.norm(gap)), float(np.linalg.norm(left))


def _mendings(
    model: mujoco.MjModel, known: Mask, channels: Sequence[Channel], qpos: Array
) -> Iterator[tuple[Mending, float]]:
    """Readings of each channel that the others tell, with the share of the contradiction that they leave."""
    rest = np.zeros(model.nv)
    for channel in channels:
        others = known.copy()
        others[channel.dof] = False
        loops = ClosedLoops(model, others)
        if not loops.tells() or not loops.told()[channel.dof]:
            continue
        told = np.array([loops.closed(q, rest, rest).qpos[channel.address] for q in qpos])
        hinge = model.jnt_type[model.dof_jntid[channel.dof]] == mujoco.mjtJoint.mjJNT_HINGE
        for sign in (1, -1):
            apart = told - sign * qpos[:, channel.address]
            if hinge:
                apart = np.unwrap(apart)
            offset = float(np.median(apart))
            left, before = (
                float(np.sqrt(np.mean(each**2))) for each in (apart - offset, told - qpos[:, channel.address])
            )
            yield Mending(channel.name, sign, offset, left), left / before if before > 0 else np.inf
