"""A force that nobody catalogued, in an equation of motion that SciPy solves, is learned as the curve that it is."""

import numpy as np
import pytest
from diagnosis_machines import comparison_settings, measured, pendulum
from test_recovery_of_forces import log

from dr_lab.comparison.calibrated import calibrate
from dr_lab.comparison.comparison import Comparison
from dr_lab.comparison.lesson import lessons
from dr_lab.comparison.study import prepare
from dr_lab.physics.radial_basis import Seen
from dr_lab.trajectory import Array

DEPTH, PLACE, REACH = 0.05, 0.4, 0.15  # J, rad, rad: a magnet beside the path
FELT = 3.0 * REACH  # rad, beyond which the magnet pulls with less than 6 % of its largest force


def magnet(position: float, speed: float) -> float:
    del speed
    away = (position - PLACE) / REACH
    return -DEPTH / REACH * away * np.exp(-0.5 * away**2)


def quiet(position: float, speed: float) -> float:
    del position, speed
    return 0.0


def curve(position: Array) -> Array:
    return np.array([magnet(q, 0.0) for q in position])


@pytest.mark.slow
def test_the_learned_force_is_the_hidden_one() -> None:
    logs = [log(seed, magnet) for seed in range(5)]
    study = prepare(Comparison(pendulum(), measured(logs[:3], logs[3:]), comparison_settings()))
    base = calibrate(study)
    (lesson,) = lessons(study, base, lambda text: None)
    assert lesson.accepted
    assert lesson.removes > 0.8
    assert [each.quantity for each in lesson.force.basis.inputs] == ["angle"]
    position = np.linspace(PLACE - FELT, PLACE + FELT, 200)
    still = np.zeros((200, 1))
    force = lesson.force.of(study.compiled, Seen(position[:, None], still, still))
    truth = curve(position)
    assert np.sqrt(((force - truth) ** 2).mean()) < 0.2 * np.sqrt((truth**2).mean())
    values = lesson.fitted_model.values()
    assert values["rod.mass"] == pytest.approx(0.6, rel=0.03)


def test_where_nothing_is_missing_nothing_is_learned() -> None:
    logs = [log(seed, quiet) for seed in range(4)]
    study = prepare(Comparison(pendulum(), measured(logs[:3], logs[3:]), comparison_settings()))
    assert lessons(study, calibrate(study), lambda text: None) == ()


@pytest.mark.slow
def test_without_held_out_logs_that_could_judge_it_nothing_is_learned() -> None:
    study = prepare(Comparison(pendulum(), measured([log(seed, magnet) for seed in range(2)]), comparison_settings()))
    phases: list[str] = []
    assert lessons(study, calibrate(study), phases.append) == ()
    assert phases == []
