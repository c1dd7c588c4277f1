"""A cubic spring swings as Duffing's equation says, and adds to whatever spring a joint has."""

import numpy as np
import pytest
from effect_machines import acceleration, block, motion, placed, with_effect
from scipy.special import ellipj

CUBIC, MASS, START = 50.0, 2.0, 0.4


def test_a_block_swings_as_a_cosine_amplitude() -> None:
    """m x'' = −c x³ from x(0) = A at rest: x = A cn(A √(c/m) t, ½)."""
    model = with_effect(block(), "hardening_spring", "rail", cubic=CUBIC)
    time, place, _ = motion(model, 3.0, qpos=START).T
    _, cosine, _, _ = ellipj(START * np.sqrt(CUBIC / MASS) * time, 0.5)
    np.testing.assert_allclose(place, START * cosine, rtol=0, atol=1e-6)


@pytest.mark.parametrize("cubic", [CUBIC, -CUBIC])
def test_it_adds_to_the_joints_own_spring_about_where_that_rests(cubic: float) -> None:
    model = with_effect(block(joint='stiffness="10 3 2" springref="0.1"'), "hardening_spring", "rail", cubic=cubic)
    x = 0.3 - 0.1
    force = -(10.0 * x + 3.0 * x**2 + (2.0 + cubic) * x**3)
    assert acceleration(model, 0.3) == pytest.approx(force / MASS, rel=1e-12)


def test_with_a_spring_both_orders_are_one_machine() -> None:
    values = {"spring@rail.stiffness": 20.0, "spring@rail.reference": -0.1, "hardening_spring@rail.cubic": CUBIC}
    own, expected = (
        block(joint='stiffness="10 0 0" springref="0.1"'),
        -(10.0 * 0.2 + CUBIC * 0.2**3 + 20.0 * 0.4) / MASS,
    )
    for names in (("spring", "hardening_spring"), ("hardening_spring", "spring")):
        machine = own
        for name in names:
            machine = machine.with_effect(placed(own, name, "rail"))
        assert acceleration(machine.compile(machine.space.vector(values)), 0.3) == pytest.approx(expected, rel=1e-9)
