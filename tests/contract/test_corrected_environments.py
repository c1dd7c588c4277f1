"""Environments of models that a fit has corrected: effects, drivers and friction laws act in them as in a replay."""

from dataclasses import replace

import numpy as np
import pytest
from effect_machines import placed, scales_of
from playing import actions, begun, played
from settings import setting

from dr_lab.effects.effect import place
from dr_lab.effects.learned_force import LearnedForce
from dr_lab.effects.residual_force import ResidualForce
from dr_lab.envs.setting import Setting
from dr_lab.errors import ModelError
from dr_lab.physics.radial_basis import Input, Seen, around, features
from dr_lab.physics.simulator import Simulator


def corrected(effect: str, site: str) -> Setting:
    plain = setting("furuta")
    return replace(plain, model=plain.model.with_effect(placed(plain.model, effect, site)))


@pytest.mark.parametrize("effect", ["coulomb_friction", "hysteresis"])  # MuJoCo's own element, a law between steps
def test_effects_of_a_corrected_model_are_played_and_randomised(effect: str) -> None:
    episodes = begun(corrected(effect, "arm"), slots=2)
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


def with_learned_force() -> Setting:
    """A spring of the arm that depends on its speed and on the voltage as well, known where the pendulum moves."""
    plain = setting("furuta")
    compiled, generator = plain.model.nominal(), np.random.default_rng(0)
    inputs = (Input("angle", "arm", 1.0), Input("velocity", "arm", 20.0), Input("command", "motor", 5.0))
    seen = Seen(*(size * generator.normal(size=(300, n)) for size, n in ((0.5, 2), (10.0, 2), (3.0, 1))))
    basis = around(inputs, features(inputs, compiled, seen), 30, 1.0)
    force = LearnedForce(basis, 0.01 * generator.normal(size=len(basis.centres)), "N·m")
    effect = place(ResidualForce(2.0, {"arm": force}), compiled, "arm", scales_of(plain.model))
    return replace(plain, model=plain.model.with_effect(effect))


@pytest.mark.parametrize("effect", ["dead_zone", "actuator_lag", "rate_limit", "voltage_sag", "residual_force"])
def test_drivers_and_forces_act_as_in_a_replay_of_the_same_commands(effect: str) -> None:
    of, steps = with_learned_force() if effect == "residual_force" else corrected(effect, "motor"), 12
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


def with_delay(delay: float) -> Setting:
    plain = setting("furuta")
    late = placed(plain.model, "actuator_delay", "motor")
    late = replace(late, parameters=(replace(late.parameters[0], nominal=delay),))
    return replace(plain, model=plain.model.with_effect(late))


def test_a_delay_that_needs_the_whole_series_is_refused() -> None:
    with pytest.raises(ModelError, match=r"actuator_delay@motor.* commands of motor"):
        begun(with_delay(0.001))
    begun(with_delay(0.0))


def test_effects_at_sensors_have_no_part() -> None:
    plain, biased = begun(setting("furuta")), begun(corrected("sensor_bias", "arm"))
    np.testing.assert_array_equal(played(biased, 5), played(plain, 5))
    assert "sensor_bias@arm.bias" in biased.model.space.names


def test_an_actuators_delay_acts() -> None:
    """A driver that is 30 ms late answers three control steps later, but for an edge within a physics step."""
    speeds = []
    for of in (setting("furuta"), with_delay(0.03)):
        episodes = begun(of)
        for name in ("qpos", "qvel"):
            episodes.simulator.batch.bind(name)[:] = 0.0
        speeds.append([episodes.step(np.full((3, 1), 4.0)).observation[0, 4] for _ in range(8)])
    prompt, delayed = np.array(speeds)
    np.testing.assert_allclose(delayed, [0.0, 0.0, 0.0, *prompt[:5]], atol=0.02 * prompt.max())
