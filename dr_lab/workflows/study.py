"""What every comparing verb starts from: windows, scales and floors of one model and one set of logs."""

from collections.abc import Mapping
from dataclasses import dataclass

import mujoco

from dr_lab.diagnosis.localise import LocaliseSettings
from dr_lab.diagnosis.model_check import ModelCheckSettings
from dr_lab.diagnosis.numerical_floor import NumericalFloor, numerical_floor
from dr_lab.diagnosis.rank import Bench
from dr_lab.diagnosis.refinement import Refinement, refine
from dr_lab.diagnosis.scales import machine_scales, with_replay
from dr_lab.diagnosis.self_test import require_own_logs_explained
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings, WindowSettings
from dr_lab.diagnosis.states import fit_states
from dr_lab.diagnosis.windows import Windows, cut
from dr_lab.effects.effect import Scales
from dr_lab.errors import ConfigError
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import thread_count
from dr_lab.trajectory import MeasurementSet


@dataclass(frozen=True)
class Study:
    """One model beside one set of logs.

    Attributes:
        model: the model as given, with a finer step where its own moves an output.
        compiled: compiled at its nominal context.
        measurements: the logs.
        bench: windows and settings on which models are compared.
        predicted: held-out windows whose start is known only from earlier samples.
        windows: how windows are cut.
        prediction: how predicted windows are cut.
        local: how the place of failure is looked for.
        scales: typical magnitudes of the machine.
        floor: error of the time step of the model as given.
        refinement: which step stands in its place, and why.
        own_chi2: χ² by channel of logs that the model made itself.
    """

    model: Model
    compiled: mujoco.MjModel
    measurements: MeasurementSet
    bench: Bench
    predicted: Windows
    windows: WindowSettings
    prediction: WindowSettings
    local: LocaliseSettings
    scales: Scales
    floor: NumericalFloor
    refinement: Refinement
    own_chi2: Mapping[str, float]


def prepare(
    model: Model,
    measurements: MeasurementSet,
    windows: WindowSettings,
    predicted: WindowSettings,
    solver: SolverSettings,
    evidence: EvidenceSettings,
    localise: LocaliseSettings,
    model_check: ModelCheckSettings,
    threads: int | None,
) -> Study:
    """Cut the logs and measure scales and the numerical floor, and check the model.

    Where the model's step moves an output, what follows has a finer one. Without held-out logs the fit logs score too,
    which the report says.

    Raises:
        ConfigError: no log is there to fit on.
        ModelError: the model diverges in every window, or does not explain logs that it made itself.
    """
    if not measurements.fit:
        raise ConfigError(
            f"Measurements {measurements.name!r} name no log to fit on. Name at least one in measurements.fit."
        )
    count = thread_count(threads)
    scored = measurements.held_out or measurements.fit
    floor = numerical_floor(model, scored, measurements, windows, count)
    refined = refine(model, scored, measurements, windows, model_check, floor, count)
    model, compiled = refined.model, refined.model.nominal()
    fit = cut(measurements.fit, measurements, compiled, windows)
    bench = Bench(
        fit=fit,
        held_out=cut(scored, measurements, compiled, windows) if measurements.held_out else fit,
        solver=solver,
        evidence=evidence,
        threads=count,
        timing_resolution=refined.given,
    )
    own = require_own_logs_explained(model, measurements, windows, solver, model_check)
    return Study(
        model=model,
        compiled=compiled,
        measurements=measurements,
        bench=bench,
        predicted=cut(scored, measurements, compiled, predicted),
        windows=windows,
        prediction=predicted,
        local=localise,
        scales=_scales(model, compiled, measurements, windows.smoother, bench),
        floor=floor,
        refinement=refined,
        own_chi2=own,
    )


def _scales(
    model: Model, compiled: mujoco.MjModel, measurements: MeasurementSet, smoother: float, bench: Bench
) -> Scales:
    """Scales of the fit logs; of joints that no channel measures, those of the nominal model in these logs."""
    found = machine_scales(compiled, measurements.fit, smoother)
    if not found.unmeasured:
        return found
    return with_replay(found, *fit_states(model, model.space.nominal, bench.fit, bench.solver, bench.threads))
