"""What an effect of a model does where it does nothing."""

from collections.abc import Mapping, Sequence

import mujoco

from dr_lab.physics.law import Law
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


class SilentEffect:
    """Edits nothing, changes no signal and adds no law; what a subclass leaves of `physics.model.ModelEffect`."""

    def prepare(self, spec: mujoco.MjSpec) -> None:
        """Nothing."""
        del spec

    def edit(self, spec: mujoco.MjSpec, values: Mapping[str, float]) -> None:
        """Nothing."""
        del spec, values

    def reading(self, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """What is read."""
        del values, channel, begin
        return read

    def command(self, values: Mapping[str, Array], actuator: str, series: Array, option: mujoco.MjOption) -> Array:
        """The commands as they are."""
        del values, actuator, option
        return series

    def drivers(self, values: Mapping[str, Array], compiled: mujoco.MjModel) -> tuple[Law, ...]:
        """None."""
        del values, compiled
        return ()

    def force_laws(self, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """None."""
        del values, models
        return ()

    def lacking(self, values: Mapping[str, float], option: mujoco.MjOption) -> str:
        """Nothing."""
        del values, option
        return ""
