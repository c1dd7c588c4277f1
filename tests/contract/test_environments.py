"""What every environment keeps: gymnasium's physics, resets that touch nothing else, an exact state."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from effect_machines import placed
from gymnasium_twins import twin
from settings import setting
from torchrl.envs.utils import check_env_specs

from dr_lab.cli.compose import options
from dr_lab.cli.folders import shipped
from dr_lab.envs.episodes import Episodes
from dr_lab.envs.setting import Setting
from dr_lab.errors import ModelError
from dr_lab.physics.simulator import Simulator
from dr_lab.trajectory import Array

NAMES = sorted(options("env", (shipped(),)))
GYMNASIUM: dict[str, dict[str, Any]] = {
    "hopper": {"id": "Hopper-v5"},
    "half_cheetah": {"id": "HalfCheetah-v5"},
    "ant": {"id": "Ant-v5"},
    "ant_without_contacts": {"id": "Ant-v5", "include_cfrc_ext_in_observation": False, "contact_cost_weight": 0.0},
    "humanoid": {"id": "Humanoid-v5"},
}
LSDR = [
    f"{machine}/{context}"
    for machine in ("hopper", "half_cheetah")
    for context in ("torso_size", "density", "friction", "damping")
]
ALL_THREE = "env/context=[hopper/torso_size,hopper/friction,hopper/damping]"
BY_FIELD = "env/context=[hopper/friction,hopper/damping]"


class Uniform:
    """A randomizer, made as simple as it can be: uniform over the inner part of the bounds."""

    def __init__(self, low: Array, high: Array) -> None:
        self.low, self.high = low, high

    def sample(self, rngs: Sequence[np.random.Generator]) -> Array:
        return np.array([rng.uniform(self.low, self.high) for rng in rngs])


def begun(of: Setting, nenv: int = 3, seed: int = 0, *, random: bool = False) -> Episodes:
    space = of.space
    source = Uniform(0.8 * space.nominal + 0.2 * space.low, 0.8 * space.nominal + 0.2 * space.high)
    return of.make(source if random else None, nenv, seed, threads=1).episodes


def actions(episodes: Episodes, seed: int = 0) -> Array:
    rng = np.random.default_rng(seed)
    return rng.uniform(episodes.low, episodes.high, (episodes.nsim, len(episodes.low)))


def played(episodes: Episodes, steps: int, seed: int = 0) -> Array:
    """Rewards and observations of so many steps, with new episodes where one ended; shape (steps, n, 1 + o)."""
    kept = []
    for k in range(steps):
        outcome = episodes.step(actions(episodes, seed + k))
        kept.append(np.concatenate([outcome.reward[:, None], outcome.observation], axis=1))
        if outcome.done.any():
            episodes.begin(np.flatnonzero(outcome.done))
    return np.array(kept)


@pytest.mark.parametrize("name", NAMES)
def test_torchrl_accepts_it(name: str) -> None:
    check_env_specs(setting(name).make(None, 2, 0, threads=1))


@pytest.mark.filterwarnings("ignore:compiler attribute 'settotalmass'")
@pytest.mark.parametrize("name", list(GYMNASIUM))
def test_steps_equal_gymnasium(name: str) -> None:
    episodes = begun(setting(name), nenv=2)
    twins: list[Any] = [twin(**GYMNASIUM[name]) for _ in range(2)]
    state = {key: episodes.simulator.batch.bind(key) for key in ("qpos", "qvel")}

    def pair(slot: int) -> None:
        twins[slot].reset(seed=0)
        twins[slot].set_state(state["qpos"][slot].copy(), state["qvel"][slot].copy())
        np.testing.assert_allclose(episodes.observation[slot], twins[slot]._get_obs(), atol=1e-9)

    ends, touched = 0, False
    for slot in range(2):
        pair(slot)
    for k in range(80):
        action = actions(episodes, k)
        outcome = episodes.step(action)
        for slot, one in enumerate(twins):
            observation, reward, terminated, _, _ = one.step(action[slot])
            np.testing.assert_allclose(outcome.observation[slot], observation, rtol=1e-9, atol=1e-9)
            assert outcome.reward[slot] == pytest.approx(reward, rel=1e-9, abs=1e-9)
            assert outcome.terminated[slot] == terminated
            touched |= one.data.cfrc_ext.any()
        if outcome.done.any():
            ends += 1
            episodes.begin(np.flatnonzero(outcome.done))
            for slot in np.flatnonzero(outcome.done):
                pair(int(slot))
    assert ends or name not in ("hopper", "humanoid")
    assert touched


def test_a_time_limit_truncates_and_a_fall_terminates() -> None:
    episodes = begun(setting("hopper", "env.task.time_limit=5"))
    outcomes = [episodes.step(np.zeros((3, 3))) for _ in range(5)]
    assert not any(o.done.any() for o in outcomes[:4])
    assert outcomes[4].truncated.all()
    assert not outcomes[4].terminated.any()
    episodes = begun(setting("hopper"))
    episodes.simulator.batch.bind("qpos")[1, 2] = 0.5
    assert list(episodes.step(np.zeros((3, 3))).terminated) == [False, True, False]


@pytest.mark.parametrize("context", [ALL_THREE, BY_FIELD], ids=["by_compilation", "by_field"])
def test_a_reset_touches_only_its_own_episodes(context: str) -> None:
    one, other = (begun(setting("hopper", context), random=True) for _ in range(2))
    for k in range(3):
        one.step(actions(one, k))
        other.step(actions(other, k))
    before = one.contexts
    one.begin(np.array([1]))
    np.testing.assert_array_equal(one.contexts[[0, 2]], before[[0, 2]])
    assert (one.contexts[1] != before[1]).all()
    a, b = one.step(actions(one)), other.step(actions(other))
    np.testing.assert_array_equal(a.observation[[0, 2]], b.observation[[0, 2]])
    np.testing.assert_array_equal(a.reward[[0, 2]], b.reward[[0, 2]])
    assert (a.observation[1] != b.observation[1]).any()


def test_a_slot_draws_the_same_whatever_the_others_do() -> None:
    few, many = (begun(setting("hopper", BY_FIELD), nenv, random=True) for nenv in (2, 3))
    np.testing.assert_array_equal(few.contexts, many.contexts[:2])
    many.begin(np.array([2, 1][::-1]))
    few.begin(np.array([1]))
    np.testing.assert_array_equal(few.observation, many.observation[:2])


@pytest.mark.parametrize("context", [ALL_THREE, BY_FIELD], ids=["by_compilation", "by_field"])
def test_nothing_adds_up_over_resets(context: str) -> None:
    of = setting("hopper", context)
    used, new = begun(of, random=True), begun(of)
    for _ in range(3):
        used.begin(np.arange(3))
    z = np.tile(0.9 * of.space.nominal + 0.1 * of.space.high, (3, 1))
    for episodes in (used, new):
        episodes.give_contexts(z)
        episodes.begin(np.arange(3))
    for name in ("qpos", "qvel", "qacc_warmstart"):
        used.simulator.batch.bind(name)[:] = new.simulator.batch.bind(name)
    np.testing.assert_array_equal(used.contexts, z)
    for k in range(5):
        np.testing.assert_array_equal(used.step(actions(used, k)).observation, new.step(actions(new, k)).observation)


@pytest.mark.parametrize("context", LSDR)
def test_every_parameter_changes_the_motion(context: str) -> None:
    of = setting(context.partition("/")[0], f"env/context={context}")
    episodes = begun(of, nenv=2)
    z = np.array([0.5 * of.space.nominal + 0.5 * of.space.high, of.space.nominal])
    episodes.give_contexts(z)
    episodes.begin(np.arange(2))
    for name in ("qpos", "qvel"):
        episodes.simulator.batch.bind(name)[1] = episodes.simulator.batch.bind(name)[0]
    rng = np.random.default_rng(0)
    for _ in range(60):
        episodes.simulator.step(np.tile(rng.uniform(episodes.low, episodes.high), (2, 1)), of.task.frame_skip)
    assert not np.allclose(*episodes.simulator.batch.bind("qpos"), rtol=0, atol=1e-6)


def test_infeasible_contexts_end_with_the_declared_return_and_stop_nobody() -> None:
    of = setting("hopper", "env/context=hopper/torso_size", "env.infeasible_return=-7")
    episodes = begun(of)
    episodes.give_contexts(np.array([[0.05], [-0.02], [0.0]]))  # the latter two do not compile
    episodes.begin(np.arange(3))
    outcome = episodes.step(np.zeros((3, 3)))
    assert list(outcome.terminated) == [False, True, True]
    np.testing.assert_array_equal(outcome.reward[1:], -7.0)
    episodes.step(np.zeros((3, 3)))  # what has ended is not counted again
    assert episodes.infeasible == 2
    episodes.give_contexts(np.full((3, 1), 0.05))
    episodes.begin(np.array([1, 2]))
    assert not episodes.step(np.zeros((3, 3))).terminated.any()


def test_divergence_ends_with_the_declared_return_and_stops_nobody() -> None:
    episodes = begun(setting("hopper", "env.infeasible_return=0"))
    earned = episodes.step(np.zeros((3, 3))).reward
    before = episodes.observation
    episodes.simulator.batch.bind("qvel")[1, 0] = 1e12
    outcome = episodes.step(np.zeros((3, 3)))
    assert list(outcome.terminated) == [False, True, False]
    assert earned[1] + outcome.reward[1] == pytest.approx(0.0)
    np.testing.assert_array_equal(outcome.observation[1], before[1])
    assert np.isfinite(outcome.observation).all()


def test_divergence_pays_nothing_where_all_rewards_are_negative() -> None:
    episodes = begun(setting("cartpole", "env.infeasible_return=0"))
    earned = episodes.step(np.zeros((3, 1))).reward
    assert (earned < 0.0).all()
    episodes.simulator.batch.bind("qvel")[1, 0] = 1e12
    outcome = episodes.step(np.zeros((3, 1)))
    assert list(outcome.terminated) == [False, True, False]
    assert outcome.reward[1] == 0.0


@pytest.mark.parametrize("name", NAMES)
def test_feasible_episodes_return_more_than_infeasible_ones(name: str) -> None:
    of = setting(name)
    episodes, rng = begun(of, nenv=4), np.random.default_rng(0)
    going, returns = np.ones(4, bool), np.zeros(4)
    for _ in range(of.task.time_limit):
        push = np.where(rng.random((4, len(episodes.low))) < 0.5, episodes.low, episodes.high)
        push[0] = 0.0
        outcome = episodes.step(push)
        returns[going] += outcome.reward[going]
        going = going & ~outcome.done
        if not going.any():
            break
    assert (returns > of.infeasible_return).all()


@pytest.mark.parametrize("context", [ALL_THREE, BY_FIELD], ids=["by_compilation", "by_field"])
def test_resumed_equals_uninterrupted(context: str) -> None:
    of = setting("hopper", context)
    one, other = begun(of, random=True), begun(of, seed=5, random=True)
    played(one, 20)
    state = one.state_dict()
    expected = played(one, 30, seed=20)
    other.load_state_dict(state)
    np.testing.assert_array_equal(played(other, 30, seed=20), expected)
    np.testing.assert_array_equal(other.contexts, one.contexts)


def test_a_shown_context_is_scaled_to_its_bounds() -> None:
    of = setting("hopper", "env/context=hopper/friction", "env.show_context=true")
    episodes = begun(of, random=True)
    assert episodes.observation.shape == (3, 12)
    np.testing.assert_allclose(episodes.observation[:, 11], (episodes.contexts[:, 0] + 3.0) / 13.0)


def test_given_contexts_are_those_of_the_next_episodes_until_none_are_given() -> None:
    env = setting("hopper", BY_FIELD).make(Uniform(np.zeros(2), np.ones(2)), 2, 0, threads=1)
    z = np.array([[2.0, 0.0], [3.0, 1.0]])
    env.set_contexts(z)
    np.testing.assert_array_equal(env.reset()["context"], z.astype(np.float32))
    env.set_contexts(None)
    assert (env.reset()["context"].numpy() < 1.0).all()


def corrected(effect: str, site: str) -> Setting:
    plain = setting("furuta")
    return replace(plain, model=plain.model.with_effect(placed(plain.model, effect, site)))


@pytest.mark.parametrize("effect", ["coulomb_friction", "hysteresis"])  # MuJoCo's own element, a law between steps
def test_effects_of_a_corrected_model_are_played_and_randomised(effect: str) -> None:
    episodes = begun(corrected(effect, "arm"), nenv=2)
    space = episodes.model.space
    z = np.tile(space.nominal, (2, 1))
    z[1, len(episodes.model.declared) :] = space.high[len(episodes.model.declared) :]
    episodes.give_contexts(z)
    episodes.begin(np.arange(2))
    for name in ("qpos", "qvel"):
        episodes.simulator.batch.bind(name)[1] = episodes.simulator.batch.bind(name)[0]
    seen = [episodes.step(np.full((2, 1), 4.0)).observation for _ in range(10)][-1]
    assert not np.allclose(seen[0], seen[1], atol=1e-4)
    assert not episodes.simulator.infeasible.any()


@pytest.mark.parametrize("effect", ["dead_zone", "actuator_lag", "rate_limit", "voltage_sag"])
def test_drivers_act_as_in_a_replay_of_the_same_commands(effect: str) -> None:
    of, steps = corrected(effect, "motor"), 12
    z = 0.5 * (of.space.nominal + of.space.high)[None]
    episodes = of.make(None, 1, 0, threads=1).episodes
    episodes.give_contexts(z)
    episodes.begin(np.arange(1))
    qpos, qvel = episodes.state
    wanted = actions(episodes, seed=3) * np.sin(np.arange(1, steps + 1))[:, None]
    moved = [(episodes.step(action[None]), episodes.state[0][0])[1] for action in wanted]
    held = np.repeat(wanted, of.task.frame_skip, axis=0)[None]
    rollout = Simulator(of.model, 1, 1).replay(z, qpos[None], qvel[None], held, held[:, :1])
    np.testing.assert_allclose(moved, rollout.qpos[0, of.task.frame_skip :: of.task.frame_skip], rtol=1e-9)
    plain = Simulator(setting("furuta").model, 1, 1)
    without = plain.replay(plain.model.space.nominal[None], qpos[None], qvel[None], held, held[:, :1])
    assert not np.allclose(moved[-1], without.qpos[0, -1], rtol=1e-3)


def test_an_effect_without_a_driver_is_refused() -> None:
    with pytest.raises(ModelError, match=r"actuator_delay@motor.* commands of motor"):
        begun(corrected("actuator_delay", "motor"))


def test_effects_at_sensors_have_no_part() -> None:
    plain, biased = begun(setting("furuta")), begun(corrected("sensor_bias", "arm"))
    np.testing.assert_array_equal(played(biased, 5), played(plain, 5))
    assert "sensor_bias@arm.bias" in biased.model.space.names


def test_an_actuators_delay_acts() -> None:
    """A driver that is 30 ms late answers three control steps later, but for an edge within a physics step."""
    late = placed(setting("furuta").model, "actuator_delay", "motor")
    late = replace(late, parameters=(replace(late.parameters[0], nominal=0.03),))
    model = setting("furuta").model.with_effect(late)
    speeds = []
    for of in (setting("furuta"), replace(setting("furuta"), model=model)):
        episodes = begun(of)
        for name in ("qpos", "qvel"):
            episodes.simulator.batch.bind(name)[:] = 0.0
        speeds.append([episodes.step(np.full((3, 1), 4.0)).observation[0, 4] for _ in range(8)])
    prompt, delayed = np.array(speeds)
    np.testing.assert_allclose(delayed, [0.0, 0.0, 0.0, *prompt[:5]], atol=0.02 * prompt.max())
