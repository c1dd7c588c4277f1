"""A cart swings its pole up on a rail whose length varies."""

from collections.abc import Sequence
from dataclasses import dataclass

from dr_lab.bounds import NotNegative, require_range
from dr_lab.envs.task import Values
from dr_lab.envs.tasks.cartpole import Cartpole
from dr_lab.errors import ConfigError
from dr_lab.physics.parameter import Parameter
from dr_lab.trajectory import Array


@dataclass(frozen=True, kw_only=True)
class CartpoleOnRail(Cartpole):
    """`Cartpole` that ends where the cart comes near the rail's end, at half of the length less a margin.

    Attributes: as `Cartpole`, and
        rail_range: of the rail's length, lowest and highest, m; nominal is the middle.
        rail_margin: m.

    Raises:
        ConfigError: the range is none, or the margins leave nothing of the shortest rail.
    """

    rail_range: Sequence[float]
    rail_margin: NotNegative

    def __post_init__(self) -> None:
        super().__post_init__()
        require_range(self.rail_range, "env.task.rail_range", "m")
        half = 0.5 * self.rail_range[0]
        if not self.rail_margin < half:
            raise ConfigError(
                f"env.task.rail_margin is {self.rail_margin:g} m at either end; expected less than half of the "
                f"shortest rail of env.task.rail_range, {half:g} m. Lower the margin, or begin the range higher."
            )

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The rail's length."""
        low, high = self.rail_range
        return (Parameter("rail.length", "m", 0.5 * (low + high), low, high),)

    def limits(self, count: int, values: Values) -> Array:
        """The same, but the cart's."""
        found = super().limits(count, values)
        found[:, 0] = 0.5 * values["rail.length"] - self.rail_margin
        return found
