import numpy as np
import pytest
from effect_machines import block, catalogue_effect, motion, placed, scales_of, with_effect

MASS, MEAN, SHARE = 2.0, 4.0, 0.5
FORWARD, BACKWARD = 6.0, 2.0  # N


@pytest.mark.parametrize(("sign", "friction"), [(1, FORWARD), (-1, BACKWARD)])
def test_each_direction_has_its_own_friction(sign: int, friction: float) -> None:
    model = with_effect(block(), "asymmetric_friction", "rail", mean=MEAN, asymmetry=SHARE)
    time, position, speed = motion(model, 1.0, qvel=sign * 0.5, ctrl=sign * 10.0).T
    gain = (10.0 - friction) / MASS
    np.testing.assert_allclose(speed, sign * (0.5 + gain * time), atol=1e-9)
    np.testing.assert_allclose(position, sign * (0.5 * time + gain * time**2 / 2), atol=1e-9)


def test_holds_up_to_the_friction_of_the_direction_and_no_further() -> None:
    model = with_effect(block(), "asymmetric_friction", "rail", mean=MEAN, asymmetry=SHARE)
    for friction in (FORWARD, -BACKWARD):
        below, above = (motion(model, 1.0, ctrl=share * friction)[-1, 1] for share in (0.9, 1.1))
        assert abs(below) < 1e-5
        assert above == pytest.approx(0.1 * friction / MASS / 2, rel=1e-3)


@pytest.mark.parametrize("share", [-1.0, 1.0])
def test_never_drives_the_joint(share: float) -> None:
    model = with_effect(block(), "asymmetric_friction", "rail", mean=MEAN, asymmetry=share)
    assert abs(motion(model, 1.0)[-1, 1]) < 1e-5
    for speed in (-1.0, 1.0):
        assert abs(motion(model, 1.0, qvel=speed)[-1, 2]) <= 1.0 + 1e-12


def test_without_asymmetry_it_is_coulomb_friction() -> None:
    one = with_effect(block(), "asymmetric_friction", "rail", mean=MEAN, asymmetry=0.0)
    other = with_effect(block(), "coulomb_friction", "rail", torque=MEAN)
    np.testing.assert_array_equal(motion(one, 1.0, qvel=1.0, ctrl=3.0), motion(other, 1.0, qvel=1.0, ctrl=3.0))


@pytest.mark.parametrize("command", [-7.0, -1.0, 1.0, 5.0, 7.0])
def test_acts_exactly_as_the_effects_that_it_says_it_is_together(command: float) -> None:
    """Sliding either way until it stands, held, and torn loose again."""
    model = with_effect(block(), "asymmetric_friction", "rail", mean=MEAN, asymmetry=SHARE)
    parts = catalogue_effect("asymmetric_friction").together({"mean": MEAN, "asymmetry": SHARE})
    assert parts == {"coulomb_friction": MEAN, "constant_offset": -SHARE * MEAN}
    both = block()
    for name in parts:
        both = both.with_effect(placed(both, name, "rail"))
    other = both.compile(both.space.vector({f"{name}@rail.torque": torque for name, torque in parts.items()}))
    for speed in (-1.0, 0.0, 1.0):
        one, two = (motion(each, 1.0, qvel=speed, ctrl=command) for each in (model, other))
        np.testing.assert_allclose(one, two, atol=1e-9)


def test_bounds_follow_the_joints_torque() -> None:
    mean, asymmetry = placed(block(), "asymmetric_friction", "rail").parameters
    assert (mean.unit, mean.low, mean.high) == ("N", 0.0, 10.0)
    assert (asymmetry.unit, asymmetry.low, asymmetry.high) == ("1", -1.0, 1.0)
    still = placed(block(), "asymmetric_friction", "rail", scales_of(block(), torque=0.0))
    assert still.parameters[0].high > 0
