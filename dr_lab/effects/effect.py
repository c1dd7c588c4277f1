"""The contract of an effect: where it can sit, its parameters, and how it edits a fresh spec."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar, TypeVar

import mujoco

from dr_lab.effects.special_case import SpecialCase
from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.law import Law
from dr_lab.physics.parameter import Parameter
from dr_lab.physics.signal import Reading
from dr_lab.trajectory import Array

_Value = TypeVar("_Value", float, Array)

# from the joint outwards; of effects that data cannot separate, the first is tried first
FAMILIES = ("friction", "transmission", "actuator", "inertia", "environment", "sensing", "open")


@dataclass(frozen=True)
class Scales:
    """Typical magnitudes of the machine in its logs; they give an effect's bounds their size.

    Of joints that no channel measures they are those of the nominal model, as it moves in the logs.

    Attributes:
        lowest: lowest position by joint, rad or m.
        highest: highest position by joint, rad or m.
        speed: 95th percentile of |q̇| by joint, rad/s or m/s.
        torque: RMS generalised force needed for the measured motion by joint, N·m or N.
        command: largest |command| by actuator, in the command's unit.
        unmeasured: joints of which no channel tells the position.
        unknown: joints of which neither a channel nor the nominal model's motion tells anything.
    """

    lowest: Mapping[str, float]
    highest: Mapping[str, float]
    speed: Mapping[str, float]
    torque: Mapping[str, float]
    command: Mapping[str, float]
    unmeasured: frozenset[str] = frozenset()
    unknown: frozenset[str] = frozenset()

    @property
    def position(self) -> Mapping[str, float]:
        """Range of motion by joint, rad or m."""
        return {joint: self.highest[joint] - lowest for joint, lowest in self.lowest.items()}

    def assuming(self, magnitude: float) -> "Scales":
        """The scales if every joint that nothing is known of had the same magnitude, in SI units, in all respects."""
        assumed = dict.fromkeys(self.unknown, magnitude)
        reached = {joint: self.lowest[joint] + magnitude for joint in self.unknown}
        return replace(
            self,
            highest={**self.highest, **reached},
            speed={**self.speed, **assumed},
            torque={**self.torque, **assumed},
        )


class Effect(ABC):
    """One physical phenomenon that a model may lack.

    An implementation says in its docstring the law, the formula with units, the limits and the source, and fills the
    class attributes. Its parameters are zero effect at nominal, where the simulated output has a usable slope.

    Attributes:
        name: the catalogue's name, equal to the file's and the yaml's.
        family: one of `FAMILIES`.
        law: one line of physics.
        fingerprint: what the residual looks like when the effect is missing.
        confused_with: names of effects that given data may not separate from it.
        holds: names of effects that it acts as, at the same site, for some values of its parameters, and how.
        shapes: short names of parameters that act only where another parameter of it is away from absent.
        lacks: what an exported MJCF file cannot express of it, empty when it is native.
        argument: what the law is a function of, where a free law of that can be fitted in its place: ``command`` of the
            actuator, ``position`` of the joint, ``inertia`` of the body and of those beyond it; empty where it cannot.
        patience: times as many iterations as others get that a start away from absent needs to show its worth.
    """

    name: ClassVar[str]
    family: ClassVar[str]
    law: ClassVar[str]
    fingerprint: ClassVar[str]
    confused_with: ClassVar[tuple[str, ...]] = ()
    holds: ClassVar[Mapping[str, SpecialCase]] = {}
    shapes: ClassVar[tuple[str, ...]] = ()
    lacks: ClassVar[str] = ""
    argument: ClassVar[str] = ""
    patience: ClassVar[int] = 1

    @abstractmethod
    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the elements of the model at which the effect can sit."""

    @abstractmethod
    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Parameters at a site, with short names, nominal = absent and bounds scaled to the machine."""

    def prepare(self, spec: mujoco.MjSpec, site: str) -> None:
        """Write into a fresh spec at its nominal values what the effect needs there in every context.

        Raises:
            ModelError: it cannot act at this site of this model.
        """
        del spec, site

    @abstractmethod
    def edit(self, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        """Write the effect into a fresh spec; `values` by short parameter name.

        Raises:
            ModelError: it cannot act at this site of this model, at no value, absent included.
        """

    def reading(self, site: str, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """What a sensor reports of a channel; `read` itself for channels that the effect does not touch.

        Args:
            site: the element the effect sits at.
            values: by short parameter name, shape (c, 1, 1).
            channel: ``"<joint>.position"``, ``"<joint>.velocity"`` or ``"sensor.<name>"``.
            read: what the sensor would report without the effect.
            begin: s on the log's clock at which the windows start, shape (w, 1).
        """
        del site, values, channel, begin
        return read

    def command(
        self, site: str, values: Mapping[str, Array], actuator: str, series: Array, option: mujoco.MjOption
    ) -> Array:
        """What becomes of an actuator's commands beside the edit; `series` itself where the effect leaves them.

        Args:
            site: the element the effect sits at.
            values: by short parameter name, shape (c, 1, 1).
            actuator: the actuator's name.
            series: step averages of the commands, the past included, shape (c or 1, w, s).
            option: the model's options, which hold the step.
        """
        del site, values, actuator, option
        return series

    def drivers(self, site: str, values: Mapping[str, Array], compiled: mujoco.MjModel) -> tuple[Law, ...]:
        """What `command` does, step by step, for commands that are not known ahead.

        Args:
            site: the element the effect sits at.
            values: by short parameter name, one for each simulation, shape (n,).
            compiled: the compiled model with the effect.
        """
        del site, values, compiled
        return ()

    def force_laws(self, site: str, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """What acts from step to step beside the edit, where MJCF has no element for it.

        Args:
            site: the element the effect sits at.
            values: by short parameter name, one for each simulation, shape (n,).
            models: the compiled model of each simulation, with all effects at its context; the layout is the same.
        """
        del site, values, models
        return ()

    def lacking(self, site: str, values: Mapping[str, float], option: mujoco.MjOption) -> str:
        """What an exported MJCF file lacks of the effect at these values, empty if nothing."""
        del option
        settings = ", ".join(f"{name} {value:.6g}" for name, value in values.items())
        return f"{self.lacks} ({self.name}@{site}: {settings})" if self.lacks else ""

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Values away from absent from which a fit also starts (where the slope at absent is zero or misleading)."""
        del parameters
        return ()


