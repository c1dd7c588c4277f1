"""LunarLander-v3 with the power of its engines as context."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from dr_lab.bounds import Count, Positive, require_bounds
from dr_lab.envs.batched_env import BatchedEnv
from dr_lab.envs.environment import Environment
from dr_lab.errors import UnknownNameError
from dr_lab.extras import MissingLibraryError
from dr_lab.physics.context import ContextSpace
from dr_lab.physics.parameter import Parameter
from dr_lab.randomizers.context_source import ContextSource
from dr_lab.trajectory import Array

_POWERS = ("main_engine_power", "side_engine_power")


@dataclass(frozen=True, kw_only=True)
class Landing:
    """What gymnasium fixes in its code or where it registers the environment.

    Attributes:
        time_limit: control steps after which an episode is cut.
        main_engine_power: where the context does not say otherwise; impulse of a step per distance that gymnasium
            assigns to the nozzle, N·s/m.
        side_engine_power: likewise.

    Raises:
        ConfigError: a number is not above 0.
    """

    time_limit: Count
    main_engine_power: Positive
    side_engine_power: Positive

    def __post_init__(self) -> None:
        require_bounds(self, "env.task")


@dataclass(frozen=True, kw_only=True)
class LunarLander(Environment):
    """gymnasium's LunarLander-v3 with continuous actions, step by step the same where the context is nominal.

    Attributes: as `Environment`, and
        task: the time limit and the nominal powers.
        parameters: those powers, by name, that make up the context: unit, low, high.
        mjcf: file of the scene.

    Raises:
        UnknownNameError: a parameter is no power of an engine.
    """

    task: Landing
    parameters: Mapping[str, Mapping[str, Any]]
    mjcf: str

    def __post_init__(self) -> None:
        for name in self.parameters:
            if name not in _POWERS:
                raise UnknownNameError("parameter", name, _POWERS, "the lunar lander")

    @property
    def space(self) -> ContextSpace:
        """Powers of engines."""
        known = self.parameters.items()
        return ContextSpace(tuple(Parameter(name, nominal=getattr(self.task, name), **each) for name, each in known))

    @property
    def time_limit(self) -> int:
        """Control steps after which an episode is cut."""
        return self.task.time_limit

    @property
    def seconds(self) -> float:
        """Length of a control step, s."""
        from dr_lab.envs.lunar_lander.lander import SECONDS  # noqa: PLC0415 (Box2D is installed by those who use it)

        return SECONDS

    def make(
        self,
        source: ContextSource | None,
        slots: int,
        seed: int,
        threads: int | None = None,
        *,
        staggered: bool = False,
    ) -> BatchedEnv:
        """Landers in as many processes as `threads` says.

        Raises:
            MissingLibraryError: Box2D is not installed.
        """
        if find_spec("Box2D") is None:
            raise MissingLibraryError(f"env={self.name}", "Box2D")
        from dr_lab.envs.lunar_lander.episodes import LanderEpisodes  # noqa: PLC0415 (likewise)

        return BatchedEnv(
            LanderEpisodes(
                self.space,
                self.powers,
                self.time_limit,
                source,
                slots,
                seed,
                show_context=self.show_context,
                threads=threads,
                staggered=staggered,
            )
        )

    def powers(self, z: Array) -> Array:
        """Powers of main and side engines, shape (k, 2), in contexts (k, parameters)."""
        found = np.tile([getattr(self.task, name) for name in _POWERS], (len(z), 1))
        for column, name in enumerate(self.space.names):
            found[:, _POWERS.index(name)] = z[:, column]
        return found

    def scene(self, z: Array) -> mujoco.MjModel:
        """Hull, legs and pad, whatever the context; the ground, which is another in every episode, is left out."""
        del z
        return mujoco.MjModel.from_xml_path(self.mjcf)

    def scene_xml(self) -> str:
        """The scene as MJCF text."""
        return Path(self.mjcf).read_text(encoding="utf-8")
