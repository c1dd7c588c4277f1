"""A policy on a plant does what it does in a model that knows all of the plant, and else in one that does not."""

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import pytest
from effect_machines import catalogue_effect, placed
from hydra.utils import instantiate
from settings import setting
from tensordict import TensorDict
from torch import Tensor

from dr_lab.cli.compose import compose
from dr_lab.comparison.export import write_context
from dr_lab.effects.from_run import from_run
from dr_lab.envs.setting import Setting
from dr_lab.errors import ConfigError
from dr_lab.evaluators import real_vs_sim
from dr_lab.evaluators.evaluator import Evaluation, Subject
from dr_lab.evaluators.real_vs_sim import RealVsSimEvaluator
from dr_lab.physics.context import ContextEstimate
from dr_lab.physics.model import Model
from dr_lab.plants.rig import Rig
from dr_lab.recorders.episode import Episode
from dr_lab.targets.model import ModelTarget
from dr_lab.targets.plant import PlantTarget
from dr_lab.targets.target import Target
from dr_lab.training.recorded import as_episode, record

STEPS = 40


def bench(plant: str, *overrides: str) -> Rig:
    return instantiate(compose("record", [f"plant={plant}", *overrides]).source).plant


def wave(observation: Tensor) -> Tensor:
    """A feedback that moves arm and pole, and saturates at times."""
    return 6.0 * observation[:, :1] - 0.5 * observation[:, 4:5] - 0.2 * observation[:, 5:6] + 1.5


def subject(start: str = "[0.0,0.0]") -> Subject:
    begin = [f"env.task.start_position={start}", "env.task.start_velocity=[0.0,0.0]"]
    found: Setting = setting("furuta", f"env.task.time_limit={STEPS}", "env/reward=furuta/shared", *begin)
    return Subject("wave", found, wave, lambda *_: pytest.fail("no training is asked for"))


def evaluated(plant: Rig, of: Subject, episodes: int = 1) -> Evaluation:
    target = partial(PlantTarget, plant=plant, machine=0, seed=0)
    evaluator = RealVsSimEvaluator(target=target, episodes=episodes, confidence=0.9, resamples=50, seed=0)
    found = evaluator.evaluate(of, Path(), lambda _: None)
    assert len(found.rows) == episodes
    assert [each.name[:5] for each in found.episodes] == ["real_", "simul"]
    assert found.told.startswith("What is called real is no hardware but a machine by another simulator")
    assert "solved" not in found.told  # the task names no such thing
    return found


def model_of_a_run(folder: Path) -> Model:
    """The documented machine with the plant's friction, as a run that found it leaves it behind."""
    plain = setting("furuta").model
    with_friction = plain.with_effect(placed(plain, "coulomb_friction", "arm"))
    truth = with_friction.space.vector({"coulomb_friction@arm.torque": 2.0e-3})
    write_context(folder / "context.yaml", ContextEstimate(with_friction.space, truth, 1e-12 * np.eye(len(truth))))
    return from_run(str(folder), plain, {"coulomb_friction": catalogue_effect("coulomb_friction")})


def test_a_gap_shows_and_the_model_of_a_run_closes_it(tmp_path: Path) -> None:
    documented = bench("furuta", "plant.nominal.spread=0.0")
    braked = bench("furuta", "plant.nominal.spread=0.0", "plant/hidden=furuta/coulomb_friction_arm")
    plain = subject()
    informed = replace(plain, setting=replace(plain.setting, model=model_of_a_run(tmp_path)))
    exact, gap, closed = (evaluated(*each) for each in ((documented, plain), (braked, plain), (braked, informed)))
    assert exact.figures["real"] == pytest.approx(exact.figures["simulated"], rel=1e-5)
    assert gap.figures["simulated"] == exact.figures["simulated"]
    assert abs(gap.figures["difference"]) > 0.02 * abs(exact.figures["real"])
    assert closed.figures["real"] == gap.figures["real"]
    assert abs(closed.figures["difference"]) < 0.01 * abs(gap.figures["difference"])
    for error in ("arm.rmse", "pole.rmse"):
        assert all(float(c[error]) < 0.02 * float(g[error]) for c, g in zip(closed.rows, gap.rows, strict=True))


@pytest.mark.parametrize(("depth", "solved"), [(0.0, 0.0), (-0.5, 1.0)], ids=["in_the_hole", "anywhere"])
def test_where_the_task_says_when_it_is_solved_its_share_is_told(depth: float, solved: float) -> None:
    near = [f"env.task.solved_depth={depth}", f"env.task.solved_radius={0.02 + abs(depth)}"]
    of = setting("swing_peg", "env.task.time_limit=3", *near)
    target = partial(ModelTarget, effects={}, context=None, seed=0)
    still = Subject(
        "still",
        of,
        lambda observation: observation.new_zeros(len(observation), 7),
        lambda *_: pytest.fail("no training"),
    )
    evaluator = RealVsSimEvaluator(target=target, episodes=2, confidence=0.9, resamples=50, seed=0)
    found = evaluator.evaluate(still, Path(), lambda _: None)
    assert found.told.endswith("solved that of those at whose end the task is solved.")
    for where in ("real", "simulated"):
        assert found.figures[f"{where}.solved"] == solved
        assert [row[f"{where}.solved"] for row in found.rows] == [solved, solved]


