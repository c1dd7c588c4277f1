"""One parameter at several places of a model."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import mujoco

from dr_lab.errors import ModelError
from dr_lab.physics.attribute import Edits
from dr_lab.physics.target import Target


@dataclass(frozen=True)
class SharedTarget:
    """Several scalars of the physics that always have the same value, e.g. the friction of all of a body's geoms.

    Attributes:
        places: where the value sits.
    """

    places: tuple[Target, ...]

    def __str__(self) -> str:
        """The text form."""
        return "[" + ", ".join(map(str, self.places)) + "]"

    def read(self, spec: mujoco.MjSpec) -> float:
        """Nominal value in the spec.

        Raises:
            ModelError: the places differ.
            UnknownNameError: an element is not in the model.
        """
        values = [place.read(spec) for place in self.places]
        if len(set(values)) > 1:
            found = ", ".join(f"{place} = {value:g}" for place, value in zip(self.places, values, strict=True))
            raise ModelError(f"Places of one parameter must have one nominal value; found {found}. Split it up.")
        return values[0]

    def write(self, spec: mujoco.MjSpec, value: float) -> None:
        """Set the value everywhere in a fresh spec (the caller's copy)."""
        for place in self.places:
            place.write(spec, value)

    def fields(self, model: mujoco.MjModel) -> Edits:
        """Compiled fields that carry the value, empty where the model must be recompiled."""
        each = [place.fields(model) for place in self.places]
        return tuple(edit for edits in each for edit in edits) if all(each) else ()


def places(targets: Iterable[Target | SharedTarget]) -> Iterator[Target]:
    """Where the values of several parameters sit, one after the other."""
    for target in targets:
        yield from target.places if isinstance(target, SharedTarget) else (target,)


def parse(given: object) -> Target | SharedTarget:
    """Read a target as a model's yaml gives it: one text, or a list of them for a value that several places share.

    Raises:
        ModelError: it is neither, or a text has another form.
        UnknownNameError: a kind or attribute does not exist.
    """
    if isinstance(given, str):
        return Target.parse(given)
    if isinstance(given, Sequence) and given:
        return SharedTarget(tuple(Target.parse(str(text)) for text in given))
    raise ModelError(f"Target {given!r} is neither a text such as body.arm.mass nor a list of such texts.")
