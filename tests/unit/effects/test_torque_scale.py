import mujoco
import numpy as np
import pytest
from effect_machines import acceleration, block, placed, with_effect

MOTORS = {
    "motor": '<motor name="drive" joint="rail" gear="3"/>',
    "servo": '<position name="drive" joint="rail" kp="20" kv="2"/>',
    "dcmotor": '<dcmotor name="drive" joint="rail" motorconst="0.4 0.4" resistance="2"/>',
    "limited": '<motor name="drive" joint="rail" forcerange="-1 2"/>',
}


@pytest.mark.parametrize("actuator", MOTORS.values(), ids=MOTORS)
@pytest.mark.parametrize("factor", [0.6, 1.7])
def test_force_is_scaled_in_every_state(actuator: str, factor: float) -> None:
    machine = block(actuator=actuator)
    scaled, plain = with_effect(machine, "torque_scale", "drive", factor=factor), machine.nominal()
    for state in ((0.0, 0.0, 3.0), (0.4, -2.0, 1.0), (-0.3, 5.0, -4.0)):
        assert acceleration(scaled, *state) == pytest.approx(factor * acceleration(plain, *state), rel=1e-12)


def test_current_of_an_inductive_motor_scales_and_keeps_its_time_constant() -> None:
    coil = '<dcmotor name="drive" joint="rail" motorconst="0.4 0.4" resistance="2" inductance="0 0.02"/>'
    machine = block(actuator=coil)
    machine.spec.option.integrator = mujoco.mjtIntegrator.mjINT_EULER  # the speed is imposed at every step
    forces = []
    for model in (machine.nominal(), with_effect(machine, "torque_scale", "drive", factor=0.7)):
        data, force = mujoco.MjData(model), []
        for k in range(60):
            data.qpos[0], data.qvel[0], data.ctrl[0] = 0.0, 0.3, np.sin(0.2 * k)
            mujoco.mj_step(model, data)
            force.append(data.actuator_force[0])
        forces.append(force)
    np.testing.assert_allclose(forces[1], 0.7 * np.array(forces[0]), rtol=1e-9, atol=1e-12)


def test_sits_only_where_it_can_scale_the_whole_force() -> None:
    effect = placed(block(), "torque_scale", "drive").effect
    cogging = '<dcmotor name="drive" joint="rail" motorconst="0.4 0.4" resistance="2" cogging="0.1 7 0"/>'
    muscle = '<muscle name="drive" joint="rail" lengthrange="0.5 1"/>'
    assert effect.sites(block(actuator=cogging).nominal()) == ()
    assert effect.sites(block(actuator=muscle).nominal()) == ()
    assert effect.sites(block(actuator=MOTORS["dcmotor"]).nominal()) == ("drive",)


def test_absent_is_one() -> None:
    (parameter,) = placed(block(), "torque_scale", "drive").parameters
    assert (parameter.low, parameter.nominal, parameter.high) == (0.5, 1.0, 2.0)
