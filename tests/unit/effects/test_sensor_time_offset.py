import mujoco
import numpy as np
from effect_machines import block, motion, placed, with_effect

from dr_lab.physics.model import from_spec
from dr_lab.trajectory import Array


def wave(time: Array) -> Array:
    return np.sin(7.0 * time)[..., None]


def test_offset_delays_every_channel_of_a_joint_and_leaves_the_physics() -> None:
    model = block().with_effect(placed(block(), "sensor_time_offset", "rail"))
    time = np.linspace(0.1, 0.2, 5)[None, None]
    for channel in ("rail.position", "rail.velocity"):
        late = model.reading(np.array([[0.004], [-0.01]]), channel, wave, np.zeros((1, 1)))(time)
        np.testing.assert_allclose(late[..., 0], [wave(time - 0.004)[0, ..., 0], wave(time + 0.01)[0, ..., 0]])
    assert model.reading(np.zeros((1, 1)), "other.position", wave, np.zeros((1, 1))) is wave
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
    model, late, begin = from_spec("block", spec, {}).with_effect(one), np.array([[0.01]]), np.zeros((1, 1))
    assert one.effect.sites(spec.copy().compile()) == ("rail", "sensor.speed")
    assert model.reading(late, "sensor.speed", wave, begin)(np.ones((1, 1, 1))) == wave(np.array(0.99))
    assert model.reading(late, "rail.position", wave, begin) is wave


def test_bounds_are_symmetric() -> None:
    (parameter,) = placed(block(), "sensor_time_offset", "rail").parameters
    assert (parameter.low, parameter.nominal, parameter.high) == (-0.02, 0.0, 0.02)
