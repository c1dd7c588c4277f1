"""Overrides that Hydra refuses: which key failed, and the spelling for names that hold a dot."""

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TypeVar

from hydra.errors import ConfigCompositionException
from omegaconf import DictConfig
from omegaconf.errors import ConfigAttributeError, ConfigKeyError

_Made = TypeVar("_Made")


@dataclass(frozen=True)
class RefusedKey:
    """A key that an override names and the configuration does not have.

    Attributes:
        key: as typed, e.g. ``"model.parameters.arm.mass.low"``.
        prefix: its longest part that exists, e.g. ``"model.parameters"``; empty at the top.
        node: what lies at the prefix, or None where Hydra refused the key without looking into the configuration.
    """

    key: str
    prefix: str
    node: Mapping[str, object] | None


def refused_key(error: Exception) -> RefusedKey | None:
    """The key that an error of Hydra speaks of, if it is about an override of an unknown key."""
    found = re.match(r"Could not override '([^']+)'", str(error))
    if not isinstance(error, ConfigCompositionException) or found is None:
        return None
    cause = error.__cause__
    if isinstance(cause, ConfigAttributeError | ConfigKeyError) and isinstance(cause.parent_node, DictConfig):
        prefix = str(cause.full_key).removesuffix(str(cause.key)).removesuffix(".")
        key = found[1] if found[1].startswith(f"{prefix}.") or not prefix else str(cause.full_key)
        node = {str(name): cause.parent_node._get_node(name) for name in cause.parent_node}
        return RefusedKey(key, prefix, node)
    return RefusedKey(found[1], "", None)


def respell(arguments: list[str], refused: RefusedKey) -> list[str] | None:
    """Spell an override of a name that holds a dot, such as the parameter ``arm.mass``, so that Hydra takes it.

    Hydra reads every dot as a level, so ``model.parameters.arm.mass.low=0.1`` fails; the same is written
    ``model.parameters={arm.mass:{low:0.1}}``, which merges.

    Args:
        arguments: those of the command.
        refused: the key that failed.

    Returns:
        The arguments with that override respelt, or None where it has no dotted name or sweeps over several values.
    """
    names = _names(refused.key.removeprefix(f"{refused.prefix}."), refused.node)
    if not refused.prefix or names is None:
        return None
    for index, argument in enumerate(arguments):
        key, _, value = argument.partition("=")
        if key == refused.key and not _sweeps(value):
            nested = "".join(f"{{{name}:" for name in names) + value + "}" * len(names)
            return [*arguments[:index], f"{refused.prefix}={nested}", *arguments[index + 1 :]]
    return None


def composed(typed: Sequence[str], compose: Callable[[list[str]], _Made]) -> tuple[list[str], _Made]:
    """Compose, and respell what Hydra refuses for a name with a dot, once for each such name.

    Args:
        typed: overrides.
        compose: makes a configuration of them, or has Hydra run what it makes.

    Returns:
        The overrides as Hydra takes them, and what they make.

    Raises:
        hydra.errors.ConfigCompositionException: an override names nothing.
    """
    spelt = list(typed)
    while True:
        try:
            return spelt, compose(spelt)
        except ConfigCompositionException as error:
            refused = refused_key(error)
            respelt = None if refused is None else respell(spelt, refused)
            if respelt is None:
                raise
            spelt = respelt


def _names(rest: str, node: object) -> list[str] | None:
    """Split a key into the names that exist below a node, or None."""
    if not isinstance(node, Mapping):
        return None
    if rest in node:
        return [rest]
    for name in node:
        if rest.startswith(f"{name}."):
            below = _names(rest.removeprefix(f"{name}."), node[name])
            if below is not None:
                return [str(name), *below]
    return None


def _sweeps(value: str) -> bool:
    return re.search(r",(?![^\[{(]*[\]})])", value) is not None
