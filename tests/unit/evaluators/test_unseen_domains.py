"""Returns of a push F in drawn masses: x' grows by F h/m a step, so a return is h F/m · T (T + 1)/2."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import mujoco
import numpy as np
import pytest
import torch
from block_on_rail import BlockOnRail, constant
from torch import nn

from dr_lab.envs.setting import Setting
from dr_lab.envs.task import Change, Fields, Values
from dr_lab.errors import ConfigError
from dr_lab.evaluators.deployment import inference_seconds, parameter_bytes
from dr_lab.evaluators.evaluator import Evaluation, Row, Subject
from dr_lab.evaluators.unseen_domains import UnseenDomainsEvaluator
from dr_lab.physics.model import from_spec
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.trajectory import Array

STEP, STEPS = 0.01, 20
XML = f"""<mujoco model="block"><option timestep="{STEP}" integrator="Euler"/><worldbody><body name="block">
  <inertial mass="2" pos="0 0 0" diaginertia="1 1 1"/><joint name="rail" type="slide" axis="1 0 0"/>
</body></worldbody><actuator><motor name="drive" joint="rail" ctrlrange="-9 9"/></actuator></mujoco>"""
MASS = {"block.mass": {"target": "body.block.mass", "unit": "kg", "low": 0.5, "high": 4.0}}


class Push(BlockOnRail):
    """The mean velocity of every step is rewarded; starts differ in the velocity."""

    def start(self, rng: np.random.Generator, compiled: mujoco.MjModel) -> tuple[Array, Array]:
        return np.zeros(compiled.nq), rng.uniform(-1.0, 1.0, compiled.nv)

    def observe(self, fields: Fields, values: Values) -> Array:
        del values
        return fields["qvel"]

    def marker(self, fields: Fields) -> Array:
        return fields["qpos"].copy()

    def reward(self, change: Change) -> Array:
        return change.velocity[:, 0]


@pytest.fixture
def subject() -> Subject:
    model = from_spec("block", mujoco.MjSpec.from_string(XML), MASS)
    task = Push(frame_skip=1, time_limit=STEPS)
    setting = Setting(
        name="block", model=model, task=task, show_context=False, infeasible_return=0.0, speed_limit=200.0
    )
    trained_on = UniformRandomizer(setting.space, {"block.mass": [1.0, 2.0]})
    return Subject("pushed", setting, constant(1.0), cast(Any, None), threads=1, trained_on=trained_on)


def evaluator(**changes: Any) -> UnseenDomainsEvaluator:  # noqa: ANN401
    given = {"distribution": None, "domains": 6, "starts": 5, "parallel": 4, "calls": 3, "seed": 0}
    return UnseenDomainsEvaluator(**(given | changes))


def domains(found: Evaluation) -> list[Row]:
    """In the order in which they were drawn."""
    assert found.summary is not None
    assert found.summary.file == "domains.csv"
    return sorted(found.summary.rows, key=lambda row: (row["domains"] == "teachers", row["domain"]))


def test_returns_are_those_of_the_drawn_domains_and_starts_differ(subject: Subject, tmp_path: Path) -> None:
    found = evaluator().evaluate(subject, tmp_path, print)
    masses = np.array([float(row["block.mass"]) for row in domains(found)])
    assert len(set(masses.tolist())) == 6
    assert ((masses > 1.0) & (masses < 2.0)).all()
    pushed = STEP / masses * STEPS * (STEPS + 1) / 2
    begun = np.array([[row["return"] for row in found.rows if row["domain"] == k] for k in range(6)]) - pushed[:, None]
    assert begun.shape == (6, 5)
    assert np.abs(begun).max() <= STEPS  # what a start of up to 1 m/s adds
    assert len(np.unique(begun.round(6))) == 30
    assert found.summary is not None
    medians = [float(row["median"]) for row in found.summary.rows]
    assert medians == sorted(medians)  # the worst domain first
    assert found.units == {"block.mass": "kg"}
    assert list(found.summary.on_page()[0]) == [*found.summary.rows[0]]
    assert found.summary._replace(shown=["median"]).on_page() == [{"median": median} for median in medians]
    every = np.sort([float(row["return"]) for row in found.rows])
    assert [row["return"] for row in found.rows] == every.tolist()
    assert found.figures["unseen.median"] == np.median(every)
    assert found.figures["unseen.lower_quartile"] == np.quantile(every, 0.25)
    assert found.figures["unseen.infeasible"] == 0.0
    assert [sample.name for sample in found.samples] == ["unseen"]
    np.testing.assert_array_equal(np.sort(found.samples[0].value), every)


def test_policies_meet_the_same_domains_from_the_same_starts(subject: Subject, tmp_path: Path) -> None:
    one, other = (
        evaluator().evaluate(replace(subject, policy=constant(force)), tmp_path, print) for force in (1.0, 3.0)
    )
    masses = np.array([float(row["block.mass"]) for row in domains(one)])
    place = lambda row: (row["domain"], row["start"])  # noqa: E731
    gained = [
        float(b["return"]) - float(a["return"])
        for a, b in zip(sorted(one.rows, key=place), sorted(other.rows, key=place), strict=True)
    ]
    expected = np.repeat(2.0 * STEP / masses * STEPS * (STEPS + 1) / 2, 5)
    np.testing.assert_allclose(gained, expected, rtol=1e-9)
    assert "the same for every policy that is played with evaluator.seed=0 and evaluator.parallel=" in one.told


def test_another_number_side_by_side_draws_other_starts_in_the_same_domains(subject: Subject, tmp_path: Path) -> None:
    few, many = (evaluator(parallel=parallel).evaluate(subject, tmp_path, print) for parallel in (3, 50))
    masses = [sorted(float(row["block.mass"]) for row in domains(found)) for found in (few, many)]
    assert masses[0] == masses[1]
    assert {row["return"] for row in few.rows} != {row["return"] for row in many.rows}


def test_domains_that_were_trained_on_stand_beside_unseen_ones(subject: Subject, tmp_path: Path) -> None:
    taught = replace(subject, domains=np.array([[4.0], [0.5]]))
    found = evaluator(starts=400, parallel=100).evaluate(taught, tmp_path, print)
    teachers = [row for row in domains(found) if row["domains"] == "teachers"]
    assert [float(row["block.mass"]) for row in teachers] == [4.0, 0.5]
    medians = [float(row["median"]) for row in teachers]
    np.testing.assert_allclose(medians, STEP / np.array([4.0, 0.5]) * STEPS * (STEPS + 1) / 2, atol=2.0)
    assert {violin.name: len(violin.value) for violin in found.samples} == {"unseen": 2400, "teachers": 800}
    assert "teachers.median" in found.figures
    assert "teachers" in found.told


def test_another_distribution_may_be_asked_for(subject: Subject, tmp_path: Path) -> None:
    near = partial(UniformRandomizer, ranges={"block.mass": [3.0, 3.1]})
    found = evaluator(distribution=near).evaluate(subject, tmp_path, print)
    assert all(3.0 < float(row["block.mass"]) < 3.1 for row in domains(found))


def test_memory_is_that_of_the_parameters_and_time_is_the_median_of_calls() -> None:
    network = nn.Linear(7, 2)
    assert parameter_bytes(network) == parameter_bytes(network.forward) == 4.0 * (7 * 2 + 2)
    assert np.isnan(parameter_bytes(constant(1.0)))
    assert 0.0 < inference_seconds(network, torch.zeros(1, 7), 20) < 0.1


def test_no_domain_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"evaluator\.domains is 0; expected at least 1"):
        evaluator(domains=0)
