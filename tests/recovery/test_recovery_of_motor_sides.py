"""What turns apart from its link, as two inertias solved by SciPy, is found again beside a wrong mass and damping."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import NOISE, STEP, clock, log_of, pendulum, solver_settings, steps_command, windows_of
from effect_machines import placed, scales_of

from dr_lab.diagnosis.fit.levenberg_marquardt import Fitter
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.plants.body import Body
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.backlash import Backlash
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.hidden.flexible_mode import FlexibleMode
from dr_lab.plants.hidden.joint_elasticity import JointElasticity
from dr_lab.plants.hidden.motor_side_elasticity import MotorSideElasticity
from dr_lab.plants.motion import Accuracy, simulate
from dr_lab.plants.pendulum import PendulumNominal
from dr_lab.trajectory import Log

MACHINE = PendulumNominal(mass=0.5, centre=0.3, inertia=0.005, rotor=0.0, gravity=9.81, spread=0.0)
TRUTH = {"rod.mass": 0.6, "hinge.damping": 0.08}
ROTOR, SECONDS, SITE = 0.02, 3.0, "hinge"
SOLVER = solver_settings(tolerance=1e-3)  # of the cost; with 1e-5 the fits end at the same values


def log(seed: int, hidden: HiddenEffect) -> Log:
    """The test's pendulum with a true mass and damping, and its motor apart from its link."""
    plain = MACHINE.machine({"link.mass": TRUTH["rod.mass"], "link.com": MACHINE.centre})
    machine = replace(plain, joints=(SITE,), damping=(TRUTH["hinge.damping"],))
    asked, time = steps_command("drive", 1.0, SECONDS, seed), clock(round(SECONDS / STEP))
    accuracy = Accuracy(relative=1e-8, absolute=1e-9, longest_step=0.005)
    states = simulate(machine, hidden, [Command(asked.time, asked.value)], time, accuracy=accuracy)
    noise = NOISE * np.random.default_rng(1000 + seed).normal(size=len(time))
    (column, *_) = Body.of(machine, hidden).read_columns
    return log_of(f"log_{seed}", {f"{SITE}.position": (time, states[:, column] + noise)}, asked)


def fitted(hidden: HiddenEffect, start: Mapping[str, float]) -> tuple[dict[str, float], float]:
    """Values of a fit from a start, by short name, and the cost a sample."""
    plain = pendulum()
    model = plain.with_effect(placed(plain, hidden.name, SITE, scales_of(plain, torque=1.0)))
    fitter = Fitter(Replay(model, windows_of(plain, [log(seed, hidden) for seed in range(2)]), 1), SOLVER)
    fit = fitter.run(model.space.vector({f"{hidden.label}.{name}": value for name, value in start.items()}))
    values = {name.removeprefix(f"{hidden.label}."): value for name, value in model.space.mapping(fit.z).items()}
    return values, fit.cost / float(fitter.replay.fitted.sum())


@pytest.mark.slow
def test_the_soft_shaft_is_found() -> None:
    """The product of rotor and compliance tells itself best: below the resonance the link sees no more."""
    hidden = JointElasticity(SITE, ROTOR, compliance=0.02, damping=0.3)
    found, cost = fitted(hidden, {"compliance": 0.015, "rotor": ROTOR})
    assert cost == pytest.approx(1.0, abs=0.1)
    assert found["rotor"] * found["compliance"] == pytest.approx(ROTOR * 0.02, rel=0.2)
    assert found["rod.mass"] == pytest.approx(TRUTH["rod.mass"], rel=0.01)


@pytest.mark.slow
def test_the_soft_shaft_is_found_from_the_motor() -> None:
    """There the link's inertia is not felt as a whole: rotor and compliance tell themselves apart."""
    hidden = MotorSideElasticity(SITE, ROTOR, compliance=0.01, damping=0.3)
    found, cost = fitted(hidden, {"compliance": 0.0075, "rotor": ROTOR})
    assert cost == pytest.approx(1.0, abs=0.15)  # how far the spring is wound at first is told by accelerations
    assert found["compliance"] == pytest.approx(0.01, rel=0.02)
    assert found["rotor"] == pytest.approx(ROTOR, rel=0.05)
    assert found["retardation"] == pytest.approx(0.3 * 0.01, rel=0.1)
    assert found["rod.mass"] == pytest.approx(TRUTH["rod.mass"], rel=0.01)
    assert found["hinge.damping"] == pytest.approx(TRUTH["hinge.damping"], rel=0.01)


@pytest.mark.slow
def test_the_gears_play_is_found() -> None:
    """Windows that begin where the teeth change sides may begin on the wrong one, hence the cost."""
    found, cost = fitted(Backlash(SITE, ROTOR, gap=0.04, stiffness=1e3, damping=3.0), {"gap": 0.03, "rotor": 0.015})
    assert cost < 2.0
    assert found["gap"] == pytest.approx(0.04, rel=0.1)
    assert found["rotor"] == pytest.approx(ROTOR, rel=0.1)
    assert found["rod.mass"] == pytest.approx(TRUTH["rod.mass"], rel=0.01)


@pytest.mark.slow
def test_the_part_that_swings_on_its_own_is_found() -> None:
    """It begins every window as the motion of the seconds before left it."""
    found, cost = fitted(FlexibleMode(SITE, 0.01, stiffness=3.0, damping=0.02), {"inertia": 0.005, "period": 0.4})
    assert cost == pytest.approx(1.0, abs=0.1)
    assert found["inertia"] == pytest.approx(0.01, rel=0.02)
    assert found["period"] == pytest.approx(2 * np.pi * np.sqrt(0.01 / 3.0), rel=0.002)
    assert found["damping"] == pytest.approx(0.5 * 0.02 / np.sqrt(0.01 * 3.0), rel=0.05)
    assert found["rod.mass"] == pytest.approx(TRUTH["rod.mass"], rel=0.01)
