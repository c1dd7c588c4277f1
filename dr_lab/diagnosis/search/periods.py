"""How often in a turn a force or a reading repeats, from the spectrum of the residuals over the joint's position."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import mujoco
import numpy as np

from dr_lab.diagnosis.evidence.bench import Bench
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.normal_equations import NormalEquations
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.fit.solved import solved
from dr_lab.diagnosis.peak_settings import PeakSettings
from dr_lab.diagnosis.windows.channels import Tape
from dr_lab.diagnosis.windows.windows import WindowSamples
from dr_lab.effects.effect import PlacedEffect
from dr_lab.effects.periodic import PERIODS, Periodic, tried
from dr_lab.physics.model import Model
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array

_AMPLITUDES = ("sine", "cosine")
_NO_PRIOR = 1e-9  # of amplitudes, beside columns in noise standard deviations a N·m; keeps what nothing shows at 0


def with_periods(bench: Bench, model: Model, fit: Fit, placed: Sequence[PlacedEffect]) -> tuple[PlacedEffect, ...]:
    """The effects; fits of those whose number of periods is searched begin at the largest peaks of the spectrum.

    Args:
        bench: the windows that are looked at.
        model: the model without the effects.
        fit: its fit to these windows.
        placed: the effects.
    """
    replay = Replay(model, bench.fit, bench.threads)
    spectrum = _Spectrum(replay, fit, bench.solver.huber, bench.evidence.peaks)
    return tuple(_begun(spectrum, one) if searched(one) else one for one in placed)


def searched(placed: PlacedEffect) -> bool:
    """Whether an effect's number of periods is searched."""
    effect = placed.effect
    return isinstance(effect, Periodic) and effect.periods is None


def _begun(spectrum: "_Spectrum", placed: PlacedEffect) -> PlacedEffect:
    """An effect that begins at the largest peaks; as it is where nothing shows it."""
    number = {p.name: p for p in placed.parameters}[f"{placed.label}.{PERIODS}"]
    found = spectrum.peaks(placed, number)
    return replace(placed, starts=found) if found else placed


