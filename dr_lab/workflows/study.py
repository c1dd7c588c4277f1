"""What every comparing verb starts from: windows, scales and floors of one model and one set of logs."""

from dataclasses import dataclass

import mujoco

from dr_lab.diagnosis.data_faults import Fault, suspect_faults
from dr_lab.diagnosis.fault_settings import FaultSettings
from dr_lab.diagnosis.localise import LocaliseSettings
from dr_lab.diagnosis.numerical_floor import NumericalFloor, numerical_floor
from dr_lab.diagnosis.rank import Bench
from dr_lab.diagnosis.scales import machine_scales, with_replay
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings, WindowSettings
from dr_lab.diagnosis.states import fit_states
from dr_lab.diagnosis.windows import Windows, cut
from dr_lab.effects.effect import Scales
from dr_lab.errors import ConfigError
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import thread_count
from dr_lab.trajectory import MeasurementSet
from dr_lab.workflows.fault_notes import say_faults


@dataclass(frozen=True)
class Study:
    """One model beside one set of logs.

    Attributes:
        model: the model as given.
        compiled: compiled at its nominal context.
        measurements: the logs.
        bench: windows and settings on which models are compared.
        predicted: held-out windows whose start is known only from earlier samples.
        windows: how windows are cut.
        prediction: how predicted windows are cut.
        local: how the place of failure is looked for.
        scales: typical magnitudes of the machine.
        floor: error of the time step.
        faults: what the model shows to be wrong with the logs.
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
    faults: tuple[Fault, ...]


def prepare(
    model: Model,
    measurements: MeasurementSet,
    windows: WindowSettings,
    predicted: WindowSettings,
    solver: SolverSettings,
    evidence: EvidenceSettings,
    localise: LocaliseSettings,
    faults: FaultSettings,
    threads: int | None,
) -> Study:
    """Cut the logs and measure scales and the numerical floor.

    Faults of the logs are printed at once, before anything is fitted. Without held-out logs the fit logs score too,
    which the report says.
    """
    if not measurements.fit:
        raise ConfigError(
            f"Measurements {measurements.name!r} name no log to fit on. Name at least one in measurements.fit."
        )
    suspected = suspect_faults(model, measurements, faults)
    say_faults(suspected, measurements)
    compiled = model.nominal()
    count = thread_count(threads)
    scored = measurements.held_out or measurements.fit
    fit = cut(measurements.fit, measurements, compiled, windows)
    bench = Bench(
        fit=fit,
        held_out=cut(scored, measurements, compiled, windows) if measurements.held_out else fit,
        solver=solver,
        evidence=evidence,
        threads=count,
    )
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
        floor=numerical_floor(model, scored, measurements, windows, count),
        faults=suspected,
    )


def _scales(
    model: Model, compiled: mujoco.MjModel, measurements: MeasurementSet, smoother: float, bench: Bench
) -> Scales:
    """Scales of the fit logs; of joints that no channel measures, those of the nominal model in these logs."""
    found = machine_scales(compiled, measurements.fit, smoother)
    if not found.unmeasured:
        return found
    return with_replay(found, *fit_states(model, model.space.nominal, bench.fit, bench.solver, bench.threads))
