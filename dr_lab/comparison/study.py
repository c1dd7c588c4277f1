"""What every comparing verb starts from: windows, scales and floors of one model and one set of logs."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.comparison.comparison import Comparison, ComparisonSettings
from dr_lab.comparison.fault_notes import known_faults
from dr_lab.comparison.first_notes import say_first
from dr_lab.comparison.silent_notes import silent_notes, unchecked_notes
from dr_lab.comparison.state_fits import StateFits
from dr_lab.comparison.unlogged_commands import longest_wait, with_lines
from dr_lab.diagnosis.checks.control_units import require_control_units
from dr_lab.diagnosis.checks.firm_loops import firm_loops
from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.checks.numerical_floor import NumericalFloor, numerical_floor
from dr_lab.diagnosis.checks.output_units import require_output_units
from dr_lab.diagnosis.checks.refinement import Refinement, refine, unneeded
from dr_lab.diagnosis.checks.self_test import require_own_logs_explained
from dr_lab.diagnosis.evidence.bench import Bench, fitted
from dr_lab.diagnosis.evidence.score import score_of
from dr_lab.diagnosis.faults.data_faults import Fault, suspect_faults
from dr_lab.diagnosis.faults.drive_fit import forces_of
from dr_lab.diagnosis.faults.straight_commands import may_follow_lines
from dr_lab.diagnosis.fit.fit import Fit
from dr_lab.diagnosis.fit.scales import machine_scales, with_replay
from dr_lab.diagnosis.fit.states import fit_states
from dr_lab.diagnosis.fit.touching import may_touch
from dr_lab.diagnosis.localise import LocaliseSettings
from dr_lab.diagnosis.settings import WindowSettings
from dr_lab.diagnosis.windows.blocks import spread
from dr_lab.diagnosis.windows.channels import resolve
from dr_lab.diagnosis.windows.folds import folds
from dr_lab.diagnosis.windows.windows import Windows, cut
from dr_lab.effects.effect import Scales
from dr_lab.errors import ConfigError
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import thread_count
from dr_lab.reports.gap_entries import NoteEntry
from dr_lab.trajectory import MeasurementSet


@dataclass(frozen=True)
class Study:
    """One model beside one set of logs.

    Attributes:
        comparison: what was asked for.
        model: the model as given, with a finer step where its own moves an output.
        compiled: compiled at its nominal context.
        bench: windows and settings on which models are compared.
        predicted: held-out windows whose start is known only from earlier samples.
        short: such windows that are so short that an error stays near the state that caused it.
        few: places of those short windows in which missing forces are looked at, evenly spread.
        fits: states of windows that were fitted for the report.
        scales: typical magnitudes of the machine.
        floor: error of the time step of the model as given.
        refinement: which step stands in its place, and why.
        faults: what the model shows to be wrong with the logs.
    """

    comparison: Comparison
    model: Model
    compiled: mujoco.MjModel
    bench: Bench
    predicted: Windows
    short: Windows
    few: NDArray[np.intp]
    fits: StateFits
    scales: Scales
    floor: NumericalFloor
    refinement: Refinement
    faults: tuple[Fault, ...]

    @property
    def measurements(self) -> MeasurementSet:
        """The logs."""
        return self.comparison.measurements

    @property
    def settings(self) -> ComparisonSettings:
        """How they are compared."""
        return self.comparison.settings

    def with_settings(self, settings: ComparisonSettings) -> "Study":
        """The same model and logs, compared in another way.

        Raises:
            DataError: no log holds such a window.
        """
        return _study(replace(self.comparison, settings=settings), self.faults)


def prepare(comparison: Comparison, tell: Callable[[Sequence[NoteEntry]], None] = say_first) -> Study:
    """Cut the logs and measure scales and the numerical floor, and check the model.

    Where the model's step moves an output, what follows has a finer one, unless the calibrated model leaves no more
    than noise as it is: then the logs ask for no other physics, or were simulated with that very step. Faults of the
    logs are told at once, as soon as is known which of them are allowed for, and what the model has and no log names.
    Without held-out logs the fit logs score too, which the report says.

    Args:
        comparison: model, logs and settings.
        tell: is called with these notes.

    Raises:
        ConfigError: no log is there to fit on.
        UnknownNameError: the model has no such channel.
        DataError: a command is a torque for a slide or a force for a hinge, or a joint's channel the other quantity.
        ModelError: the model diverges in every window, or does not explain logs that it made itself.
    """
    measured = comparison.measurements
    if not measured.fit:
        raise ConfigError(
            f"Measurements {measured.name!r} name no log to fit on. Name at least one in measurements.fit."
        )
    every = (*measured.fit, *measured.held_out)
    require_control_units(comparison.model.nominal(), every)
    require_output_units(comparison.model.nominal(), every)
    forces = forces_of(comparison.model, measured, comparison.settings.faults)
    suspected = suspect_faults(forces, measured)
    read = with_lines(comparison, suspected, may_follow_lines(forces, measured, comparison.settings.faults))
    compiled = comparison.model.nominal()
    resolve(compiled, tuple(measured.fit[0].outputs))  # a name that is wrong is no channel that is lacking
    silent = (*silent_notes(compiled, measured), *unchecked_notes(measured, comparison.settings.faults))
    tell([*known_faults(suspected, read.measurements), *silent])
    return _study(read, suspected)


def _study(comparison: Comparison, faults: tuple[Fault, ...]) -> Study:
    model, measured, settings = comparison.model, comparison.measurements, comparison.settings
    count, windows = thread_count(settings.threads), settings.windows
    resolution = longest_wait(measured, faults)
    scored = measured.held_out or measured.fit
    floor = numerical_floor(model, scored, measured, windows, count)
    refined = _refined(comparison, floor, resolution)
    compiled = refined.model.nominal()
    bench = _bench(refined.model, comparison, max(floor.step, resolution))
    short = cut(scored, measured, compiled, _short(settings.predicted, settings.localise))
    require_own_logs_explained(refined.model, measured, windows, settings.solver, settings.model_check)
    return Study(
        comparison=comparison,
        model=refined.model,
        compiled=compiled,
        bench=bench,
        predicted=cut(scored, measured, compiled, settings.predicted.of_machine(compiled.nv)),
        short=short,
        few=spread(len(short), settings.localise.formula.windows_of(compiled.nv)),
        fits=StateFits(settings.solver, count),
        scales=_scales(refined.model, compiled, measured, windows.smoother, bench),
        floor=floor,
        refinement=refined,
        faults=faults,
    )


def _bench(model: Model, comparison: Comparison, resolution: float) -> Bench:
    """Windows on which models are compared; no delay below `resolution` in s is told from none."""
    measured, settings, compiled = comparison.measurements, comparison.settings, model.nominal()
    windows = settings.windows.of_machine(compiled.nv)
    fit = cut(measured.fit, measured, compiled, windows)
    scored = cut(measured.held_out, measured, compiled, windows) if measured.held_out else fit
    chooses, confirms = (fit, None) if scored is fit else folds(scored)
    threads = thread_count(settings.threads)
    return Bench(fit, chooses, settings.solver, settings.evidence, threads, resolution, confirms)


def _refined(comparison: Comparison, floor: NumericalFloor, wait: float) -> Refinement:
    """The model with a step that does not show, or as given where the logs ask for nothing else."""
    model, measured, settings = comparison.model, comparison.measurements, comparison.settings
    check, count, scored = settings.model_check, thread_count(settings.threads), measured.held_out or measured.fit
    loops = firm_loops(model, scored, measured, settings.windows, check, count)
    shows = max(floor.largest, loops.share) > check.least_share
    if shows and _explains(model, _bench(model, comparison, max(floor.step, wait)), check):
        return unneeded(model, floor)
    if loops.share <= check.least_share:
        return refine(model, scored, measured, settings.windows, check, floor, count)
    floor = numerical_floor(loops.model, scored, measured, settings.windows, count)
    refined = refine(loops.model, scored, measured, settings.windows, check, floor, count)
    return replace(refined, message=f"{loops.message} {refined.message}".strip())


def _explains(model: Model, bench: Bench, check: ModelCheckSettings) -> bool:
    """Whether the model, calibrated, leaves no more than noise on the scored windows.

    It is given up where it is foretold to leave far more in the windows that it sees.
    """
    few = bench.screening()
    dear = (model.inertials or may_touch(model.nominal())) and few is not bench
    if dear and _hopeful(model, few, check) is None:
        return False
    fit = _hopeful(model, bench, check)
    if fit is None:
        return False
    score = score_of(*fit_states(model, fit.z, bench.held_out, bench.solver, bench.threads))
    return score.chi2 <= check.most_chi2(score.freedom)


def _hopeful(model: Model, bench: Bench, check: ModelCheckSettings) -> Fit | None:
    """The model's calibration; None where it is foretold to leave far more than noise in the windows that it sees."""
    hopeless = check.hopeless * bench.samples
    fit = fitted(bench, model, model.space.nominal, goal=hopeless)
    return fit if fit.cost <= hopeless else None


def _short(predicted: WindowSettings, localise: LocaliseSettings) -> WindowSettings:
    return replace(predicted.of_length(localise.length), seconds=localise.seconds)


def _scales(
    model: Model, compiled: mujoco.MjModel, measurements: MeasurementSet, smoother: float, bench: Bench
) -> Scales:
    """Scales of the fit logs; of joints that no channel measures, those of the model in these logs."""
    found = machine_scales(compiled, measurements.fit, smoother)
    if not found.unmeasured:
        return found
    return with_replay(found, *fit_states(model, model.space.nominal, bench.fit, bench.solver, bench.threads))
