"""A servo whose own encoder closes the loop, at rest, against closed forms."""

import numpy as np
import pytest
from effect_machines import block, catalogue_effect, placed, scales_of

from dr_lab.physics.simulator import Simulator

ROTOR = 0.5  # kg


@pytest.mark.parametrize(("name", "read"), [("motor_side_elasticity", 0.075), ("servo_elasticity", 0.05)])
def test_a_servo_feels_its_own_encoder(name: str, read: float) -> None:
    """At rest kp (u − q_m) = T = k q of the spring behind the link, and q_m = q + C T: C = 1/100 gives q_m = 3/4 u."""
    values = {"compliance": 0.01, "rotor": ROTOR, "retardation": 0.02}
    assert at_rest(name, values) == pytest.approx(read, rel=1e-3)


@pytest.mark.parametrize(("name", "gap", "rest"), [("servo_backlash", 0.02, 0.06), ("backlash", 0.02, 0.2 / 3)])
def test_a_servos_own_encoder_does_not_see_the_play(name: str, gap: float, rest: float) -> None:
    """At rest kp (u − q_m) = k q with the link at the near wall, q = q_m − gap/2; with the link's encoder q_m is q."""
    assert at_rest(name, {"gap": gap, "rotor": ROTOR}) == pytest.approx(rest, rel=2e-3)


def at_rest(name: str, values: dict[str, float]) -> float:
    """What is read of a link on a spring of 50 N/m that a servo of 100 N/m pulls 0.1 m from 0, once it rests."""
    model = block('<position name="drive" joint="rail" kp="100" kv="10"/>', joint='stiffness="50" damping="20"')
    extended = model.with_effect(placed(model, name, "rail", scales_of(model)))
    z = extended.space.vector({f"{name}@rail.{key}": value for key, value in values.items()})
    controls, rest = np.full((1, 3000, 1), 0.1), np.zeros((1, 1, 1))
    rollout = Simulator(extended, 1, threads=1).replay(z[None], rest, rest, controls, controls[:, :1])
    assert rollout.qvel[0, -1, 0] == pytest.approx(0.0, abs=1e-4)
    return float(rollout.qpos[0, -1, 0])


@pytest.mark.parametrize("name", ["servo_backlash", "servo_elasticity"])
def test_only_a_position_controllers_loop_can_miss_what_is_behind_it(name: str) -> None:
    assert catalogue_effect(name).sites(block('<position name="drive" joint="rail" kp="100"/>').nominal()) == ("rail",)
    assert catalogue_effect(name).sites(block('<motor name="drive" joint="rail"/>').nominal()) == ()
