"""Residuals of all windows for many contexts and initial states, as one batch of simulations."""

import copy
from collections.abc import Iterator, Sequence
from concurrent.futures import CancelledError
from dataclasses import replace
from functools import cached_property, partial
from itertools import pairwise
from threading import Event

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.fit.point import huber_weights
from dr_lab.diagnosis.fit.touching import may_touch, touches
from dr_lab.diagnosis.windows.channels import Channel, Tape, available, residual
from dr_lab.diagnosis.windows.invert_reading import reach, unread
from dr_lab.diagnosis.windows.run_in import RunIn
from dr_lab.diagnosis.windows.until_known import until_known
from dr_lab.diagnosis.windows.windows import Windows, WindowSamples
from dr_lab.errors import DataError
from dr_lab.physics.effect_parts import CommandFilter
from dr_lab.physics.law import History
from dr_lab.physics.model import Model
from dr_lab.physics.signal import Reading
from dr_lab.physics.simulator import Simulator
from dr_lab.physics.single_stage import single_stage
from dr_lab.trajectory import Array

Mask = NDArray[np.bool_]
_ROUNDING = 1e-9  # s
_BESIDE = 2  # steps beside a time that is read: sensors are known before a step, and are read between two
_LARGEST = float(np.finfo(float).max) ** 0.25  # noise standard deviations; below, products of slopes stay finite


