"""Ten inertial parameters of a body as one declaration."""

import mujoco
import numpy as np
import pytest

from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.inertial import FIELDS
from dr_lab.physics.model import Model, from_spec
from dr_lab.physics.pseudo_inertia import SHORT, Inertial, LogCholesky, principal, second_moments
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

XML = """
<mujoco model="two">
  <worldbody>
    <body name="upper" pos="0 0 1">
      <inertial mass="2" pos="0 0 0" diaginertia="0.03 0.02 0.015"/>
      <joint name="shoulder" axis="0 1 0" damping="0.1"/>
      <body name="lower" pos="0 0 -0.4">
        <inertial mass="1.2" pos="0.02 -0.01 -0.2" quat="0.6 0 0.8 0" diaginertia="0.02 0.018 0.006"/>
        <joint name="elbow" axis="1 0 0"/>
        <body name="rod" pos="0 0 -0.4">
          <inertial mass="0.1" pos="0 0 -0.1" diaginertia="1e-3 1e-3 2e-12"/>
          <joint name="tip" axis="0 1 0"/>
          <body name="camera"><inertial mass="0.01" pos="0 0 0" diaginertia="0 0 0"/></body>
        </body>
      </body>
    </body>
    <body name="stand"><geom size="0.1"/></body>
  </worldbody>
</mujoco>
"""
BODIES = ("upper", "lower", "rod")


def declared(given: object = BODIES, **more: object) -> Model:
    return from_spec("two", mujoco.MjSpec.from_string(XML), {"inertial": given, **more})


def require_possible(mass: float, moments: Array) -> None:
    """A body of positive mass whose principal moments are those of positive mass elements: A + B ≥ C."""
    assert mass > 0
    assert (moments > 0).all()
    assert 2 * moments.max() <= moments.sum() * (1 + 1e-9)


def test_no_value_gives_a_body_that_cannot_exist() -> None:
    rng = np.random.default_rng(3)
    model = declared()
    unit = np.concatenate([rng.uniform(0, 1, (200, 30)), rng.integers(0, 2, (200, 30)).astype(float), np.eye(30)])
    for z in model.space.from_unit(unit):
        compiled = model.compile(z)  # MuJoCo itself refuses A + B < C
        for name in BODIES:
            require_possible(float(compiled.body(name).mass[0]), compiled.body(name).inertia)


def test_ten_times_the_bounds_are_still_bodies() -> None:
    rng, shape = np.random.default_rng(4), LogCholesky.of(1.0, np.zeros(3), np.diag([0.03, 0.02, 0.015]))
    found = shape.at(rng.normal(0, 4, (5000, 10)))
    for mass, moments in zip(found.mass, found.moments, strict=True):
        require_possible(float(mass), moments)
    smallest = np.linalg.eigvalsh(second_moments(found.tensor))[:, 0]
    assert (smallest >= -1e-9 * found.moments.max(1)).all()


def test_a_sheet_is_a_body() -> None:
    """It has A + B = C, and short of that by the last bit MuJoCo compiles nothing."""
    rng = np.random.default_rng(7)
    roots = rng.normal(size=(2000, 3, 2))
    moments, axes = principal(roots @ roots.transpose(0, 2, 1))
    largest, *others = np.sort(moments)[:, ::-1].T
    assert (others[0] + others[1] >= largest).all()
    one = Inertial(np.ones(2000), np.zeros((2000, 3)), moments, axes)
    np.testing.assert_allclose(second_moments(one.tensor), roots @ roots.transpose(0, 2, 1), atol=1e-12)


def test_at_zero_stands_the_body_of_the_file() -> None:
    plain, model = mujoco.MjSpec.from_string(XML).compile(), declared()
    np.testing.assert_array_equal(model.space.nominal, np.zeros(30))
    nominal = model.nominal()
    data, other = mujoco.MjData(plain), mujoco.MjData(nominal)
    data.qpos[:] = other.qpos[:] = [0.3, -0.5, 0.2]
    data.qvel[:] = other.qvel[:] = [1.0, 2.0, -1.0]
    mujoco.mj_forward(plain, data)
    mujoco.mj_forward(nominal, other)
    np.testing.assert_allclose(other.qacc, data.qacc, rtol=1e-6)  # the rod has a thickness of 1e-4 of its length


@pytest.mark.parametrize("turn", ['euler="30 20 10"', 'axisangle="1 0 0 40"', 'xyaxes="0 1 0 1 0 0"'])
def test_at_zero_stands_the_body_however_its_axes_are_given(turn: str) -> None:
    text = XML.replace('quat="0.6 0 0.8 0" diaginertia="0.02 0.018 0.006"', f'{turn} diaginertia="0.006 0.02 0.018"')
    spec = mujoco.MjSpec.from_string(text)
    plain, model = spec.copy().compile(), from_spec("two", spec, {"inertial": ["lower"]}).nominal()
    given, found = (
        Inertial(each.mass, each.ipos[None], each.inertia[None], each.iquat[None]).tensor[0]
        for each in (plain.body("lower"), model.body("lower"))
    )
    np.testing.assert_allclose(found, given, atol=1e-12)


