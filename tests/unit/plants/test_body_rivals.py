"""Which bodies' effects count as rivals."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from hydra.utils import instantiate
from omegaconf import OmegaConf

from dr_lab.plants.alike.body_rivals import body_rivals
from dr_lab.plants.alike.course import Course
from dr_lab.plants.alike.felt import Felt
from dr_lab.plants.alike.lacking import lacking
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.mujoco_machine import MujocoMachine

RULE = Path(__file__).parents[3] / "conf" / "classes" / "predicted.yaml"
ARM = """<mujoco><compiler angle="radian"/><worldbody><body name="upper"><joint name="shoulder" axis="0 1 0"/>
  <inertial pos="0.1 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
  <body name="lower" pos="0.3 0 0"><joint name="elbow" axis="0 1 0"/>
  <inertial pos="0.1 0 0" mass="{mass}" diaginertia="{inertia} {inertia} {inertia}"/>
  </body></body></worldbody></mujoco>"""


def rivals(mass: float) -> dict[str, int]:
    """Of an arm of two links of such a mass in kg along some motion, by label."""
    model = mujoco.MjModel.from_xml_string(ARM.format(mass=mass, inertia=0.01 * mass))
    rng, none = np.random.default_rng(3), ()
    q, v, a = rng.standard_normal((3, 20, 2))
    machine, edge = MujocoMachine.of(model), np.linspace(0.0, 0.1, 21)
    course = Course(machine, edge, q, v, a, np.zeros((20, 0)), none, none, none, none, none, NoEffect())
    rule, command = instantiate(OmegaConf.load(RULE).rule), np.zeros((20, 0))
    base = lacking(course, machine, command)
    return {each.label: each.parameters for each in body_rivals(course, rule.grids, rule.felt, command, base)}


def test_what_a_planar_arm_feels() -> None:
    assert rivals(1.0) == {
        "payload@upper": 2,
        "centre_of_mass_offset@upper": 2,
        "inertia_error@upper": 1,
        "cable_force@upper": 4,
        "payload@lower": 2,
        "planar_payload@lower": 4,
        "centre_of_mass_offset@lower": 2,
        "link_length@lower": 1,
        "inertia_error@lower": 1,
        "cable_force@lower": 4,
        "base_tilt@world": 1,
        "gravity_compensation@world": 1,
        "air_drag@world": 1,
    }


@pytest.mark.parametrize("mass", [1e-7, 1e3])
def test_tiny_and_huge_machines_feel_the_same(mass: float) -> None:
    assert rivals(mass).keys() - {"air_drag@world"} == rivals(1.0).keys() - {"air_drag@world"}


def test_a_combination_that_nothing_feels_is_told_from_weak_ones() -> None:
    felt, rng = Felt(change=1e-6, combination=1e-4), np.random.default_rng(0)
    one, two = rng.standard_normal((2, 30, 2))
    assert felt.together([one, 1e-9 * two])  # the units of what changes do not matter
    assert not felt.together([one, two, one - 2 * two])
    assert not felt.together([one, one + 1e-6 * two])
