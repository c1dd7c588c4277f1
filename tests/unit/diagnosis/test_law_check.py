"""Laws of named effects against free laws of the same argument, on machines whose law is known."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import cast

import mujoco
import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect, hanging

from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.fit.scales import machine_scales
from dr_lab.diagnosis.search.candidate import Candidate
from dr_lab.diagnosis.search.free_inertia import free_inertia
from dr_lab.diagnosis.search.free_law import curve
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.diagnosis.search.law_check import LawCheck, check_laws
from dr_lab.diagnosis.search.step import AddedEffect
from dr_lab.effects.effect import place

WIDTH = 0.3  # N·m, of the dead zone; the command goes up to 1 N·m


def squared(u: float) -> float:
    return abs(u) * u


def dead(u: float) -> float:
    return float(np.sign(u) * max(abs(u) - WIDTH, 0.0))


def plain(u: float) -> float:
    return u


@cache
def judged(
    effect: str, site: str, made: Callable[[float], float], creep: float = 0.0, unmodelled: float = 0.0
) -> tuple[Ladder, tuple[LawCheck, ...], Bench]:
    """A pendulum whose motor makes `made` of its command, diagnosed with one effect.

    Its joint has tanh friction that creeps at speeds of about `creep` in rad/s, and a force that belongs to no effect
    shakes it.
    """

    def push(data: mujoco.MjData) -> None:
        u, v, t = float(data.ctrl[0]), float(data.qvel[0]), float(data.time)
        friction = 0.1 * np.tanh(v / creep) if creep else 0.0
        data.qfrc_applied[0] = made(u) - u - friction + unmodelled * np.sin(9 * t + 0.5 * t**2)

    logs = [swinging(f"log_{k}", pendulum().nominal(), k, force=push, seconds=4.0) for k in range(3)]
    model = pendulum()
    compiled, scales = model.nominal(), machine_scales(model.nominal(), logs[:2], 0.03)
    windows = windows_of(model, logs[:2]), windows_of(model, logs[2:])
    bench = Bench(*windows, solver_settings(), evidence_settings(), 1)
    base = fit_and_score(bench, model, model.space.nominal)
    placed = place(catalogue_effect(effect), compiled, site, scales)
    starts = [base.values() | dict(start) for start in ({}, *placed.starts)]
    extended = base.model.with_effect(placed)
    fitted = (fit_and_score(bench, extended, extended.space.vector(start), base.fit.delta) for start in starts)
    step = AddedEffect(min(fitted, key=lambda each: each.fit.order), ())
    return Ladder((), base, (step,)), check_laws(bench, (step,), scales, compiled), bench


def test_a_squared_command_is_no_dead_zone() -> None:
    ladder, (law,), bench = judged("dead_zone", "drive", squared)
    assert law.refuted
    assert law.gain.gap > 0.9
    assert "dead_zone@drive is the nearest of the catalogue, but its law is not the machine's" in law.sentence
    assert ladder.models[0].held_out.chi2 > 4 * ladder.models[1].held_out.chi2 > 4.0
    named = Ladder(ladder.rungs, ladder.base, ladder.steps)
    assert named.verdict(bench.evidence) == "named"
    assert Ladder(ladder.rungs, ladder.base, ladder.steps, laws=(law,)).verdict(bench.evidence) == "unexplained"


@pytest.mark.slow
def test_a_law_that_leaves_noise_alone_is_not_checked() -> None:
    ladder, laws, _ = judged("dead_zone", "drive", dead)
    assert laws == ()
    assert ladder.models[1].values()["dead_zone@drive.width"] == pytest.approx(WIDTH, rel=0.02)


@pytest.mark.slow
def test_a_dead_zone_stays_beside_what_is_no_function_of_the_command() -> None:
    ladder, (law,), _ = judged("dead_zone", "drive", dead, unmodelled=0.05)
    assert ladder.models[1].held_out.chi2 > 2.0
    assert not law.refuted
    assert law.gain.gap < 0.3


@pytest.mark.parametrize(("truth", "refuted"), [(squared, True), pytest.param(dead, False, marks=pytest.mark.slow)])
def test_equals_are_refuted_together_or_not_at_all(truth: Callable[[float], float], refuted: bool) -> None:
    """Under a squared command a dead zone and a weak motor are; under a dead zone a power law and itself are not."""
    effects = ("dead_zone", "torque_scale") if refuted else ("command_power", "dead_zone")
    (first, _, bench), (second, *_) = (judged(name, "drive", truth) for name in effects)
    step, other = first.steps[0], second.steps[0]
    rival = cast(Candidate, SimpleNamespace(effect=other.effect, fitted_model=other.fitted_model))
    compiled = pendulum().nominal()
    logs = [swinging(f"log_{k}", compiled, k, force=lambda _: None, seconds=4.0) for k in range(2)]
    scales = machine_scales(compiled, logs, 0.03)  # a command's size does not depend on what the motor makes of it
    (law,) = check_laws(bench, (replace(step, rivals=(rival,)),), scales, compiled)
    assert law.refuted == refuted
    assert law.gain.gap > 0.7  # beside the first one a free curve explains much, whatever the truth is


def test_friction_that_creeps_is_friction() -> None:
    ladder, laws, bench = judged("coulomb_friction", "hinge", plain, creep=1.0)
    assert ladder.models[1].held_out.chi2 > 1.5
    assert laws == ()
    assert ladder.verdict(bench.evidence) == "named"


def test_ten_free_parameters_hold_a_load_at_any_place() -> None:
    model, mass, where = hanging(), 0.2, np.array([0.05, 0.1, -0.2])
    free = free_inertia("rod", model.nominal())
    assert len(free.own) == 10
    names = [p.name.removeprefix("free_inertia@rod.rod.") for p in free.own]
    at = dict(zip("xyz", where, strict=True))
    moments = {axis: mass * at[axis] for axis in "xyz"}
    squares = {a + b: mass * at[a] * at[b] for a, b in ("xx", "yy", "zz", "xy", "xz", "yz")}
    change = {"mass": mass} | {f"moment_{k}": v for k, v in (moments | squares).items()}
    spec = model.spec.copy()
    free.edit(spec, free.site, {p.name: float(change[name]) for p, name in zip(free.own, names, strict=True)})
    loaded = model.spec.copy()
    body = loaded.body("rod").add_body(pos=where)
    body.explicitinertial, body.mass, body.ipos, body.inertia = True, mass, np.zeros(3), np.zeros(3)
    found, known = _forces(spec.compile()), _forces(loaded.compile())
    np.testing.assert_allclose(found, known, rtol=1e-9)


def _forces(compiled: mujoco.MjModel) -> np.ndarray:
    """Torque that holds an accelerated pendulum."""
    data = mujoco.MjData(compiled)
    data.qpos[0], data.qvel[0], data.qacc[0] = 0.7, 2.0, 3.0
    mujoco.mj_inverse(compiled, data)
    return data.qfrc_inverse.copy()


def test_a_curve_is_linear_between_its_knots_and_held_beyond() -> None:
    values = np.array([[0.0, 1.0], [2.0, 1.0], [0.0, 3.0]])
    found = curve(np.array([[-5.0, 0.25], [1.5, 9.0]]), np.array([0.0, 1.0, 2.0]), values)
    np.testing.assert_allclose(found, [[0.0, 0.5], [2.0, 3.0]])
