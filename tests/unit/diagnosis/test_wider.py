from dataclasses import replace

import numpy as np
import pytest
from diagnosis_machines import (
    evidence_settings,
    pendulum,
    simulated,
    solver_settings,
    steps_command,
    swinging,
    windows_of,
    windows_settings,
)
from diagnosis_machines import log_of as logged
from effect_machines import block, catalogue_effect, placed, scales_of

from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.search.rank import rank
from dr_lab.diagnosis.search.wider import reach, widened
from dr_lab.diagnosis.windows.windows import Windows
from dr_lab.effects.actuator_delay import ActuatorDelay
from dr_lab.effects.effect import PlacedEffect, place

LAG = 0.03  # s


def windows() -> Windows:
    return windows_of(pendulum(), [swinging("a", pendulum().nominal(), 0, seconds=1.5)])


def bounds(one: PlacedEffect | None) -> list[tuple[float, float]]:
    assert one is not None
    return [(p.low, p.high) for p in one.parameters]


def test_a_bound_that_a_fit_ran_into_is_twice_as_far_from_absent() -> None:
    one = placed(pendulum(), "constant_offset", "hinge")
    (low, high) = bounds(one)[0]
    assert bounds(widened(one, np.array([high]), windows())) == [(low, 2 * high)]
    assert bounds(widened(one, np.array([low]), windows())) == [(2 * low, high)]
    assert widened(one, np.array([0.9 * high]), windows()) is None


def test_absent_and_signs_stay() -> None:
    friction = placed(pendulum(), "coulomb_friction", "hinge")
    assert widened(friction, np.array([0.0]), windows()) is None
    scale = placed(block(), "torque_scale", "drive")
    assert bounds(widened(scale, np.array([0.5]), windows())) == [(0.25, 2.0)]
    assert bounds(widened(scale, np.array([2.0]), windows())) == [(0.5, 3.0)]


@pytest.mark.parametrize(
    ("name", "site", "values"),
    [
        ("asymmetric_friction", "hinge", [0.1, 1.0]),
        ("sensor_low_pass", "hinge", [0.005857]),
        ("end_stop", "hinge", None),
    ],
)
def test_physics_is_no_bound_that_moves(name: str, site: str, values: list[float] | None) -> None:
    one = placed(pendulum(), name, site)
    at = [p.low if p.low < p.nominal else p.high for p in one.parameters] if values is None else values
    assert widened(one, np.array(at), windows()) is None


@pytest.mark.parametrize("name", ["spring", "hardening_spring"])
def test_a_spring_may_rest_beyond_where_the_machine_moves(name: str) -> None:
    one = placed(pendulum(), name, "hinge")
    _, (low, high) = bounds(one)
    assert bounds(widened(one, np.array([0.01, high]), windows()))[1] == (low, 2 * high)


def test_a_delay_grows_as_far_as_commands_are_kept() -> None:
    one: PlacedEffect | None = placed(pendulum(), "actuator_delay", "drive")
    first, last = bounds(one)[0][1], 0.0
    while one is not None:
        last = bounds(one)[0][1]
        assert isinstance(one.effect, ActuatorDelay)
        assert one.effect.longest == last
        one = widened(one, np.array([last]), windows())
    assert first == 0.05
    assert last == pytest.approx(0.9 * windows_settings().kept, rel=0.02)


def test_the_reach_of_bounds_is_what_moving_them_gives() -> None:
    offset, lag = placed(pendulum(), "constant_offset", "hinge"), placed(pendulum(), "actuator_lag", "drive")
    for one, count in ((offset, 2), (lag, 2)):
        far: PlacedEffect | None = one
        for _ in range(count):
            assert far is not None
            far = widened(far, np.array([bounds(far)[0][1]]), windows())
        (low, high), (_, farthest) = bounds(one)[0], bounds(far)[0]
        assert reach(one, windows(), count)[1] == pytest.approx((farthest - high) / (high - low))
    assert reach(offset, windows(), 2)[0] == pytest.approx(reach(offset, windows(), 2)[1])
    assert reach(lag, windows(), 2)[0] == [0.0]
    assert reach(placed(pendulum(), "asymmetric_friction", "hinge"), windows(), 2)[1][1] == 0.0


def test_the_first_bounds_are_remembered() -> None:
    one = placed(pendulum(), "actuator_lag", "drive")
    twice = widened(one, np.array([0.012]), windows())
    assert twice is not None
    again = widened(twice, np.array([0.024]), windows())
    assert again is not None
    assert again.looked == (("actuator_lag@drive.tau", 0.0, 0.012),)
    assert bounds(again) == [(0.0, 0.048)]


@pytest.mark.slow
def test_a_slow_driver_is_found_beyond_where_one_looks_first() -> None:
    """A lag of 30 ms, by the exponential between the edges of its command."""
    logs = []
    for seed, name in enumerate("abcd"):
        command = steps_command("drive", 1.0, 3.0, seed)
        fine = np.arange(0.0, 3.0, 0.002)
        held = command.value[np.searchsorted(command.time, fine + 1e-9, side="right") - 1]
        level, rows = held[0], []
        for asked in held:
            end = asked + (level - asked) * np.exp(-0.002 / LAG)
            rows.append(asked + (level - asked) * LAG / 0.002 * (1 - np.exp(-0.002 / LAG)))
            level = end
        slow = replace(command, time=fine, value=np.array(rows))
        moved = simulated(pendulum().nominal(), slow, 3.0, qpos=[0.8])
        reading = moved["qpos"][:, 0] + 1e-3 * np.random.default_rng(seed).normal(size=len(moved["time"]))
        logs.append(logged(name, {"hinge.position": (moved["time"], reading)}, command))
    model = pendulum()
    bench = Bench(
        windows_of(model, logs[:2]), windows_of(model, logs[2:]), solver_settings(), evidence_settings(), threads=1
    )
    base = fit_and_score(bench, model, model.space.nominal)
    one = place(catalogue_effect("actuator_lag"), model.nominal(), "drive", scales_of(model))
    found = rank(bench, base, [one], lambda _: None).candidates[0]
    assert found.fitted_model.values()["actuator_lag@drive.tau"] == pytest.approx(LAG, rel=0.03)
    assert found.fitted_model.held_out.chi2 == pytest.approx(1.0, abs=0.1)
    delay = place(catalogue_effect("actuator_delay"), model.nominal(), "drive", scales_of(model))
    assert rank(bench, base, [delay, one], lambda _: None).candidates[0].effect.label == one.label
    stays = replace(bench, evidence=evidence_settings(widenings=0))
    held = rank(stays, base, [one], lambda _: None).candidates[0]
    assert held.fitted_model.values()["actuator_lag@drive.tau"] == pytest.approx(0.012, rel=0.01)


def test_friction_that_creeps_more_slowly_than_one_looks_first_may_but_not_faster() -> None:
    one = placed(pendulum(), "presliding_friction", "hinge")
    torque, way, creep, retardation = one.parameters
    slow = widened(one, np.array([0.5 * torque.high, way.nominal, creep.low, 0.0]), windows())
    assert bounds(slow)[2] == (creep.low / 2, creep.high)
    fast = np.array([0.5 * torque.high, way.high, creep.high, retardation.high])
    assert widened(one, fast, windows()) is None
