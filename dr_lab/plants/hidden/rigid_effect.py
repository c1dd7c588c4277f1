"""What effects of bodies and gears have in common."""

from dr_lab.errors import ConfigError
from dr_lab.plants.hidden.effect import HiddenEffect
from dr_lab.plants.machine import Machine
from dr_lab.plants.mujoco_machine import MujocoMachine


class RigidEffect(HiddenEffect):
    """An effect of machines whose bodies stand in an MJCF file, whichever engine plays them."""

    def described(self, machine: Machine) -> MujocoMachine:
        """The machine, if it is one.

        Raises:
            ConfigError: it is not.
        """
        if not isinstance(machine, MujocoMachine):
            raise ConfigError(
                f"Hidden effect {self.label}: the bodies of this machine are lines without shape. Give a machine whose "
                "documents are an MJCF file: plant=strangers/elbow or another of that folder, or plant=arm."
            )
        return machine
