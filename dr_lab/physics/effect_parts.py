"""The parts of which an effect is made. An effect has those that it needs; the others are absent."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence

import mujoco

from dr_lab.physics.law import Law
from dr_lab.physics.pseudo_inertia import Rooted
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array


class SpecPreparation(ABC):
    """What the spec needs in every context, whatever the values of the parameters."""

    @abstractmethod
    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Write it into a fresh spec, before any parameter is written.

        Raises:
            ModelError: the effect cannot act at this site of this model.
        """


class SpecEdit(ABC):
    """What MJCF itself can express."""

    @abstractmethod
    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Write the effect into a fresh spec.

        Args:
            spec: the spec, with the model's own parameters and the effects before this one written into it.
            site: the element the effect sits at.
            values: by short parameter name.

        Raises:
            ModelError: the effect cannot act at this site of this model, at no value, absent included.
        """

    def expressible(self, values: Mapping[str, float], option: mujoco.MjOption) -> bool:
        """Whether MJCF can express the effect at these values, by short parameter name; otherwise it has none there."""
        del values, option
        return True


class AddedBody(ABC):
    """A body that a `SpecEdit` adds under the effect's label, whose mass, centre and inertia are its parameters."""

    @abstractmethod
    def added(self, values: Mapping[str, Array]) -> Rooted:
        """The bodies at n values each, in a frame that no parameter moves.

        Args:
            values: by short parameter name, shape (n,).
        """

    @abstractmethod
    def values_of(self, body: Rooted) -> dict[str, Array]:
        """The values at which it is these bodies, as for `added`."""


class SensorTransform(ABC):
    """What lies between the motion and its record."""

    @abstractmethod
    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """What a sensor reports of a channel; `read` itself for channels that the effect does not touch.

        Args:
            site: the element the effect sits at.
            values: by short parameter name, shape (c, 1, 1).
            channel: ``"<joint>.position"``, ``"<joint>.velocity"`` or ``"sensor.<name>"``.
            read: what the sensor would report without the effect.
            begin: s on the log's clock at which the windows start, shape (w, 1).
        """


class CommandFilter(ABC):
    """What becomes of commands before they reach the actuator at the effect's site.

    Those that need commands of before a start, as they shift them, come last: what a filter does at one time it also
    does later, and commands between steps are clearer than what clipping makes of them.
    """

    @property
    def memory(self) -> float:
        """Time in s before a start of which the commands must be known."""
        return 0.0

    @abstractmethod
    def filtered(self, values: Mapping[str, Array], series: Array, option: mujoco.MjOption) -> Array:
        """A recorded series of commands behind the filter; `series` itself where these values leave it.

        Args:
            values: by short parameter name, shape (c, 1, 1).
            series: step averages of the commands, the past included, shape (c or 1, w, s).
            option: the model's options, which hold the step.

        Returns:
            Step averages behind the filter, shape (c or 1, w, s).
        """


class StepwiseFilter(CommandFilter):
    """A command filter that also acts on commands that are not known ahead, as those of a policy."""

    @abstractmethod
    def driver(self, values: Mapping[str, Array], column: int, step: float) -> Law:
        """The filter as a law that changes the command of each step.

        Args:
            values: by short parameter name, one for each simulation, shape (n,).
            column: of the actuator's command in the controls.
            step: length of a step in s.
        """


class ForceLaw(ABC):
    """What acts from step to step, where MJCF has no element for it."""

    @abstractmethod
    def force_law(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> Law:
        """The law with the values of n simulations.

        Args:
            site: the element the effect sits at.
            values: by short parameter name, one for each simulation, shape (n,).
            models: the compiled model of each simulation, with all effects at its context; the layout is the same.
        """
