"""A time step that does not show: what the diagnosis goes on with where the model's own step moves an output."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np

from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.checks.numerical_floor import NumericalFloor, in_parts, numerical_floor
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.errors import ModelError
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log, MeasurementSet

_RK4 = mujoco.mjtIntegrator.mjINT_RK4
_STAGES = 4  # model evaluations in a step of RK4


@dataclass(frozen=True)
class Refinement:
    """The model that the diagnosis goes on with.

    Attributes:
        model: the model, with another step or integrator where its own moves an output.
        given: step of the model as given, s; no timing effect that is smaller can be told from it.
        share: largest error of the step by a channel, in noise standard deviations, as given.
        left: the same of the model that goes on.
        message: what was changed and why, or why nothing was; empty where the step is fine.
    """

    model: Model
    given: float
    share: float
    left: float
    message: str


@dataclass(frozen=True)
class _Tried:
    model: Model
    cost: int
    share: float


def refine(
    model: Model,
    logs: Sequence[Log],
    measured: MeasurementSet,
    settings: WindowSettings,
    check: ModelCheckSettings,
    floor: NumericalFloor,
    threads: int | None,
) -> Refinement:
    """The cheapest of finer steps and RK4, in model evaluations, whose own error is below `check.least_share`.

    Where none is, the one with the least error stands if finer steps help at all; in contacts that tip over they do
    not, and the model stays as given.

    Args:
        model: the model as given.
        logs: logs whose windows are simulated.
        measured: gives the noise.
        settings: how windows are cut.
        check: which error is allowed, and how far to refine.
        floor: error of the model as given in all windows.
        threads: C threads.
    """
    share = floor.largest
    if share <= check.least_share:
        return _as_given(model, floor, "")
    few = replace(settings, seconds=max(check.windows, 1) * settings.length)
    tried = []
    for finer, cost in _finer(model, check.finest):
        found = _Tried(finer, cost, _share(finer, logs, measured, few, threads))
        if found.share <= check.least_share:
            return _refined(model, floor, found, "")
        tried.append(found)
    best = min(tried, key=lambda each: each.share, default=None)
    if best is not None and best.share < check.converging * min(share, _share(model, logs, measured, few, threads)):
        allowed = f" That is still more than {check.least_share:g}; model_check.finest={check.finest} ends the search."
        return _refined(model, floor, best, allowed)
    remains = f"Finer steps, down to a {check.finest}th, do not take that away (contacts, or chaos)"
    return _as_given(model, floor, f"{_moved(floor)} {remains}, so that the step stays.")


def unneeded(model: Model, floor: NumericalFloor) -> Refinement:
    """The model as given, where the logs ask for nothing else."""
    message = (
        f"{_moved(floor)} As the calibrated model leaves no more than noise with it, it stays; another simulator, or "
        "the machine, may show the difference."
    )
    return _as_given(model, floor, message)


def _as_given(model: Model, floor: NumericalFloor, message: str) -> Refinement:
    return Refinement(model, floor.step, floor.largest, floor.largest, message)


def _finer(model: Model, finest: int) -> list[tuple[Model, int]]:
    """Finer models with their cost in evaluations for each step of the model as given, cheapest first."""
    compiled, halvings = model.nominal(), range(int(np.log2(finest)) + 1)
    found = [(in_parts(model, 2**k), 2**k) for k in halvings if k]
    # RK4 reads delayed commands half a step early.
    if compiled.opt.integrator != _RK4 and not compiled.nhistory:
        smooth = _smooth(model)
        found += [(in_parts(smooth, 2**k), _STAGES * 2**k) for k in halvings if _STAGES * 2**k <= finest]
    return sorted(found, key=lambda each: each[1])


def _smooth(model: Model) -> Model:
    """The model with RK4, which is of first order with filters that are integrated exactly, or early."""
    spec = model.spec.copy()
    spec.option.integrator = _RK4
    for actuator in spec.actuators:
        actuator.actearly = False
        if actuator.dyntype == mujoco.mjtDyn.mjDYN_FILTEREXACT and actuator.dynprm[0] > spec.option.timestep:
            actuator.dyntype = mujoco.mjtDyn.mjDYN_FILTER
    return replace(model, spec=spec)


def _share(
    model: Model, logs: Sequence[Log], measured: MeasurementSet, settings: WindowSettings, threads: int | None
) -> float:
    """Largest error of a model's step by a channel; infinite where it diverges."""
    try:
        return numerical_floor(model, logs, measured, settings, threads).largest
    except ModelError:
        return np.inf


def _refined(model: Model, floor: NumericalFloor, found: _Tried, rest: str) -> Refinement:
    option, was = found.model.spec.option, model.spec.option
    asked = [] if option.timestep == was.timestep else [f"timestep {option.timestep:g} s"]
    if option.integrator != was.integrator:
        asked.append('integrator "RK4"')
    pairs = list(zip(found.model.spec.actuators, model.spec.actuators, strict=True))
    if any(new.dyntype != old.dyntype for new, old in pairs):
        asked.append('dyntype "filter" in place of "filterexact"')
    if any(new.actearly != old.actearly for new, old in pairs):
        asked.append('actearly "false"')
    message = (
        f"{_moved(floor)} All models here are simulated with {', '.join(asked)} in its place: {found.share:.2g} "
        f"standard deviations are left, at {found.cost} times the cost.{rest} The model.xml of a run has that; "
        "your own MJCF has not: set it there, too."
    )
    return Refinement(found.model, floor.step, floor.largest, found.share, message)


def _moved(floor: NumericalFloor) -> str:
    return (
        f"The time step of {floor.step:g} s alone moves {floor.worst} by {floor.largest:.2g} noise standard deviations "
        "within a window, which can pass for missing physics."
    )
