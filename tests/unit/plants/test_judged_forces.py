"""What the judge takes for the forces at a joint, against closed forms."""

import mujoco
import numpy as np

from dr_lab.plants.alike.course import Course
from dr_lab.plants.alike.forces import Forces
from dr_lab.plants.alike.lacking import lacking
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.mujoco_machine import MujocoMachine

SERVO = """<mujoco><compiler angle="radian"/><worldbody><body name="arm"><joint name="arm" axis="0 1 0" damping="0.2"/>
  <inertial pos="0.3 0 0" mass="0.5" diaginertia="0.004 0.004 0.004"/></body></worldbody>
  <actuator><position name="servo" joint="arm" kp="6" kv="0.15"/></actuator></mujoco>"""


def test_a_servos_feedback_is_part_of_its_drive_and_not_of_what_acts_from_outside() -> None:
    q, v, a = np.random.default_rng(2).standard_normal((3, 20, 1))
    command, none = np.linspace(-1.0, 1.0, 20)[:, None], ()
    machine = MujocoMachine.of(mujoco.MjModel.from_xml_string(SERVO))
    course = Course(
        machine, np.linspace(0.0, 0.1, 21), q, v, a, np.zeros((20, 0)), none, none, none, none, none, NoEffect()
    )
    forces = Forces.of(course, command, lacking(course, machine, command))
    np.testing.assert_allclose(forces.drive, 6 * (command - q) - 0.15 * v, atol=1e-9)
    np.testing.assert_allclose(forces.outside, 0.5 * 9.81 * 0.3 * np.cos(q), atol=1e-9)
    np.testing.assert_allclose(forces.pulled["servo"], 6 * (command - q), atol=1e-9)
