import pytest
from effect_machines import acceleration, block, hanging, placed, with_effect


def test_slide_accelerates_by_force_over_mass_plus_armature() -> None:
    model = with_effect(block(joint='armature="0.5"'), "armature", "rail", inertia=1.5)
    assert acceleration(model, ctrl=8.0) == pytest.approx(8.0 / (2.0 + 0.5 + 1.5), rel=1e-12)


def test_rotor_adds_inertia_but_no_weight() -> None:
    model = with_effect(hanging(), "armature", "hinge", inertia=0.05)
    inertia = 0.005 + 0.5 * 0.3**2 + 0.05
    assert acceleration(model, qpos=1.5707963267948966) == pytest.approx(-0.5 * 9.81 * 0.3 / inertia, rel=1e-12)


def test_upper_bound_is_twice_the_joints_own_inertia() -> None:
    (parameter,) = placed(hanging(), "armature", "hinge").parameters
    assert parameter.high == pytest.approx(2 * (0.005 + 0.5 * 0.3**2), rel=1e-12)
    assert placed(block(), "armature", "rail").parameters[0].unit == "kg"


def test_it_is_also_looked_for_from_its_largest() -> None:
    """Motion falls with one over the inertia: from none, a step hardly sees a rotor far heavier than the link."""
    one = placed(hanging(), "armature", "hinge")
    assert [*one.starts] == [{"armature@hinge.inertia": one.parameters[0].high}]
