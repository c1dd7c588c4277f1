"""The same machine in MuJoCo, with values and effects that this side does not know."""

from collections.abc import Mapping
from dataclasses import replace
from typing import ClassVar, cast

import numpy as np
import torch
from tensordict import TensorDict
from torch import Tensor

from dr_lab.collectors.collector import Drive, Policy
from dr_lab.collectors.play import play
from dr_lab.effects.effect import Effect
from dr_lab.effects.named import require_possible, with_named_effects
from dr_lab.envs.batched_env import single
from dr_lab.envs.setting import Setting
from dr_lab.envs.slots import Starts
from dr_lab.errors import ConfigError
from dr_lab.physics.model import Model
from dr_lab.seeding import derived_seed
from dr_lab.targets.target import Target, require_drive


class ModelTarget(Target):
    """A model with a hidden context, whose effects are those that the context names.

    Args:
        setting: machine and task as this side knows them.
        effects: the catalogue from which `context` takes effects.
        context: true values by parameter name, of the setting's own parameters and of effects
            (``coulomb_friction@arm.torque``); None changes nothing.
        seed: of the starts that are not given.
        model: another model of the machine, such as a run of ``dr-lab close`` ended with; None for that of the setting.

    Raises:
        UnknownNameError: a parameter, effect or site does not exist.
        ConfigError: the model has other joints, actuators or time steps, or no machine has such values.
    """

    nature: ClassVar[str] = (
        "no hardware but the model itself, with the values and effects of evaluator.target.context, if any"
    )

    def __init__(
        self,
        setting: Setting,
        effects: Mapping[str, Effect],
        context: Mapping[str, float] | None,
        seed: int,
        model: Model | None = None,
    ) -> None:
        self._space, values = setting.space, dict(context or {})
        asked = {parameter.name for parameter in setting.task.parameters}
        machine = setting.model if model is None else _require_same(setting.model, model)
        machine = with_named_effects(machine, effects, [name for name in values if name not in asked])
        self._setting = replace(setting, model=machine, show_context=False)
        self._z, self._seed = self._setting.space.vector(values), derived_seed(seed, "target")
        require_possible(machine, self._z[: len(machine.space.names)], "The target's context")
        self._told = single(setting.space.to_unit(setting.space.nominal)) if setting.show_context else None

    def play(self, drive: Drive | None, starts: Starts | None, count: int) -> TensorDict:
        """All episodes side by side."""
        env = self._setting.make(None, count, self._seed)
        self._seed = derived_seed(self._seed, "next")  # so that starts differ from call to call
        acts = require_drive(drive)
        acts = acts if isinstance(acts, np.ndarray) else _Told(acts, self._told)
        played = play(env.episodes, acts, np.tile(self._z, (count, 1)), starts)
        bounds = torch.from_numpy(env.episodes.low), torch.from_numpy(env.episodes.high)
        played["action"] = cast(Tensor, played["action"]).double().clamp(*bounds)
        if self._told is not None:
            for key in ("observation", ("next", "observation")):
                played[key] = _joined(cast(Tensor, played[key]), self._told)
        return played.exclude("context", ("next", "context"))


def _require_same(known: Model, true: Model) -> Model:
    """The true model, of the same machine as the known one."""
    mine, theirs = _layout(known), _layout(true)
    if mine != theirs:
        raise ConfigError(
            f"The target's model has {theirs}; that of env has {mine}. Give a model of the same machine: "
            "evaluator.target.model…"
        )
    return true


def _layout(model: Model) -> str:
    compiled = replace(model, effects=()).nominal()  # some effects bring actuators that nobody commands
    joints = ", ".join(compiled.joint(i).name for i in range(compiled.njnt))
    actuators = ", ".join(compiled.actuator(i).name for i in range(compiled.nactuator))
    return f"joints {joints}, actuators {actuators} and steps of {compiled.opt.timestep:g} s"


class _Told:
    """A policy that is told the same context in every state."""

    def __init__(self, policy: Policy, told: Tensor | None) -> None:
        self._policy, self._told = policy, told

    def __call__(self, observation: Tensor) -> Tensor:
        return self._policy(observation if self._told is None else _joined(observation, self._told))


def _joined(observation: Tensor, told: Tensor) -> Tensor:
    return torch.cat([observation, told.expand(*observation.shape[:-1], -1)], -1)
