"""The contract of an effect: where it can sit, its parameters, and how it edits a fresh spec."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from math import inf
from typing import ClassVar

import mujoco

from dr_lab.effects.special_case import SpecialCase
from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.effect_parts import CommandFilter, ForceLaw, SensorTransform, SpecEdit
from dr_lab.physics.model_effect import Value
from dr_lab.physics.parameter import Parameter

# From the joint outwards. Of effects that data cannot separate, the one of the earliest family is tried first.
FAMILIES = ("friction", "transmission", "actuator", "inertia", "environment", "sensing", "open")


_ACTING = (SpecEdit, SensorTransform, CommandFilter, ForceLaw)


@dataclass(frozen=True)
class Scales:
    """Typical magnitudes of the machine in its logs; they give an effect's bounds their size.

    For a joint that no channel measures they are those of the nominal model's motion in the logs.

    Attributes:
        lowest: lowest position by joint, rad or m.
        highest: highest position by joint, rad or m.
        speed: 95th percentile of |q̇| by joint, rad/s or m/s.
        torque: RMS generalised force needed for the measured motion by joint, N·m or N.
        command: largest |command| by actuator, in the command's unit.
        uncommanded: actuators whose command no log holds.
        unmeasured: joints of which no channel tells the position.
        unknown: joints of which neither a channel nor the nominal model's motion tells a magnitude.
    """

    lowest: Mapping[str, float]
    highest: Mapping[str, float]
    speed: Mapping[str, float]
    torque: Mapping[str, float]
    command: Mapping[str, float]
    uncommanded: frozenset[str] = frozenset()
    unmeasured: frozenset[str] = frozenset()
    unknown: frozenset[str] = frozenset()

    @property
    def position(self) -> Mapping[str, float]:
        """Range of motion by joint, rad or m."""
        return {joint: self.highest[joint] - lowest for joint, lowest in self.lowest.items()}

    def most_used(self, elements: Sequence[str]) -> str:
        """The one of some elements that had the largest command; the first one where none had any."""
        return max(elements, key=lambda name: self.command.get(name, 0.0))

    def assuming(self, magnitude: float) -> "Scales":
        """The scales with one magnitude, in SI units, assumed for all that is not known of the unknown joints."""
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

    An implementation also derives from the parts of `physics.effect_parts` in which it acts. Its docstring says the
    law, the formula with units, the limits and the source, and it fills the class attributes. At the nominal values of
    its parameters it is absent, and the simulated output has a usable slope there.

    Attributes:
        name: the catalogue's name, equal to the file's and the yaml's.
        family: one of `FAMILIES`.
        law: one line of physics.
        fingerprint: what the residual looks like when the effect is missing.
        confused_with: names of effects that given data may not separate from it.
        holds: its special cases: effects that it acts as, at the same site, for some values of its parameters, and how.
        shapes: short names of the parameters that act only while another one is away from absent.
        outlying: those of the shapes that may lie beyond where the machine moves, as a spring's rest position.
        sharpened: those of the shapes whose lower bound, above 0, may be halved: towards 0 the effect only becomes one
            of its special cases.
        divisors: short names of the parameters that the law divides by, so that 0 and less make none.
        limited: short names of other parameters whose bounds are physics, not where one looks first; see `limit`.
        lacks: what an exported MJCF file cannot express of it, empty when it is native.
        argument: what the law is a function of, if a free law of the same argument can check it: ``command`` of the
            actuator, ``position`` of the joint, ``inertia`` of the body and of those beyond it; otherwise empty.
        by_command: whether it makes something else of an actuator's command, which logs must hold then.
        attached: whether somebody attaches it to the machine: it is absent from logs that were recorded without, where
            the measurements tell which these are.
        patience: factor on the number of iterations after which a start away from absent is judged.
    """

    name: ClassVar[str]
    family: ClassVar[str]
    law: ClassVar[str]
    fingerprint: ClassVar[str]
    confused_with: ClassVar[tuple[str, ...]] = ()
    holds: ClassVar[Mapping[str, SpecialCase]] = {}
    shapes: ClassVar[tuple[str, ...]] = ()
    outlying: ClassVar[tuple[str, ...]] = ()
    sharpened: ClassVar[tuple[str, ...]] = ()
    divisors: ClassVar[tuple[str, ...]] = ()
    limited: ClassVar[tuple[str, ...]] = ()
    lacks: ClassVar[str] = ""
    argument: ClassVar[str] = ""
    by_command: ClassVar[bool] = False
    attached: ClassVar[bool] = False
    patience: ClassVar[int] = 1

    @abstractmethod
    def sites(self, model: mujoco.MjModel) -> tuple[str, ...]:
        """Names of the elements of the model at which the effect can sit."""

    @abstractmethod
    def parameters(self, model: mujoco.MjModel, site: str, scales: Scales) -> tuple[Parameter, ...]:
        """Parameters at a site, with short names, nominal = absent and bounds scaled to the machine."""

    def elements(self, model: mujoco.MjModel, site: str) -> tuple[str, ...]:
        """The elements at which it acts with the same values: the site, unless it stands for several."""
        del model
        return (site,)

    def shown_by(self, site: str, channels: Collection[str]) -> bool:
        """Whether logs of these channels can show the effect at a site as one of its own; else it is not looked for."""
        del site, channels
        return True

    def lacking(self, site: str, values: Mapping[str, float], option: mujoco.MjOption) -> str:
        """What an exported MJCF file lacks of the effect at these values, empty if nothing."""
        del option
        settings = ", ".join(f"{name} {value:.6g}" for name, value in values.items())
        return f"{self.lacks} ({self.name}@{site}: {settings})" if self.lacks else ""

    def limit(self, name: str, kept: float, margin: float) -> float:
        """How far from nominal a bound of a parameter may be moved where a fit runs into it; 0: not at all.

        Args:
            name: the parameter's short name.
            kept: s of commands before a window.
            margin: s of motion on either side of a window.
        """
        del kept, margin
        fixed = {*self.shapes, *self.limited} - {*self.outlying}
        return 0.0 if name in fixed else inf

    def within(self, parameters: tuple[Parameter, ...]) -> "Effect":
        """The effect for parameters with other bounds, by short names, where it makes room for what they allow."""
        del parameters
        return self

    def replayed(self, spec: mujoco.MjSpec, elements: Sequence[str]) -> "Effect":
        """The effect at these elements where all commands are known ahead; itself unless it is another one there."""
        del spec, elements
        return self

    def together(self, values: Mapping[str, float]) -> Mapping[str, float]:
        """What others of one parameter at the same site have that act exactly as this does; none where there are none.

        Args:
            values: the effect's, by short names.

        Returns:
            Their values by effect, in the unit of this one's first parameter.
        """
        del values
        return {}

    def starts(self, parameters: tuple[Parameter, ...]) -> tuple[Mapping[str, float], ...]:
        """Values away from absent from which a fit also starts (where the slope at absent is zero or misleading)."""
        del parameters
        return ()


