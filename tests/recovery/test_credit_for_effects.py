"""No effect gets credit for what the model below it could do: fits end converged, and are compared from there."""

from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from diagnosis_machines import evidence_settings, pendulum, solver_settings, swinging, windows_of
from effect_machines import catalogue_effect

from dr_lab.diagnosis.evidence.bench import Bench, fit_and_score
from dr_lab.diagnosis.fit.scales import machine_scales
from dr_lab.diagnosis.search.climb import Climb, climb
from dr_lab.diagnosis.search.climb_watch import Silence
from dr_lab.diagnosis.search.ladder import Ladder
from dr_lab.trajectory import Log

Force = Callable[[mujoco.MjData], None]
STIFFNESS, REST, LIMIT = 0.4, 0.2, 0.45  # N·m/rad, rad, N·m (commands reach 1 N·m)
OTHERS = ("constant_offset", "load_dependent_friction", "viscous_friction", "coulomb_friction")


def sprung(data: mujoco.MjData) -> None:
    """A spring with a rest position of its own."""
    data.qfrc_applied[0] = -STIFFNESS * (data.qpos[0] - REST)


def limited(data: mujoco.MjData) -> None:
    """A driver that gives no more than its limit."""
    data.ctrl[0] = np.clip(data.ctrl[0], -LIMIT, LIMIT)


def limited_and_sprung(data: mujoco.MjData) -> None:
    limited(data)
    sprung(data)


def logs_under(force: Force) -> list[Log]:
    return [swinging(f"log_{k}", pendulum().nominal(), k, force=force, seconds=3.0) for k in range(5)]


def climbed(force: Force, *names: str) -> tuple[Bench, Ladder]:
    model, logs = pendulum(), logs_under(force)
    bench = Bench(windows_of(model, logs[:3]), windows_of(model, logs[3:]), solver_settings(), evidence_settings(), 1)
    effects = {name: catalogue_effect(name) for name in (*names, *OTHERS)}
    base, compiled = fit_and_score(bench, model, model.space.nominal), model.nominal()
    scales = machine_scales(compiled, logs[:3], 0.03)
    scales.command["drive"] = 1.0  # pyright: ignore[reportIndexIssue]
    return bench, climb(Climb.begun(bench, base), effects, scales, compiled, most=3, watch=Silence())


@pytest.mark.slow
@pytest.mark.parametrize(
    ("force", "names", "found"),
    [
        (sprung, ("spring",), {"spring@hinge"}),
        (limited, ("saturation",), {"saturation@drive"}),
        (limited_and_sprung, ("spring", "saturation"), {"spring@hinge", "saturation@drive"}),
    ],
)
def test_an_effect_is_found_alone_and_no_other_moves_it_on(force: Force, names: tuple[str], found: set[str]) -> None:
    bench, ladder = climbed(force, *names)
    last = ladder.models[-1]
    assert {effect.label for effect in last.model.effects} == found
    assert last.held_out.chi2 == pytest.approx(1.0, abs=0.1)
    values = last.values()
    if "spring@hinge" in found:
        assert values["spring@hinge.stiffness"] == pytest.approx(STIFFNESS, rel=0.02)
        assert values["spring@hinge.reference"] == pytest.approx(REST, rel=0.03)
    if "saturation@drive" in found:
        assert 1 / values["saturation@drive.inverse_limit"] == pytest.approx(LIMIT, rel=0.01)
    # From where the last fit ended, the model without any one effect does not beat the rung below.
    for model, below in zip(ladder.models[1:], ladder.models[:-1], strict=True):
        start = np.array([model.values()[name] for name in below.model.space.names])
        again = fit_and_score(bench, below.model, start, model.fit.delta)
        assert below.fit.cost <= again.fit.cost * (1 + 10 * bench.solver.tolerance)
        assert model.fit.converged
