"""The documented plant and the shipped MuJoCo model are the same machine."""

from pathlib import Path

import mujoco
import numpy as np
from hydra.utils import instantiate
from plant_machines import TIGHT

from dr_lab.cli.compose import compose
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.motion import simulate

MODEL = Path(__file__).parents[3] / "conf" / "model" / "furuta.xml"


def test_nominal_plant_and_model_move_alike() -> None:
    nominal = instantiate(compose("record", ["plant=furuta"]).plant.nominal)
    model = mujoco.MjModel.from_xml_path(str(MODEL))
    model.opt.timestep = 0.001
    data = mujoco.MjData(model)
    held = Command(np.arange(0.0, 1.0, 0.004), 6.0 * np.sin(9.0 * np.arange(0.0, 1.0, 0.004)))
    time, rows = np.linspace(0.001, 1.0, 1000), []
    for now in time:
        data.ctrl[:] = held.at(np.array([now - 0.0005]))
        mujoco.mj_step(model, data)
        rows.append(data.qpos.copy())
    named = {
        "arm.mass": model.body("arm").mass[0],
        "pole.mass": model.body("pole").mass[0],
        "arm.damping": model.joint("arm").damping[0],
        "pole.damping": model.joint("pole").damping[0],
    }
    states = simulate(nominal.machine(named), NoEffect(), [held], time, accuracy=TIGHT)
    assert named == {
        "arm.mass": nominal.arm_mass,
        "pole.mass": nominal.pole_mass,
        "arm.damping": nominal.arm_damping,
        "pole.damping": nominal.pole_damping,
    }
    # The model gives its thin rods 1e-9 kg·m² about their own axes.
    np.testing.assert_allclose(states[:, :2], rows, rtol=0, atol=1e-4)
