"""What effects of contacts have in common."""

from dr_lab.errors import ConfigError
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine
from dr_lab.plants.mujoco_machine import MujocoMachine
from dr_lab.plants.pinocchio_machine import PinocchioMachine


class HiddenContactEffect(HiddenEffect):
    """An effect of all contacts of a machine, at the body that touches the ground."""

    def touching(self, machine: Machine) -> MujocoMachine:
        """The machine, if it is one that can touch anything.

        Raises:
            ConfigError: it cannot.
        """
        moved_by_other = isinstance(machine, PinocchioMachine)
        if not isinstance(machine, MujocoMachine) or moved_by_other or self.site not in machine.bodies:
            raise ConfigError(
                f"Hidden effect {self.label}: this machine has no contacts. Give one that has: plant=bouncer."
            )
        return machine
