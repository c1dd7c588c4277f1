"""Dry friction of the model's own that holds better than MuJoCo's default lets it."""

import numpy as np
import pytest
from effect_machines import block_by, catalogue_effect, stopping, with_effect

OWN = 'frictionloss="8"'
INTEGRATORS = pytest.mark.parametrize("integrator", ["RK4", "implicitfast", "Euler"])


@INTEGRATORS
def test_absent_the_friction_is_as_its_author_wrote_it(integrator: str) -> None:
    same = with_effect(block_by(integrator, OWN), "hard_friction", "rail", softness=1.0)
    np.testing.assert_array_equal(stopping(same), stopping(block_by(integrator, OWN).nominal()))


@INTEGRATORS
def test_the_hardest_is_nearly_coulomb_friction(integrator: str) -> None:
    hard = with_effect(block_by(integrator, OWN), "hard_friction", "rail", softness=0.01)
    coulomb = with_effect(block_by(integrator), "coulomb_friction", "rail", torque=8.0)
    np.testing.assert_allclose(stopping(hard), stopping(coulomb), atol=1e-4)


def test_the_harder_the_slower_it_creeps() -> None:
    """(1 − d) a₀/(d b) with 1 − d and 1/b half of the way to MuJoCo's defaults, and a₀ = 6 N / 2 kg."""
    speeds = [
        stopping(with_effect(block_by("RK4", OWN), "hard_friction", "rail", softness=s))[-1, 2]
        for s in (0.01, 0.5, 1.0)
    ]
    assert (np.diff(speeds) > 0).all()
    part, impedance = 0.5 * 0.002 / 1.8 + 0.5 / 94.737, 0.5 * (0.999 + 0.9)
    assert speeds[1] == pytest.approx((1 - impedance) * 3.0 * part, rel=0.01)


@pytest.mark.parametrize(
    ("joint", "sites"),
    [
        (OWN, ("rail",)),
        ("", ()),
        (f'{OWN} solreffriction="0.004 1"', ()),
        (f'{OWN} solimpfriction="0.99 0.999 0.001"', ()),
    ],
)
def test_it_sits_where_friction_is_soft_and_nobody_chose_so(joint: str, sites: tuple[str, ...]) -> None:
    assert catalogue_effect("hard_friction").sites(block_by("RK4", joint).nominal()) == sites
