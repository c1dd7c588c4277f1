import mujoco
import numpy as np
import pytest

from dr_lab.errors import ConfigError
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator

XML = """
<mujoco model="toy">
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody>
    <body name="arm">
      <inertial mass="0.5" pos="0 0 -0.3" diaginertia="0.01 0.01 0.001"/>
      <joint name="hinge" axis="0 1 0" damping="0.05"/>
      <geom name="tip" size="0.02" pos="0 0 -0.5" contype="0" conaffinity="0" mass="0"/>
    </body>
    <body name="slider" pos="0 1 0">
      <joint name="rail" type="slide" axis="1 0 0"/><geom name="block" size="0.05" density="500"/>
    </body>
  </worldbody>
  <actuator>
    <motor name="motor" joint="hinge" delay="0.01" nsample="8" interp="linear"/>
    <motor name="push" joint="rail"/>
  </actuator>
  <sensor><jointvel name="speed" joint="rail"/></sensor>
</mujoco>
"""
FIELDS = {
    "arm.mass": {"target": "body.arm.mass", "unit": "kg", "low": 0.1, "high": 2.0},
    "arm.com": {"target": "body.arm.ipos[2]", "unit": "m", "low": -0.6, "high": -0.1},
    "hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 1.0},
    "gravity": {"target": "option.gravity[2]", "unit": "m/s²", "low": -12.0, "high": -8.0},
}
SIZE = {"radius": {"target": "geom.block.size[0]", "unit": "m", "low": -0.1, "high": 0.1}}


def toy(parameters: dict[str, dict[str, object]]) -> Model:
    return from_spec("toy", mujoco.MjSpec.from_string(XML), parameters)


def start(model: Model, contexts: int, windows: int) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(1)
    nv = model.nominal().nv
    qpos = np.broadcast_to(rng.normal(size=(windows, nv)), (contexts, windows, nv))
    return qpos.copy(), np.zeros((contexts, windows, nv))


def test_replay_equals_plain_mujoco_steps() -> None:
    model = toy(FIELDS)
    rng = np.random.default_rng(0)
    z = model.space.from_unit(rng.uniform(0.2, 0.8, (2, 4)))
    qpos, qvel = start(model, 2, 3)
    controls, past = rng.normal(size=(3, 40, 2)), rng.normal(size=(3, 10, 2))
    rollout = Simulator(model, 6, threads=2).replay(z, qpos, qvel, controls, past)
    for context in range(2):
        for window in range(3):
            compiled = model.compile(z[context])
            data = mujoco.MjData(compiled)
            data.qpos[:] = qpos[context, window]
            mujoco.mj_initCtrlHistory(compiled, data, 0, np.arange(-8, 0) * 0.002, past[window, -8:, 0])
            for k in range(40):
                data.ctrl[:] = controls[window, k]
                mujoco.mj_step(compiled, data)
                i = context * 3 + window
                np.testing.assert_allclose(rollout.qpos[i, k + 1], data.qpos, atol=1e-12)
                np.testing.assert_allclose(rollout.sensordata[i, k], rollout.qvel[i, k, 1:], atol=1e-12)
    assert not rollout.infeasible.any()


def test_a_delayed_actuator_acts_late_by_its_delay() -> None:
    model = toy(FIELDS)
    controls = np.zeros((1, 20, 2))
    controls[0, :, 0] = 1.0
    rollout = Simulator(model, 1).replay(
        model.space.nominal[None], np.zeros((1, 1, 2)), np.zeros((1, 1, 2)), controls, np.zeros((1, 10, 2))
    )
    moving = np.flatnonzero(rollout.qvel[0, :, 0])
    assert moving[0] == 6  # 10 ms = 5 steps of 2 ms later than the first step's end


def test_infeasible_contexts_are_marked_and_stop_nobody() -> None:
    model = toy(FIELDS | SIZE)
    z = np.tile(model.space.nominal, (2, 1))
    z[0, -1] = -0.05  # a negative radius does not compile
    qpos, qvel = start(model, 2, 1)
    rollout = Simulator(model, 2).replay(z, qpos, qvel, np.zeros((1, 5, 2)), np.zeros((1, 10, 2)))
    np.testing.assert_array_equal(rollout.infeasible, [True, False])


@pytest.mark.parametrize("value", [0.0, -0.3, 1e-16, np.nan])
@pytest.mark.parametrize("target", ["body.arm.mass", "body.arm.inertia_scale"])
def test_a_body_without_inertia_is_as_infeasible_by_field_as_by_compilation(target: str, value: float) -> None:
    parameter = {"inertia": {"target": target, "unit": "1", "low": 0.1, "high": 2.0}}
    by_field, by_model = Simulator(toy(parameter), 3), Simulator(toy(parameter | SIZE), 3)
    for simulator, rest in ((by_field, []), (by_model, [0.05])):
        simulator.set_contexts(np.array([[1.0, *rest], [value, *rest], [0.5, *rest]]))
        simulator.reset()
        simulator.step(np.ones((3, 2)))
        np.testing.assert_array_equal(simulator.infeasible, [False, True, False])
        assert (simulator.batch.warning[:, :, 1] == 0).all()  # what it got instead is harmless
        simulator.set_contexts(np.array([[0.7, *rest]]), np.array([1]))
        assert not simulator.infeasible.any()


