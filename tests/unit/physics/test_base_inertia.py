"""Combinations of inertias that the motion depends on."""

import mujoco
import numpy as np
import pytest
from effect_machines import CONF, placed

from dr_lab.physics.base_inertia import base_directions
from dr_lab.physics.model import Model, from_spec, load
from dr_lab.trajectory import Array

ONE = """<mujoco model="one"><option {option}/><worldbody><body name="rod" pos="0 0 1">
  <inertial mass="0.5" pos="0.02 0.01 -0.3" diaginertia="0.005 0.004 0.002"/>{joint}
  <site name="end"/></body></worldbody><sensor>{sensor}</sensor></mujoco>"""


def one_body(joint: str, option: str = "", sensor: str = "") -> Model:
    spec = mujoco.MjSpec.from_string(ONE.format(joint=joint, option=option, sensor=sensor))
    return from_spec("one", spec, {"inertial": "all"})


def arm() -> Model:
    return load("seven", CONF / "model/strangers/seven.xml", {"inertial": "all"})


@pytest.mark.parametrize(
    ("joint", "count"),
    [
        ('<joint axis="0 1 0"/>', 3),  # inertia about the axis, and the two moments across it
        ('<joint type="slide" axis="1 0 0"/>', 1),  # mass
        ('<joint type="ball"/>', 9),  # all but the mass
        ("<freejoint/>", 10),
    ],
)
def test_a_joint_feels_so_many_combinations(joint: str, count: int) -> None:
    model = one_body(joint)
    found = base_directions(model, model.space.nominal)
    assert found is not None
    assert found.shape == (count, 10)
    np.testing.assert_allclose(found @ found.T, np.eye(count), atol=1e-12)


def forces(model: Model, z: Array) -> Array:
    """Inertia and the forces of gravity and speed in a few poses: all of what moves the machine."""
    compiled, found = model.compile(z), list[Array]()
    data, rng = mujoco.MjData(compiled), np.random.default_rng(5)
    for _ in range(4):
        data.qpos[:], data.qvel[:] = rng.normal(size=(2, compiled.nv))
        mujoco.mj_forward(compiled, data)
        whole = np.zeros((compiled.nv, compiled.nv))
        mujoco.mj_fullM(compiled, data, whole)
        found += [whole.ravel(), data.qfrc_bias.copy()]
    return np.concatenate(found)


def test_an_arm_feels_nothing_else() -> None:
    """Slopes of what moves it by the 70 numbers of its links are those along 45 directions."""
    model = arm()
    z = model.space.nominal + 0.02 * np.random.default_rng(0).normal(size=70) * model.space.span
    found = base_directions(model, z)
    assert found is not None
    assert found.shape == (45, 70)
    step = 1e-5 * model.space.span * np.eye(70)
    slopes = np.stack([forces(model, z + each) - forces(model, z - each) for each in step]) / 2e-5
    missed = slopes - found.T @ (found @ slopes)
    assert np.abs(missed).max() < 1e-6 * np.abs(slopes).max()


@pytest.mark.parametrize(
    ("bodies", "count"), [(["link1"], 3), (["link2"], 9), (["link7"], 10), (["link2", "link4"], 19)]
)
def test_some_bodies_of_an_arm_are_felt_by_few_of_its_joints(bodies: list[str], count: int) -> None:
    """Both axes that turn link 2 go through its origin, so that its mass alone is not felt."""
    model = load("seven", CONF / "model/strangers/seven.xml", {"inertial": bodies})
    found = base_directions(model, model.space.nominal)
    assert found is not None
    assert found.shape == (count, 10 * len(bodies))


@pytest.mark.parametrize(
    ("option", "sensor"),
    [('density="1.2"', ""), ("", '<force site="end"/>'), ("", '<framepos objtype="body" objname="rod"/>')],
)
def test_where_more_than_the_motion_tells_inertia_no_combination_drops_out(option: str, sensor: str) -> None:
    model = one_body('<joint axis="0 1 0"/>', option, sensor)
    assert base_directions(model, model.space.nominal) is None


def test_beside_a_constraint_that_is_softened_by_inertia_no_combination_drops_out() -> None:
    text = ONE.format(joint='<joint name="hinge" axis="0 1 0"/>', option="", sensor="")
    tied = text.replace("<sensor>", '<equality><connect body1="rod" anchor="0 0 0"/></equality><sensor>')
    model = from_spec("one", mujoco.MjSpec.from_string(tied), {"inertial": "all"})
    assert base_directions(model, model.space.nominal) is None


def test_effects_that_edit_a_body_let_no_combination_drop_out() -> None:
    plain = arm()
    for name, where, alone in (("coulomb_friction", "joint4", True), ("inertia_error", "link7", False)):
        model = plain.with_effect(placed(plain, name, where))
        assert (base_directions(model, model.space.nominal) is not None) == alone


def test_without_free_bodies_there_is_nothing_to_combine() -> None:
    model = load("seven", CONF / "model/strangers/seven.xml", {})
    assert base_directions(model, model.space.nominal) is None
