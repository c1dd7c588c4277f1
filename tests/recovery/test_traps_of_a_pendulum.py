"""Two effects that a fit of damping and dry friction hides well are still called by their names.

A pendulum under a position servo acts 30 ms late: fits of damping and friction to it come out tight and five times too
large. A pendulum's joint holds more at rest than it brakes in motion: Coulomb and viscous friction explain most of it.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnosis_machines import log_of, measured, model_of
from hydra.utils import instantiate
from omegaconf import DictConfig
from scipy.integrate import OdeSolution, solve_ivp

from dr_lab.cli.compose import compose
from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.study import Study, prepare
from dr_lab.diagnosis.evidence.bench import FittedModel, fit_and_score
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.verdict import Verdict, decide
from dr_lab.effects.catalogue import candidates
from dr_lab.effects.effect import place
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array, Log, MeasurementSet, Noise, Signal
from dr_lab.workflows.record import record

DELAY, SECONDS, HOLD = 0.030, 6.0, 0.4
KP, KV, MASS, LENGTH, INERTIA, DAMPING = 8.0, 0.3, 0.5, 0.3, 0.005, 0.05
POSITION_NOISE, VELOCITY_NOISE = 2e-3, 2e-2
SERVO = f"""<mujoco model="servo">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="RK4"/>
  <worldbody><body name="rod">
    <inertial mass="{MASS}" pos="0 0 -{LENGTH}" diaginertia="{INERTIA} {INERTIA} 0.001"/>
    <joint name="hinge" axis="0 1 0" damping="0.02" frictionloss="0.01"/>
  </body></worldbody>
  <actuator><position name="servo" joint="hinge" kp="{KP}" kv="{KV}"/></actuator>
</mujoco>"""
FREE = {
    "hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 1.0},
    "hinge.friction": {"target": "joint.hinge.frictionloss", "unit": "N·m", "low": 0.0, "high": 0.5},
}
RIVALS = (
    "effect=[actuator_delay,actuator_lag,viscous_friction,coulomb_friction,stribeck_friction,torque_scale,armature,"
    "spring,constant_offset,payload,sensor_time_offset]"
)


def servo(begin: float, end: float, state: Array, asked: float) -> OdeSolution:
    """I θ'' = kp (r − θ) − kv θ' − d θ' − m g l sin θ while the target r stays."""
    inertia, weight = INERTIA + MASS * LENGTH**2, MASS * 9.81 * LENGTH

    def slope(_: float, y: Array) -> list[float]:
        return [y[1], (KP * (asked - y[0]) - (KV + DAMPING) * y[1] - weight * np.sin(y[0])) / inertia]

    found = solve_ivp(slope, (begin, end), state, rtol=1e-10, atol=1e-12, dense_output=True).sol
    assert found is not None
    return found


def late(seed: int) -> Log:
    """A log of the servo whose target, new every 0.4 s, acts 30 ms after it was sent."""
    rng = np.random.default_rng(seed)
    target, edges = rng.uniform(-1.0, 1.0, round(SECONDS / HOLD)), np.arange(0.0, SECONDS, HOLD)
    time, state, rows = np.arange(0.0, SECONDS, 0.002), np.array([0.3, 0.0]), []
    acts = [0.0, *(edges[1:] + DELAY), SECONDS]
    for begin, end, asked in zip(acts[:-1], acts[1:], target, strict=True):
        motion = servo(begin, end, state, asked)
        rows.append(motion(time[(time >= begin) & (time < end)]).T)
        state = motion(end)
    position, velocity = (np.concatenate(rows) + rng.normal(size=(len(time), 2)) * [POSITION_NOISE, VELOCITY_NOISE]).T
    outputs = {"hinge.position": (time, position), "hinge.velocity": (time, velocity)}
    return log_of(f"log_{seed}", outputs, Signal("servo", "rad", edges, target))


def study_of(model: Model, measurements: MeasurementSet, cfg: DictConfig) -> Study:
    """Model and logs with the settings of a composed diagnosis."""
    return prepare(Comparison(model, measurements, instantiate(cfg.comparison.settings, _convert_="all", threads=1)))


def judged(study: Study, base: FittedModel, cfg: DictConfig) -> tuple[Verdict, Candidate]:
    """The verdict on the rivals beside a base, and the best of them."""
    effects = instantiate(cfg.effects, _convert_="all")
    placed = candidates(base.model, effects, study.scales, study.compiled).placed
    base, ranking, _ = rank(study.bench, base, placed, lambda _: None)
    return decide(base, ranking, study.bench.evidence), ranking[0]


@pytest.mark.slow
def test_a_late_command_is_no_damping() -> None:
    cfg = compose("diagnose", [RIVALS, "windows.length=0.5", "windows.seconds=5.0"])
    logs = [late(seed) for seed in range(3)]
    noise = {
        "hinge.position": Noise(POSITION_NOISE, "rad", "given"),
        "hinge.velocity": Noise(VELOCITY_NOISE, "rad/s", "given"),
    }
    study = study_of(model_of(SERVO, FREE), replace(measured(logs[:2], logs[2:]), noise=noise), cfg)
    base = calibrate(study)
    assert base.fit.z[study.model.space.index("hinge.damping")] > 2 * DAMPING  # the trap
    verdict, best = judged(study, base, cfg)
    assert (verdict.kind, verdict.effects) == ("named", ("actuator_delay@servo",)), verdict.reason
    values = best.fitted_model.model.space.mapping(best.fitted_model.fit.z)
    assert values["actuator_delay@servo.delay"] == pytest.approx(DELAY, rel=0.02)
    assert values["hinge.damping"] == pytest.approx(DAMPING, rel=0.15)
    assert best.fitted_model.held_out.chi2 < 1.1


@pytest.mark.slow
def test_stribeck_friction_is_not_passed_as_coulomb_and_viscous_friction(tmp_path: Path) -> None:
    hidden = ["plant/hidden=pendulum/stribeck_friction", "plant.hidden.speed=1.0"]
    gentle = ["plant.peaks=[1.5,1.2,1.4]", "plant.duration=4.0"]  # slow enough for the excess to matter
    record(instantiate(compose("record", ["plant=pendulum", *hidden, *gentle]).source), str(tmp_path), 0, tmp_path)
    logs = f"measurements.logs=[{tmp_path}/*.mcap]"
    split = ["measurements.fit=[log_1,log_2]", "measurements.held_out=[log_3]", "windows.seconds=4.8"]
    cfg = compose("diagnose", [RIVALS, "model=pendulum", "measurements=pendulum", logs, *split])
    plain = instantiate(cfg.model, _convert_="all")
    study = study_of(plain, instantiate(cfg.measurements, _convert_="all"), cfg)
    effects = instantiate(cfg.effects, _convert_="all")
    passed = plain
    for name in ("viscous_friction", "coulomb_friction"):
        passed = passed.with_effect(place(effects[name], study.compiled, "pendulum", study.scales))
    base = fit_and_score(study.bench, passed, passed.space.nominal)
    assert base.held_out.chi2 > 1.5
    verdict, best = judged(study, base, cfg)
    assert (verdict.kind, verdict.effects) == ("named", ("stribeck_friction@pendulum",)), verdict.reason
    assert best.fitted_model.held_out.chi2 - 1 < (base.held_out.chi2 - 1) / 2
