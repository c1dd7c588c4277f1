"""Machines by their documented constants: the Lagrangian's acceleration at drawn contexts, and the nominal machine."""

from collections.abc import Callable, Mapping

import mujoco
import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.physics.model import Model
from dr_lab.physics.simulator import Simulator
from dr_lab.plants.cartpole import CartPole
from dr_lab.plants.drive import Motor
from dr_lab.plants.furuta import Furuta
from dr_lab.plants.lagrangian import LagrangianMachine
from dr_lab.plants.moments import Moments
from dr_lab.seeding import stream
from dr_lab.trajectory import Array

Constants = Mapping[str, float]
DRAWS = 20
DRY = 0.02 * (0.38 + 0.127) * 9.81  # N, of the cart at rest, which model=cartpole leaves out


def machine(name: str) -> Model:
    return instantiate(compose("compare", [f"model={name}"]).model, _convert_="all")


def furuta(c: Constants) -> LagrangianMachine:
    return Furuta(
        links=(Moments.rod(c["arm.mass"], c["arm.length"]), Moments.rod(c["pole.mass"], c["pole.length"])),
        damping=(c["arm.damping"], c["pole.damping"]),
        armature=(0.0, 0.0),
        gravity=(0.0, 0.0, -c["gravity"]),
        drives=(Motor(c["motor.constant"], c["motor.resistance"]),),
        length=c["arm.length"],
    )


def cartpole(c: Constants) -> LagrangianMachine:
    ratio = c["gear.ratio"] / c["pinion.radius"]
    return CartPole(
        links=(Moments.point(c["cart.mass"], 0.0), Moments.rod(c["pole.mass"], 2 * c["pole.half_length"])),
        damping=(c["cart.damping"], c["pole.damping"]),
        armature=(c["gear.efficiency"] * ratio**2 * c["rotor.inertia"], 0.0),
        gravity=(0.0, 0.0, -c["gravity"]),
        drives=(
            Motor(ratio * c["motor.constant"], c["motor.resistance"] / (c["gear.efficiency"] * c["motor.efficiency"])),
        ),
    )


def no_dry_friction(c: Constants) -> float:
    del c
    return 0.0


def of_the_cart(c: Constants) -> float:
    return c["rail.friction"] * (c["cart.mass"] + c["pole.mass"]) * c["gravity"]


@pytest.mark.parametrize(
    ("name", "lagrangian", "dry", "tolerance"),
    [
        ("furuta", furuta, no_dry_friction, 1e-4),  # its thin rods have 1e-9 kg·m² about their own axes
        ("cartpole", cartpole, of_the_cart, 1e-9),
    ],
)
def test_drawn_constants_accelerate_as_the_lagrangian_says(
    name: str, lagrangian: Callable[[Constants], LagrangianMachine], dry: Callable[[Constants], float], tolerance: float
) -> None:
    model = machine(f"{name}_constants")
    rng = stream(0, name)
    z = model.space.from_unit(rng.random((DRAWS, len(model.space.names))))
    position, velocity = rng.uniform(-3.0, 3.0, (DRAWS, 2)), rng.uniform(-6.0, 6.0, (DRAWS, 2))
    velocity[:, 0] += np.sign(velocity[:, 0])  # it slides, well away from where dry friction turns
    volts = rng.uniform(-8.0, 8.0, (DRAWS, 1))
    found = accelerations(model, z, position, velocity, volts)
    for k in range(DRAWS):
        constants = model.space.mapping(z[k])
        applied = (-dry(constants) * np.sign(velocity[k, 0]), 0.0)
        mass, force = lagrangian(constants).terms(
            tuple(position[k].tolist()), tuple(velocity[k].tolist()), tuple(volts[k].tolist()), applied
        )
        expected = np.linalg.solve(mass, force)
        assert np.linalg.norm(found[k] - expected) < tolerance * np.linalg.norm(expected)


def accelerations(model: Model, z: Array, position: Array, velocity: Array, volts: Array) -> Array:
    """Of simulations whose constants were written as fields, shape (n, 2)."""
    simulator = Simulator(model, len(z), threads=1)
    simulator.set_contexts(z)
    rows = []
    for k in range(len(z)):
        one = simulator.batch.get_model(k)
        data = mujoco.MjData(one)
        data.qpos[:], data.qvel[:], data.ctrl[:] = position[k], velocity[k], volts[k]
        mujoco.mj_forward(one, data)
        rows.append(data.qacc.copy())
    return np.array(rows)


@pytest.mark.parametrize("name", ["furuta_constants", "cartpole_constants"])
def test_constants_written_as_fields_equal_the_compiled_model(name: str) -> None:
    model = machine(name)
    z = model.space.from_unit(stream(1, name).random((4, len(model.space.names))))
    simulator = Simulator(model, 4, threads=1)
    for _ in range(2):  # nothing accumulates
        simulator.set_contexts(z)
    for k, row in enumerate(z):
        by_field, compiled = simulator.batch.get_model(k), model.compile(row)
        np.testing.assert_allclose(by_field.opt.gravity, compiled.opt.gravity, rtol=1e-14)
        for field in ("body_mass", "body_inertia", "body_ipos", "body_pos", "actuator_gear", "actuator_gainprm",
                      "dof_damping", "dof_armature", "dof_frictionloss", "dof_M0", "body_subtreemass"):  # fmt: skip
            np.testing.assert_allclose(getattr(by_field, field), getattr(compiled, field), rtol=1e-12, err_msg=field)


@pytest.mark.parametrize(("name", "friction"), [("furuta", 0.0), ("cartpole", DRY)])
def test_nominal_constants_are_the_machine_of_the_file_but_for_its_friction(name: str, friction: float) -> None:
    documented, shipped = machine(f"{name}_constants").nominal(), machine(name).nominal()
    for field in (
        "body_mass",
        "body_inertia",
        "body_ipos",
        "body_pos",
        "actuator_gear",
        "actuator_gainprm",
        "dof_armature",
    ):
        np.testing.assert_allclose(getattr(documented, field), getattr(shipped, field), rtol=1e-5, err_msg=field)
    np.testing.assert_allclose(documented.dof_frictionloss, [friction, 0.0], rtol=1e-12)
