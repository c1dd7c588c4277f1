"""A load that some logs were recorded with: beside the others it is told from the link, of which all is free."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import mujoco
import numpy as np
import pytest
from diagnosis_machines import PENDULUM, evidence_settings, solver_settings, swinging, windows_of
from effect_machines import NAMES, catalogue_effect, placed

from dr_lab.comparison.notes import shared_loads
from dr_lab.diagnosis.evidence.bench import Bench, fitted
from dr_lab.diagnosis.fit.covariance import estimate
from dr_lab.diagnosis.fit.replay import Replay
from dr_lab.physics.effect_parts import CommandFilter, SensorTransform
from dr_lab.physics.model import Model, from_spec

HEAVIER = PENDULUM.replace('mass="0.5" pos="0 0 -0.3"', 'mass="0.58" pos="0 0 -0.29"')
MASS, DISTANCE = 0.2, 0.4
LABEL = "payload@rod"


def compiled(*, loaded: bool) -> mujoco.MjModel:
    spec = mujoco.MjSpec.from_string(HEAVIER)
    if loaded:
        load = spec.body("rod").add_body(pos=[0, 0, -DISTANCE])
        load.explicitinertial, load.mass, load.ipos, load.inertia = True, MASS, np.zeros(3), np.zeros(3)
    return spec.compile()


def model() -> Model:
    machine = from_spec("pendulum", mujoco.MjSpec.from_string(PENDULUM), "inertial")
    return machine.with_effect(placed(machine, "payload", "rod"))


def bench(*, told: bool) -> Bench:
    logs = [swinging(f"log_{seed}", compiled(loaded=seed > 2), seed) for seed in (1, 2, 3, 4)]
    if told:
        logs = [replace(log, loaded=seed > 2) for seed, log in enumerate(logs, 1)]
    windows = windows_of(model(), logs)
    return Bench(windows, windows, solver_settings(), evidence_settings(), 1)


@pytest.mark.slow
def test_the_load_is_told_by_what_differs_between_the_logs() -> None:
    one, machine = bench(told=True), model()
    start = machine.space.vector({f"{LABEL}.mass": 0.1})
    fit = fitted(one, machine, start)
    known = estimate(machine.space, fit, one.fit, one.evidence)
    values, std = machine.space.mapping(fit.z), dict(zip(machine.space.names, known.std, strict=True))
    assert fit.converged or fit.over
    assert (fit.residuals[Replay(machine, one.fit, 1).fitted] ** 2).mean() < 1.1
    assert values[f"{LABEL}.mass"] == pytest.approx(MASS, rel=0.05)
    assert values[f"{LABEL}.distance"] == pytest.approx(DISTANCE, rel=0.05)
    assert abs(values[f"{LABEL}.mass"] - MASS) < 4 * std[f"{LABEL}.mass"]


def test_where_that_is_not_told_it_acts_in_all_logs() -> None:
    machine, z = model(), model().space.vector({f"{LABEL}.mass": 0.2})
    for told, expected in ((False, [True] * 4), (True, [False, False, True, True])):
        windows = bench(told=told).fit
        replay = Replay(machine, windows, 1)
        delta = np.zeros((1, len(windows), replay.nstate))
        moved = replay.residuals(z[None], delta)[0] - replay.residuals(machine.space.nominal[None], delta)[0]
        acts = [bool(np.abs(moved[0, windows.log == k]).max() > 1e-6) for k in range(4)]
        assert acts == expected


def test_what_is_looked_at_first_holds_a_load_that_one_log_had() -> None:
    one = bench(told=True)
    windows = replace(one.fit, loaded=one.fit.log == 1)
    few = replace(one, fit=windows, evidence=evidence_settings(screen_windows=2, screen_seconds=1e-3))
    assert sorted(windows.loaded[few.screened()].tolist()) == [False, True]


def test_a_load_that_no_log_tells_from_its_link_is_said_to_be() -> None:
    plain = from_spec("pendulum", mujoco.MjSpec.from_string(PENDULUM), {})
    known = plain.with_effect(placed(plain, "payload", "rod"))
    more = "</body><body name='other'><joint/><geom size='.1'/></body></worldbody>"
    link = PENDULUM.replace("</body></worldbody>", more)
    other = from_spec("two", mujoco.MjSpec.from_string(link), {"inertial": ["other"]})
    other = other.with_effect(placed(other, "payload", "rod"))
    cases = ((model(), False, ["shared_load"]), (model(), True, []), (known, False, []), (other, False, []))
    for machine, told, expected in cases:
        last = SimpleNamespace(model=machine)
        assert [note.kind for note in shared_loads(bench(told=told), cast(Any, last))] == expected


def test_what_is_attached_acts_on_the_machine_itself() -> None:
    """Commands and readings are transformed alike in all windows."""
    attached = [effect for effect in map(catalogue_effect, NAMES) if effect.attached]
    assert {effect.name for effect in attached} == {"payload", "planar_payload", "rigid_payload"}
    assert not any(isinstance(effect, CommandFilter | SensorTransform) for effect in attached)
