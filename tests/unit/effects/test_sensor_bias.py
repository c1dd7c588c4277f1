import mujoco
import numpy as np
import pytest
from effect_machines import block, catalogue_effect, hanging, motion, placed, scales_of, with_effect

from dr_lab.physics.effect_parts import SensorTransform
from dr_lab.trajectory import Array

START = np.zeros((1, 1))


def wave(time: Array) -> Array:
    return np.sin(7.0 * time)[..., None]


def with_sensors() -> mujoco.MjModel:
    """A block with a sensor of one value, a vector and an orientation."""
    spec = block().spec
    kinds = mujoco.mjtSensor
    joint, body = mujoco.mjtObj.mjOBJ_JOINT, mujoco.mjtObj.mjOBJ_BODY
    spec.add_sensor(name="scalar", type=kinds.mjSENS_JOINTPOS, objtype=joint, objname="rail")
    spec.add_sensor(name="vector", type=kinds.mjSENS_FRAMEPOS, objtype=body, objname="block")
    spec.add_sensor(name="turn", type=kinds.mjSENS_FRAMEQUAT, objtype=body, objname="block")
    return spec.compile()


def test_position_is_shifted_and_velocity_is_not() -> None:
    model, time = block().with_effect(placed(block(), "sensor_bias", "rail")), np.linspace(0.1, 0.2, 5)[None, None]
    seen = model.reading(np.array([[0.04], [0.0], [-0.2]]), "rail.position", wave, START)(time)
    np.testing.assert_allclose(seen[:, 0, :, 0], np.sin(7.0 * time[0]) + np.array([[0.04], [0.0], [-0.2]]))
    for channel in ("rail.velocity", "other.position"):
        assert model.reading(np.array([[0.04]]), channel, wave, START) is wave


def test_physics_is_untouched() -> None:
    biased = with_effect(hanging(), "sensor_bias", "hinge", bias=0.1)
    np.testing.assert_array_equal(motion(biased, 0.1, qpos=0.4), motion(hanging().nominal(), 0.1, qpos=0.4))


@pytest.mark.parametrize("name", ["sensor_bias", "sensor_scale", "sensor_drift"])
def test_only_what_has_one_value_is_a_site(name: str) -> None:
    axes = tuple(f"sensor.vector.{axis}" for axis in "xyz")
    assert catalogue_effect(name).sites(with_sensors()) == ("rail", "sensor.scalar", *axes)


def test_a_sensor_is_shifted() -> None:
    effect, values = catalogue_effect("sensor_bias"), {"bias": np.full((1, 1, 1), 0.5)}
    assert isinstance(effect, SensorTransform)
    read = effect.reading("sensor.scalar", values, "sensor.scalar", wave, START)
    assert read(np.ones((1, 1, 1))) == np.sin(7.0) + 0.5
    assert effect.reading("sensor.scalar", values, "rail.position", wave, START) is wave


def test_bounds_follow_the_range_of_motion() -> None:
    effect, model = catalogue_effect("sensor_bias"), with_sensors()
    (wide,) = effect.parameters(model, "rail", scales_of(block(), position=2.0))
    (still,) = effect.parameters(model, "rail", scales_of(block(), position=0.0))
    (sensor,) = effect.parameters(model, "sensor.scalar", scales_of(block()))
    assert [(p.low, p.high, p.unit) for p in (wide, still)] == [(-0.5, 0.5, "m"), (-0.25e-3, 0.25e-3, "m")]
    assert (sensor.high, sensor.unit) == (0.25, "reading")
    assert effect.parameters(hanging().nominal(), "hinge", scales_of(hanging()))[0].unit == "rad"


def test_a_joint_whose_zero_lies_elsewhere_moves_alike_and_reads_a_bias() -> None:
    """A hinge that is at 0.1 rad where the model has its zero, under gravity and torque."""
    turned = hanging()
    turned.spec.joint("hinge").ref += 0.1
    plain = motion(hanging().nominal(), 1.0, qpos=0.4, ctrl=0.3)
    moved = motion(turned.nominal(), 1.0, qpos=0.5, ctrl=0.3)
    biased = hanging().with_effect(placed(hanging(), "sensor_bias", "hinge"))

    def read(time: Array) -> Array:
        return np.interp(time, plain[:, 0], plain[:, 1])[..., None]

    seen = biased.reading(np.array([[0.1]]), "hinge.position", read, START)(plain[None, None, :, 0])[0, 0, :, 0]
    np.testing.assert_allclose(seen, moved[:, 1], atol=1e-9)
