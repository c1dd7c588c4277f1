"""A hidden machine is found by how it moves, and the distance of two courses is what its formula says."""

from collections.abc import Mapping
from functools import partial
from typing import Any, cast

import numpy as np
import pytest
import torch
from settings import setting
from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.collector import Drive
from dr_lab.collectors.experience import Experience
from dr_lab.collectors.lean import LeanCollector
from dr_lab.distribution_learners.simopt.discrepancy import Discrepancy
from dr_lab.distribution_learners.simopt.quantity import quantities
from dr_lab.distribution_learners.simopt.simopt import SimOpt
from dr_lab.envs.setting import Setting
from dr_lab.envs.slots import Starts
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextSpace
from dr_lab.randomizers.gaussian import gaussian
from dr_lab.randomizers.randomizer import Randomizer
from dr_lab.randomizers.uniform import UniformRandomizer
from dr_lab.targets.model import ModelTarget
from dr_lab.targets.target import Target
from dr_lab.trajectory import Array

FURUTA: Setting = setting("furuta", "env.task.time_limit=40")
COMPILED = FURUTA.model.nominal()
HIDDEN = {"arm.mass": 0.13, "pole.mass": 0.018}  # kg; the model has 0.095 and 0.024
PLAIN = Discrepancy(weights=None, l1=0.5, l2=1.0, smoothing=0.0, truncation=4.0)
BATCH = TensorDict()  # of no interest to SimOpt


def wave(observation: Tensor) -> Tensor:
    return 6.0 * observation[:, :1] - 0.5 * observation[:, 4:5] + 1.5


def wide(space: ContextSpace, relative_std: float = 0.5, clip: bool = True) -> Randomizer:
    return gaussian(space, mean=None, std=None, relative_std=relative_std, clip=clip)


def learner(randomizer: Randomizer, seed: int = 0, **changes: Any) -> SimOpt:  # noqa: ANN401
    numbers: dict[str, Any] = {"rollouts": 2, "samples": 60, "updates": 3, "max_kl": 1.0, "least_temperature": 1e-6}
    numbers |= {"discrepancy": PLAIN, "warm_up": 0, "every": 1, "setting": FURUTA} | changes
    numbers = {"target": partial(ModelTarget, effects={}, context=HIDDEN, seed=0)} | numbers
    return SimOpt(randomizer, seed, **numbers)


def experience(randomizer: Randomizer) -> Experience:
    collector = LeanCollector(FURUTA.make(randomizer, 2, 0, threads=1), wave, 4)
    return Experience(collector, wave, FURUTA.make(None, 40, 1, threads=1).episodes)


def run(learner: SimOpt, iterations: int) -> list[Mapping[str, float]]:
    played = experience(learner.randomizer)
    return [learner.update(BATCH, played) for _ in range(iterations)]


def course(position: Array, ends: int | None = None) -> TensorDict:
    """Episodes of which the arm's position after every control step is known, shape (k, t); the pole hangs still."""
    k, steps = position.shape
    mask = torch.arange(steps).expand(k, -1) < (steps if ends is None else ends)
    qpos = torch.from_numpy(np.stack([position, np.zeros_like(position)], -1))
    then = TensorDict({"qpos": qpos, "qvel": torch.zeros_like(qpos)}, batch_size=[k, steps])
    return TensorDict({"mask": mask, "next": then}, batch_size=[k, steps])


def costs(discrepancy: Discrepancy, real: TensorDict, simulated: TensorDict) -> Array:
    return discrepancy(discrepancy.measured(COMPILED, {}), cast(TensorDict, real[0]), simulated)


def test_a_constant_distance_is_weighed_as_the_formula_says() -> None:
    real, simulated = course(np.zeros((1, 10))), course(np.array([[0.2] * 10, [-0.1] * 10]))
    np.testing.assert_allclose(costs(PLAIN, real, simulated), [10 * (0.5 * 0.2 + 0.04), 10 * (0.5 * 0.1 + 0.01)])
    twice = Discrepancy({"arm.position": 2.0}, l1=0.5, l2=1.0, smoothing=3.0, truncation=4.0)
    np.testing.assert_allclose(costs(twice, real, simulated)[0], 10 * (0.5 * 0.4 + 0.16))
    blind = Discrepancy({"pole.position": 1.0, "arm.velocity": 1.0}, l1=0.5, l2=1.0, smoothing=0.0, truncation=4.0)
    np.testing.assert_array_equal(costs(blind, real, simulated), 0.0)


def test_what_the_task_sees_is_measured_by_its_column() -> None:
    real, simulated = course(np.zeros((1, 10))), course(np.ones((1, 10)))
    for episodes, place in ((real, 0.0), (simulated, 0.3)):
        episodes["next", "observation"] = torch.tensor([7.0, place]).expand(1, 10, 2)
    peg = Discrepancy({"peg.z": 1.0}, l1=0.5, l2=1.0, smoothing=5.0, truncation=4.0)
    found = peg(peg.measured(COMPILED, {"peg.z": 1}), cast(TensorDict, real[0]), simulated)
    np.testing.assert_allclose(found, 10 * (0.5 * 0.3 + 0.09), rtol=1e-6)
    with pytest.raises(UnknownNameError, match=r"peg\.z"):
        peg.measured(COMPILED, {})


def test_who_ends_early_stays_and_what_follows_the_real_end_does_not_count() -> None:
    ramp = np.arange(1.0, 6.0)[None]
    only_l1 = Discrepancy({"arm.position": 1.0}, l1=1.0, l2=0.0, smoothing=0.0, truncation=4.0)
    assert costs(only_l1, course(ramp), course(ramp, ends=3))[0] == pytest.approx(1.0 + 2.0)  # 3 stays, beside 4 and 5
    assert costs(only_l1, course(ramp, ends=3), course(np.where(ramp > 3, 99.0, ramp)))[0] == 0.0


