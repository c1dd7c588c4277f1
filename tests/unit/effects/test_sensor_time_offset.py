import mujoco
import numpy as np
from effect_machines import block, motion, placed, with_effect

from dr_lab.physics.model import from_spec


def test_offset_delays_every_channel_of_a_joint_and_leaves_the_physics() -> None:
    model = block().with_effect(placed(block(), "sensor_time_offset", "rail"))
    assert model.output_delays(np.array([0.004])) == {"rail.position": 0.004, "rail.velocity": 0.004}
    shifted = with_effect(block(), "sensor_time_offset", "rail", offset=-0.01)
    np.testing.assert_array_equal(
        motion(shifted, 0.1, qvel=1.0, ctrl=3.0), motion(block().nominal(), 0.1, 0.0, 1.0, 3.0)
    )


def test_sensors_are_sites_of_their_own() -> None:
    machine = block()
    spec = machine.spec
    spec.add_sensor(
        name="speed", type=mujoco.mjtSensor.mjSENS_JOINTVEL, objtype=mujoco.mjtObj.mjOBJ_JOINT, objname="rail"
    )
    one = placed(from_spec("block", spec, {}), "sensor_time_offset", "sensor.speed")
    assert one.effect.sites(spec.copy().compile()) == ("rail", "sensor.speed")
    assert one.output_delay({"sensor_time_offset@sensor.speed.offset": 0.01}) == {"sensor.speed": 0.01}


def test_bounds_are_symmetric() -> None:
    (parameter,) = placed(block(), "sensor_time_offset", "rail").parameters
    assert (parameter.low, parameter.nominal, parameter.high) == (-0.02, 0.0, 0.02)
