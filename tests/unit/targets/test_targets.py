"""Targets are driven and watched: their motions are those of what is behind them, which cannot be read."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import torch
from effect_machines import catalogue_effect
from hydra.utils import instantiate
from settings import setting
from torch import Tensor

from dr_lab.cli.compose import compose
from dr_lab.cli.folders import shipped
from dr_lab.cli.groups import options
from dr_lab.collectors.play import play
from dr_lab.comparison.export import write_context
from dr_lab.effects.from_run import from_run
from dr_lab.effects.named import with_named_effects
from dr_lab.envs.setting import Setting
from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.physics.context import ContextEstimate, ContextSpace
from dr_lab.targets.model import ModelTarget
from dr_lab.targets.plant import PlantTarget
from dr_lab.targets.target import Target

STEPS = 20
FRICTION = {"coulomb_friction@arm.torque": 2.0e-3}
STARTS = (np.array([[0.1, 0.2], [-0.1, 0.1]]), np.array([[0.0, 0.1], [0.2, 0.0]]))


def furuta(*overrides: str) -> Setting:
    return setting("furuta", f"env.task.time_limit={STEPS}", *overrides)


def wave(observation: Tensor) -> Tensor:
    return 6.0 * observation[:, :1] - 0.5 * observation[:, 4:5] + 1.5


def hidden(context: dict[str, float]) -> Callable[[Setting], Target]:
    effects = {"coulomb_friction": catalogue_effect("coulomb_friction")}
    return partial(ModelTarget, effects=effects, context=context, seed=0)


def bench(hidden_effect: str) -> Callable[[Setting], Target]:
    options = ["plant=furuta", "plant.nominal.spread=0.0", f"plant/hidden={hidden_effect}"]
    return partial(PlantTarget, plant=instantiate(compose("record", options).source).plant, machine=0, seed=0)


MAKERS = [hidden(FRICTION), bench("furuta/coulomb_friction_arm")]


@pytest.mark.parametrize("make", MAKERS)
def test_nothing_can_be_read_of_a_target_but_motions(make: Callable[[Setting], Target]) -> None:
    target = make(furuta("env.show_context=true"))
    assert [name for name in dir(target) if not name.startswith("_")] == ["drivable", "nature", "play"]
    played = target.play(wave, STARTS, 2)
    keys = {key if isinstance(key, str) else key[-1] for key in played.keys(True, True)}
    known = {"observation", "action", "mask", "qpos", "qvel", "reward", "terminated", "truncated", "done", "infeasible"}
    assert keys == known
    told = furuta("env.show_context=true").space
    seen = cast(Tensor, played["observation"])[:, :, -len(told.names) :]
    torch.testing.assert_close(seen[0, 0], torch.from_numpy(told.to_unit(told.nominal)).float())


@pytest.mark.parametrize("make", [hidden({}), bench("none")])
def test_without_anything_hidden_a_target_moves_as_the_model(make: Callable[[Setting], Target]) -> None:
    found = furuta()
    expected = play(found.make(None, 2, 0, threads=1).episodes, wave, np.tile(found.space.nominal, (2, 1)), STARTS)
    played = make(found).play(wave, STARTS, 2)
    for key in ("observation", "qpos", "qvel", ("next", "qpos"), ("next", "reward"), ("next", "done"), "mask"):
        torch.testing.assert_close(played[key], expected[key], rtol=1e-4, atol=1e-4)


def test_a_model_and_a_plant_with_the_same_hidden_effect_move_alike() -> None:
    plain, *both = (make(furuta()).play(wave, STARTS, 2)["next", "qpos"] for make in (hidden({}), *MAKERS))
    gap, left = cast(Tensor, plain - both[0]).abs().max().item(), cast(Tensor, both[0] - both[1]).abs().max().item()
    assert gap > 1e-3
    assert left < 0.02 * gap


@pytest.mark.parametrize("make", MAKERS)
def test_commands_repeat_what_the_policy_did(make: Callable[[Setting], Target]) -> None:
    played = make(furuta()).play(wave, STARTS, 2)
    again = make(furuta()).play(cast(Tensor, played["action"])[:, :8].double().numpy(), STARTS, 2)
    assert again.shape == (2, 8)
    torch.testing.assert_close(again["next", "qpos"], played["next", "qpos"][:, :8])
    assert again["next", "truncated"][:, -1].all()
    assert not again["next", "done"][:, :-1].any()


@pytest.mark.parametrize("make", MAKERS)
def test_starts_that_are_not_given_are_the_tasks(make: Callable[[Setting], Target]) -> None:
    target = make(furuta())
    first, second = (target.play(wave, None, 2)["qpos"][:, 0] for _ in range(2))
    begun = torch.cat([first, second])
    assert len(begun.unique(dim=0)) == 4
    assert (begun.abs() <= torch.tensor([0.035, 0.0175])).all()


def test_an_effect_that_does_not_exist_is_told() -> None:
    with pytest.raises(UnknownNameError, match="rusty_hinge"):
        hidden({"rusty_hinge@arm.torque": 1.0})(furuta())


def test_a_model_that_a_run_ended_with_moves_as_that_with_its_effects(tmp_path: Path) -> None:
    known, (name, value) = furuta().model, *FRICTION.items()
    effects = {"coulomb_friction": catalogue_effect("coulomb_friction")}
    *own, torque = with_named_effects(known, effects, [name]).space.parameters
    space = ContextSpace((*own, replace(torque, high=2.0 * value)))
    found = ContextEstimate(space, space.vector({name: value}), 1e-12 * np.eye(len(space.names)))
    write_context(tmp_path / "context.yaml", found)
    closed = partial(ModelTarget, effects={}, context=None, seed=0, model=from_run(str(tmp_path), known, effects))
    played, expected = (make(furuta()).play(wave, STARTS, 2) for make in (closed, hidden(FRICTION)))
    torch.testing.assert_close(played["next", "qpos"], expected["next", "qpos"])


def test_an_effect_that_brings_an_actuator_makes_no_other_machine() -> None:
    known = furuta().model
    names = [f"cogging@pole.{part}" for part in ("sine", "cosine")]
    cogged = with_named_effects(known, {"cogging": catalogue_effect("cogging")}, names)
    assert cogged.nominal().nactuator > known.nominal().nactuator
    played, expected = (
        partial(ModelTarget, effects={}, context=None, seed=0, model=model)(furuta()).play(wave, STARTS, 2)
        for model in (cogged, known)
    )
    torch.testing.assert_close(played["next", "qpos"], expected["next", "qpos"])  # absent at its nominal values


def test_a_model_of_another_machine_is_refused() -> None:
    other = partial(ModelTarget, effects={}, context=None, seed=0, model=setting("cartpole").model)
    with pytest.raises(ConfigError, match=r"has joints cart, pole, .* that of env has joints arm, pole"):
        other(furuta())


@pytest.mark.parametrize("name", sorted(options("target", (shipped(),)).keys() - {"from_run"}))
def test_every_target_is_composed_with_the_evaluator(name: str) -> None:
    cfg = compose("evaluate", ["evaluator=real_vs_sim", f"target@evaluator.target={name}"])
    made = instantiate(cfg.evaluator, _convert_="all")
    machine = setting("ergo_reacher") if name == "ergo_robot" else furuta("env.task.voltage=6.0")  # as in the logs
    assert isinstance(made.target(machine), Target)


@pytest.mark.parametrize(
    ("context", "told"),
    [
        (
            {"coulomb_friction@arm.torque": -1e-3},
            r"context has coulomb_friction@arm\.torque -0\.001, expected at least 0",
        ),
        ({"arm.mass": -0.1}, "context makes no machine: .*mass"),
    ],
)
def test_values_that_no_machine_has_are_refused(context: dict[str, float], told: str) -> None:
    with pytest.raises(ConfigError, match=told):
        hidden(context)(furuta())
