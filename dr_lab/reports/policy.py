"""What goes into an exported policy and what comes out; `policy.schema.json` says what each key means."""

from dataclasses import dataclass

SCHEMA = "dr_lab/policy/1"


@dataclass(frozen=True)
class InputEntry:
    """One input; its name is None where no single quantity equals it."""

    name: str | None


@dataclass(frozen=True)
class OutputEntry:
    """One output and its bounds."""

    name: str
    low: float
    high: float


@dataclass(frozen=True)
class PolicyReport:
    """An exported policy; `policy.json` holds it."""

    schema: str
    verb: str
    trained: str
    env: str
    seconds: float
    inputs: tuple[InputEntry, ...]
    seen: str
    outputs: tuple[OutputEntry, ...]
    notes: tuple[str, ...]
    run: str
