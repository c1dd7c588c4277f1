"""What a report says of where the model fails: only of what fails, by what is measured."""

import mujoco
import numpy as np
import pytest
from diagnosis_machines import log_of, pendulum, short_comparison, simulated, steps_command

from dr_lab.comparison.localised import failure
from dr_lab.comparison.study import prepare
from dr_lab.diagnosis.evidence.score import score_of
from dr_lab.reports.gap import Failure
from dr_lab.trajectory import Log, MeasurementSet, Noise

STD = {"hinge.position": 1e-3, "hinge.velocity": 1e-2}  # rad, rad/s
DEAF = {"hinge.position": 0.1, "hinge.velocity": 5.0}


def logs(std: dict[str, float], friction: float) -> MeasurementSet:
    """Two logs of a pendulum, the second held out, of which the channels with a noise are measured."""
    made = tuple(log(seed, std, friction) for seed in range(2))
    noise = {name: Noise(each, "", "given") for name, each in std.items()}
    return MeasurementSet("test", made[:1], made[1:], noise, dict.fromkeys(std, 0.1))


def log(seed: int, std: dict[str, float], friction: float) -> Log:
    def rub(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = -friction * np.tanh(data.qvel[0] / 0.02)

    command, rng = steps_command("drive", 1.0, 3.0, seed), np.random.default_rng(seed)
    motion = simulated(pendulum().nominal(), command, 3.0, qpos=[0.8], force=rub)
    read = {"hinge.position": motion["qpos"][:, 0], "hinge.velocity": motion["qvel"][:, 0]}
    noisy = {name: read[name] + each * rng.normal(size=len(motion["time"])) for name, each in std.items()}
    return log_of(f"log_{seed}", {name: (motion["time"], value) for name, value in noisy.items()}, command)


def found(measured: MeasurementSet) -> Failure:
    study = prepare(short_comparison(pendulum(), measured))
    z = study.model.space.nominal
    return failure(study, study.model, z, score_of(*study.fits(study.model, z, study.bench.held_out)))


def test_a_right_model_fails_nowhere() -> None:
    told = found(logs(STD, friction=0.0))
    assert told.where == ()
    assert len(told.horizons) > 0


@pytest.mark.parametrize("deaf", STD)
def test_a_channel_that_shows_nothing_but_noise_is_no_place_of_failure(deaf: str) -> None:
    told = found(logs(STD | {deaf: DEAF[deaf]}, friction=0.1))
    assert {region.signal for region in told.where} == {*STD} - {deaf}
