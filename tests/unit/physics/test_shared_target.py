import mujoco
import numpy as np
import pytest

from dr_lab.errors import ModelError
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator

XML = """
<mujoco model="shapes">
  <worldbody>
    <body name="a"><joint name="a" axis="0 1 0" damping="0.5"/><geom name="a" size="0.1 0.3" type="capsule"/></body>
    <body name="b" pos="0 2 0">
      <joint name="b" axis="0 1 0" damping="0.5"/><geom name="b" pos="0.2 0 0" size="0.2" density="500"/>
    </body>
  </worldbody>
</mujoco>
"""
BOTH = {"target": ["joint.a.damping", "joint.b.damping"], "unit": "N·m·s/rad", "low": 0.0, "high": 2.0}
MASS = {"target": "body.b.mass", "unit": "kg", "low": 1.0, "high": 100.0}
SCALE = {"target": "body.b.inertia_scale", "unit": "1", "low": 0.5, "high": 2.0}
AIR = {"target": "option.density", "unit": "kg/m³", "low": 0.0, "high": 2.0}


def model(parameters: dict[str, dict[str, object]]) -> Model:
    return from_spec("shapes", mujoco.MjSpec.from_string(XML), parameters)


def test_one_value_reaches_every_place_by_field_and_by_compilation() -> None:
    shared = model({"damping": BOTH})
    assert shared.space.nominal[0] == 0.5
    simulator = Simulator(shared, 2)
    simulator.set_contexts(np.array([[1.5]]), np.array([1]))
    np.testing.assert_array_equal(simulator.batch.get_model(1).dof_damping, [1.5, 1.5])
    np.testing.assert_array_equal(simulator.batch.get_model(0).dof_damping, [0.5, 0.5])
    np.testing.assert_array_equal(shared.compile(np.array([1.5])).dof_damping, [1.5, 1.5])


def test_places_with_different_values_are_refused() -> None:
    with pytest.raises(ModelError, match="one nominal value"):
        model({"density": {"target": ["geom.a.density", "geom.b.density"], "unit": "1", "low": 1.0, "high": 2e3}})


def test_masses_that_follow_from_shapes_are_written_out_unchanged() -> None:
    plain, written = mujoco.MjModel.from_xml_string(XML), model({"b.mass": MASS}).nominal()
    for field in ("body_mass", "body_inertia", "body_ipos", "body_iquat", "dof_invweight0"):
        np.testing.assert_array_equal(getattr(written, field), getattr(plain, field))
    heavy = model({"b.mass": MASS}).compile(np.array([2.0 * plain.body_mass[2]]))
    np.testing.assert_allclose(heavy.body_inertia[2], 2.0 * plain.body_inertia[2], rtol=1e-14)


def test_a_given_mass_and_a_varying_shape_exclude_each_other() -> None:
    with pytest.raises(ModelError, match="exclude each other"):
        model({"b.mass": MASS, "r": {"target": "geom.b.size[0]", "unit": "m", "low": 0.1, "high": 0.3}})


def test_fields_that_several_parameters_share_equal_the_compiled_model() -> None:
    both = model({"b.mass": MASS, "b.inertia": SCALE, "damping": BOTH, "air": AIR})
    z = np.array([[30.0, 1.7, 0.1, 1.2], [5.0, 0.6, 1.9, 0.3]])
    simulator = Simulator(both, 2)
    for _ in range(2):  # nothing accumulates
        simulator.set_contexts(z)
    for i, row in enumerate(z):
        by_field, by_compilation = simulator.batch.get_model(i), both.compile(row)
        assert by_field.opt.density == row[3]
        for field in ("body_mass", "body_inertia", "dof_damping", "dof_M0", "body_invweight0"):
            np.testing.assert_allclose(getattr(by_field, field), getattr(by_compilation, field), rtol=1e-12)
