import pytest
from effect_machines import acceleration, block, placed, with_effect

SERVO = '<position name="drive" joint="rail" kp="20" kv="2"/>'


@pytest.mark.parametrize("factor", [0.4, 1.0, 2.5])
def test_only_the_pull_towards_the_target_is_scaled(factor: float) -> None:
    machine = block(actuator=SERVO)
    wrong, still = with_effect(machine, "gain_error", "drive", factor=factor), machine.nominal()
    for q, v, u in ((0.0, 0.0, 3.0), (0.4, -2.0, 1.0), (-0.3, 5.0, -4.0)):
        at_target = acceleration(still, q, v, q)  # damping alone
        pull = acceleration(still, q, v, u) - at_target
        assert acceleration(wrong, q, v, u) - at_target == pytest.approx(factor * pull, rel=1e-12)


def test_sits_at_position_servos_alone() -> None:
    effect = placed(block(actuator=SERVO), "gain_error", "drive").effect
    assert effect.sites(block().nominal()) == ()
    assert effect.sites(block(actuator='<velocity name="drive" joint="rail" kv="3"/>').nominal()) == ()
    assert effect.sites(block(actuator=SERVO).nominal()) == ("drive",)


def test_absent_is_one() -> None:
    (parameter,) = placed(block(actuator=SERVO), "gain_error", "drive").parameters
    assert (parameter.low, parameter.nominal, parameter.high) == (0.3, 1.0, 3.0)
