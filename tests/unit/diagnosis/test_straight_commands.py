"""Commands that changed between their samples are suspected by the motion, those that held are not."""

from dataclasses import replace

import mujoco
import numpy as np

from dr_lab.diagnosis.faults.drive_fit import forces_of
from dr_lab.diagnosis.faults.straight_commands import may_follow_lines
from dr_lab.physics.model import from_spec
from dr_lab.trajectory import Array, Log, MeasurementSet, Signal
from tests.diagnosis_machines import PENDULUM, clock, fault_settings, log_of, measured, pendulum, simulated

EVERY = 5  # steps of 2 ms


def log(held: bool, seed: int, every: int = EVERY, between: str = "") -> Log:
    """A pendulum under waves, sent at every step or as often as they are logged."""
    time, rng = clock(2000), np.random.default_rng(seed)
    waves = 0.6 * np.sin(9 * time + rng.uniform(0, 6)) + 0.5 * np.sin(25 * time + rng.uniform(0, 6))
    sent: Array = np.repeat(waves[::every], every) if held else waves
    motion = simulated(pendulum().nominal(), Signal("drive", "N·m", time, sent), 4.0, qpos=[0.5])
    reading = motion["qpos"][:, 0] + 1e-4 * rng.standard_normal(len(motion["time"]))
    logged = Signal("drive", "N·m", time[::every], sent[::every], between=between)
    return log_of(f"log_{seed}", {"hinge.position": (motion["time"][::2], reading[::2])}, logged)


def suspected(logs: MeasurementSet) -> tuple[str, ...]:
    return may_follow_lines(forces_of(pendulum(), logs, fault_settings()), logs, fault_settings())


def test_commands_that_changed_between_their_samples_are_suspected() -> None:
    assert suspected(measured([log(held=False, seed=1), log(held=False, seed=2)], noise=1e-4)) == ("drive",)


def test_commands_that_held_are_not() -> None:
    assert suspected(measured([log(held=True, seed=1), log(held=True, seed=2)], noise=1e-4)) == ()


def test_what_the_measurements_say_is_not_asked() -> None:
    assert suspected(measured([log(held=False, seed=1, between="hold")], noise=1e-4)) == ()


def test_what_the_model_s_step_hides_is_not_asked() -> None:
    assert suspected(measured([log(held=False, seed=1, every=2)], noise=1e-4)) == ()


def test_of_machines_that_cannot_be_tested_coarse_commands_are_suspected() -> None:
    logs = [log(held=True, seed=1, every=every) for every in (10, 5)]
    coarse, fine = (measured([each], noise=1e-4) for each in logs)
    assert may_follow_lines(None, coarse, fault_settings()) == ("drive",)
    assert may_follow_lines(None, fine, fault_settings()) == ()
    said = measured([log(held=True, seed=1, every=10, between="hold")], noise=1e-4)
    assert may_follow_lines(None, said, fault_settings()) == ()
    silent = measured([replace(logs[0], commands={})], noise=1e-4)
    assert suspected(silent) == ()


def test_coarse_commands_are_asked_however_long_the_model_s_steps_are() -> None:
    """Two steps of 10 ms apart, they are not rare to the model."""
    spec = mujoco.MjSpec.from_string(PENDULUM)
    spec.option.timestep = 0.01
    slow, logs = (
        from_spec("pendulum", spec, {}),
        measured([log(held=False, seed=s, every=10) for s in (1, 2)], noise=1e-4),
    )
    assert may_follow_lines(forces_of(slow, logs, fault_settings()), logs, fault_settings()) == ("drive",)
