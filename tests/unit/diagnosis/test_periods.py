from collections.abc import Callable
from dataclasses import replace

import mujoco
import numpy as np
import pytest
from diagnosis_machines import (
    NOISE,
    evidence_settings,
    log_of,
    model_of,
    pendulum,
    simulated,
    solver_settings,
    steps_command,
    swinging,
    windows_of,
)
from effect_machines import catalogue_effect, scales_of

from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.search.periods import with_periods
from dr_lab.effects.cogging import Cogging
from dr_lab.effects.effect import Effect, PlacedEffect, place
from dr_lab.physics.model import Model
from dr_lab.trajectory import Log

PITCH = 0.024  # m
AXIS = """<mujoco model="axis"><compiler angle="radian"/><option timestep="0.002" gravity="0 0 0"/>
  <worldbody><body name="slider"><inertial mass="1.5" pos="0 0 0" diaginertia="1 1 1"/>
    <joint name="rail" type="slide" axis="1 0 0" damping="3"/></body></worldbody>
  <actuator><motor name="drive" joint="rail" gear="10"/></actuator>
</mujoco>"""


def ripple(periods: float, amplitude: float) -> Callable[[mujoco.MjData], None]:
    """A cosine of the position, held through each step."""

    def force(data: mujoco.MjData) -> None:
        data.qfrc_applied[0] = amplitude * np.cos(periods * data.qpos[0])

    return force


def begun(model: Model, logs: list[Log], effect: Effect, site: str, noise: float = NOISE) -> PlacedEffect:
    """The effect after the search beside the calibrated model."""
    windows = windows_of(model, logs, noise=noise)
    bench = Bench(windows, windows, solver_settings(), evidence_settings(), threads=1)
    base = fit_and_score(bench, model, model.space.nominal)
    scales = scales_of(model, torque=1.0, position=2.0, speed=1.0)
    one = place(effect, model.nominal(), site, scales)
    return with_periods(bench, model, base.fit, [one])[0]


@pytest.mark.parametrize("periods", [4, 9, 31])
def test_a_motors_teeth_are_counted(periods: int) -> None:
    model = pendulum()
    logs = [swinging(name, model.nominal(), seed, force=ripple(periods, 0.1)) for seed, name in enumerate("ab")]
    found = begun(model, logs, catalogue_effect("cogging"), "hinge").starts[0]
    assert found["cogging@hinge.periods"] == periods
    assert found["cogging@hinge.cosine"] == pytest.approx(0.1, rel=0.15)
    assert abs(found["cogging@hinge.sine"]) < 0.02


def test_the_pitch_of_a_linear_motor_is_measured() -> None:
    model = model_of(AXIS)
    logs = []
    for seed, name in enumerate("ab"):
        command = steps_command("drive", 1.0, 3.0, seed)
        moved = simulated(model.nominal(), command, 3.0, force=ripple(2 * np.pi / PITCH, 2.0))
        reading = moved["qpos"][:, 0] + 1e-4 * np.random.default_rng(seed).normal(size=len(moved["time"]))
        logs.append(log_of(name, {"rail.position": (moved["time"], reading)}, command))
    found = begun(model, logs, catalogue_effect("cogging"), "rail", noise=1e-4).starts[0]
    assert 2 * np.pi / found["cogging@rail.periods"] == pytest.approx(PITCH, rel=0.01)


def test_a_disc_behind_a_gear_is_told_from_one_at_the_joint() -> None:
    model = pendulum()
    for turns in (1, 3):
        logs = []
        for seed, name in enumerate("ab"):
            clean = swinging(name, model.nominal(), seed, noise=0.0)
            angle = clean.outputs["hinge.position"]
            wrong = angle.value + 0.02 * np.sin(turns * angle.value)
            wrong += NOISE * np.random.default_rng(seed).normal(size=len(wrong))
            logs.append(replace(clean, outputs={"hinge.position": replace(angle, value=wrong)}))
        found = begun(model, logs, catalogue_effect("encoder_eccentricity"), "hinge").starts[0]
        assert found["encoder_eccentricity@hinge.periods"] == turns
        assert (
            0.01 * turns < found["encoder_eccentricity@hinge.sine"] < 0.025 * turns
        )  # the fitted motion follows a part of it


def test_what_the_user_gives_is_kept() -> None:
    model = pendulum()
    logs = [swinging("a", model.nominal(), 0, force=ripple(9, 0.1))]
    found = catalogue_effect("cogging")
    assert isinstance(found, Cogging)
    one = begun(model, logs, replace(found, periods=7.0), "hinge")
    assert not one.starts
    assert [p.name for p in one.parameters] == ["cogging@hinge.sine", "cogging@hinge.cosine"]
    spring = begun(model, logs, catalogue_effect("spring"), "hinge")
    assert len(spring.starts) == 2