@dataclass(frozen=True)
class PlacedEffect:
    """An effect at a site of one model; fulfils `physics.model_effect.ModelEffect`.

    Attributes:
        effect: the phenomenon.
        site: the element it sits at, or what stands for several.
        parameters: its parameters under their full names, ``"<effect>@<site>.<short name>"``.
        elements: those at which it acts.
        starts: full name → value, starts of a fit away from absent.
        looked: full name and bounds at first, of the parameters whose bounds were moved since.
    """

    effect: Effect
    site: str
    parameters: tuple[Parameter, ...]
    elements: tuple[str, ...]
    starts: tuple[Mapping[str, float], ...] = field(default=())
    looked: tuple[tuple[str, float, float], ...] = ()

    @property
    def label(self) -> str:
        """``effect@site``."""
        return f"{self.effect.name}@{self.site}"

    @property
    def attached(self) -> bool:
        """Whether it is absent from logs that were recorded without a load."""
        return self.effect.attached

    @property
    def absent(self) -> dict[str, float]:
        """Full name → nominal value of the parameters that make it act; it is absent where all of them are there."""
        shapes = {f"{self.label}.{name}" for name in self.effect.shapes}
        return {p.name: p.nominal for p in self.parameters if p.name not in shapes}

    def bounded(self, parameters: tuple[Parameter, ...]) -> "PlacedEffect":
        """The effect whose parameters, under the same full names, have other bounds or nominal values."""
        prefix = f"{self.label}."
        short = tuple(replace(p, name=p.name.removeprefix(prefix)) for p in parameters)
        return replace(self, effect=self.effect.within(short), parameters=parameters)

    def moved(self, parameters: tuple[Parameter, ...]) -> "PlacedEffect":
        """The effect with bounds that were moved from where one looks first, which is remembered."""
        looked = {name: (name, low, high) for name, low, high in self.looked}
        for before, after in zip(self.parameters, parameters, strict=True):
            if after != before:
                looked.setdefault(before.name, (before.name, before.low, before.high))
        return replace(self.bounded(parameters), looked=tuple(looked.values()))

    def replayed(self, spec: mujoco.MjSpec) -> "PlacedEffect":
        """The effect as it acts where all commands are known ahead."""
        effect = self.effect.replayed(spec, self.elements)
        return self if effect is self.effect else replace(self, effect=effect)

    def local(self, values: Mapping[str, Value]) -> dict[str, Value]:
        """The effect's own values by short name, out of a context's by full name."""
        prefix = f"{self.label}."
        return {p.name.removeprefix(prefix): values[p.name] for p in self.parameters}


