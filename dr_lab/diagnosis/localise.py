"""Where the model fails: the regions of joint, speed, position, command and reversal that hold the error."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from dr_lab.bounds import Count, Natural, Positive, Share, require_bounds
from dr_lab.channel_names import POSITION, VELOCITY
from dr_lab.diagnosis.fit.point import Point
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.missing_force.force_formula import FormulaSettings
from dr_lab.diagnosis.windows.channels import Tape
from dr_lab.diagnosis.windows.commands import steps_at
from dr_lab.trajectory import Array

if TYPE_CHECKING:
    from sklearn.tree import DecisionTreeRegressor


@dataclass(frozen=True)
class LocaliseSettings:
    """Windows and tree that find regions.

    Attributes:
        length: s, horizon of the windows; short, so that an error stays near the state that caused it.
        seconds: time in all that is taken of the logs, evenly spread.
        depth: most conditions that describe a region.
        least: smallest share of the samples that makes a region.
        regions: regions reported per channel.
        horizons: number of horizons at which the error is told.
        lags: largest lag of the residual–input correlation, samples either way.
        formula: how a formula of what no effect explains is looked for.

    Raises:
        ConfigError: a number is too small, or `least` is no share.
    """

    length: Positive
    seconds: Positive
    depth: Count
    least: Share
    regions: Count
    horizons: Count
    lags: Natural
    formula: FormulaSettings

    def __post_init__(self) -> None:
        require_bounds(self, "localise")


@dataclass(frozen=True)
class Region:
    """A part of the motion and its share of a channel's squared error.

    Attributes:
        signal: the channel.
        region: conditions in words.
        share: share of the channel's squared error.
        samples: share of its samples.
        chi2: mean squared residual there, in noise variances.
    """

    signal: str
    region: str
    share: float
    samples: float
    chi2: float


def localise(replay: Replay, fit: Point, settings: LocaliseSettings, tape: Tape | None = None) -> list[Region]:
    """Regions that hold most of the error, worst channel and region first.

    A shallow regression tree splits each channel's squared residual by the simulated state and the command; a leaf is
    reported where its residuals exceed the channel's mean. Residuals grow with the time since a window's start was
    known, so the tree sees them relative to all windows' mean at the same sample; otherwise it would find late samples.

    Args:
        replay: the windows.
        fit: context and states.
        settings: size of the tree.
        tape: what the model does there, if that is known.
    """
    if tape is None:
        tape, _ = replay.simulate(fit.z[None], fit.delta[None])
    found = []
    for samples, error in replay.by_channel(fit.residuals):
        used = samples.scored & ~fit.infeasible[:, None]
        names, features = _features(replay, tape, samples.time)
        if names and used.any():
            square = (error**2).mean(-1)
            mean = np.where(used, square, 0.0).sum(0) / np.maximum(used.sum(0), 1)
            relative = np.divide(square, mean, out=np.zeros_like(square), where=mean > 0)
            found += _leaves(samples.channel.name, names, features[used], square[used], relative[used], settings)
    return sorted(found, key=lambda r: -r.share * r.chi2)


def _features(replay: Replay, tape: Tape, time: Array) -> tuple[list[tuple[str, str]], Array]:
    """Names with units, and values of the features at the samples, shape (w, m, features).

    Where only a joint's velocity is measured, its position is none of them: nobody knows where it began.
    """
    columns: list[Array] = []
    names: list[tuple[str, str]] = []
    kinds = (POSITION, VELOCITY)
    channels = [s.channel.name for s in replay.windows.samples if s.channel.kind in kinds]
    for joint in dict.fromkeys(name.rpartition(".")[0] for name in channels):
        slide = "m" if replay.slides(joint) else "rad"
        position, velocity = (tape.read(replay.joint(joint, kind), time[None])[0, ..., 0] for kind in kinds)
        if slide == "rad":  # an unlimited hinge is at the same place after every turn
            position = np.arctan2(np.sin(position), np.cos(position))
        columns.append(np.abs(velocity))
        names.append((f"|{joint} velocity|", f"{slide}/s"))
        if f"{joint}.{POSITION}" in channels:
            columns.append(position)
            names.append((f"{joint} position", slide))
        columns.append(_since_reversal(velocity, time))
        names.append((f"time since {joint} reversed", "s"))
    step = steps_at(time, replay.windows.step, replay.windows.controls.shape[1])
    for name, ctrl in replay.commands.items():
        columns.append(np.abs(np.take_along_axis(replay.windows.controls[..., ctrl], step, axis=1)))
        names.append((f"|{name} command|", ""))
    return names, np.stack(columns, axis=-1) if columns else np.zeros((*time.shape, 0))


def _since_reversal(velocity: Array, time: Array) -> Array:
    """Time since the velocity last changed its sign within the window, s; since its start where it has not."""
    turned = np.zeros(velocity.shape, bool)
    turned[:, 1:] = np.sign(velocity[:, 1:]) != np.sign(velocity[:, :-1])
    turned[:, 0] = True
    last = np.maximum.accumulate(np.where(turned, time, -np.inf), axis=1)
    return time - last


def _leaves(
    signal: str,
    names: list[tuple[str, str]],
    features: Array,
    square: Array,
    relative: Array,
    settings: LocaliseSettings,
) -> list[Region]:
    # scikit-learn takes longer to import than all the rest of a verb; only what looks for regions waits for it.
    from sklearn.tree import DecisionTreeRegressor  # noqa: PLC0415

    least = max(1, int(settings.least * len(square)))
    tree = DecisionTreeRegressor(max_depth=settings.depth, min_samples_leaf=least, random_state=0)
    tree.fit(features, relative)
    leaf = tree.apply(features)
    regions = []
    for node in np.unique(leaf):
        inside = leaf == node
        if relative[inside].mean() > relative.mean():
            share, chi2 = float(square[inside].sum() / square.sum()), float(square[inside].mean())
            words = _words(tree, int(node), names)
            regions.append(Region(signal, words, share, float(inside.mean()), chi2))
    return sorted(regions, key=lambda r: -r.share)[: settings.regions]


def _words(tree: "DecisionTreeRegressor", leaf: int, names: list[tuple[str, str]]) -> str:
    """Conditions on the path to a leaf, one a feature, the tightest on each side."""
    t, node, bounds = tree.tree_, leaf, dict[tuple[int, str], float]()
    while node != 0:
        parent = int(np.flatnonzero((t.children_left == node) | (t.children_right == node))[0])
        side = "<" if t.children_left[parent] == node else ">"
        bounds.setdefault((int(t.feature[parent]), side), float(t.threshold[parent]))
        node = parent
    once = dict.fromkeys(feature for feature, _ in reversed(bounds))
    parts = [_condition(*names[f], bounds.get((f, ">")), bounds.get((f, "<"))) for f in once]
    return " and ".join(parts) if parts else "everywhere"


def _condition(name: str, unit: str, low: float | None, high: float | None) -> str:
    """One feature's bounds in words: ``x > 1 m``, ``x < 2 m`` or ``1 m < x < 2 m``."""
    below, above = ("" if bound is None else f"{bound:.3g} {unit}".rstrip() for bound in (low, high))
    if below and above:
        return f"{below} < {name} < {above}"
    return f"{name} > {below}" if below else f"{name} < {above}"