def test_the_numbers_mean_what_they_say() -> None:
    inertia = np.diag([0.03, 0.02, 0.015])
    shape = LogCholesky.of(2.0, np.array([0.1, 0.0, -0.2]), inertia)
    heavier = shape.at(np.array([[np.log(1.3), *np.zeros(9)]]))
    np.testing.assert_allclose(heavier.mass, [2.6])
    np.testing.assert_allclose(heavier.centre, [[0.1, 0.0, -0.2]])
    np.testing.assert_allclose(heavier.tensor[0], 1.3 * inertia, atol=1e-15)
    radii = np.sqrt(np.diag(second_moments(inertia)) / 2.0)
    moved = shape.at(np.array([[0, 0.5, -0.2, 0.1, *np.zeros(6)]]))
    np.testing.assert_allclose(moved.centre[0], [0.1, 0.0, -0.2] + radii * [0.5, -0.2, 0.1])
    np.testing.assert_allclose(moved.tensor[0], inertia, atol=1e-15)
    longer = shape.at(np.array([[*np.zeros(4), 0.3, *np.zeros(5)]]))
    np.testing.assert_allclose(np.diag(second_moments(longer.tensor[0]))[0], 2 * radii[0] ** 2 * np.exp(0.6))


def test_every_body_that_can_exist_is_reached() -> None:
    """Any two bodies are ten numbers apart, here found by the factor of the pseudo-inertia."""
    rng = np.random.default_rng(5)
    shape = LogCholesky.of(2.0, np.array([0.1, 0.0, -0.2]), np.diag([0.03, 0.02, 0.015]))
    root = np.triu(rng.normal(size=(3, 3)))
    root *= np.sign(np.diag(root))
    deformed = np.linalg.solve(shape.root, root)
    stretch = np.log(np.diag(deformed))
    shear = [deformed[0, 1], deformed[1, 2], deformed[0, 2]]
    shift = np.linalg.solve(shape.root, np.array([0.3, 0.2, 0.1]) - shape.centre)
    found = shape.at(np.array([[np.log(5.0 / 2.0), *shift, *stretch, *shear]]))
    np.testing.assert_allclose(found.mass, [5.0])
    np.testing.assert_allclose(found.centre, [[0.3, 0.2, 0.1]])
    np.testing.assert_allclose(second_moments(found.tensor[0]), 5.0 * root @ root.T, atol=1e-12)


def test_fields_hold_what_recompiling_gives() -> None:
    damping = {"target": "joint.shoulder.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 1.0}
    model, rng = declared(damping=damping), np.random.default_rng(6)
    z = model.space.from_unit(rng.uniform(0.1, 0.9, 31))
    simulator = Simulator(model, 3)
    for _ in range(2):  # edits do not accumulate
        simulator.set_contexts(z[None], np.array([1]))
    written, recompiled = simulator.batch.get_model(1), model.compile(z)
    for name in (*FIELDS, "body_subtreemass", "dof_M0", "dof_invweight0", "body_invweight0", "dof_damping"):
        np.testing.assert_allclose(getattr(written, name), getattr(recompiled, name), rtol=1e-12, atol=1e-15)
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(simulator.batch.get_model(0), name), getattr(model.nominal(), name))
    simulator.reset()
    simulator.step(np.zeros((3, 0)), nstep=50)
    data = mujoco.MjData(recompiled)
    mujoco.mj_step(recompiled, data, 50)
    np.testing.assert_allclose(simulator.batch.bind("qpos")[1], data.qpos, atol=1e-12)


def test_one_word_frees_every_moving_body() -> None:
    spec = mujoco.MjSpec.from_string(XML.replace('diaginertia="0 0 0"', 'diaginertia="1e-6 1e-6 1e-6"'))
    model = from_spec("two", spec, "inertial")
    names = ("upper", "lower", "rod", "camera")
    assert model.space.names == tuple(f"{body}.inertial.{short}" for body in names for short in SHORT)
    assert all(p.prior == 0.25 and p.low == -p.high for p in model.space.parameters)


def test_bounds_of_its_own() -> None:
    model = declared({"bodies": ["lower"], "mass": 0.7})
    assert model.space.parameters[0].high == 0.7
    assert len(model.space.parameters) == 10


def test_inferred_inertias_are_written_out() -> None:
    spec = mujoco.MjSpec.from_string(
        '<mujoco><worldbody><body name="b"><joint name="j" axis="0 1 0"/><geom type="capsule" size="0.1 0.3" '
        'pos="0.3 0 0"/></body></worldbody></mujoco>'
    )
    model = from_spec("one", spec, "inertial")
    np.testing.assert_allclose(model.nominal().body("b").mass, spec.compile().body("b").mass)
    z = model.space.vector({"b.inertial.mass": np.log(1.5)})
    np.testing.assert_allclose(model.compile(z).body("b").inertia.sum(), 1.5 * spec.compile().body("b").inertia.sum())


@pytest.mark.parametrize(
    ("given", "more", "error", "told"),
    [
        (["lowe"], {}, UnknownNameError, "Did you mean 'lower'"),
        (["stand"], {}, UnknownNameError, "moving body with mass"),
        ("lower", {}, ModelError, "neither 'all' nor a list of bodies"),
        (7, {}, ModelError, "neither 'all' nor a list"),
        ({"bodies": ["lower"], "masss": 0.1}, {}, UnknownNameError, "mass"),
        (["camera"], {}, ModelError, "has a mass but no size"),
        (
            ["lower"],
            {"m": {"target": "body.lower.mass", "unit": "kg", "low": 1.0, "high": 2.0}},
            ModelError,
            "all of the inertia of body 'lower', which holds it",
        ),
        (["lower"], {"m": 3}, ModelError, "expected target, unit, low and high"),
    ],
)
def test_what_cannot_be_meant_is_refused(given: object, more: dict[str, object], error: type, told: str) -> None:
    with pytest.raises(error, match=told):
        declared(given, **more)


def test_another_word_is_no_declaration() -> None:
    with pytest.raises(ModelError, match="Only 'inertial' stands by itself"):
        from_spec("two", mujoco.MjSpec.from_string(XML), "inertials")
