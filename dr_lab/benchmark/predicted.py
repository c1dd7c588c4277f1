"""Equivalence classes that are worked out from the truth, without anything that the diagnosis uses."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from dr_lab.benchmark.case import Case
from dr_lab.benchmark.equivalence import TruthClasses
from dr_lab.benchmark.observed import Compose, Observed
from dr_lab.errors import ConfigError
from dr_lab.plants.alike.classes import Classes
from dr_lab.plants.mujoco_machine import MujocoMachine
from dr_lab.plants.pinocchio_machine import PinocchioMachine
from dr_lab.plants.rig import Rig
from dr_lab.sources.plant import PlantSource


@dataclass(frozen=True)
class PredictedClasses(TruthClasses):
    """The class of every truth by `dr_lab.plants.alike`, whatever the answer is.

    Where another engine than Pinocchio moves the machine, as where bodies touch something, a truth is the only member
    of its class: what contacts do is not worked out.

    Attributes:
        rule: how classes are predicted.
    """

    rule: Classes

    def require(self, case: Case, compose: Compose) -> None:
        """Refuse logs that classes cannot be predicted of.

        Raises:
            ConfigError: they do not come from a plant, or the equations of the plant are written out by hand.
        """
        _documented(case, compose)

    def of(
        self, case: Case, truths: Sequence[str], found: Sequence[Sequence[str]], observed: Observed, compose: Compose
    ) -> Mapping[str, Mapping[str, int]]:
        """The class of every truth.

        Raises:
            ConfigError: as by `require`.
        """
        del found, observed
        plant = _documented(case, compose)
        if not truths or not isinstance(plant.documented, PinocchioMachine):
            return {}
        return {truth: members for truth, members in self.rule.of(plant, case.seed).items() if truth in truths}


def _documented(case: Case, compose: Compose) -> Rig:
    """The bench of a case, whose machine has an MJCF file."""
    source = compose("record", case.recording(case.instruments))["source"]
    if not isinstance(source, PlantSource):
        raise ConfigError(f"Case {case.name}: classes are predicted for logs of a plant alone (source=plant).")
    if not isinstance(source.plant.documented, MujocoMachine):
        raise ConfigError(
            f"Case {case.name}: classes are predicted of machines whose documents are an MJCF file; "
            f"{case.machine} is a {type(source.plant.documented).__name__}, whose equations are written out. "
            "Give classes=ranked."
        )
    return source.plant