def test_a_filter_forgives_a_shift_in_time() -> None:
    time = np.arange(200)
    real, late = course(np.sin(time)[None]), course(np.sin(time - 0.5)[None])
    sharp, smooth = (
        Discrepancy({"arm.position": 1.0}, l1=0.0, l2=1.0, smoothing=std, truncation=4.0) for std in (0.0, 5.0)
    )
    assert costs(smooth, real, late)[0] < 0.02 * costs(sharp, real, late)[0]


@pytest.mark.slow
def test_a_hidden_machine_is_found_within_the_bound_of_every_update() -> None:
    learner_ = learner(wide(FURUTA.space), samples=150, rollouts=1)
    figures = run(learner_, 8)
    assert all(each["divergence"] <= 1.0 + 1e-6 for each in figures)
    assert figures[-1]["discrepancy"] < 5e-3 * figures[0]["discrepancy"]
    moments = learner_.randomizer.moments()
    assert moments is not None
    found = dict(zip(FURUTA.space.names, moments[0], strict=True))
    for name, value in HIDDEN.items():
        assert found[name] == pytest.approx(value, rel=0.02)


def test_contexts_that_cannot_be_simulated_cost_as_much_as_the_worst() -> None:
    found = wide(FURUTA.space, relative_std=3.0, clip=False)
    (figures,) = run(learner(found), 1)
    assert 0.05 < figures["infeasible"] < 1.0
    assert np.isfinite(figures["discrepancy"])
    moments = found.moments()
    assert moments is not None
    assert np.isfinite(moments[1]).all()


def test_it_waits_while_the_policy_warms_up() -> None:
    assert learner(wide(FURUTA.space), warm_up=2, every=100).first == 300


def test_continues_exactly() -> None:
    whole, first = learner(wide(FURUTA.space), samples=20), learner(wide(FURUTA.space), samples=20)
    last = run(whole, 2)[-1]
    run(first, 1)
    second = learner(wide(FURUTA.space), samples=20, seed=3)
    second.load_state_dict(first.state_dict())
    assert run(second, 1)[-1] == last
    for one, other in zip(second.compared(), whole.compared(), strict=True):
        np.testing.assert_array_equal(one.mean, other.mean)
        np.testing.assert_array_equal(one.drawn, other.drawn)


@pytest.mark.slow
def test_recorded_motions_find_the_machine_by_what_was_commanded() -> None:
    """A wave of its own for every log, from starts of its own."""
    rng, steps = np.random.default_rng(0), 40
    machine = ModelTarget(FURUTA, {}, HIDDEN, seed=0)
    commands = 3.0 * np.sin(np.arange(steps) * rng.uniform(0.1, 0.5, (2, 1)))[..., None]
    starts = rng.normal(0.0, 0.3, (2, 2, 2))
    recorded = machine.play(commands, (starts[0], starts[1]), 2)

    class Logs(Target):
        drivable = False

        def play(self, drive: Drive | None, starts: Starts | None, count: int) -> TensorDict:
            assert drive is None
            assert starts is None
            return cast(TensorDict, recorded[:count])

    learner_ = learner(wide(FURUTA.space), samples=100, target=lambda _: Logs())
    figures = run(learner_, 8)
    assert figures[-1]["discrepancy_of_mean"] < 5e-3 * figures[0]["discrepancy"]
    mean = cast(tuple[Array, Array], learner_.randomizer.moments())[0]
    for name, value in HIDDEN.items():
        assert mean[FURUTA.space.index(name)] == pytest.approx(value, rel=0.03)


def test_what_is_shown_is_what_was_compared() -> None:
    truth = FURUTA.space.mapping(FURUTA.space.nominal) | HIDDEN
    exact = gaussian(FURUTA.space, mean=truth, std=None, relative_std=1e-5, clip=True)
    learner_ = learner(exact)
    assert learner_.compared() == ()
    (figures,) = run(learner_, 1)
    arm, pole = learner_.compared()
    assert (arm.name, arm.unit, pole.name, pole.unit) == ("arm.position", "rad", "pole.position", "rad")
    assert len(arm.time) == 40
    assert arm.time[0] == pytest.approx(0.01)
    assert arm.drawn.shape == (6, 40)
    assert np.ptp(arm.target) > 0.05
    np.testing.assert_allclose(arm.mean, arm.target, atol=1e-3)
    assert figures["discrepancy_of_mean"] < 1e-2
    assert learner_.compared() == ()  # until there is something new


def test_what_cannot_be_moved_or_measured_is_refused() -> None:
    uniform = UniformRandomizer(FURUTA.space, ranges={})
    with pytest.raises(ConfigError, match="Take randomizer=gaussian or from_run"):
        learner(uniform)
    for weights, error in (({"arm.positon": 1.0}, UnknownNameError), ({"arm.position": 0.0}, ConfigError)):
        with pytest.raises(error):
            learner(wide(FURUTA.space), discrepancy=Discrepancy(weights, 0.5, 1.0, 0.0, 4.0))
    with pytest.raises(ConfigError, match=r"distribution_learner\.max_kl is 0; expected a number above 0\."):
        learner(wide(FURUTA.space), max_kl=0.0)
    assert list(quantities(COMPILED, {})) == ["arm.position", "pole.position", "arm.velocity", "pole.velocity"]
