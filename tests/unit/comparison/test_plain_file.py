"""Files of models that MJCF cannot express: what stands in, and what they say of themselves."""

from pathlib import Path

import mujoco
import numpy as np
import pytest
from diagnosis_machines import measured, pendulum, short_comparison, swinging
from hydra.utils import instantiate

from dr_lab.cli.compose import compose
from dr_lab.comparison.export import write_model
from dr_lab.comparison.plain_file import file_note
from dr_lab.comparison.study import Study, prepare
from dr_lab.effects.effect import Effect, place
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


@pytest.fixture(scope="module")
def study() -> Study:
    logs = [swinging(f"log_{k}", pendulum().nominal(), k) for k in range(2)]
    return prepare(short_comparison(pendulum(), measured(logs[:1], logs[1:])))


@pytest.fixture(scope="module")
def effects() -> dict[str, Effect]:
    return instantiate(compose("close", ["threads=1"]).effects, _convert_="all")


def with_effect(study: Study, effect: Effect, **values: float) -> tuple[Model, Array]:
    model = study.model.with_effect(place(effect, study.compiled, "hinge", study.scales))
    return model, model.space.vector({f"{effect.name}@hinge.{name}": value for name, value in values.items()})


def test_smooth_friction_is_dry_friction_in_the_file(study: Study, effects: dict[str, Effect], tmp_path: Path) -> None:
    path = tmp_path / "model.xml"
    read_back, missing = write_model(path, *with_effect(study, effects["smooth_friction"], torque=0.02, creep=0.01))
    assert mujoco.MjModel.from_xml_path(str(path)).dof_frictionloss.tolist() == [0.02]
    assert read_back.compile(read_back.space.nominal).dof_frictionloss.tolist() == [0.0]  # there the effect itself acts
    assert missing[-1] == "In place of smooth_friction@hinge model.xml adds 0.02 to the frictionloss of hinge."
    assert missing[-1] in path.read_text()


def test_what_dry_friction_cannot_stand_for_is_only_told(
    study: Study, effects: dict[str, Effect], tmp_path: Path
) -> None:
    path = tmp_path / "model.xml"
    _, (told,) = write_model(path, *with_effect(study, effects["sensor_time_offset"], offset=0.01))
    assert "cannot say" in told
    assert mujoco.MjModel.from_xml_path(str(path)).dof_frictionloss.tolist() == [0.0]


@pytest.mark.parametrize(("share", "filtered"), [(0.5, False), (10.0, True)])
def test_a_lag_of_more_than_a_step_is_a_filter_in_the_file(
    study: Study, effects: dict[str, Effect], tmp_path: Path, share: float, *, filtered: bool
) -> None:
    """It is at 1 − exp(−t/τ) up to a step ago after a step of the command."""
    step, path = study.compiled.opt.timestep, tmp_path / "model.xml"
    lag = effects["actuator_lag"]
    model = study.model.with_effect(place(lag, study.compiled, "drive", study.scales))
    _, missing = write_model(path, model, model.space.vector({"actuator_lag@drive.tau": share * step}))
    found = mujoco.MjModel.from_xml_path(str(path))
    assert (found.actuator_dyntype[0] == mujoco.mjtDyn.mjDYN_FILTEREXACT) == filtered
    assert any("filterexact" in each for each in missing) == filtered
    if filtered:
        data = mujoco.MjData(found)
        data.ctrl[0] = 1.0
        mujoco.mj_step(found, data, 20)
        assert 1 - np.exp(-18.9 / share) < data.act[0] <= 1 - np.exp(-20 / share)


@pytest.mark.parametrize(
    ("effect", "value", "far"), [("sensor_time_offset", 0.0, False), ("friction_drift", 0.3, True)]
)
def test_a_file_says_how_well_it_predicts_alone(
    study: Study, effects: dict[str, Effect], tmp_path: Path, effect: str, value: float, *, far: bool
) -> None:
    """The logs are the pendulum's own: the file of a friction that they lack is far off, and one of a sensor is not."""
    model, z = with_effect(study, effects[effect])
    z = z + value * (model.space.high - z) * np.array(["dry" in name for name in model.space.names])
    read_back, _ = write_model(tmp_path / "model.xml", model, z)
    told = file_note(study, tmp_path / "model.xml", read_back, 1.0).message
    chi2 = float(told.partition("χ² ")[2].partition(",")[0])
    assert "the model found 1." in told
    assert (chi2 > 2.0) == far
