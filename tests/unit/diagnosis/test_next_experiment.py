from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest
from diagnosis_machines import NOISE, solver_settings, windows_settings
from effect_machines import block, placed
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.diagnosis.evidence.bench import FittedModel
from dr_lab.diagnosis.experiment import readings
from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.diagnosis.next_experiment import ExperimentMachine, ExperimentSettings, propose
from dr_lab.diagnosis.windows.windows import cut
from dr_lab.trajectory import Log, MeasurementSet, Noise, Signal

LIMIT = 6.0  # N
WINDOWS = windows_settings(seconds=3.6)
MACHINE = ExperimentMachine(
    start=np.zeros(1),
    limits={"drive": (-LIMIT, LIMIT)},
    noise={"rail.position": Noise(NOISE, "m", "given")},
    windows=WINDOWS,
    solver=solver_settings(),
    threads=1,
)


def fitted(effect: str, *values: float, site: str = "rail") -> FittedModel:
    """A block on a rail with one effect at the given values."""
    model = block().with_effect(placed(block(), effect, site))
    return FittedModel(model, cast(Any, SimpleNamespace(z=np.array(values))), cast(Any, None), cast(Any, None))


def settings() -> ExperimentSettings:
    return instantiate(compose("diagnose", []).next_experiment, _convert_="all")


COULOMB, VISCOUS = fitted("coulomb_friction", 1.0), fitted("viscous_friction", 0.8)


def test_the_proposed_experiment_decides() -> None:
    found = propose(COULOMB, VISCOUS, MACHINE, settings())
    assert found is not None
    assert found.separates == ("coulomb_friction@rail", "viscous_friction@rail")
    assert np.abs(found.commands["drive"].value).max() <= LIMIT  # a hair above would trip a drive
    time = np.arange(0.0, 6.0, 1 / 250)
    shown = readings(COULOMB.model, COULOMB.fit.z, MACHINE.start, found.commands, ["rail.position"], time)
    value = shown["rail.position"][:, 0] + NOISE * np.random.default_rng(0).normal(size=len(time))
    log = Log("played", {"rail.position": Signal("rail.position", "m", time, value)}, found.commands)
    measured = MeasurementSet("played", (log,), (), MACHINE.noise, {"rail.position": 0.1})
    costs = []
    for each in (COULOMB, VISCOUS):
        windows = cut([log], measured, each.model.nominal(), WINDOWS)
        fit = Fitter(Replay(each.model, windows, 1), MACHINE.solver).run(each.fit.z)
        costs.append(fit.cost)
    missed = costs[1] - costs[0]
    assert missed > 25  # five standard deviations
    assert missed > 0.5 * found.sigma**2


def test_the_best_experiment_is_refitted_first() -> None:
    every, first = (propose(COULOMB, VISCOUS, MACHINE, replace(settings(), refitted=count)) for count in (6, 1))
    assert every is not None
    assert first is not None
    assert first.sigma == pytest.approx(every.sigma)
    assert first.excitation == every.excitation
    given = settings().excitations
    backwards = replace(settings(), refitted=1, excitations={name: given[name] for name in reversed(list(given))})
    turned = propose(COULOMB, VISCOUS, MACHINE, backwards)
    assert turned is not None
    assert turned.excitation == first.excitation


def test_what_is_the_same_to_every_experiment_is_not_separated() -> None:
    """A constant force along a horizontal rail and a rail that is not level."""
    offset, tilt = fitted("constant_offset", 0.5), fitted("base_tilt", 0.0, site="world")
    (tilted,) = tilt.model.effects
    values = np.zeros(len(tilted.parameters))
    values[0] = 0.5 / (2 * 9.81)
    found = propose(offset, fitted("base_tilt", *values, site="world"), MACHINE, settings())
    assert found is not None
    assert found.sigma < 5


def test_the_command_uses_a_range_that_is_not_symmetric() -> None:
    machine = ExperimentMachine(**{**vars(MACHINE), "limits": {"drive": (1.0, 3.0)}})
    found = propose(COULOMB, VISCOUS, machine, settings())
    assert found is not None
    value = found.commands["drive"].value
    assert value.min() >= 1.0
    assert value.max() <= 3.0
    assert value.mean() == pytest.approx(2.0, abs=0.5)
