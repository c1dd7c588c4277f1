import numpy as np
from effect_machines import block, motion, placed, scales_of, with_effect


def test_speed_decays_as_one_over_time() -> None:
    model = with_effect(block(), "quadratic_drag", "rail", coefficient=3.0)
    time, _, speed = motion(model, 1.0, qvel=-2.0).T
    np.testing.assert_allclose(speed, -2.0 / (1 + 3.0 / 2.0 * 2.0 * time), rtol=1e-8)


def test_upper_bound_is_twice_torque_over_speed_squared() -> None:
    machine = block()
    (parameter,) = placed(machine, "quadratic_drag", "rail", scales_of(machine, torque=18.0, speed=3.0)).parameters
    assert (parameter.high, parameter.unit) == (4.0, "N·s²/m²")
