"""What is compared, and how: the one thing that every comparing verb is given."""

from collections.abc import Mapping
from dataclasses import dataclass

from dr_lab.diagnosis.checks.model_check import ModelCheckSettings
from dr_lab.diagnosis.faults.fault_settings import FaultSettings
from dr_lab.diagnosis.localise import LocaliseSettings
from dr_lab.diagnosis.missing_force.learning_settings import LearningSettings
from dr_lab.diagnosis.settings import EvidenceSettings, SolverSettings, WindowSettings
from dr_lab.effects.effect import Effect
from dr_lab.physics.model import Model
from dr_lab.trajectory import MeasurementSet


@dataclass(frozen=True)
class ComparisonSettings:
    """How a model is compared with logs; ``conf/comparison/default.yaml`` gathers the values.

    Attributes:
        windows: how logs are cut.
        predicted: how predicted windows are cut.
        solver: settings of the fits.
        evidence: when a gain counts.
        localise: how the place of failure is looked for.
        learning: how a force is learned that no effect explains.
        model_check: what is checked of the model before anything is blamed on the machine.
        faults: when a log is said to be faulty.
        usual: what models lack most often, which is allowed for where it is asked what commands did between samples.
        threads: worker threads; None takes every core.
    """

    windows: WindowSettings
    predicted: WindowSettings
    solver: SolverSettings
    evidence: EvidenceSettings
    localise: LocaliseSettings
    learning: LearningSettings
    model_check: ModelCheckSettings
    faults: FaultSettings
    usual: Mapping[str, Effect]
    threads: int | None


@dataclass(frozen=True)
class Comparison:
    """A model beside logs, and how they are compared.

    Attributes:
        model: the model as given.
        measurements: the logs.
        settings: how they are compared.
    """

    model: Model
    measurements: MeasurementSet
    settings: ComparisonSettings
