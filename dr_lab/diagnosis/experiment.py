"""Experiments played on a model: what its sensors report of rollouts from rest under held commands."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from math import ceil

import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.windows.channels import Channel, Tape, resolve
from dr_lab.diagnosis.windows.commands import averages
from dr_lab.diagnosis.windows.invert_reading import reach
from dr_lab.errors import ModelError
from dr_lab.physics.activations import resting
from dr_lab.physics.effect_parts import CommandFilter
from dr_lab.physics.model import Model
from dr_lab.physics.signal import Reading
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array, Signal


@dataclass(frozen=True)
class Played:
    """Experiments as a model plays them in several contexts, by the same rules by which logs are replayed.

    Attributes:
        model: the model with its effects.
        z: its contexts, shape (c, n).
        tape: the motion, c contexts × w experiments.
        infeasible: simulations that diverge, or whose context does not compile, shape (c, w).
    """

    model: Model
    z: Array
    tape: Tape
    infeasible: NDArray[np.bool_]

    def read(self, channels: Sequence[str], time: Array) -> dict[str, Array]:
        """What sensors report; a delayed reading shows the motion of earlier, before the start the start's.

        Args:
            channels: names of channels.
            time: increasing times in s after the start, shape (m,).

        Returns:
            By channel name, in its unit, shape (c, w, m, raw size).

        Raises:
            UnknownNameError: the model has no such channel.
        """
        shown, count = resolve(self.model.nominal(), channels), self.infeasible.shape[1]
        begin, every = np.zeros((count, 1)), np.broadcast_to(time, (1, count, len(time)))
        return {
            channel.name: _sensor(self.model, self.z, channel.name, begin, partial(_from_start, self.tape, channel))(
                every
            )
            for channel in shown
        }


def play(
    model: Model,
    z: Array,
    start: Array,
    experiments: Sequence[Mapping[str, Signal]],
    duration: float,
    threads: int | None = 1,
) -> Played:
    """Play every experiment in every context, as one batch of simulations.

    Commands act as their average over each step, and hold their first value before it.

    Args:
        model: the model with its effects.
        z: contexts, shape (c, n).
        start: positions at time 0, at rest, shape (nq,).
        experiments: held commands by actuator name of w experiments, times in s after the start.
        duration: s.
        threads: C threads; None takes every core.

    Raises:
        ModelError: the model does not compile at its nominal context.
    """
    known = model.replayed()
    compiled = known.nominal()
    step, history = compiled.opt.timestep, int(compiled.actuator_history[:, 0].max(initial=0))
    npast = max([1, history, *(ceil(part.memory / step) for _, _, part in known.having(CommandFilter))])
    edges = step * np.arange(-npast, int(np.ceil(duration / step)) + 2)
    columns = {name: int(compiled.actuator_ctrladr[compiled.actuator(name).id]) for name in experiments[0]}
    controls = np.concatenate([averages(each, columns, compiled.nu, edges[None]) for each in experiments])
    shape = (len(z), len(experiments))
    qpos, rest = np.broadcast_to(start, (*shape, compiled.nq)), np.zeros((*shape, compiled.nv))
    simulator, act = Simulator(known, len(z) * len(experiments), threads), None
    if compiled.na:
        at_rest = [resting(compiled, qpos[0], each[:, 0]) for each in simulator.commanded(z, controls[:, :1])]
        act = np.broadcast_to(at_rest, (*shape, compiled.na))
    rollout = simulator.replay(z, qpos, rest, controls[:, npast:], controls[:, :npast], act=act)
    laid = (getattr(rollout, name) for name in ("qpos", "qvel", "sensordata", "start", "controls"))
    tape = Tape(*(rows.reshape(*shape, *rows.shape[1:]) for rows in laid), step=step)
    return Played(model, z, tape, rollout.infeasible.reshape(shape))


def readings(
    model: Model, z: Array, start: Array, commands: Mapping[str, Signal], channels: Sequence[str], time: Array
) -> dict[str, Array]:
    """What sensors report of one experiment that begins at rest; see `play` and `Played.read`.

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
    resolve(model.nominal(), channels)
    model.compile(z)  # says what is wrong where it does not compile
    played = play(model, z[None], start, [commands], float(time[-1]) + farthest(model, z[None], channels))
    if played.infeasible.any():
        raise ModelError(
            f"The simulation of model {model.name!r} diverges. Lower the commands, the context's values or the time "
            "step of its MJCF."
        )
    return {name: shown[0, 0] for name, shown in played.read(channels, time).items()}


def farthest(model: Model, z: Array, channels: Sequence[str]) -> float:
    """By how much in s readings of the channels look beyond their time, in contexts z (c, n)."""
    return max(reach(partial(_sensor, model, z, channel, np.zeros((1, 1)))) for channel in channels)


def _sensor(model: Model, z: Array, channel: str, begin: Array, read: Reading) -> Reading:
    return model.reading(z, channel, read, begin)


def _from_start(tape: Tape, channel: Channel, time: Array) -> Array:
    """A channel of a motion that rests before its start."""
    return tape.read(channel, np.maximum(time, 0.0))
