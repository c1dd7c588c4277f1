"""Formulas of a missing force: found where there is one, absent where there is only noise."""

import numpy as np
import pytest

from dr_lab.diagnosis.missing_force.force_formula import FormulaSettings, Variable, sparse_formula

SETTINGS = FormulaSettings(
    terms=4, harmonics=3, folds=4, parts=8, worth=0.02, least=40, windows=400, pushes=2800, trees=30
)
GENERATOR = np.random.default_rng(0)
ANGLE, SPEED, COMMAND, NOISE = GENERATOR.normal(size=(4, 400)) * np.array([[1.5], [3.0], [2.0], [1.0]])
LOGS = np.repeat(np.arange(4), 100)
VARIABLES = [
    Variable("arm position", "rad", "angle", ANGLE, "arm.q"),
    Variable("arm velocity", "rad/s", "velocity", SPEED, "arm.v"),
    Variable("motor command", "", "command", COMMAND, "motor.u"),
]


def test_a_hidden_formula_comes_back_with_its_coefficients_and_units() -> None:
    force = 0.2 * np.sin(2 * ANGLE) - 0.1 * np.sign(SPEED) + 0.01 * NOISE
    found = sparse_formula(force, "N·m", VARIABLES, LOGS, SETTINGS)
    assert found is not None
    assert found.coefficients == {
        "sin(2 [arm position])": pytest.approx(0.2, rel=0.01),
        "sign([arm velocity])": pytest.approx(-0.1, rel=0.02),
    }
    assert set(found.units.values()) == {"N·m"}
    assert [*found.expressions.values()] == ["sin(2 * arm.q)", "sign(arm.v)"]
    assert 0.98 < found.share <= found.ceiling <= 1.0


def test_units_follow_the_terms() -> None:
    found = sparse_formula(0.3 * np.abs(SPEED) * SPEED, "N·m", VARIABLES, LOGS, SETTINGS)
    assert found is not None
    assert found.units == {"|[arm velocity]| [arm velocity]": "N·m/((rad/s)²)"}
    assert found.share == pytest.approx(1.0)


def test_noise_has_no_formula_and_no_ceiling() -> None:
    found = sparse_formula(NOISE, "N·m", VARIABLES, LOGS, SETTINGS)
    assert found is not None
    assert found.coefficients == {}
    assert found.share == 0.0
    assert found.ceiling < 0.1


def test_a_force_that_no_term_fits_still_has_a_ceiling() -> None:
    """A narrow detent: a forest sees it, four smooth terms do not."""
    force = np.where(np.abs(ANGLE - 0.4) < 0.3, 1.0, 0.0)
    found = sparse_formula(force, "N·m", VARIABLES, LOGS, SETTINGS)
    assert found is not None
    assert found.ceiling > 0.85
    assert found.share < 0.7


def test_windows_that_diverged_are_left_out_and_few_say_nothing() -> None:
    force = 0.3 * COMMAND
    force[::3] = np.nan
    found = sparse_formula(force, "N", VARIABLES, LOGS, SETTINGS)
    assert found is not None
    assert found.coefficients == {"[motor command]": pytest.approx(0.3)}
    assert sparse_formula(np.where(np.arange(400) < 30, force, np.nan), "N", VARIABLES, LOGS, SETTINGS) is None
    assert sparse_formula(force, "N", VARIABLES, np.zeros(400, int), SETTINGS) is None


@pytest.mark.parametrize(("dofs", "windows"), [(0, 400), (2, 400), (7, 400), (18, 155), (100, 40)])
def test_machines_with_many_degrees_of_freedom_look_at_fewer_windows(dofs: int, windows: int) -> None:
    assert SETTINGS.windows_of(dofs) == windows
