"""An experiment played on a model: what its sensors report of a rollout from rest under held commands."""

from collections.abc import Mapping, Sequence
from functools import partial

import numpy as np

from dr_lab.diagnosis.windows.channels import Channel, Tape, resolve
from dr_lab.diagnosis.windows.commands import averages
from dr_lab.diagnosis.windows.invert_reading import reach
from dr_lab.errors import ModelError
from dr_lab.physics.activations import resting
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array, Signal


def readings(
    model: Model, z: Array, start: Array, commands: Mapping[str, Signal], channels: Sequence[str], time: Array
) -> dict[str, Array]:
    """What sensors report of an experiment that begins at rest, by the same rules by which logs are replayed.

    Commands act as their average over each step, and hold their first value before it; a reading that an effect
    delays shows the motion of earlier, before the start the start's.

    Args:
        model: the model with its effects.
        z: its context, shape (n,).
        start: positions at time 0, shape (nq,).
        commands: held commands by actuator name, times in s after the start.
        channels: names of k channels.
        time: increasing times of the readings in s after the start, shape (m,).

    Returns:
        By channel name, in its unit, shape (m, raw size).

    Raises:
        ModelError: the context does not compile, or its simulation diverges.
        UnknownNameError: the model has no such channel.
    """
    shown = resolve(model.nominal(), channels)
    sensors = {c: partial(model.reading, z[None], c.name, begin=np.zeros((1, 1))) for c in shown}
    tape = _simulate(model, z, start, commands, float(time[-1]) + max(reach(sensor) for sensor in sensors.values()))
    return {
        channel.name: sensor(read=partial(_from_start, tape, channel))(time[None, None])[0, 0]
        for channel, sensor in sensors.items()
    }


def _from_start(tape: Tape, channel: Channel, time: Array) -> Array:
    """A channel of a motion that rests before its start."""
    return tape.read(channel, np.maximum(time, 0.0))


def _simulate(model: Model, z: Array, start: Array, commands: Mapping[str, Signal], duration: float) -> Tape:
    """One rollout that covers a duration in s."""
    compiled = model.compile(z)
    step, npast = compiled.opt.timestep, max(1, int(compiled.actuator_history[:, 0].max(initial=0)))
    edges = step * np.arange(-npast, int(np.ceil(duration / step)) + 2)
    columns = {name: int(compiled.actuator_ctrladr[compiled.actuator(name).id]) for name in commands}
    controls = averages(commands, columns, compiled.nu, edges[None])
    past, rest = controls[:, :npast], np.zeros((1, 1, compiled.nv))
    act = resting(compiled, start[None], controls[:, 0])[None] if compiled.na else None
    simulator = Simulator(model, 1, threads=1)
    rollout = simulator.replay(z[None], start[None, None], rest, controls[:, npast:], past, act=act)
    if rollout.infeasible.any():
        raise ModelError(
            f"The simulation of model {model.name!r} diverges. Lower the commands, the context's values or the time "
            "step of its MJCF."
        )
    return Tape(
        qpos=rollout.qpos[None],
        qvel=rollout.qvel[None],
        sensordata=rollout.sensordata[None],
        start=rollout.start[None],
        controls=rollout.controls[None],
        step=step,
    )
