"""Ways along which bodies change as the equations of motion are linear in them."""

import mujoco
import numpy as np
import pytest
from effect_machines import CONF, placed, replayed

from dr_lab.physics.model import Model, load
from dr_lab.physics.pseudo_inertia import LogCholesky, Rooted
from dr_lab.physics.straight import Straight
from dr_lab.trajectory import Array

LOAD = "rigid_payload@link7"


def loaded_arm() -> Model:
    machine = load("seven", CONF / "model/strangers/seven.xml", {"inertial": ["link6", "link7"]})
    return machine.with_effect(placed(machine, "rigid_payload", "link7"))


def pseudo(model: Model, z: Array, body: str, *, frame: str | None = None) -> Array:
    """Pseudo-inertia of a body of the compiled model, in its own frame or in that of the one that carries it."""
    compiled = model.compile(z)
    one, turned = compiled.body(body), np.zeros(9)
    mujoco.mju_quat2Mat(turned, one.iquat)
    axes, mass, centre = turned.reshape(3, 3), float(one.mass[0]), one.ipos.copy()
    second = axes @ (one.inertia.sum() / 2 * np.eye(3) - np.diag(one.inertia)) @ axes.T
    if frame is not None:
        mujoco.mju_quat2Mat(turned, one.quat)
        place = turned.reshape(3, 3)
        centre, second = one.pos + place @ centre, place @ second @ place.T
    found = np.empty((4, 4))
    found[:3, :3] = second + mass * np.outer(centre, centre)
    found[:3, 3] = found[3, :3] = mass * centre
    found[3, 3] = mass
    return found


def start(model: Model) -> Array:
    values = {"mass": 1.0, "distance": 0.05, "side": -0.02, "along": 0.1, "skew_xy": 0.01}
    values |= {f"spread_{axis}": 0.04 for axis in "xyz"}
    z = model.space.vector({f"{LOAD}.{name}": value for name, value in values.items()})
    z[:20] = 0.2 * np.random.default_rng(0).normal(size=20) * model.space.high[:20]
    return z


def test_a_step_changes_every_body_linearly_and_by_its_slope() -> None:
    model, rng = loaded_arm(), np.random.default_rng(1)
    z = start(model)
    step = 0.05 * rng.normal(size=len(z)) * model.space.span * np.where(np.arange(len(z)) < 20, 1.0, 0.05)
    end = Straight.of(model).end(z, step)
    for body in ("link6", "link7", LOAD):
        here, there = pseudo(model, z, body), pseudo(model, end, body)
        slope = (pseudo(model, z + 1e-5 * step, body) - pseudo(model, z - 1e-5 * step, body)) / 2e-5
        np.testing.assert_allclose(there - here, slope, atol=1e-6)
    assert np.abs(end - z - step).max() > 1e-3  # its own parameters bend


def test_what_a_load_takes_from_its_link_moves_nothing() -> None:
    """A step that the motion does not show to first order is one that it does not show at all."""
    model, z = loaded_arm(), start(loaded_arm())
    rows = np.array([model.space.index(name) for name in model.space.names if "link7" in name])

    def total(at: Array) -> Array:
        return (pseudo(model, at, "link7") + pseudo(model, at, LOAD, frame="link7"))[np.triu_indices(4)]

    ahead = [total(z + 1e-6 * each) - total(z - 1e-6 * each) for each in np.eye(len(z))[rows]]
    hidden = np.linalg.svd(np.array(ahead).T / 2e-6)[2][-1]
    step = np.zeros(len(z))
    step[rows] = 0.03 * hidden / np.abs(hidden).max()
    bent, plain = total(Straight.of(model).end(z, step)) - total(z), total(z + step) - total(z)
    assert np.abs(bent).max() < 0.01 * np.abs(plain).max()


def test_a_load_without_mass_gets_one() -> None:
    model = loaded_arm()
    z, step = model.space.nominal, np.zeros(len(model.space.names))
    step[model.space.index(f"{LOAD}.mass")] = 0.3
    end = Straight.of(model).end(z, step)
    assert end[model.space.index(f"{LOAD}.mass")] == pytest.approx(0.3)
    np.testing.assert_allclose(np.delete(end, 20), np.delete(z, 20), atol=1e-5)  # a point is as thin as rounding


def test_what_a_load_cannot_be_its_link_is() -> None:
    """A load that shrinks to a point on a straight way would go on beyond it."""
    model = loaded_arm()
    z, step = start(model), np.zeros(len(model.space.names))
    for axis in "xyz":
        z[model.space.index(f"{LOAD}.spread_{axis}")] = 0.015
        step[model.space.index(f"{LOAD}.spread_{axis}")] = -0.015
    z[model.space.index(f"{LOAD}.skew_xy")] = 0.0
    end = Straight.of(model).end(z, step)
    assert (model.space.to_unit(end)[20:] > -1e-9).all()
    spreads = [end[model.space.index(f"{LOAD}.spread_{axis}")] for axis in "xyz"]
    np.testing.assert_allclose(spreads, 0.0, atol=1e-3)

    def total(at: Array) -> Array:
        return pseudo(model, at, "link7") + pseudo(model, at, LOAD, frame="link7")

    slope = (total(z + 1e-5 * step) - total(z - 1e-5 * step)) / 2e-5
    np.testing.assert_allclose(total(end) - total(z), slope, atol=1e-6)
    np.testing.assert_array_equal(Straight.of(model).apart().end(z, step)[:20], z[:20])


@pytest.mark.parametrize("seed", range(5))
def test_the_ten_numbers_and_the_body_are_one(seed: int) -> None:
    rng = np.random.default_rng(seed)
    shape = LogCholesky.of(2.0, np.array([0.1, -0.2, 0.3]), np.diag([0.03, 0.02, 0.04]))
    theta = rng.normal(size=(1, 10)) * 0.3
    body = shape.rooted(theta)
    np.testing.assert_allclose(shape.numbers(body), theta, atol=1e-12)
    again = Rooted.of(body.pseudo[0])
    assert again is not None
    np.testing.assert_allclose(shape.numbers(again), theta, atol=1e-7)


def test_bodies_in_fields_move_as_compiled_ones_do() -> None:
    machine = load("seven", CONF / "model/strangers/seven.xml", {"inertial": "all"})
    rng, controls = np.random.default_rng(3), np.full((1, 40, 7), 2.0)
    for name, site in (("rigid_payload", "link7"), ("coulomb_friction", "joint4"), ("backlash", "joint6")):
        model = machine.with_effect(placed(machine, name, site))
        assert model.bodies_apart
        z = model.space.from_unit(rng.uniform(0.2, 0.8, (3, len(model.space.names))))
        found = replayed(model, z, controls, controls[:, :30])
        model.__dict__["bodies_apart"] = False  # as it would be if it were not exact
        np.testing.assert_allclose(found, replayed(model, z, controls, controls[:, :30]), atol=1e-9)


def test_effects_that_edit_the_bodies_are_compiled_with_them() -> None:
    machine = load("seven", CONF / "model/strangers/seven.xml", {"inertial": "all"})
    for name in ("centre_of_mass_offset", "inertia_error"):
        assert not machine.with_effect(placed(machine, name, "link7")).bodies_apart
