"""Logs of a machine that an MJCF describes, as its owner has them: a table of time, positions and controls."""

from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
from own_robot import write_csv

from dr_lab.trajectory import Array

_EVERY = 0.005  # s, between two rows


def played(
    mjcf: str, start: list[float], seconds: float, control: Callable[[float], list[float]] | None = None, seed: int = 0
) -> tuple[Array, Array, Array]:
    """Times, positions of the joints and controls of a machine.

    Args:
        mjcf: the machine.
        start: qpos.
        seconds: duration.
        control: of the time in s; None leaves all at 0.
        seed: of the noise of 0.1 mm or 0.1 mrad.
    """
    model = mujoco.MjModel.from_xml_string(mjcf)
    data = mujoco.MjData(model)
    data.qpos[:] = start
    each, rows = round(_EVERY / model.opt.timestep), []
    for k in range(round(seconds / model.opt.timestep)):
        if k % each == 0:
            data.ctrl[:] = control(data.time) if control is not None else 0.0
            rows.append(np.concatenate([[data.time], data.qpos, data.ctrl]))
        mujoco.mj_step(model, data)
    table = np.array(rows)
    noise = np.random.default_rng(seed).normal(scale=1e-4, size=(len(table), model.nq))
    return table[:, 0], table[:, 1 : 1 + model.nq] + noise, table[:, 1 + model.nq :]


def write_log(name: str, header: str, *columns: Array) -> str:
    """A table ``logs/<name>.csv`` with a header like ``t,x,theta``; its path."""
    flat = [column for each in columns for column in np.atleast_2d(each.T)]
    return str(write_csv(Path(f"logs/{name}.csv"), dict(zip(header.split(","), flat, strict=True))))
