"""What every comparing verb starts from: windows, scales and floors of one model and one set of logs."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray

from dr_lab.diagnosis.bench import Bench
from dr_lab.diagnosis.data_faults import Fault, suspect_faults
from dr_lab.diagnosis.fault_settings import FaultSettings
from dr_lab.diagnosis.fit import Fitter
from dr_lab.diagnosis.localise import LocaliseSettings
from dr_lab.diagnosis.model_check import ModelCheckSettings
from dr_lab.diagnosis.numerical_floor import NumericalFloor, numerical_floor
from dr_lab.diagnosis.refinement import Refinement, refine, unneeded
from dr_lab.diagnosis.replay import Replay
from dr_lab.diagnosis.scales import machine_scales, with_replay
from dr_lab.diagnosis.score import score_of
from dr_lab.diagnosis.self_test import require_own_logs_explained
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings, WindowSettings
from dr_lab.diagnosis.states import fit_states
from dr_lab.diagnosis.windows import Windows, cut
from dr_lab.effects.effect import Scales
from dr_lab.errors import ConfigError
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import thread_count
from dr_lab.trajectory import MeasurementSet
from dr_lab.workflows.fault_notes import say_faults
from dr_lab.workflows.state_fits import StateFits


@dataclass(frozen=True)
class Study:
    """One model beside one set of logs.

    Attributes:
        model: the model as given, with a finer step where its own moves an output.
        compiled: compiled at its nominal context.
        measurements: the logs.
        bench: windows and settings on which models are compared.
        predicted: held-out windows whose start is known only from earlier samples.
        short: such windows that are so short that an error stays near the state that caused it.
        few: places of those short windows in which missing forces are looked at, evenly spread.
        fits: states of windows that were fitted for the report.
        windows: how windows are cut.
        prediction: how predicted windows are cut.
        local: how the place of failure is looked for.
        scales: typical magnitudes of the machine.
        floor: error of the time step of the model as given.
        refinement: which step stands in its place, and why.
        own_chi2: χ² by channel of logs that the model made itself.
        faults: what the model shows to be wrong with the logs.
    """

    model: Model
    compiled: mujoco.MjModel
    measurements: MeasurementSet
    bench: Bench
    predicted: Windows
    short: Windows
    few: NDArray[np.intp]
    fits: StateFits
    windows: WindowSettings
    prediction: WindowSettings
    local: LocaliseSettings
    scales: Scales
    floor: NumericalFloor
    refinement: Refinement
    own_chi2: Mapping[str, float]
    faults: tuple[Fault, ...]


def prepare(
    model: Model,
    measurements: MeasurementSet,
    windows: WindowSettings,
    predicted: WindowSettings,
    solver: SolverSettings,
    evidence: EvidenceSettings,
    localise: LocaliseSettings,
    model_check: ModelCheckSettings,
    faults: FaultSettings,
    threads: int | None,
) -> Study:
    """Cut the logs and measure scales and the numerical floor, and check the model.

    Where the model's step moves an output, what follows has a finer one, unless the calibrated model leaves no more
    than noise as it is: then the logs ask for no other physics, or were simulated with that very step. Faults of the
    logs are printed at once, before anything is fitted. Without held-out logs the fit logs score too, which the report
    says.

    Raises:
        ConfigError: no log is there to fit on.
        ModelError: the model diverges in every window, or does not explain logs that it made itself.
    """
    if not measurements.fit:
        raise ConfigError(
            f"Measurements {measurements.name!r} name no log to fit on. Name at least one in measurements.fit."
        )
    suspected = suspect_faults(model, measurements, faults)
    say_faults(suspected, measurements)
    count = thread_count(threads)
    scored = measurements.held_out or measurements.fit
    floor = numerical_floor(model, scored, measurements, windows, count)
    resolution = max(floor.step, _longest_wait(measurements, suspected))
    bench = Bench(*_windows(model, measurements, windows), solver, evidence, count, timing_resolution=resolution)
    if floor.largest > model_check.least_share and _explains(model, bench, model_check):
        refined = unneeded(model, floor)
    else:
        refined = refine(model, scored, measurements, windows, model_check, floor, count)
    if refined.model is not model:
        model = refined.model
        fit, held_out = _windows(model, measurements, windows)
        bench = replace(bench, fit=fit, held_out=held_out)
    compiled = model.nominal()
    own = require_own_logs_explained(model, measurements, windows, solver, model_check)
    short = cut(scored, measurements, compiled, _short(predicted, localise))
    return Study(
        model=model,
        compiled=compiled,
        measurements=measurements,
        bench=bench,
        predicted=cut(scored, measurements, compiled, predicted),
        short=short,
        few=_spread(len(short), localise.formula.windows),
        fits=StateFits(solver, count),
        windows=windows,
        prediction=predicted,
        local=localise,
        scales=_scales(model, compiled, measurements, windows.smoother, bench),
        floor=floor,
        refinement=refined,
        own_chi2=own,
        faults=suspected,
    )


def _longest_wait(measured: MeasurementSet, suspected: Sequence[Fault]) -> float:
    """Longest usual time in s between two samples of commands that seem logged more slowly than they changed; or 0."""
    logs = {log.name: log for log in (*measured.fit, *measured.held_out)}
    rare = [logs[fault.log].commands[fault.signal] for fault in suspected if fault.kind == "decimated"]
    return max((float(np.median(np.diff(signal.time))) for signal in rare), default=0.0)


def _windows(model: Model, measurements: MeasurementSet, windows: WindowSettings) -> tuple[Windows, Windows]:
    """Windows to fit on and to score, the same where no log is held out."""
    compiled = model.nominal()
    fit = cut(measurements.fit, measurements, compiled, windows)
    return fit, cut(measurements.held_out, measurements, compiled, windows) if measurements.held_out else fit


def _explains(model: Model, bench: Bench, check: ModelCheckSettings) -> bool:
    """Whether the model, calibrated, leaves no more than noise on the scored windows."""
    fit = Fitter(Replay(model, bench.fit, bench.threads), bench.solver).run(model.space.nominal)
    score = score_of(*fit_states(model, fit.z, bench.held_out, bench.solver, bench.threads))
    return score.chi2 <= check.most_chi2(score.freedom)


def _short(predicted: WindowSettings, localise: LocaliseSettings) -> WindowSettings:
    return replace(predicted, length=localise.length, stride=localise.length, max_windows=localise.max_windows)


def _spread(count: int, most: int) -> NDArray[np.intp]:
    """At most so many of a count of places, from the first to the last."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.intp))


def _scales(
    model: Model, compiled: mujoco.MjModel, measurements: MeasurementSet, smoother: float, bench: Bench
) -> Scales:
    """Scales of the fit logs; of joints that no channel measures, those of the nominal model in these logs."""
    found = machine_scales(compiled, measurements.fit, smoother)
    if not found.unmeasured:
        return found
    return with_replay(found, *fit_states(model, model.space.nominal, bench.fit, bench.solver, bench.threads))
