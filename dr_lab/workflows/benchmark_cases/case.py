"""What is to be diagnosed: one machine with something hidden, one set of instruments, one seed."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from dr_lab.errors import ConfigError, UnknownNameError

Kind = Literal["none", "single", "several", "outside"]
NOTHING = "none"


@dataclass(frozen=True)
class Machine:
    """A simulated machine, how it is diagnosed, and what can be hidden in it.

    Attributes:
        record: overrides of ``dr-lab record`` that choose the machine.
        diagnose: overrides of ``dr-lab diagnose`` that choose its model and how its logs are read.
        single: options of ``plant/hidden`` that hide one effect of the catalogue.
        several: options that hide several of them.
        outside: options that hide what the catalogue does not hold.
    """

    record: Sequence[str]
    diagnose: Sequence[str]
    single: Sequence[str]
    several: Sequence[str]
    outside: Sequence[str]

    def hidden(self, kind: Kind) -> Sequence[str]:
        """The options of ``plant/hidden`` that are of a kind."""
        options: dict[Kind, Sequence[str]] = {
            "none": (NOTHING,),
            "single": self.single,
            "several": self.several,
            "outside": self.outside,
        }
        return options[kind]


@dataclass(frozen=True)
class CaseSet:
    """Cases that are all combinations of machines, hidden effects, instruments and seeds.

    Attributes:
        kind: ``none``, ``single``, ``several`` effects, or an effect ``outside`` of the catalogue.
        instruments: options of ``plant/instruments``: the noise levels.
        seeds: of true parameters, clocks, excitation and jitter.
        machines: which ones; None takes all.
        hidden: which options of the kind; None takes all.
    """

    kind: Kind
    instruments: Sequence[str]
    seeds: Sequence[int]
    machines: Sequence[str] | None = None
    hidden: Sequence[str] | None = None


@dataclass(frozen=True)
class Case:
    """One diagnosis of logs whose truth is known.

    Attributes:
        machine: its name.
        kind: ``none``, ``single``, ``several`` or ``outside``.
        hidden: option of ``plant/hidden``.
        instruments: option of ``plant/instruments``.
        seed: of everything random in the logs.
        record: overrides of ``dr-lab record`` that choose the machine.
        diagnose: overrides of ``dr-lab diagnose`` that choose its model.
    """

    machine: str
    kind: Kind
    hidden: str
    instruments: str
    seed: int
    record: tuple[str, ...]
    diagnose: tuple[str, ...]

    @property
    def name(self) -> str:
        """Name of the case, fit for a file."""
        own = self.hidden.replace("/", "-").removeprefix(f"{self.machine}-")
        return f"{self.machine}-{own}-{self.instruments}-{self.seed}"


def expand(sets: Mapping[str, CaseSet], machines: Mapping[str, Machine]) -> tuple[Case, ...]:
    """The cases of several sets; those of the first seeds come first, a case of two sets once.

    Raises:
        UnknownNameError: a set asks for something hidden that none of its machines knows.
        ConfigError: no case is left.
    """
    for name, wanted in sets.items():
        known = {option for machine in machines.values() for option in machine.hidden(wanted.kind)}
        foreign = set(wanted.machines or ()) - machines.keys()
        for option in wanted.hidden or ():
            if option not in known and not foreign:
                raise UnknownNameError(f"hidden effect of the kind {wanted.kind!r}", option, known, f"cases.{name}")
    cases = dict.fromkeys(case for wanted in sets.values() for case in _cases(wanted, machines))
    if not cases:
        raise ConfigError(
            f"No case is left: cases {', '.join(sets) or 'none'}, machines {', '.join(machines) or 'none'}. "
            "Choose them with benchmark=quick and machine=all."
        )
    return tuple(sorted(cases, key=lambda case: case.seed))


def _cases(wanted: CaseSet, machines: Mapping[str, Machine]) -> Iterator[Case]:
    for seed in wanted.seeds:
        for name, machine in machines.items():
            if wanted.machines is not None and name not in wanted.machines:
                continue
            for option in machine.hidden(wanted.kind):
                if wanted.hidden is not None and option not in wanted.hidden:
                    continue
                for instruments in wanted.instruments:
                    overrides = tuple(machine.record), tuple(machine.diagnose)
                    yield Case(name, wanted.kind, option, instruments, seed, *overrides)
