import pytest
from effect_machines import acceleration, block, placed, with_effect


@pytest.mark.parametrize("command", [-9.0, -3.0, 0.5, 4.0, 7.0])
def test_command_is_clipped_at_the_limit(command: float) -> None:
    model = with_effect(block(), "saturation", "drive", inverse_limit=1 / 4.0)
    assert acceleration(model, ctrl=command) == pytest.approx(min(max(command, -4.0), 4.0) / 2.0, rel=1e-12)


def test_only_narrows_the_actuators_own_range() -> None:
    machine = block(actuator='<motor name="drive" joint="rail" ctrlrange="-1 6"/>')
    limited = with_effect(machine, "saturation", "drive", inverse_limit=1 / 4.0)
    assert limited.actuator_ctrlrange[0].tolist() == [-1.0, 4.0]
    absent = with_effect(machine, "saturation", "drive", inverse_limit=0.0)
    assert absent.actuator_ctrlrange[0].tolist() == [-1.0, 6.0]


def test_a_range_that_the_model_switches_off_does_not_count() -> None:
    machine = block(actuator='<motor name="drive" joint="rail" ctrlrange="-1 1" ctrllimited="false"/>')
    limited = with_effect(machine, "saturation", "drive", inverse_limit=1 / 4.0)
    assert limited.actuator_ctrlrange[0].tolist() == [-4.0, 4.0]


def test_fits_start_at_shares_of_the_largest_command() -> None:
    one = placed(block(), "saturation", "drive")
    limits = [1 / start["saturation@drive.inverse_limit"] for start in one.starts]
    assert limits == pytest.approx([4.0, 2.5])
    assert one.parameters[0].high == pytest.approx(1 / 0.5)
