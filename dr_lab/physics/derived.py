"""A scalar of the physics that follows from several parameters."""

from dataclasses import dataclass

from dr_lab.physics.expression import Expression
from dr_lab.physics.target import Target


@dataclass(frozen=True)
class Derived:
    """A place of the physics and the formula of what stands there, e.g. a rod's inertia m l²/12.

    Attributes:
        target: the place.
        formula: of parameters, by name.
    """

    target: Target
    formula: Expression

    @classmethod
    def parse(cls, target: str, formula: str, parameters: tuple[str, ...]) -> "Derived":
        """Read both as a model's yaml gives them.

        Raises:
            ModelError: the target has another form.
            UnknownNameError: its kind or attribute does not exist.
            ConfigError: the formula cannot be read, or uses a name that is no parameter.
        """
        return cls(Target.parse(target), Expression(str(formula), parameters))
