"""Every model file: loads in MuJoCo alone, conserves energy, weighs what is documented, declares live parameters."""

from functools import cache
from pathlib import Path

import hydra
import mujoco
import numpy as np
import pytest

from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.cli.groups import options
from dr_lab.physics.model import Model

FOLDER = shipped() / "model"
FILES = sorted(FOLDER.glob("*.xml"))
NAMES = sorted(set(options("model", (shipped(),))) - {"from_run"})  # which is whatever model the run began with
TOUCHING = ("bouncer", "cube", "hopper")  # machines whose shapes touch the ground
FINE = 1e-3  # s; at which RK4 keeps the energy of the fastest machine
MASSES = {  # kg, sums of the documented values
    "arm": 1.98 + 3.4445 + 1.437 + 0.871 + 0.805 + 0.261,
    "ball": 1.5 * 0.028349523,
    "bouncer": 1.2 + 0.5,
    "cartpole": 0.38 + 0.127,
    "cube": 0.37,
    "double_pendulum_a0": 0.5593806 + 0.6043459,
    "double_pendulum_c1": 0.5234602 + 0.6255677,
    "emps": 95.1089,
    "furuta": 0.095 + 0.024,
    "hopper": 3.6651914 + 4.0578905 + 2.7813567 + 5.3155748,
    "multiarm": 0.1476,
    "multiarm_double": 0.0938 + 0.1376,
    "pendulum": 0.676,
    "pendulum_measured": 0.796,
    "servo_sts3250": 1.13,
    "servo_xl330": 0.49,
}


@cache
def loaded(name: str) -> Model:
    return hydra.utils.instantiate(compose("compare", [f"model={name}"]).model)


def frictionless(path: Path) -> mujoco.MjModel:
    """The machine alone: no damping, motors, joint limits or contacts; energy is computed."""
    spec = mujoco.MjSpec.from_file(str(path))
    for joint in spec.joints:
        joint.damping, joint.frictionloss = np.zeros(3), 0.0
    flags = mujoco.mjtDisableBit
    spec.option.disableflags |= int(flags.mjDSBL_ACTUATION | flags.mjDSBL_CONTACT | flags.mjDSBL_LIMIT)
    spec.option.enableflags |= int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_RK4
    spec.option.timestep = min(spec.option.timestep, FINE)
    return spec.compile()


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_loads_in_mujoco_alone_without_a_word(path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.nv > 0
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_weighs_what_is_documented(path: Path) -> None:
    assert mujoco.MjModel.from_xml_path(str(path)).body_mass.sum() == pytest.approx(MASSES[path.stem], rel=1e-7)


@pytest.mark.parametrize("path", FILES, ids=lambda p: p.stem)
def test_energy_is_conserved_without_friction(path: Path) -> None:
    model = frictionless(path)
    data = mujoco.MjData(model)
    rng = np.random.default_rng(0)
    data.qpos[:] += rng.uniform(-1, 1, model.nq)
    data.qvel[:] = rng.uniform(-1, 1, model.nv)
    energy = []
    for _ in range(round(2 / model.opt.timestep)):
        mujoco.mj_step(model, data)
        energy.append(data.energy.copy())
    total, scale = np.sum(energy, axis=1), np.max(np.array(energy)[:, 1])
    assert np.abs(total - total[0]).max() < 1e-6 * scale


@pytest.mark.parametrize("path", [p for p in FILES if p.stem not in TOUCHING], ids=lambda p: p.stem)
def test_shapes_are_pictures_only(path: Path) -> None:
    model = mujoco.MjModel.from_xml_path(str(path))
    assert model.ngeom >= 5
    assert not model.geom_contype.any()
    assert not model.geom_conaffinity.any()
    heavier = mujoco.MjSpec.from_file(str(path))
    for geom in heavier.geoms:
        geom.mass = 1.0
    assert np.array_equal(heavier.compile().body_mass[1:], model.body_mass[1:])


@pytest.mark.parametrize("name", NAMES)
def test_declares_parameters_that_change_the_physics(name: str) -> None:
    model = loaded(name)  # raises if a target is missing, dead, or its nominal outside the bounds
    assert model.name == name
    assert model.declared
    for parameter in model.declared:
        assert parameter.low * parameter.high >= 0, f"{parameter.name} changes sign within its bounds"
        assert parameter.nominal < parameter.high, f"{parameter.name} starts at its upper bound"
    assert model.nominal().nv > 0


@pytest.mark.parametrize("name", NAMES)
def test_compiles_at_the_corners_of_its_bounds(name: str) -> None:
    space = loaded(name).space
    for z in (space.low, space.high):
        assert np.isfinite(loaded(name).compile(z).body_mass).all()
