"""What a model's yaml says of one free parameter."""

from collections.abc import Mapping

from dr_lab.errors import ModelError, UnknownNameError

_KEYS = ("target", "nominal", "unit", "low", "high")


def require_known(model: str, name: str, entry: Mapping[str, object]) -> None:
    """Check the keys of a parameter's entry.

    Raises:
        UnknownNameError: there is another key.
        ModelError: both target and nominal are given.
    """
    for key in entry:
        if key not in _KEYS:
            raise UnknownNameError("key", str(key), _KEYS, f"parameter {name!r} of model {model!r}")
    if {"target", "nominal"} <= set(entry):
        raise ModelError(
            f"Parameter {name!r} of model {model!r} has target and nominal. Delete nominal, which the file says, or "
            "target, if the parameter only enters what is derived."
        )


def value_of(model: str, name: str, entry: Mapping[str, object], key: str) -> object:
    """What stands under a key.

    Raises:
        ModelError: the key is missing.
    """
    if key not in entry:
        raise ModelError(
            f"Parameter {name!r} of model {model!r} has no {key!r}; given: {', '.join(map(str, entry)) or 'nothing'}. "
            "A parameter needs target, unit, low and high."
        )
    return entry[key]


def number(model: str, name: str, entry: Mapping[str, object], key: str) -> float:
    """The number that stands under a key.

    Raises:
        ModelError: the key is missing, or is no number.
    """
    value = value_of(model, name, entry, key)
    if not isinstance(value, int | float) or isinstance(value, bool):
        raise ModelError(f"Parameter {name!r} of model {model!r}: {key} = {value!r} is not a number.")
    return float(value)
