from collections.abc import Iterator

import mujoco
import pytest

from dr_lab.physics.timers import stop_timers

STEP = int(mujoco.mjtTimer.mjTIMER_STEP)


@pytest.fixture(autouse=True)
def stopped_again() -> Iterator[None]:
    yield
    stop_timers()


def duration() -> float:
    model = mujoco.MjModel.from_xml_string(
        "<mujoco><worldbody><body><joint/><geom size='0.1'/></body></worldbody></mujoco>"
    )
    data = mujoco.MjData(model)
    mujoco.mj_step(model, data, 100)
    return float(data.timer[STEP].duration)


def test_the_stopped_clock_costs_nothing_and_can_be_given_back() -> None:
    mujoco.set_mjcb_time(None)
    assert duration() > 0
    stop_timers()
    assert duration() == 0
    mujoco.set_mjcb_time(None)
    assert duration() > 0
