"""The contract of a target: what stands for the real machine."""

from abc import ABC, abstractmethod
from typing import ClassVar

from tensordict import TensorDict

from dr_lab.collectors.collector import Drive
from dr_lab.envs.slots import Starts
from dr_lab.errors import ConfigError


def require_drive(drive: Drive | None) -> Drive:
    """What acts on a machine that does not move by itself.

    Raises:
        ConfigError: nothing does.
    """
    if drive is None:
        raise ConfigError("This target has no commands of its own. Give a policy or commands, or take target=logs.")
    return drive


class Target(ABC):
    """A machine whose parameters and effects nobody on this side knows.

    It can be played and no more: what is behind it cannot be read, and what it gives holds motions, not causes. It is
    made for a setting, whose task says what is seen and rewarded; a policy that sees the context is told the nominal
    one.

    Attributes:
        drivable: whether a policy or commands of one's choice can act on it, from starts of one's choice.
        nature: what it is, for a person who reads of "real" and must not take a simulation for hardware.
    """

    drivable: ClassVar[bool] = True
    nature: ClassVar[str] = "a target of your own"

    @abstractmethod
    def play(self, drive: Drive | None, starts: Starts | None, count: int) -> TensorDict:
        """Drive the machine for whole episodes.

        Args:
            drive: what acts. Commands are cut off at the actuators' bounds, and an episode ends after the last. None:
                what the machine was commanded when it was recorded, which only logs know.
            starts: positions (count, nq) and velocities (count, nv); None takes those of the machine.
            count: number of episodes.

        Returns:
            Size [count, t], as `collectors.play.play` gives it, without the context.

        Raises:
            ConfigError: this machine cannot be driven so, or is another one than the task's.
        """
