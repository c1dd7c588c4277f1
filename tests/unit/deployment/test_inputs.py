"""What each input of a policy is, and the names of a machine's columns."""

from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np

from dr_lab.deployment.inputs import inputs_of
from dr_lab.physics.parameter import Parameter
from dr_lab.recorders.episode import Episode
from dr_lab.recorders.joint_labels import actuators, columns
from dr_lab.trajectory import Array

ARM = mujoco.MjModel.from_xml_string("""
<mujoco>
  <worldbody>
    <body><joint name="rail" type="slide"/><geom size="1"/>
      <body><joint name="pole"/><geom size="1"/></body>
    </body>
  </worldbody>
  <actuator><motor joint="rail"/><motor name="drive" joint="pole"/><motor tendon="belt"/></actuator>
  <tendon><fixed name="belt"><joint joint="pole" coef="1"/></fixed></tendon>
</mujoco>
""")


def moved(observe: object, seed: int = 0) -> Episode:
    """An episode in which all moves at random; `observe` makes observations (t, o) of qpos and qvel."""
    rng = np.random.default_rng(seed)
    qpos, qvel = rng.normal(size=(21, 2)), rng.normal(size=(21, 2))
    seen: Array = observe(qpos, qvel)  # pyright: ignore[reportCallIssue]
    time, action, reward = np.arange(21.0), np.zeros((20, 3)), np.zeros(20)
    return Episode("e", {}, ARM, time, qpos, qvel, seen, action, reward, "truncated")


def test_inputs_that_are_a_state_or_the_sine_of_an_angle_are_named() -> None:
    def observe(q: Array, v: Array) -> Array:
        return np.stack([q[:, 0], np.sin(q[:, 1]), np.cos(q[:, 1]), v[:, 0], v[:, 1]], axis=1)

    found = inputs_of([moved(observe), moved(observe, seed=1)], ())
    angles = ["sin(pole position)", "cos(pole position)"]
    assert found == ("rail position [m]", *angles, "rail velocity [m/s]", "pole velocity [rad/s]")


def test_a_small_angle_is_told_from_its_sine() -> None:
    def still(observe: Callable[[Array], Array]) -> tuple[str | None, ...]:
        episode = moved(lambda q, v: q + v)
        qpos = 0.01 * episode.qpos
        return inputs_of([replace(episode, qpos=qpos, observation=observe(qpos).astype(np.float32))], ())

    assert still(np.sin)[1] == "sin(pole position)"
    assert still(np.array)[1] == "pole position [rad]"


def test_what_is_made_of_several_has_no_name() -> None:
    assert inputs_of([moved(lambda q, v: np.stack([q[:, 0] + q[:, 1], 0.0 * v[:, 0]], axis=1))], ()) == (None, None)


def test_an_input_is_only_what_it_is_in_all_episodes() -> None:
    here, there = moved(lambda q, v: q[:, :1] + 0.0 * v[:, :1]), moved(lambda q, v: v[:, :1] + 0.0 * q[:, :1])
    assert inputs_of([here, there], ()) == (None,)


def test_the_context_follows_as_a_share_of_its_bounds() -> None:
    shown = (Parameter("pole.mass", "kg", 1.0, 0.5, 2.5), Parameter("gain", "1", 1.0, 0.0, 2.0))
    found = inputs_of([moved(lambda q, v: np.hstack([q, v, 0.25 + 0.0 * q]))], shown)
    assert found[4:] == ("pole.mass: (value in kg − 0.5) / 2", "gain: (value − 0) / 2")


def test_columns_of_free_and_ball_joints_are_named_as_mujoco_has_them() -> None:
    model = mujoco.MjModel.from_xml_string("""
    <mujoco>
      <worldbody>
        <body><freejoint name="base"/><geom size="1"/><body><joint type="ball"/><geom size="1"/></body></body>
      </worldbody>
    </mujoco>
    """)
    positions, velocities = columns(model)
    assert (len(positions), len(velocities)) == (model.nq, model.nv)
    assert positions[2:5] == [("base z", "m"), ("base qw", "1"), ("base qx", "1")]
    assert velocities[2:4] == [("base vz", "m/s"), ("base wx", "rad/s")]
    assert velocities[-1] == ("joint_1 wz", "rad/s")


def test_an_actuator_without_a_name_is_called_by_its_joint() -> None:
    assert actuators(ARM) == ("actuator of rail", "drive", "actuator_2")


def test_an_actuator_without_a_command_has_no_action() -> None:
    """As a force that a user's file adds before its motors."""
    model = mujoco.MjModel.from_xml_string("""<mujoco><worldbody><body><joint name="pole"/><geom size="1"/></body>
      </worldbody><actuator>
        <general name="weight" joint="pole" gaintype="dcmotor" dyntype="dcmotor" actearly="true" input="none"
          biastype="affine" biasprm="1"/>
        <motor name="drive" joint="pole"/>
      </actuator></mujoco>""")
    assert actuators(model) == ("drive",)
