"""What is to be diagnosed: one machine with something hidden, one set of instruments, one seed."""

import itertools
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from dr_lab.errors import ConfigError, UnknownNameError

Kind = Literal["none", "single", "several", "outside"]
NOTHING = "none"


@dataclass(frozen=True)
class BenchmarkMachine:
    """A simulated machine, how it is diagnosed, and what can be hidden in it.

    Attributes:
        record: overrides of ``dr-lab record`` that choose the machine.
        diagnose: overrides of ``dr-lab diagnose`` that choose its model and how its logs are read.
        single: options of ``plant/hidden`` that hide one effect of the catalogue.
        several: options that hide several of them.
        outside: options that hide what the catalogue does not hold.
        none: options that hide nothing; a machine whose cases are listed one by one has none.
    """

    record: Sequence[str]
    diagnose: Sequence[str]
    single: Sequence[str]
    several: Sequence[str]
    outside: Sequence[str]
    none: Sequence[str] = (NOTHING,)

    def hidden(self, kind: Kind) -> Sequence[str]:
        """The options of ``plant/hidden`` that are of a kind."""
        options: dict[Kind, Sequence[str]] = {
            "none": self.none,
            "single": self.single,
            "several": self.several,
            "outside": self.outside,
        }
        return options[kind]


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
        label: name of a case that is listed by itself; its overrides hold what is hidden and what sees it.
        lenient: whether an honest abstention is right as well, for what the catalogue cannot hold yet.
    """

    machine: str
    kind: Kind
    hidden: str
    instruments: str
    seed: int
    record: tuple[str, ...]
    diagnose: tuple[str, ...]
    label: str = ""
    lenient: bool = False

    @property
    def name(self) -> str:
        """Name of the case, fit for a file."""
        if self.label:
            return self.label
        own = self.hidden.replace("/", "-").removeprefix(f"{self.machine}-")
        return f"{self.machine}-{own}-{self.instruments}-{self.seed}"

    def recording(self, instruments: str) -> list[str]:
        """Overrides of ``dr-lab record`` that make its logs, seen by an option of ``plant/instruments``."""
        seed = f"seed={self.seed}"
        if self.label:
            return [*self.record, seed]
        return [*self.record, f"plant/hidden={self.hidden}", f"plant/instruments={instruments}", seed]


class Cases(ABC):
    """A set of cases."""

    @abstractmethod
    def cases(self, set_name: str, machines: Mapping[str, BenchmarkMachine]) -> Iterator[Case]:
        """The cases of the machines that were chosen.

        Raises:
            UnknownNameError: the set asks for something hidden that its machine does not have.
        """


@dataclass(frozen=True)
class CaseSet(Cases):
    """Cases that are all combinations of machines, hidden effects, instruments and seeds.

    Attributes:
        kind: ``none``, ``single``, ``several`` effects, or an effect ``outside`` of the catalogue.
        instruments: options of ``plant/instruments``: the noise levels.
        seeds: of true parameters, clocks, excitation and jitter.
        hidden: by machine, which of its options of the kind; None takes all of all machines.
    """

    kind: Kind
    instruments: Sequence[str]
    seeds: Sequence[int]
    hidden: Mapping[str, Sequence[str]] | None = None

    def cases(self, set_name: str, machines: Mapping[str, BenchmarkMachine]) -> Iterator[Case]:
        """All combinations."""
        for name, machine in machines.items():
            known = machine.hidden(self.kind)
            options = known if self.hidden is None else self.hidden.get(name, ())
            for option, instruments, seed in itertools.product(options, self.instruments, self.seeds):
                if option not in known:
                    raise UnknownNameError("hidden effect", option, known, f"machine.{name}.{self.kind} ({set_name})")
                overrides = tuple(machine.record), tuple(machine.diagnose)
                yield Case(name, self.kind, option, instruments, seed, *overrides)


def expand(sets: Mapping[str, Cases], machines: Mapping[str, BenchmarkMachine]) -> tuple[Case, ...]:
    """The cases of several sets; those of the first seeds come first, a case of two sets once.

    Sets may speak of machines that were not chosen.

    Raises:
        UnknownNameError: a set asks for something hidden that its machine does not have.
        ConfigError: no case is left.
    """
    cases = dict.fromkeys(case for name, wanted in sets.items() for case in wanted.cases(name, machines))
    if not cases:
        raise ConfigError(
            f"No case is left: cases {', '.join(sets) or 'none'}, machines {', '.join(machines) or 'none'}. "
            "Choose them with benchmark=quick and machine=all."
        )
    return tuple(sorted(cases, key=lambda case: case.seed))
