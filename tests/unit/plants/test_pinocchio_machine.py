"""Pinocchio's equations against MuJoCo's, at one instant and along a motion."""

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from hydra.utils import instantiate
from strangers import STRANGERS, needs_pinocchio

from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.errors import ModelError
from dr_lab.plants.cable import Cable
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.machine import Vector
from dr_lab.plants.motion import Accuracy, simulate
from dr_lab.plants.mujoco_machine import Coupling, MujocoMachine
from dr_lab.plants.pinocchio_engine import tree
from dr_lab.plants.pinocchio_machine import PinocchioMachine, PinocchioNominal
from dr_lab.trajectory import Array

pytestmark = needs_pinocchio

ALTERED: dict[str, Callable[[MujocoMachine], MujocoMachine]] = {
    "armature": lambda m: m.with_armature(m.joints[0], 0.02),
    "load": lambda m: m.with_load(m.bodies[-1], 0.3, 0.1),
    "tool": lambda m: m.with_mass_at(m.bodies[-1], 0.7, np.array([0.05, -0.02, 0.1])),
    "centre": lambda m: m.with_centre_moved(m.bodies[-1], np.array([0.01, 0.02, -0.03])),
    "inertia": lambda m: m.with_inertia_scaled(m.bodies[-1], 1.7),
    "gravity": lambda m: m.with_gravity((0.3, -0.4, -9.7)),
    "drive": lambda m: m.with_drive_scaled(m.actuators[-1], 0.8),
    "link": lambda m: m.with_link_longer(m.bodies[-1], 0.03) if m.link(m.bodies[-1]) else m,
    "cable": lambda m: m.with_coupling(Coupling((0, len(m.joints) - 1), (0.03, -0.02), 0.004, 900.0)),
    "hose": lambda m: m.with_cable(Cable(m.bodies[-1], np.array([0.9, -0.4, 1.5]), 0.1, 80.0)),
    "medium": lambda m: m.with_medium(2.0, (1.0, -2.0, 0.0)),
}


def model_of(name: str) -> mujoco.MjModel:
    path = shipped() / "model" / "strangers" / f"{name}.xml"
    return PinocchioNominal(mjcf=str(path), free=(), spread=0.0).model({})


def accelerations(machine: MujocoMachine, *state: Vector) -> Array:
    mass, force = machine.terms(*state)
    return np.asarray(np.linalg.solve(np.array(mass), force), dtype=np.float64)


@pytest.mark.parametrize("name", STRANGERS)
def test_both_engines_accelerate_alike(name: str) -> None:
    model, generator = model_of(name), np.random.default_rng(1)
    ours, theirs = MujocoMachine.of(model), PinocchioMachine.of(model)
    for alter in (lambda m: m, *ALTERED.values()):
        for _ in range(3):
            state = [generator.uniform(-2, 2, size).tolist() for size in (model.nq, model.nv, model.nu, model.nv)]
            expected = accelerations(alter(ours), *state)
            size = max(float(np.abs(expected).max()), 1.0)
            np.testing.assert_allclose(accelerations(alter(theirs), *state) / size, expected / size, rtol=0, atol=1e-9)


@pytest.mark.parametrize("name", STRANGERS)
def test_both_engines_lack_the_same_along_a_motion(name: str) -> None:
    model, generator = model_of(name), np.random.default_rng(2)
    ours, theirs = MujocoMachine.of(model), PinocchioMachine.of(model)

    def geared(machine: MujocoMachine) -> MujocoMachine:
        return machine.with_gear_law(machine.joints[0], lambda drive, outside, v: 0.1 * drive - outside + v)

    for alter in (lambda m: m, geared, *ALTERED.values()):
        motion = [generator.uniform(-2, 2, (3, size)) for size in (model.nq, model.nv, model.nv, model.nu)]
        expected = alter(ours).lacking(*motion)
        size = max(float(np.abs(expected).max()), 1.0)
        np.testing.assert_allclose(alter(theirs).lacking(*motion) / size, expected / size, rtol=0, atol=1e-9)


def test_a_weaker_position_gain_pulls_less() -> None:
    machine = PinocchioMachine.of(model_of("paddle"))
    none, at = [0.0], [0.5]
    weaker = machine.with_stiffness_scaled("servo", 0.7)
    pulls = [m.terms(at, none, none, none)[1][0] for m in (machine, weaker)]
    assert pulls[1] - pulls[0] == pytest.approx(0.3 * 6.0 * 0.5)  # kp 6 N·m/rad


def test_gears_add_what_their_law_says_of_drive_and_load() -> None:
    seen: list[tuple[float, float, float]] = []

    def law(drive: float, outside: float, velocity: float) -> float:
        seen.append((drive, outside, velocity))
        return 1.5

    for kind in (MujocoMachine, PinocchioMachine):
        machine = kind.of(model_of("lift")).with_gear_law("lift", law)
        force = machine.terms([0.0], [0.2], [50.0], [0.0])[1][0]
        assert force == pytest.approx(50.0 - 4 * 9.81 - 12 * 0.2 + 1.5)
        assert seen[-1] == pytest.approx((50.0, -4 * 9.81, 0.2))


def test_what_pinocchio_would_leave_out_is_refused() -> None:
    for name in ("double_pendulum_c1", "furuta"):
        model = mujoco.MjModel.from_xml_path(str(shipped() / "model" / f"{name}.xml"))
        with pytest.raises(ModelError, match="A machine of Pinocchio"):
            PinocchioMachine.of(model).terms([0.0] * 2, [0.0] * 2, [0.0] * model.nu, [0.0] * 2)
    with pytest.raises(ModelError, match="one joint a body"):
        tree(
            mujoco.MjModel.from_xml_string(
                '<mujoco><worldbody><body><joint ref="1"/><geom size=".1"/></body></worldbody></mujoco>'
            )
        )


def test_a_whole_motion_is_that_of_the_model_in_fine_steps() -> None:
    nominal = instantiate(compose("record", ["plant=strangers/elbow_servo"]).plant.nominal)
    plant, compiled = nominal.machine(nominal.documented()), model_of("elbow_servo")
    compiled.opt.timestep, compiled.opt.integrator = 0.0005, int(mujoco.mjtIntegrator.mjINT_RK4)
    edge = np.arange(0.0, 0.5, 0.004)
    held = [Command(edge, peak * np.sin((9.0 + 4.0 * k) * edge)) for k, peak in enumerate((0.8, 0.6))]
    time, rows, data = np.linspace(0.0005, 0.5, 1000), [], mujoco.MjData(compiled)
    for command in np.stack([command.at(time - 0.00025) for command in held], axis=1):
        data.ctrl[:] = command
        mujoco.mj_step(compiled, data)
        rows.append(data.qpos.copy())
    states = simulate(plant, NoEffect(), held, time, accuracy=Accuracy(1e-9, 1e-10, 0.005))
    assert np.abs(rows).max() > 0.3
    np.testing.assert_allclose(states[:, :2], rows, rtol=0, atol=1e-6)
