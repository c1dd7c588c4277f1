"""Attributes by which the compiler changes all bodies together leave each body's inertia its own."""

import mujoco
import numpy as np
import pytest
from effect_machines import placed, with_effect

from dr_lab.errors import ModelError
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.simulator import Simulator

ATTRIBUTES = ('settotalmass="10"', 'boundmass="0.9"', 'boundinertia="0.02"')
FIELDS = ("body_mass", "body_inertia", "body_ipos", "body_iquat", "dof_M0")
DENSITY = {"b.density": {"target": "geom.b.density", "unit": "kg/m³", "low": 100.0, "high": 5000.0}}


def arm(compiler: str, inertial: str = "") -> mujoco.MjSpec:
    """Two links on hinges; their shapes give the inertia, unless it is given."""
    shape = '<geom name="{}" type="capsule" size="0.03" fromto="0 0 0 0.4 0 0"/>'
    return mujoco.MjSpec.from_string(f"""<mujoco><compiler angle="radian" {compiler}/><worldbody>
      <body name="a"><joint name="one" axis="0 1 0"/>{inertial}{shape.format("a")}
        <body name="b" pos="0.4 0 0"><joint name="two" axis="0 1 0"/>{inertial}{shape.format("b")}</body>
      </body></worldbody></mujoco>""")


def model(compiler: str, inertial: str = "", **mass: float) -> Model:
    free = {"b.mass": {"target": "body.b.mass", "unit": "kg", **mass}} if mass else {}
    return from_spec("arm", arm(compiler, inertial), free)


@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")
@pytest.mark.parametrize("compiler", ATTRIBUTES)
def test_the_compiled_model_stays_the_same(compiler: str) -> None:
    plain, written = arm(compiler).compile(), model(compiler).nominal()
    for field in FIELDS:
        np.testing.assert_array_equal(getattr(written, field), getattr(plain, field))


@pytest.mark.parametrize("compiler", ATTRIBUTES)
@pytest.mark.parametrize(
    ("name", "values"),
    [("payload", {}), ("payload", {"mass": 1.0}), ("inertia_error", {"factor": 1.5}), ("centre_of_mass_offset", {})],
)
def test_an_effect_at_one_body_leaves_the_others(compiler: str, name: str, values: dict[str, float]) -> None:
    machine = model(compiler)
    plain, changed = machine.nominal(), with_effect(machine, name, "b", **values)
    np.testing.assert_allclose(changed.body_mass[:3], plain.body_mass, rtol=1e-12)
    np.testing.assert_allclose(changed.body_inertia[1], plain.body_inertia[1], rtol=1e-12)
    if not values:
        np.testing.assert_allclose(changed.dof_M0, plain.dof_M0, rtol=1e-12)


def test_a_declared_mass_is_that_of_the_compiled_model_by_field_and_by_compilation() -> None:
    given = '<inertial mass="1" pos="0.2 0 0" diaginertia="0.01 0.02 0.02"/>'
    machine = model(ATTRIBUTES[0], given, low=2.0, high=8.0)
    np.testing.assert_allclose(machine.space.nominal, [5.0])
    z = np.array([[7.0], [3.0]])
    simulator = Simulator(machine, 2, threads=1)
    simulator.set_contexts(z)
    for i, (mass,) in enumerate(z):
        for compiled in (machine.compile(z[i]), simulator.batch.get_model(i)):
            np.testing.assert_allclose(compiled.body_mass, [0.0, 5.0, mass], rtol=1e-12)


@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")
@pytest.mark.parametrize("name", ["payload", "inertia_error"])
def test_where_a_shape_varies_an_effect_at_one_body_is_refused(name: str) -> None:
    machine = from_spec("arm", arm(ATTRIBUTES[0]), DENSITY)
    heavy = machine.compile(machine.space.high)
    assert heavy.body_mass.sum() == pytest.approx(10.0)  # as the file says
    extended = machine.with_effect(placed(machine, name, "b"))
    values = {f"{name}@b.{'mass' if name == 'payload' else 'factor'}": 1.5}
    with pytest.raises(ModelError, match="settotalmass changes those of all bodies"):
        extended.compile(extended.space.vector(values))
