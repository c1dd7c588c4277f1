"""An effect whose value a linear test finds compatible with absent, as what would replace it is out of bounds."""

from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import (
    PENDULUM,
    PENDULUM_PARAMETERS,
    evidence_settings,
    log_of,
    model_of,
    simulated,
    solver_settings,
    steps_command,
    swinging,
    windows_of,
)
from effect_machines import placed, scales_of

from dr_lab.diagnosis.checks.numerical_floor import in_parts
from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.evidence.compatible import chance_within, known_of
from dr_lab.diagnosis.evidence.noise_floor import at_floor
from dr_lab.diagnosis.search.deletions import Deletions
from dr_lab.diagnosis.search.pruning import drop_absent
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.trajectory import Log

NOISE, EXCESS = 0.02, 0.08  # rad/s, 1
WHEEL = """<mujoco model="wheel"><compiler angle="radian"/>
  <option timestep="0.002" integrator="implicitfast" gravity="0 0 0"/>
  <worldbody><body name="rod"><inertial mass="1" pos="0 0 0" diaginertia=".02 .02 .02"/>
    <joint name="hinge" axis="0 1 0" damping="0.001"/></body></worldbody>
  <actuator><general name="drive" joint="hinge" biastype="affine" biasprm="0 0 -0.05"/></actuator></mujoco>"""
FREE = {
    "inertia": {"target": "body.rod.inertia[1]", "unit": "kg·m²", "low": 0.012, "high": 0.04},
    "damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 0.05},
}


def log(seed: int) -> Log:
    """The speed of a motor with back-EMF, by a tachometer that reads too much."""
    command = steps_command("drive", 1.0, 6.0, seed, period=0.5)
    command = replace(command, value=command.value + 0.8)
    motion = simulated(model_of(WHEEL).nominal(), command, 6.0)
    noise = NOISE * np.random.default_rng(seed).normal(size=len(motion["time"]))
    read = (1 + EXCESS) * motion["qvel"][:, 0] + noise
    return log_of(f"log_{seed}", {"hinge.velocity": (motion["time"], read)}, command)


def test_an_effect_stays_that_others_replace_beyond_their_bounds_alone() -> None:
    """Inertia, damping and the tachometer's scale trade; only a damping below 0 would do without the scale."""
    model = model_of(WHEEL, FREE)
    scale = placed(model, "sensor_scale", "hinge", scales_of(model))
    richer = model.with_effect(scale)
    fit, held_out = windows_of(model, [log(0), log(1)], noise=NOISE), windows_of(model, [log(2)], noise=NOISE)
    bench = Bench(fit, held_out, solver_settings(), evidence_settings(), threads=1)
    base = fit_and_score(bench, model, model.space.nominal)
    whole = fit_and_score(bench, richer, richer.space.nominal)
    assert at_floor(whole.held_out, bench.evidence)
    assert not at_floor(base.held_out, bench.evidence)
    kept, dropped = drop_absent(Deletions(bench), base, (AddedEffect(whole, ()),))
    assert [step.effect.label for step in kept] == [scale.label]
    assert dropped == ()


@pytest.mark.parametrize(("late", "stays"), [(0.0, False), (0.01, True)])
def test_an_effect_that_makes_up_for_the_time_step_goes(late: float, stays: bool) -> None:
    """The logs, by steps a sixteenth as long, ask for an offset in time beyond doubt, which is half a step's."""
    model = model_of(PENDULUM.replace("RK4", "Euler"), {"rod.mass": PENDULUM_PARAMETERS["rod.mass"]})
    machine = in_parts(model, 16).nominal()
    logs = [_late(swinging(f"log_{seed}", machine, seed, noise=1e-5), late) for seed in (0, 1, 2)]
    fit, held_out = (windows_of(model, part, noise=1e-5) for part in (logs[:2], logs[2:]))
    bench = Bench(fit, held_out, solver_settings(), evidence_settings(), threads=1)
    offset = placed(model, "sensor_time_offset", "hinge", scales_of(model))
    richer = model.with_effect(offset)
    base, whole = (fit_and_score(bench, each, each.space.nominal) for each in (model, richer))
    assert whole.held_out.chi2 < base.held_out.chi2 / 100
    assert chance_within(known_of(bench, whole), offset.absent) < 1e-6
    kept, _ = drop_absent(Deletions(bench), base, (AddedEffect(whole, ()),))
    assert bool(kept) == stays


def _late(log: Log, seconds: float) -> Log:
    return replace(log, outputs={n: replace(each, time=each.time + seconds) for n, each in log.outputs.items()})