def test_pairs_begin_alike_and_their_differences_are_paired() -> None:
    found = evaluated(bench("furuta", "plant.nominal.spread=0.0"), subject(start="[0.1,0.1]"), episodes=2)
    real, simulated = found.episodes
    np.testing.assert_array_equal(real.qpos[0], simulated.qpos[0])
    assert not real.context  # the model's is not the machine's
    assert simulated.context
    starts = {float(row["real"]) for row in found.rows}
    assert len(starts) == 2
    for row in found.rows:
        assert row["difference"] == float(row["real"]) - float(row["simulated"])


def test_an_episode_that_diverged_in_the_model_is_counted_and_no_part_of_the_means(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    plant, start = bench("furuta", "plant.nominal.spread=0.0"), subject(start="[0.1,0.1]")
    whole = evaluated(plant, start, episodes=2)

    def diverging(*given: Any) -> list[Episode]:  # noqa: ANN401
        first, *others = record(*given)
        return [replace(first, ended="infeasible"), *others]

    monkeypatch.setattr(real_vs_sim, "record", diverging)
    found = evaluated(plant, start, episodes=2)
    assert (whole.figures["infeasible"], found.figures["infeasible"]) == (0.0, 0.5)
    assert [np.isnan(float(row["difference"])) for row in found.rows] == [True, False]
    for key in ("simulated", "difference"):
        assert found.figures[key] == whole.rows[1][key]
    assert found.figures["real"] == whole.figures["real"]
    assert found.units == {"arm.rmse": "rad", "pole.rmse": "rad"}


def test_an_episode_that_diverged_on_the_target_is_counted(monkeypatch: pytest.MonkeyPatch) -> None:
    def diverging(*given: Any) -> Episode:  # noqa: ANN401
        episode = as_episode(*given)
        return replace(episode, ended="infeasible") if episode.name == "real_2" else episode

    monkeypatch.setattr(real_vs_sim, "as_episode", diverging)
    found = evaluated(bench("furuta", "plant.nominal.spread=0.0"), subject(start="[0.1,0.1]"), episodes=2)
    assert (found.figures["infeasible"], found.figures["real.infeasible"]) == (0.0, 0.5)
    assert "real.infeasible that of those on what is called real" in found.told


def test_a_free_joint_has_an_error_for_each_of_its_numbers() -> None:
    """The same machine twice: what differs is nothing, and every number of a position has a name and a unit."""
    of = setting("ant", "env.task.time_limit=3")
    width = len(of.model.nominal().actuator_gear)

    def still(observation: Tensor) -> Tensor:
        return observation.new_zeros(len(observation), width)

    target = partial(ModelTarget, effects={}, context=None, seed=0)
    evaluator = RealVsSimEvaluator(target=target, episodes=2, confidence=0.9, resamples=50, seed=0)
    asked = Subject("still", of, still, lambda *_: pytest.fail("no training"))
    found = evaluator.evaluate(asked, Path(), lambda _: None)
    place, quaternion = ["root.x", "root.y", "root.z"], ["root.qw", "root.qx", "root.qy", "root.qz"]
    assert list(found.units)[:8] == [f"{name}.rmse" for name in [*place, *quaternion, "hip_1"]]
    assert list(found.units.values())[:8] == ["m"] * 3 + ["1"] * 4 + ["rad"]
    assert [[row[key] for key in found.units] for row in found.rows] == [[0.0] * 15] * 2


def test_a_plant_of_another_machine_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"joints pendulum and actuators motor; the model has arm, pole") as refused:
        evaluated(bench("pendulum"), subject())
    remedy = str(refused.value).partition("same machine: ")[2].partition("=NAME")[0]
    chosen = compose("evaluate", ["evaluator=real_vs_sim", f"{remedy}=cartpole"])
    assert chosen.evaluator.target.plant.nominal._target_.endswith("CartPoleNominal")


def test_recorded_logs_are_sent_to_compare_before_anything_is_played() -> None:
    class Recorded(Target):
        drivable, nature = False, "the recorded logs of a shelf"

        def play(self, drive: object, starts: object, count: int) -> TensorDict:
            raise AssertionError

    evaluator = RealVsSimEvaluator(target=lambda _: Recorded(), episodes=1, confidence=0.9, resamples=1, seed=0)
    of = replace(subject(), policy=lambda _: pytest.fail("nothing is to be played"))
    with pytest.raises(ConfigError, match=r"the recorded logs of a shelf and cannot be driven\. .* dr-lab compare"):
        evaluator.evaluate(of, Path(), lambda _: None)


def test_a_confidence_beyond_one_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"evaluator\.confidence is 1\.5; expected a share between 0 and 1"):
        RealVsSimEvaluator(target=cast(Any, PlantTarget), episodes=1, confidence=1.5, resamples=1, seed=0)