def place(effect: Effect, model: mujoco.MjModel, site: str, scales: Scales) -> PlacedEffect:
    """Put an effect at a site.

    Raises:
        UnknownNameError: the effect cannot sit there; the message lists where it can.
        ModelError: the effect acts in no part of the physics or declares no parameter, no log holds the command that it
            changes, the size of its bounds is not known, or the model's file has it.
    """
    sites = effect.sites(model)
    if site not in sites:
        raise UnknownNameError(f"site for {effect.name}", site, sites, "the model")
    if not isinstance(effect, _ACTING):
        names = ", ".join(part.__name__ for part in _ACTING)
        raise ModelError(f"Effect {effect.name!r} does nothing. Derive {type(effect).__name__} from one of {names}.")
    elements = effect.elements(model, site)
    if effect.by_command and (blind := sorted({*elements} & scales.uncommanded)):
        raise ModelError(f"No log holds the command of {', '.join(blind)}, of which it would make something else.")
    sized = scales.most_used(elements)
    short = effect.parameters(model, sized, scales)
    if not short:
        raise ModelError(f"Effect {effect.name!r} declares no parameter at {site!r}.")
    if scales.unknown and short != effect.parameters(model, sized, scales.assuming(1.0)):
        raise ModelError(
            f"The bounds of its parameters have no size: no channel measures {', '.join(sorted(scales.unknown))}, and "
            "the nominal model rests there in the logs, or diverges. Log the joint's position or excite it."
        )
    label = f"{effect.name}@{site}."
    _require_new(model, label)
    full = tuple(Parameter(label + p.name, p.unit, p.nominal, p.low, p.high) for p in short)
    starts = tuple({label + k: v for k, v in start.items()} for start in effect.starts(short))
    return PlacedEffect(effect, site, full, elements, starts)


def _require_new(model: mujoco.MjModel, label: str) -> None:
    """Refuse an effect whose elements stand in the model's file, as where that is the improved one of an earlier run.

    Raises:
        ModelError: they do.
    """
    for kind, count in (("body", model.nbody), ("actuator", model.nactuator), ("tendon", model.ntendon)):
        for name in (getattr(model, kind)(row).name for row in range(count)):
            if f"{name}.".startswith(label):
                raise ModelError(
                    f"The model's file has this effect already, as {kind} {name!r}, which an earlier run wrote. Make "
                    "its numbers parameters of the model, or begin with the file that the run began with."
                )
