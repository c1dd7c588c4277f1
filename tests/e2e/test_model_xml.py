"""`model.xml` with `rollout.npz`: MuJoCo alone repeats what was recorded, whatever effect was added."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hydra.utils import instantiate
from scipy.interpolate import CubicHermiteSpline

from dr_lab.cli.compose import compose
from dr_lab.comparison.export import play, write_model, write_rollout
from dr_lab.comparison.study import Study, prepare
from dr_lab.effects.effect import Effect, place
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array

PLAIN = Path(__file__).with_name("plain_mujoco.py")
EXACT = 1e-9
# rad; what six digits of a model's numbers may move the pendulum by within a window
SIX_DIGITS = 2e-4
# Effects with their values. MuJoCo delays commands by itself from 3 ms on (one and a half steps with RK4).
PLACED: dict[str, tuple[str, str, dict[str, float]]] = {
    "absent": ("coulomb_friction", "arm", {"torque": 0.0}),
    "coulomb": ("coulomb_friction", "arm", {"torque": 2.1e-3}),
    "stribeck": ("stribeck_friction", "arm", {"kinetic": 1.5e-3, "excess": 1.1e-3, "speed": 0.7}),
    "viscous": ("viscous_friction", "pole", {"coefficient": 2.3e-5}),
    "drag": ("quadratic_drag", "arm", {"coefficient": 2.7e-5}),
    "delay_12_ms": ("actuator_delay", "motor", {"delay": 0.0123}),
    "delay_below_a_step": ("actuator_delay", "motor", {"delay": 0.0013}),
    "delay_below_one_and_a_half": ("actuator_delay", "motor", {"delay": 0.0027}),
    "late_reading": ("sensor_time_offset", "pole", {"offset": 0.0041}),
    "offset": ("constant_offset", "arm", {"torque": -1.3e-3}),
    "payload": ("payload", "pole", {"mass": 0.0053, "distance": 0.091}),
    "scale": ("torque_scale", "motor", {"factor": 0.87}),
    "spring": ("spring", "arm", {"stiffness": 3.1e-3, "reference": 0.4}),
    "armature": ("armature", "arm", {"inertia": 2.3e-5}),
    "tilt": ("base_tilt", "world", {"about_x": 0.02, "about_y": -0.01}),
    "saturation": ("saturation", "motor", {"inverse_limit": 0.31}),
}


def plain(*folders: Path) -> dict[str, list[float]]:
    """Differences that an interpreter without dr_lab finds."""
    done = subprocess.run([sys.executable, PLAIN, *folders], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    return {Path(name).name: found for name, found in json.loads(done.stdout).items()}


@pytest.fixture(scope="module")
def demo() -> tuple[Study, dict[str, Effect]]:
    """The demo's logs, the first seconds of two of them."""
    cut = ["measurements.fit=['log_1[0:3]']", "measurements.held_out=['log_5[0:2]']", "windows.seconds=0.9"]
    cfg = compose("close", [*cut, "threads=2"])
    return prepare(instantiate(cfg.comparison, _convert_="all")), instantiate(cfg.effects, _convert_="all")


@pytest.fixture(scope="module")
def exported(demo: tuple[Study, dict[str, Effect]], tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Every case written as `finish` writes it."""
    study, effects = demo
    folders = {name: tmp_path_factory.mktemp(name) for name in PLACED}
    for name, folder in folders.items():
        model, z = extended(study, effects, name)
        read_back, _ = write_model(folder / "model.xml", model, z)
        write_rollout(folder / "rollout.npz", play(study, read_back, read_back.space.nominal, study.predicted))
    return folders


def extended(study: Study, effects: dict[str, Effect], name: str) -> tuple[Model, Array]:
    """The pendulum with a case's effect, and its context."""
    effect, site, values = PLACED[name]
    model = study.model.with_effect(place(effects[effect], study.compiled, site, study.scales))
    return model, model.space.vector({f"{effect}@{site}.{key}": value for key, value in values.items()})


def test_mujoco_alone_repeats_every_effect(exported: dict[str, Path]) -> None:
    found = plain(*exported.values())
    assert len(found) == len(PLACED)
    for folder, (position, velocity) in found.items():
        assert position < EXACT, folder
        assert velocity < 1e3 * EXACT, folder


@pytest.mark.parametrize("name", PLACED)
def test_the_file_loses_nothing_of_the_model(demo: tuple[Study, dict[str, Effect]], tmp_path: Path, name: str) -> None:
    study, effects = demo
    model, z = extended(study, effects, name)
    read_back, _ = write_model(tmp_path / "model.xml", model, z)
    before = play(study, model, z, study.predicted)
    after = play(study, read_back, read_back.space.nominal, study.predicted)
    delta = before.fit.delta[None]
    moved = after.replay.simulate(read_back.space.nominal[None], delta)[0].qpos
    np.testing.assert_allclose(moved, before.replay.simulate(z[None], delta)[0].qpos, rtol=0, atol=SIX_DIGITS)
    there = after.replay.residuals(read_back.space.nominal[None], delta)[0]
    np.testing.assert_allclose(there, before.replay.residuals(z[None], delta)[0], rtol=0, atol=0.2)  # noise std


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("delay_below_a_step", "commands of motor act 0.0013 s late"),
        ("late_reading", "sensor_time_offset@pole: offset 0.0041"),
        ("delay_12_ms", ""),
        ("coulomb", ""),
    ],
)
def test_the_file_says_what_it_lacks(
    demo: tuple[Study, dict[str, Effect]], tmp_path: Path, name: str, sentence: str
) -> None:
    path = tmp_path / "model.xml"
    _, missing = write_model(path, *extended(*demo, name))
    assert [s for s in missing if sentence in s] == missing[:1]
    text = path.read_text()
    assert sentence in text
    assert ("cannot say" in text) == bool(sentence)


def test_commands_that_mujoco_cannot_delay_are_stored_late(exported: dict[str, Path]) -> None:
    given, late = (np.load(exported[name] / "rollout.npz")["ctrl"][..., 0] for name in ("absent", "delay_below_a_step"))
    steps = np.arange(given.shape[1])
    curve = CubicHermiteSpline(steps, given, np.gradient(given, axis=1), axis=1)
    inner = slice(2, -2)  # slopes at the ends are one-sided, and commands of before the window are not stored
    np.testing.assert_allclose(late[:, inner], curve(steps - 0.0013 / 0.002)[:, inner], atol=1e-12)
