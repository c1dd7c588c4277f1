"""Dry friction that creeps as MuJoCo's own does."""

import numpy as np
import pytest
from effect_machines import block_by, catalogue_effect, placed, stopping, with_effect

TORQUE = 8.0  # N
DEFAULT = 'frictionloss="8"'
INTEGRATORS = pytest.mark.parametrize("integrator", ["RK4", "implicitfast", "Euler"])


@INTEGRATORS
def test_at_softness_1_it_is_what_friction_loss_alone_gives(integrator: str) -> None:
    soft = with_effect(block_by(integrator), "soft_friction", "rail", torque=TORQUE, softness=1.0)
    np.testing.assert_allclose(stopping(soft), stopping(block_by(integrator, DEFAULT).nominal()), atol=1e-8)


@INTEGRATORS
def test_the_hardest_is_nearly_coulomb_friction(integrator: str) -> None:
    hard = with_effect(block_by(integrator), "coulomb_friction", "rail", torque=TORQUE)
    soft = with_effect(block_by(integrator), "soft_friction", "rail", torque=TORQUE, softness=0.01)
    np.testing.assert_allclose(stopping(soft), stopping(hard), atol=1e-4)


def test_the_softer_the_faster_it_creeps() -> None:
    speeds = [
        stopping(with_effect(block_by("RK4"), "soft_friction", "rail", torque=TORQUE, softness=softness))[-1, 2]
        for softness in (0.01, 0.5, 1.0, 1.25)
    ]
    assert speeds[0] < 1e-4
    assert (np.diff(speeds) > 0).all()
    # (1 - d) a0/(d b) with MuJoCo's defaults d = 0.9 and b = 2/(0.95 · 0.02 s), and a0 = 6 N / 2 kg
    assert speeds[2] == pytest.approx(0.1 * 3.0 / (0.9 * 2 / 0.019), rel=1e-3)


def test_without_torque_it_leaves_other_friction_as_hard_as_it_is() -> None:
    model = block_by("RK4")
    hard = model.with_effect(placed(model, "coulomb_friction", "rail"))
    both = hard.with_effect(placed(model, "soft_friction", "rail"))
    values = {"coulomb_friction@rail.torque": TORQUE, "soft_friction@rail.softness": 1.0}
    alone = hard.compile(hard.space.vector({"coulomb_friction@rail.torque": TORQUE}))
    np.testing.assert_array_equal(
        stopping(both.compile(both.space.vector({**values, "soft_friction@rail.torque": 0.0}))), stopping(alone)
    )
    half = both.compile(both.space.vector({**values, "soft_friction@rail.torque": TORQUE}))
    softer = with_effect(model, "soft_friction", "rail", torque=2 * TORQUE, softness=0.5)
    np.testing.assert_allclose(half.dof_solref, softer.dof_solref)
    np.testing.assert_allclose(half.dof_solimp, softer.dof_solimp)


def test_joints_with_friction_loss_of_their_own_are_no_sites() -> None:
    effect = catalogue_effect("soft_friction")
    assert effect.sites(block_by("RK4").nominal()) == ("rail",)
    assert effect.sites(block_by("RK4", DEFAULT).nominal()) == ()
