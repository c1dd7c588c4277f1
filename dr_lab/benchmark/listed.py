"""Cases that are listed one by one: what is hidden where, how large, and what sees it."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from dr_lab.benchmark.case import NOTHING, BenchmarkMachine, Case, Cases, Kind
from dr_lab.errors import ConfigError

_HIDDEN = "plant/hidden=general/"


@dataclass(frozen=True)
class Entry:
    """One case of a list.

    Attributes:
        machine: its name.
        seed: of everything random in the logs.
        hide: ``option@site`` → numbers, options of ``plant/hidden/general`` in the order in which they act.
        instruments: option of ``plant/instruments``; None leaves the machine's own.
        record: further overrides of ``dr-lab record``.
        diagnose: further overrides of ``dr-lab diagnose``.
        lenient: whether an honest abstention is right as well.
    """

    machine: str
    seed: int
    hide: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    instruments: str | None = None
    record: Sequence[str] = ()
    diagnose: Sequence[str] = ()
    lenient: bool = False

    @property
    def hidden(self) -> str:
        """What is hidden, in words."""
        return " + ".join(self.hide) or NOTHING

    def overrides(self) -> tuple[str, ...]:
        """What hides it and what sees it, as overrides of ``dr-lab record``."""
        seen = [] if self.instruments is None else [f"plant/instruments={self.instruments}"]
        if len(self.hide) == 1:
            ((label, numbers),) = self.hide.items()
            effect, _, site = label.partition("@")
            return (f"{_HIDDEN}{effect}", *_numbers("plant.hidden", {"site": site, **numbers}), *seen, *self.record)
        parts: list[str] = [f"{_HIDDEN}several"] * bool(self.hide)
        for number, (label, numbers) in enumerate(self.hide.items(), start=1):
            effect, _, site = label.partition("@")
            place = f"plant.hidden.effects.part_{number}"
            parts += [f"+plant/hidden@{place}=general/{effect}", *_numbers(place, {"site": site, **numbers})]
        return (*parts, *seen, *self.record)


@dataclass(frozen=True)
class Listed(Cases):
    """Cases of one kind.

    Attributes:
        kind: ``none``, ``single``, ``several`` effects, or an effect ``outside`` of the catalogue.
        entries: by name, each with the fields of `Entry`.
    """

    kind: Kind
    entries: Mapping[str, Mapping[str, Any]]

    def cases(self, set_name: str, machines: Mapping[str, BenchmarkMachine]) -> Iterator[Case]:
        """The cases of the machines that were chosen.

        Raises:
            ConfigError: an entry has a field that there is not, or lacks one.
        """
        for name, fields in self.entries.items():
            try:
                entry = Entry(**fields)
            except TypeError as error:
                known = ", ".join(Entry.__dataclass_fields__)
                raise ConfigError(f"cases.{set_name}.entries.{name}: {error}. An entry has {known}.") from error
            if entry.machine in machines:
                machine = machines[entry.machine]
                yield Case(
                    machine=entry.machine,
                    kind=self.kind,
                    hidden=entry.hidden,
                    instruments=entry.instruments or "own",
                    seed=entry.seed,
                    record=(*machine.record, *entry.overrides()),
                    diagnose=(*machine.diagnose, *entry.diagnose),
                    label=name,
                    lenient=entry.lenient,
                )


def _numbers(place: str, numbers: Mapping[str, Any]) -> list[str]:
    return [f"{place}.{key}={_spelt(value)}" for key, value in numbers.items()]


def _spelt(value: object) -> str:
    """A value as Hydra reads it."""
    return f"[{','.join(map(_spelt, value))}]" if isinstance(value, list | tuple) else str(value)