class Replay:
    """Simulates windows under a model and compares them with the measured samples.

    Residuals of a window are (measured − simulated)/std, all channels side by side, zero where a window has no sample.

    Args:
        model: the model with its effects.
        windows: the windows; their controls follow the layout of the model without effects, whose actuators come first.
        threads: C threads; None takes every core.
        stop: once it is set, from another thread, the replay refuses to go on.

    Attributes:
        fitted: residuals that estimate starts and parameters, shape (w, m).
        scored: residuals that count in the score, shape (w, m).
        channels: columns of each channel's residuals.
    """

    def __init__(self, model: Model, windows: Windows, threads: int | None = None, stop: Event | None = None) -> None:
        self.model = model
        self.windows = windows
        self._played = model.replayed()
        self._threads = threads
        self._stop = stop
        self._simulators: dict[int, Simulator] = {}
        self._absent = _absent(model, windows)
        self._compiled = compiled = self._played.nominal()
        self._controls, self._past = (_widen(each, compiled.nu) for each in (windows.controls, windows.past))
        past, held = windows.before, _widen(windows.before.controls, compiled.nu)
        self._history = History(windows.begin, past.qpos, past.qvel, held, past.far, past.interval)
        known = windows.activations
        self._run_in = None if known is None else RunIn(self._played, self._history, known.begin, threads)
        self._steps = self._read_steps(self._reaches())
        self._require_past()
        self.fitted, self.scored = self._mask("fitted"), self._mask("scored")
        ends = np.cumsum([0, *(s.time.shape[1] * s.channel.size for s in windows.samples)])
        self.channels = [slice(int(first), int(last)) for first, last in pairwise(ends)]

    def part(self, rows: NDArray[np.intp]) -> "Replay":
        """The replay of some of the windows, at these places."""
        return self._like(self.model, self.windows.pick(rows))

    def until_known(self) -> "Replay":
        """The replay of as much of the windows as estimates their starts; itself where that is all."""
        windows = until_known(self.windows)
        return self if windows is self.windows else self._like(self.model, windows)

    def exact(self) -> "Replay":
        """The same, where slopes are taken by the model's own steps, too."""
        found = self._like(self.model, self.windows)
        found.quick = found
        return found

    @cached_property
    def quick(self) -> "Replay":
        """The replay by steps that evaluate the model once, which slopes are taken by; itself if its own steps do."""
        model = single_stage(self.model)
        if model is self.model:
            return self
        found = self._like(model, self.windows)
        found.begin_like(self)
        return found

    @cached_property
    def touching(self) -> bool:
        """Whether shapes touch one another in the windows at the nominal context."""
        start = self.model.space.nominal[None], np.zeros((1, len(self.windows), self.nstate))
        return may_touch(self._compiled) and touches(self._compiled, self.simulate(*start)[0].qpos[0])

    def _like(self, model: Model, windows: Windows) -> "Replay":
        """The replay of the same motion by another model's steps, or of a part of it."""
        found = Replay(model, windows, self._threads, self._stop)
        found.touching = self.touching
        return found

    @property
    def nstate(self) -> int:
        """Unknowns of one window: those of its start, activations that nothing else tells, unlogged commands."""
        return len(self.windows.prior.std)

    @property
    def commands(self) -> dict[str, int]:
        """Column in `ctrl` of each command of the windows."""
        return dict(self.windows.commands)

    @property
    def compiled(self) -> mujoco.MjModel:
        """The model compiled at its nominal context."""
        return self._compiled

    def joint(self, name: str, kind: str) -> Channel:
        """The ``position`` or ``velocity`` channel of a hinge or slide joint."""
        return available(self._compiled)[f"{name}.{kind}"]

    def slides(self, joint: str) -> bool:
        """Whether a joint is a slide (its unit is the metre)."""
        return int(self._compiled.joint(joint).type[0]) == int(mujoco.mjtJoint.mjJNT_SLIDE)

    def residuals(self, z: Array, delta: Array) -> tuple[Array, Mask]:
        """Residuals in noise standard deviations.

        Args:
            z: contexts, shape (c, n).
            delta: corrections of the initial states in the tangent space, shape (c, w, nstate).

        Returns:
            Residuals, shape (c, w, m), zero for samples that do not exist and in windows that diverge; and which
            windows are infeasible, (c, w): those that diverge, and those whose residuals are no finite numbers or so
            large that a cost made of them would be none.
        """
        return self.compared(z, *self._simulate(z, delta, self._steps))

    @np.errstate(over="ignore", invalid="ignore")
    def compared(self, z: Array, tape: Tape, infeasible: Mask) -> tuple[Array, Mask]:
        """What `residuals` gives, of rollouts that `simulate` gave; numpy does not warn of those that diverged."""
        blocks = []
        for samples in self.windows.samples:
            simulated = self.reading(z, tape, samples.channel)(samples.time[None])
            difference = residual(samples.channel, simulated, samples.value) / samples.std
            exists = (samples.fitted | samples.scored) & ~infeasible[..., None]
            blocks.append(np.where(exists[..., None], difference, 0.0).reshape(*difference.shape[:2], -1))
        residuals = np.concatenate(blocks, axis=2)
        lost = ~(np.abs(residuals) < _LARGEST).all(axis=2)  # NaN is not below
        residuals[lost] = 0.0
        return residuals, infeasible | lost

    def reading(self, z: Array, tape: Tape, channel: Channel) -> Reading:
        """What the sensor of a channel reports of a tape under contexts z (c, n)."""
        return self.model.reading(z, channel.name, partial(tape.read, channel), self.windows.begin[:, None])

    def weights(self, residuals: Array, infeasible: Mask, limit: float) -> Array:
        """Huber weights of residuals (w, m), of windows (w,) that diverge none; see `huber_weights`."""
        return huber_weights(residuals, self.fitted, infeasible, limit, self.channels)

    def by_channel(self, residuals: Array) -> Iterator[tuple[WindowSamples, Array]]:
        """Each channel's samples with its columns of the residuals, (w, all) → (w, m, size)."""
        for samples, columns in zip(self.windows.samples, self.channels, strict=True):
            yield samples, residuals[:, columns].reshape(*samples.time.shape, samples.channel.size)

    def simulate(self, z: Array, delta: Array) -> tuple[Tape, Mask]:
        """Rollouts of every window under every context, to the windows' ends; arguments as `residuals`.

        Raises:
            CancelledError: the replay was told to stop.
        """
        return self._simulate(z, delta, self.windows.controls.shape[1])

    def _simulate(self, z: Array, delta: Array, steps: int) -> tuple[Tape, Mask]:
        """The first steps of `simulate`."""
        if self._stop is not None and self._stop.is_set():
            raise CancelledError
        contexts, count = shape = delta.shape[:2]
        (qpos, qvel), act = self._starts(z, delta), self._activations(z, delta)
        simulator = self._simulator(contexts * count)
        each = z if self._absent is None else np.where(self._absent, self.model.space.nominal, z[:, None])
        controls = self._commanded(delta)[..., :steps, :]
        rollout = simulator.replay(each, qpos, qvel, controls, self._past, self._history, act)
        tape = Tape(
            rollout.qpos.reshape(*shape, *rollout.qpos.shape[1:]),
            rollout.qvel.reshape(*shape, *rollout.qvel.shape[1:]),
            rollout.sensordata.reshape(*shape, *rollout.sensordata.shape[1:]),
            rollout.start.reshape(*shape, -1),
            rollout.controls.reshape(*shape, *rollout.controls.shape[1:]),
            self.windows.step,
        )
        return tape, rollout.infeasible.reshape(shape)

    def _starts(self, z: Array, delta: Array) -> tuple[Array, Array]:
        """Initial states: those whose reading is the prior's mean, plus the corrections."""
        nv, prior, begin = self._compiled.nv, self.windows.prior, self.windows.begin[:, None]
        moved = np.zeros((*delta.shape[:2], 2 * nv))
        for channel, place, reported in prior.reported([samples.channel for samples in self.windows.samples]):
            found = unread(reported, partial(self.model.reading, z, channel.name, begin=begin))
            moved[..., place] = np.stack(np.broadcast_arrays(*found[: len(place)]), axis=-1)
        change = prior.change(delta, moved)
        qpos = np.broadcast_to(prior.qpos, (*delta.shape[:2], self._compiled.nq)).copy()
        if self._compiled.nq == nv:
            qpos += change[..., :nv]
        else:
            for index in np.ndindex(delta.shape[:2]):
                mujoco.mj_integratePos(self._compiled, qpos[index], change[index][:nv], 1.0)
        return qpos, prior.qvel + change[..., nv:]

    def begin_like(self, other: "Replay") -> None:
        """Begin with the activations of a replay of the same windows with another step."""
        self._run_in = other._run_in

    def _activations(self, z: Array, delta: Array) -> Array | None:
        """Activations at the starts: as the run-in leaves them, the unknown ones corrected; shape (c, w, na)."""
        known = self.windows.activations
        if known is None or self._run_in is None:
            return None
        act = self._run_in.ends(z)
        first = self.windows.prior.nstate
        act[..., known.unknown] += delta[..., first : first + len(known.unknown)]
        return act

    def _commanded(self, delta: Array) -> Array:
        """Controls of the windows, shape (w, s, nu), or of every simulation where commands are not known throughout."""
        missing = self.windows.unlogged
        if missing is None:
            return self._controls
        return missing.added(self._controls, delta[..., self.nstate - missing.column.shape[1] :])

    def _reaches(self) -> list[float]:
        """How early or late in s each effect reads outputs, at its bounds.

        Raises:
            DataError: one reads them where nothing is simulated. Where two effects together reach farther, the motion
                rests beyond its ends.
        """
        begin, names = self.windows.begin[:, None], [samples.channel.name for samples in self.windows.samples]
        found = []
        for effect in self.model.effects:
            alone = replace(self.model, effects=(effect,))
            bounds = np.stack([alone.space.low, alone.space.high])
            reaches = [reach(partial(alone.reading, bounds, name, begin=begin)) for name in names]
            found.append(max(reaches, default=0.0))
        longest = max(found, default=0.0)
        if longest > self.windows.margin + _ROUNDING:
            raise DataError(
                f"Outputs of model {self.model.name!r} may be {longest:g} s late, but windows.margin is "
                f"{self.windows.margin:g} s. Set windows.margin to at least {longest:g}, or lower the effect's bound."
            )
        return found

    def _read_steps(self, reaches: Sequence[float]) -> int:
        """How many steps the residuals are read from: up to the last sample, as late as effects read it."""
        times = [float(s.time[s.fitted | s.scored].max(initial=0.0)) for s in self.windows.samples]
        last = max(times, default=0.0) + sum(reaches)
        return min(int(last / self.windows.step + _ROUNDING) + _BESIDE, self.windows.controls.shape[1])

    def _require_past(self) -> None:
        """A delayed actuator must find the commands of before the start."""
        history = self.windows.step * (int(self._compiled.actuator_history[:, 0].max(initial=0)) - 1)
        need = max([history, *(part.memory for _, _, part in self._played.having(CommandFilter))])
        kept = self.windows.step * self._past.shape[1]
        if kept < need * (1 - _ROUNDING):
            raise DataError(
                f"Model {self.model.name!r} delays commands by up to {need:g} s, but windows.kept keeps {kept:g} s. "
                f"Set windows.kept to at least {need:g}."
            )

    def _simulator(self, nsim: int) -> Simulator:
        if nsim not in self._simulators:
            self._simulators[nsim] = Simulator(self._played, nsim, self._threads, nominal=copy.copy(self._compiled))
        return self._simulators[nsim]

    def _mask(self, which: str) -> Mask:
        return np.concatenate([np.repeat(getattr(s, which), s.channel.size, 1) for s in self.windows.samples], axis=1)


def _absent(model: Model, windows: Windows) -> Mask | None:
    """Parameters that are nominal in a window, since their effect was not attached, (w, n); None where all act."""
    attached = [effect.attached for effect in model.effects for _ in effect.parameters]
    columns = np.array([False] * len(model.declared) + attached)
    rows = ~windows.loaded
    return rows[:, None] & columns if rows.any() and columns.any() else None


def _widen(controls: Array, nu: int) -> Array:
    """Controls with zero columns for actuators that effects added behind the model's own."""
    extra = nu - controls.shape[2]
    return np.pad(controls, ((0, 0), (0, 0), (0, extra))) if extra else controls