@dataclass(frozen=True)
class _Spectrum:
    """Least squares of sin(n q) and cos(n q) on the residuals of a fitted model, for one n after the other.

    A force f(t) at a joint moves the output by ∫ s(t − τ) f(τ) dτ, where s is the slope of the output by the window's
    initial velocity, times M⁻¹ (the response to a push; within a short window it is the same at any time). No model is
    simulated but once. What the start states and the model's parameters can take up is regressed out.

    Attributes:
        replay: the fit windows under the model.
        fit: of the model.
        huber: of the residuals' weights.
        settings: which peaks count.
    """

    replay: Replay
    fit: Fit
    huber: float
    settings: PeakSettings

    def peaks(self, placed: PlacedEffect, number: Parameter) -> tuple[dict[str, float], ...]:
        """Amplitudes and n at the largest peaks, by full names; nothing where no channel shows the joint."""
        joint = placed.site
        position = self._position(joint)[~self.fit.infeasible]
        way = float(np.ptp(position)) if len(position) else 0.0
        if not way:
            return ()
        numbers = tried(number, way)
        reads = isinstance(placed.effect, Periodic) and placed.effect.read
        gains, amplitudes = self._gains(joint, (self._read if reads else self._pushed)(joint, numbers))
        best = _largest_peaks(gains, self.settings)
        bounds = {p.name: p for p in placed.parameters}
        return tuple(self._start(placed.label, bounds, numbers[k], amplitudes[k]) for k in best)

    @staticmethod
    def _start(label: str, bounds: dict[str, Parameter], number: float, amplitudes: Array) -> dict[str, float]:
        values = {f"{label}.{PERIODS}": float(number)}
        values |= {f"{label}.{name}": float(a) for name, a in zip(_AMPLITUDES, amplitudes, strict=True)}
        return {name: float(np.clip(value, bounds[name].low, bounds[name].high)) for name, value in values.items()}

    @cached_property
    def _tape(self) -> Tape:
        return self.replay.simulate(self.fit.z[None], self.fit.delta[None])[0]

    def _position(self, joint: str) -> Array:
        """Of the joint in the middle of each step, shape (w, s)."""
        steps = self._tape.qpos[0][:, :, self.replay.joint(joint, "position").address]
        return 0.5 * (steps[:, 1:] + steps[:, :-1])

    def _showing(self, joint: str) -> list[tuple[WindowSamples, slice]]:
        """The channels that show the joint, and their columns of the residuals: its own, all where it has none."""
        every = list(zip(self.replay.windows.samples, self.replay.channels, strict=True))
        names = (f"{joint}.position", f"{joint}.velocity")
        return [pair for pair in every if pair[0].channel.name in names] or every

    def _read(self, joint: str, numbers: Array) -> Array:
        """What the readings' sines and cosines make of the residuals, shape (w, m, 2, numbers)."""
        parts = []
        for samples, _ in self._showing(joint):
            shown = np.zeros((*samples.time.shape, 2, len(numbers)))
            if samples.channel.name == f"{joint}.position":
                seen = self.replay.reading(self.fit.z[None], self._tape, samples.channel)(samples.time[None])
                shown = -_waves(seen[0, ..., 0], numbers) / (numbers * samples.std)
            parts.append(np.repeat(shown, samples.channel.size, axis=1))
        return np.concatenate(parts, axis=1)

    def _pushed(self, joint: str, numbers: Array) -> Array:
        """What a force's sines and cosines make of the residuals, shape (w, m, 2, numbers)."""
        pushes, position, step = self._pushes(joint), self._position(joint), self.replay.windows.step
        middle = step * (np.arange(position.shape[1]) + 0.5)
        parts = []
        for samples, columns in self._showing(joint):
            shape = (*samples.time.shape, samples.channel.size)
            slope, exists = pushes[:, columns].reshape(shape), samples.fitted | samples.scored
            shown = np.zeros((*shape, 2, len(numbers)))
            for w in np.flatnonzero(~self.fit.infeasible):
                time, waves = samples.time[w, exists[w]], _waves(position[w], numbers).reshape(len(middle), -1)
                for k in range(samples.channel.size):
                    after = _after_a_push(time, slope[w, exists[w], k], middle, velocity=_jumps(samples))
                    shown[w, exists[w], k] = (step * after @ waves).reshape(len(time), 2, -1)
            parts.append(shown.reshape(shape[0], -1, 2, len(numbers)))
        return np.concatenate(parts, axis=1)

    def _pushes(self, joint: str) -> Array:
        """Slope of the residuals by a push of 1 N·m·s or 1 N·s at the joint when a window begins, shape (w, all)."""
        model, nv = self.replay.model.compile(self.fit.z), self.replay.compiled.nv
        data, force, gained = mujoco.MjData(model), np.zeros((1, nv)), np.zeros((1, nv))
        force[0, self.replay.joint(joint, "velocity").dof] = 1.0
        middle = self._tape.qpos[0][:, self._tape.qpos.shape[2] // 2]
        change = np.zeros((len(middle), 2 * nv))
        for row, q in zip(change, middle, strict=True):
            data.qpos[:] = q
            mujoco.mj_fwdPosition(model, data)
            mujoco.mj_solveM(model, data, gained, force)
            row[nv:] = gained[0]
        return self.replay.windows.prior.slope(self.fit.slopes.state, change)

    def _gains(self, joint: str, shown: Array) -> tuple[Array, Array]:
        """By how much each pair lowers the cost, shape (numbers,), and its best amplitudes, shape (numbers, 2).

        Pairs are never fitted together, so that of their products only those within a pair are formed.
        """
        fit = self.fit
        every = np.arange(fit.residuals.shape[1])
        columns = np.concatenate([every[columns] for _, columns in self._showing(joint)])
        weight = self.replay.weights(fit.residuals, fit.infeasible, self.huber)[:, columns]
        residual, state, free = (x[:, columns] for x in (fit.residuals, fit.slopes.state, fit.slopes.parameter))
        linear = NormalEquations.build(
            residual=residual,
            state_jacobian=state,
            parameter_jacobian=free,
            weight=weight,
            delta=fit.delta,
            state_precision=self.replay.windows.prior.std**-2.0,
            prior=fit.equations.prior,
            prior_gradient=np.zeros_like(fit.equations.prior),
        )
        weighted = shown * weight[..., None, None]
        mixed = np.einsum("wms,wman->wsan", state, weighted, optimize=True)
        taken = solved(linear.state, mixed.reshape(*mixed.shape[:2], -1)).reshape(mixed.shape)
        within = np.einsum("wman,wmbn->nab", weighted, shown) - np.einsum("wsan,wsbn->nab", mixed, taken)
        beside = np.concatenate([free, residual[..., None]], axis=2)
        follows = np.concatenate([linear.mixed, linear.state_gradient[..., None]], axis=2)
        across = np.einsum("wmf,wman->fan", beside, weighted, optimize=True)
        across -= np.einsum("wsf,wsan->fan", follows, taken, optimize=True)
        reduced = linear.reduced
        return _of_pairs(within, across, reduced.information + np.diag(linear.prior), reduced.gradient.sum(0))


def _waves(position: Array, numbers: Array) -> Array:
    """sin(n q) and cos(n q), shape (…) → (…, 2, numbers)."""
    phase = position[..., None] * numbers
    return np.stack([np.sin(phase), np.cos(phase)], axis=-2)


def _jumps(samples: WindowSamples) -> bool:
    """Whether a push shows at once in a channel; a position moves only then."""
    return samples.channel.kind != "position"


def _after_a_push(time: Array, slope: Array, pushed: Array, *, velocity: bool) -> Array:
    """Slopes at times after pushes at other times, by those after a push at time 0; shape (times, pushes)."""
    first = slope[:1] if velocity else np.zeros(1)
    after = time[:, None] - pushed
    shown = np.interp(after, np.append(0.0, time), np.append(first, slope))
    return np.where(after > 0, shown, 0.0)


def _of_pairs(within: Array, across: Array, information: Array, gradient: Array) -> tuple[Array, Array]:
    """Gain and step of each pair of columns once the free columns are regressed out.

    Args:
        within: products of each pair's columns, shape (numbers, 2, 2).
        across: those with the free columns, and with the residuals in the last row, shape (free + 1, 2, numbers).
        information: products of the free columns, shape (free, free).
        gradient: those with the residuals, shape (free,).
    """
    mixed, columns = across[:-1], 2 * len(within)
    taken = np.linalg.solve(information, mixed.reshape(-1, columns)).reshape(mixed.shape)
    blocks = within + _NO_PRIOR * np.eye(2) - np.einsum("fan,fbn->nab", mixed, taken)
    slopes = (across[-1] - np.einsum("fan,f->an", taken, gradient)).T
    steps = -np.linalg.solve(blocks, slopes[..., None])[..., 0]
    return np.asarray(-(slopes * steps).sum(1)), np.asarray(steps, dtype=np.float64)


def _largest_peaks(gains: Array, settings: PeakSettings) -> list[int]:
    """Places of the largest local maximum, and of others that are about as large."""
    padded = np.pad(gains, 1, constant_values=-np.inf)
    near = gains >= settings.near * gains.max(initial=0.0)
    peaks = np.flatnonzero((gains >= padded[:-2]) & (gains >= padded[2:]) & near)
    return [int(k) for k in peaks[np.argsort(-gains[peaks], kind="stable")][: settings.most]]