def test_what_is_welded_to_a_massless_body_carries_it() -> None:
    heavy = '<inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/>'
    xml = f"""<mujoco><worldbody><body name="rotor">{heavy}<joint name="hinge"/><body name="load">{heavy}</body></body>
      <body name="stand">{heavy}</body></worldbody></mujoco>"""
    names = ("rotor", "load", "stand")
    parameters = {name: {"target": f"body.{name}.mass", "unit": "kg", "low": 0.0, "high": 3.0} for name in names}
    simulator = Simulator(from_spec("welded", mujoco.MjSpec.from_string(xml), parameters), 4)
    simulator.set_contexts(np.array([[0.0, 2.0, 2.0], [2.0, 0.0, 2.0], [2.0, 2.0, 0.0], [0.0, 0.0, 2.0]]))
    np.testing.assert_array_equal(simulator.infeasible, [False, False, False, True])


def test_divergence_is_marked_and_cleared_by_reset() -> None:
    simulator = Simulator(toy(FIELDS), 2)
    simulator.batch.bind("qvel")[0, 0] = 1e12
    simulator.step(np.zeros((2, 2)))
    np.testing.assert_array_equal(simulator.infeasible, [True, False])
    simulator.reset(np.array([0]))
    assert not simulator.infeasible.any()


@pytest.mark.parametrize("name", list(FIELDS))
def test_fields_and_recompiled_models_agree(name: str) -> None:
    by_field, by_model = toy({name: FIELDS[name]}), toy({name: FIELDS[name]} | SIZE)
    low, high = by_field.space.low[0], by_field.space.high[0]
    values = np.array([[0.7 * low + 0.3 * high], [high]])
    qpos, qvel = start(by_field, 2, 2)
    controls, past = np.ones((2, 30, 2)), np.zeros((2, 10, 2))
    one = Simulator(by_field, 4).replay(values, qpos, qvel, controls, past)
    both = np.hstack([values, np.full((2, 1), 0.05)])
    other = Simulator(by_model, 4).replay(both, qpos, qvel, controls, past)
    np.testing.assert_allclose(one.qpos, other.qpos, atol=1e-12)


def test_a_centre_of_mass_may_leave_the_bodys_origin() -> None:
    """MuJoCo stores a body with its centre there in a shorter form, from which nothing may then be moved."""
    xml = """<mujoco><worldbody><body name="b">
      <joint type="slide" axis="1 0 0"/><joint axis="0 1 0" damping="0.1"/>
      <inertial pos="0 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
      <geom size="0.02" contype="0" conaffinity="0"/><site name="s"/>
    </body></worldbody><sensor><accelerometer site="s"/></sensor></mujoco>"""
    com = {"target": "body.b.ipos[0]", "unit": "m", "low": -0.2, "high": 0.2}
    model = from_spec("simple", mujoco.MjSpec.from_string(xml), {"com": com})
    values = np.array([[0.0], [0.1], [-0.2], [0.0]])
    simulator = Simulator(model, 4, threads=1)
    rollout = simulator.replay(values, *start(model, 4, 1), np.zeros((1, 40, 0)), np.zeros((1, 1, 0)))
    assert not rollout.infeasible.any()
    for value, qpos, sensed in zip(values, rollout.qpos, rollout.sensordata, strict=True):
        compiled = model.compile(value)
        data = mujoco.MjData(compiled)
        data.qpos[:] = qpos[0]
        for k in range(40):
            mujoco.mj_step(compiled, data)
            np.testing.assert_allclose(qpos[k + 1], data.qpos, atol=1e-12)
            np.testing.assert_allclose(sensed[k], data.sensordata, atol=1e-9)


def test_contexts_start_from_nominal_every_time() -> None:
    simulator = Simulator(toy(FIELDS), 1)
    for _ in range(3):
        simulator.set_contexts(np.array([[1.0, -0.3, 0.05, -9.81]]))
    np.testing.assert_allclose(simulator.batch.get_model(0).body("arm").inertia, [0.02, 0.02, 0.002])


@pytest.mark.parametrize("threads", [0, -1])
def test_less_than_one_thread_is_refused(threads: int) -> None:
    with pytest.raises(ConfigError, match=rf"threads is {threads}; expected at least 1, or null for all cores\."):
        Simulator(toy({}), 2, threads)
