"""How a force is learned that no effect explains."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

from dr_lab.bounds import Count, Natural, Positive, Share, at_least, require_bounds
from dr_lab.errors import ConfigError


@dataclass(frozen=True)
class LearningSettings:
    """How a force is learned that no effect explains.

    Attributes:
        joints: most joints at which `dr-lab close` learns one; 0 for none.
        inputs: most quantities that it depends on.
        worth: share of the cost that a further quantity must remove of parts of the logs that a step did not see.
        centres: most bell curves that it is made of.
        widths: of the bell curves that are tried, in standard deviations of a quantity.
        sizes: standard deviations of the force that are tried, in the joint's typical torque.
        fade: over which it falls to zero beyond what was seen, in widths.
        states: how many of the logs the bell curves are placed by.
        parts: of a window, in each of which the force of a linear step is taken for its mean.
        rounds: most linear steps.
        refit: most steps of a refit of all parameters after each.
        least: share of the cost that a further step must remove of the fitted windows.
        most: largest factor on the learned force when it is fitted with all parameters, which begins at 1.
        better: share of the squared predicted error of the held-out logs that it must remove.
        worse: share by which the squared predicted error of one of them may rise.

    Raises:
        ConfigError: a number is out of its bounds, or there is no width or size.
    """

    joints: Natural
    inputs: Count
    worth: Share
    centres: Count
    widths: Sequence[float]
    sizes: Sequence[float]
    fade: Positive
    states: Annotated[int, at_least(2)]
    parts: Count
    rounds: Count
    refit: Count
    least: Share
    most: Annotated[float, at_least(1.0)]
    better: Share
    worse: Share

    def __post_init__(self) -> None:
        require_bounds(self, "learning")
        for name in ("widths", "sizes"):
            values = getattr(self, name)
            if not values or min(values) <= 0:
                raise ConfigError(f"learning.{name} is {list(values)}; expected numbers above 0, one at least.")
