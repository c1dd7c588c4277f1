"""Channels that the model follows far better when they are read in another unit, or turned."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, NamedTuple

import numpy as np

from dr_lab.bounds import Count, Positive, at_least, require_bounds
from dr_lab.channel_names import POSITION, VELOCITY, is_sensor, joint_of, quantity
from dr_lab.diagnosis.evidence.score import Score, score_of
from dr_lab.diagnosis.faults.fault_words import channel_units, remedy_of_unit
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.settings import SolverSettings, WindowSettings
from dr_lab.diagnosis.windows.start import untold_joints
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log, MeasurementSet

_DEGREE = np.pi / 180.0
# An angle that covers less than a turn of radians is none of degrees that anyone would log.
_TURN = 2 * np.pi


@dataclass(frozen=True)
class ReadingSettings:
    """When channels seem to be read in another unit or sign than they have.

    Attributes:
        windows: of each log that are looked at.
        follows: a model that leaves less χ² per sample has the unit of the data, whatever else it lacks.
        better: factor by which the other reading must lower χ².
        most: channels that are read otherwise, one at a time, those that the model follows worst.

    Raises:
        ConfigError: a number is out of its range.
    """

    windows: Count
    follows: Positive
    better: Annotated[float, at_least(1.0)]
    most: Count

    def __post_init__(self) -> None:
        require_bounds(self, "faults.reading")


@dataclass(frozen=True)
class Misreading:
    """Channels that seem to be read wrongly.

    Attributes:
        channels: their names.
        chi2: held-out χ² as declared.
        chi2_read_anew: the same with these channels read otherwise.
        told: how they are read then, as the end of a sentence.
        remedy: what to write.
        turned: whether that is the other sign.
    """

    channels: tuple[str, ...]
    chi2: float
    chi2_read_anew: float
    told: str
    remedy: str
    turned: bool = False

    @property
    def message(self) -> str:
        """The suspicion in sentences."""
        names = ", ".join(self.channels)
        return (
            f"{names}, as declared, leave{'s' * (len(self.channels) == 1)} χ² {self.chi2:.3g}; {self.told} "
            f"{self.chi2_read_anew:.3g}. {self.remedy}"
        )


@dataclass(frozen=True)
class FewWindows:
    """How well a model at its nominal context follows few windows of logs, from fitted starts.

    Attributes:
        model: the model.
        rules: how many windows, and when a channel seems to be misread.
        settings: how logs are cut.
        solver: settings of the fit of start states.
        threads: C threads.
    """

    model: Model
    rules: ReadingSettings
    settings: WindowSettings
    solver: SolverSettings
    threads: int | None

    def score(self, measured: MeasurementSet) -> Score:
        """Score of the held-out logs, or of the fit logs where none is held out."""
        logs = _looked_at(measured)
        most = self.rules.windows * self.settings.length * len(logs)
        few = replace(self.settings, seconds=min(self.settings.seconds, most))
        windows = cut(logs, measured, self.model.nominal(), few)
        return score_of(*fit_states(self.model, self.model.space.nominal, windows, self.solver, self.threads))


def suspect_degrees(few: FewWindows, measured: MeasurementSet) -> Misreading | None:
    """Compare the model with the logs as declared and with wide angles read as degrees.

    Noise is scaled with its channel, so both χ² weigh the same relative errors.
    """
    wide = tuple(name for name in measured.noise if _is_wide(name, measured, _looked_at(measured)))
    if not wide or (given := few.score(measured).chi2) < few.rules.follows:
        return None
    factors = dict.fromkeys((*wide, *(f"{joint_of(name)}.{VELOCITY}" for name in wide)), _DEGREE)
    other = few.score(_scaled(measured, factors)).chi2
    told = "read as degrees (the factor 57.3 = 180/π)"
    remedy = "Write unit: deg if the numbers are degrees."
    return Misreading(wide, given, other, told, remedy) if other * few.rules.better < given else None


def suspect_misread(few: FewWindows, measured: MeasurementSet) -> Misreading | None:
    """The scalar channel whose numbers the model follows far better with the other sign, or in another unit.

    Inverse dynamics tells signs and units of joints and commands, but only where all joints are measured, and of no
    sensor. One that is misread is among those that the model follows worst.
    """
    outputs, untested = _looked_at(measured)[0].outputs, untold_joints(few.model.nominal(), (*measured.noise,))
    names = [name for name in measured.noise if (is_sensor(name) or untested) and outputs[name].value.ndim == 1]
    if not names or (given := few.score(measured)).chi2 < few.rules.follows:
        return None
    worst = sorted(names, key=lambda name: -_misfit(given, name))[: few.rules.most]
    every = [reading for name in worst for reading in _readings(name, measured.noise[name].unit)]
    others = [few.score(_scaled(measured, {reading.channel: reading.factor})).chi2 for reading in every]
    other, best = min(zip(others, every, strict=True), key=lambda pair: pair[0])
    if other * few.rules.better >= given.chi2:
        return None
    return Misreading((best.channel,), given.chi2, other, best.told, best.remedy, turned=best.factor < 0)


def _looked_at(measured: MeasurementSet) -> Sequence[Log]:
    return measured.held_out or measured.fit


class _Reading(NamedTuple):
    """Another reading of a channel: its numbers times a factor, in words, and what to write."""

    channel: str
    factor: float
    told: str
    remedy: str


def _readings(name: str, unit: str) -> Iterator[_Reading]:
    place = f"measurements.outputs.{name}"
    yield _Reading(name, -1.0, "with the other sign", f"Turn its sign in {place}, or its axis in the model.")
    for true, called, factor in channel_units(unit):
        told = f"if it is in {true} and called {called}"
        yield _Reading(name, factor, told, remedy_of_unit(place, true, called, factor))


def _misfit(score: Score, name: str) -> float:
    """χ² of a channel alone; infinite where no window tells it."""
    channel = score.channels.get(name)
    return np.inf if channel is None else channel.chi2


def _is_wide(name: str, measured: MeasurementSet, logs: Sequence[Log]) -> bool:
    if measured.noise[name].unit != "rad" or quantity(name) != POSITION:
        return False
    return any(float(np.ptp(log.outputs[name].value)) > _TURN for log in logs)


def _scaled(measured: MeasurementSet, factors: Mapping[str, float]) -> MeasurementSet:
    """The logs with some channels' numbers and noise times factors."""

    def scaled(log: Log) -> Log:
        outputs = {
            name: replace(signal, value=signal.value * factors.get(name, 1.0)) for name, signal in log.outputs.items()
        }
        return replace(log, outputs=outputs)

    noise = {
        name: replace(value, std=value.std * abs(factors.get(name, 1.0))) for name, value in measured.noise.items()
    }
    return replace(
        measured, fit=tuple(map(scaled, measured.fit)), held_out=tuple(map(scaled, measured.held_out)), noise=noise
    )
