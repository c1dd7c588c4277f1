"""Angles whose numbers the model follows far better when they are read as degrees."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from dr_lab.bounds import Count, Positive, at_least, require_bounds
from dr_lab.channel_names import POSITION, VELOCITY, joint_of, quantity
from dr_lab.diagnosis.evidence.score import score_of
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.settings import SolverSettings, WindowSettings
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log, MeasurementSet

_DEGREE = np.pi / 180.0
# An angle that covers less than a turn of radians is none of degrees that anyone would log.
_TURN = 2 * np.pi


@dataclass(frozen=True)
class DegreeSettings:
    """When angles seem to be in degrees.

    Attributes:
        windows: of each log that are looked at.
        follows: a model that leaves less χ² per sample has the unit of the data, whatever else it lacks.
        better: factor by which the other reading must lower χ².

    Raises:
        ConfigError: a number is out of its range.
    """

    windows: Count
    follows: Positive
    better: Annotated[float, at_least(1.0)]

    def __post_init__(self) -> None:
        require_bounds(self, "faults.degrees")


@dataclass(frozen=True)
class UnitSuspicion:
    """Channels that seem to be in degrees.

    Attributes:
        channels: their names.
        chi2: held-out χ² as declared.
        chi2_degrees: the same with these channels read as degrees.
    """

    channels: tuple[str, ...]
    chi2: float
    chi2_degrees: float


def suspect_degrees(
    model: Model,
    measured: MeasurementSet,
    rules: DegreeSettings,
    settings: WindowSettings,
    solver: SolverSettings,
    threads: int,
) -> UnitSuspicion | None:
    """Compare the model at its nominal context with the logs as declared and with wide angles read as degrees.

    Noise is scaled with its channel, so both χ² weigh the same relative errors.

    Args:
        model: the model.
        measured: the logs; the held-out ones are looked at, or the fit logs where none is held out.
        rules: when they seem to be.
        settings: how they are cut.
        solver: settings of the fit of start states.
        threads: C threads.

    Returns:
        The suspicion, or None.
    """
    logs = measured.held_out or measured.fit
    wide = tuple(name for name in measured.noise if _is_wide(name, measured, logs))
    if not wide:
        return None
    few = replace(settings, seconds=min(settings.seconds, rules.windows * settings.length * len(logs)))

    def chi2(data: MeasurementSet) -> float:
        windows = cut(data.held_out or data.fit, data, model.nominal(), few)
        return score_of(*fit_states(model, model.space.nominal, windows, solver, threads)).chi2

    given = chi2(measured)
    if given < rules.follows:
        return None
    other = chi2(_as_degrees(measured, {*wide, *(f"{joint_of(name)}.{VELOCITY}" for name in wide)}))
    return UnitSuspicion(wide, given, other) if other * rules.better < given else None


def _is_wide(name: str, measured: MeasurementSet, logs: Sequence[Log]) -> bool:
    if measured.noise[name].unit != "rad" or quantity(name) != POSITION:
        return False
    return any(float(np.ptp(log.outputs[name].value)) > _TURN for log in logs)


def _as_degrees(measured: MeasurementSet, channels: Collection[str]) -> MeasurementSet:
    def scaled(log: Log) -> Log:
        outputs = {
            name: replace(signal, value=signal.value * _DEGREE) if name in channels else signal
            for name, signal in log.outputs.items()
        }
        return replace(log, outputs=outputs)

    noise = {
        name: replace(value, std=value.std * _DEGREE) if name in channels else value
        for name, value in measured.noise.items()
    }
    return replace(
        measured, fit=tuple(map(scaled, measured.fit)), held_out=tuple(map(scaled, measured.held_out)), noise=noise
    )
