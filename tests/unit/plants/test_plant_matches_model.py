"""The documented plant and the shipped MuJoCo model are the same machine."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.plants.command import Command
from dr_lab.plants.hidden.base_tilt import BaseTilt
from dr_lab.plants.hidden.no_effect import NoEffect
from dr_lab.plants.motion import Accuracy, simulate
from dr_lab.plants.nominal import Nominal

CONF = Path(__file__).parents[3] / "conf"


def nominal_of(machine: str) -> Nominal:
    return instantiate(compose("record", [f"plant={machine}"]).plant.nominal)


@pytest.mark.parametrize(
    ("machine", "model", "peaks", "tolerance"),
    [
        ("furuta", "furuta", (6.0,), 1e-4),  # the model gives its thin rods 1e-9 kg·m² about their own axes
        ("pendulum", "pendulum", (2.0,), 1e-6),
        ("cartpole", "cartpole", (8.0,), 1e-6),
        ("double_pendulum", "double_pendulum_c1", (1.5, 1.0), 1e-6),
        ("arm", "arm", (20.0, 30.0, 10.0, 3.0, 3.0, 2.0), 1e-6),
        ("bouncer", "bouncer", (9.0, 7.0), 1e-5),  # what a step of half a millisecond leaves of a soft contact
    ],
)
def test_nominal_plant_and_model_move_alike_on_a_tilted_base(
    machine: str, model: str, peaks: tuple[float, ...], tolerance: float
) -> None:
    compiled = mujoco.MjModel.from_xml_path(str(CONF / "model" / f"{model}.xml"))
    nominal = nominal_of(machine)
    plant = BaseTilt(about_x=0.1, about_y=0.1).alter(nominal.machine(nominal.documented()))
    step = 0.0005
    compiled.opt.timestep, compiled.opt.gravity = step, plant.gravity
    data = mujoco.MjData(compiled)
    edge = np.arange(0.0, 0.6, 0.004)
    held = [Command(edge, peak * np.sin((9.0 + 4.0 * k) * edge)) for k, peak in enumerate(peaks)]
    time, rows = np.linspace(step, 0.6, 1200), []
    sent = np.stack([command.at(time - step / 2) for command in held], axis=1)
    for command in sent:
        data.ctrl[:] = command
        mujoco.mj_step(compiled, data)
        rows.append(data.qpos.copy())
    accuracy = Accuracy(relative=1e-3 * tolerance, absolute=1e-4 * tolerance, longest_step=0.005)
    states = simulate(plant, NoEffect(), held, time, accuracy=accuracy)
    assert np.abs(rows).max() > 0.1
    np.testing.assert_allclose(states[:, : compiled.nq], rows, rtol=0, atol=tolerance)


@pytest.mark.parametrize("machine", ["furuta", "pendulum", "cartpole", "double_pendulum", "arm", "bouncer"])
def test_what_the_plant_spreads_is_what_the_model_leaves_free(machine: str) -> None:
    parameters = instantiate(compose("compare", [f"model={machine}"]).model, _convert_="all").space
    documented = nominal_of(machine).documented()
    assert documented.keys() <= {*parameters.names}
    for name, nominal in zip(parameters.names, parameters.nominal, strict=True):
        assert documented[name] == pytest.approx(nominal, rel=1e-6)
