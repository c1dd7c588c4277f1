"""What the documents say of a machine, and how far the real one may be from it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

from dr_lab.bounds import at_least, below
from dr_lab.plants.machine import Machine
from dr_lab.seeding import stream


@dataclass(frozen=True, kw_only=True)
class Nominal(ABC):
    """Documented constants of a machine; some of them are only known to within a spread.

    Attributes:
        spread: the true values of what is not exactly known lie within ± this share of the documented ones.
    """

    spread: Annotated[float, at_least(0.0), below(1.0)]

    @abstractmethod
    def documented(self) -> dict[str, float]:
        """What is not exactly known, by the names under which the model declares it as a parameter, in SI units."""

    @abstractmethod
    def machine(self, true: Mapping[str, float]) -> Machine:
        """The machine with true values for what is not exactly known; all else is as documented."""

    def true_values(self, seed: int) -> dict[str, float]:
        """True values of the machine that a seed stands for, by the model's names."""
        return {
            name: value * (1 + self.spread * stream(seed, "truth", name).uniform(-1.0, 1.0))
            for name, value in self.documented().items()
        }