@dataclass(frozen=True)
class PlacedEffect:
    """An effect at a site of one model; fulfils `physics.model.ModelEffect`.

    Attributes:
        effect: the phenomenon.
        site: the element it sits at.
        parameters: its parameters under their full names, ``"<effect>@<site>.<short name>"``.
        starts: full name → value, starts of a fit away from absent.
    """

    effect: Effect
    site: str
    parameters: tuple[Parameter, ...]
    starts: tuple[Mapping[str, float], ...] = field(default=())

    @property
    def label(self) -> str:
        """``effect@site``."""
        return f"{self.effect.name}@{self.site}"

    @property
    def absent(self) -> dict[str, float]:
        """Full name → nominal value of the parameters that make it act; it is absent where all of them are there."""
        shapes = {f"{self.label}.{name}" for name in self.effect.shapes}
        return {p.name: p.nominal for p in self.parameters if p.name not in shapes}

    def prepare(self, spec: mujoco.MjSpec) -> None:
        """Write into a fresh spec at its nominal values what the effect needs in every context."""
        self.effect.prepare(spec, self.site)

    def edit(self, spec: mujoco.MjSpec, values: Mapping[str, float]) -> None:
        """Write the effect into a fresh spec; `values` by full name."""
        self.effect.edit(spec, self.site, self._short(values))

    def reading(self, values: Mapping[str, Array], channel: str, read: Reading, begin: Array) -> Reading:
        """What a sensor reports of a channel; `values` by full name."""
        return self.effect.reading(self.site, self._short(values), channel, read, begin)

    def command(self, values: Mapping[str, Array], actuator: str, series: Array, option: mujoco.MjOption) -> Array:
        """What becomes of an actuator's commands; `values` by full name."""
        return self.effect.command(self.site, self._short(values), actuator, series, option)

    def drivers(self, values: Mapping[str, Array], compiled: mujoco.MjModel) -> tuple[Law, ...]:
        """What `command` does, step by step; `values` by full name."""
        return self.effect.drivers(self.site, self._short(values), compiled)

    def force_laws(self, values: Mapping[str, Array], models: Sequence[mujoco.MjModel]) -> tuple[Law, ...]:
        """What acts from step to step; `values` by full name."""
        return self.effect.force_laws(self.site, self._short(values), models)

    def lacking(self, values: Mapping[str, float], option: mujoco.MjOption) -> str:
        """What an exported MJCF file lacks of the effect; `values` by full name."""
        return self.effect.lacking(self.site, self._short(values), option)

    def _short(self, values: Mapping[str, _Value]) -> dict[str, _Value]:
        prefix = f"{self.label}."
        return {p.name.removeprefix(prefix): values[p.name] for p in self.parameters}


def place(effect: Effect, model: mujoco.MjModel, site: str, scales: Scales) -> PlacedEffect:
    """Put an effect at a site.

    Raises:
        UnknownNameError: the effect cannot sit there; the message lists where it can.
        ModelError: the effect declares no parameter, or the size of its bounds is not known.
    """
    sites = effect.sites(model)
    if site not in sites:
        raise UnknownNameError(f"site for {effect.name}", site, sites, "the model")
    short = effect.parameters(model, site, scales)
    if not short:
        raise ModelError(f"Effect {effect.name!r} declares no parameter at {site!r}.")
    if scales.unknown and short != effect.parameters(model, site, scales.assuming(1.0)):
        raise ModelError(
            f"The bounds of its parameters have no size: no channel measures {', '.join(sorted(scales.unknown))}, and "
            "the nominal model rests there in the logs, or diverges. Log the joint's position or excite it."
        )
    label = f"{effect.name}@{site}."
    full = tuple(Parameter(label + p.name, p.unit, p.nominal, p.low, p.high) for p in short)
    starts = tuple({label + k: v for k, v in start.items()} for start in effect.starts(short))
    return PlacedEffect(effect, site, full, starts)
