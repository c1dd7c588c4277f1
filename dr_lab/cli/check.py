"""Checking a composed configuration against the signatures that it will call, before any work is done."""

import collections.abc
import inspect
import types
import typing
from collections.abc import Callable, Collection, Iterator, Mapping
from typing import Any

from omegaconf import DictConfig, OmegaConf
from typeguard import CollectionCheckStrategy, TypeCheckError, check_type

from dr_lab.cli.expected import expected
from dr_lab.cli.place import Place, interpolated
from dr_lab.cli.targets import locate
from dr_lab.errors import ConfigError, UnknownNameError

INSTRUCTIONS = ("_target_", "_args_", "_convert_", "_partial_", "_recursive_")
PLAIN = (bool, int, float, str, type(None), Any)
YAML = (dict, list, str, int, float, type(None))
CONTAINERS = (list, dict, collections.abc.Sequence, collections.abc.Mapping, typing.Literal, types.UnionType)


def check(
    cfg: DictConfig, workflow: Callable[..., Any], verb: str, supplied: Collection[str], unused: Collection[str] = ()
) -> None:
    """Check the whole of a job's configuration.

    Args:
        cfg: the composed configuration without Hydra's node.
        workflow: the function that takes the top-level keys as keyword arguments.
        verb: its name, for messages.
        supplied: parameters of the workflow that do not come from the configuration.
        unused: top-level keys that the workflow does not get.

    Raises:
        ConfigError: a value is missing or of the wrong type, or a target cannot be built.
        UnknownNameError: a key is no parameter of what it configures.
        omegaconf.errors.OmegaConfBaseException: an interpolation leads nowhere.
    """
    missing = sorted(_missing(OmegaConf.to_container(cfg, resolve=False), ""))
    if missing:
        given = " ".join(f"{key}=…" for key in missing)
        raise ConfigError(f"No value for {', '.join(missing)}. Give one: dr-lab {verb} {given}")
    values = OmegaConf.to_container(cfg, resolve=True)
    if not isinstance(values, dict):
        raise ConfigError(f"The configuration of {verb} is a {type(values).__name__}, expected keys with values.")
    plain = {str(key): value for key, value in values.items() if key not in unused}
    top = Place(sources=interpolated(cfg))
    _check_call(plain, workflow, f"dr-lab {verb}", top, supplied)
    check_targets(plain, top)


def _missing(value: object, path: str) -> Iterator[str]:
    """Keys that wait for a value; `OmegaConf.missing_keys` fails where a resolver would be given one of them."""
    if isinstance(value, Mapping):
        for key, child in value.items():
            yield from _missing(child, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list):
        for index, child in enumerate(value):
            yield from _missing(child, f"{path}[{index}]")
    elif value == "???":
        yield path


def check_targets(value: object, place: Place) -> None:
    """Check every `_target_` below a value against the signature of what it names.

    Args:
        value: of a configuration, interpolations resolved.
        place: its key.

    Raises:
        ConfigError: a value is missing or of the wrong type, or a target cannot be built.
        UnknownNameError: a key is no parameter of what it configures.
    """
    if isinstance(value, Mapping):
        if "_target_" in value:
            _check_target(value, place)
        for key, child in value.items():
            check_targets(child, place.below(key))
    elif isinstance(value, list):
        for index, child in enumerate(value):
            check_targets(child, place.item(index))


def _check_target(node: Mapping[str, Any], place: Place) -> None:
    target = node["_target_"]
    function = locate(str(target), str(place))
    arguments = {key: value for key, value in node.items() if key not in INSTRUCTIONS}
    incomplete = node.get("_partial_", False) or "_args_" in node
    supplied = _parameters(function) if incomplete else ()
    _check_call(arguments, function, str(target), place, supplied)


def _check_call(
    arguments: Mapping[str, Any], function: Callable[..., Any], name: str, place: Place, supplied: Collection[str]
) -> None:
    """Check keyword arguments against a signature: none unknown, none missing, plain ones of the right type."""
    parameters = _parameters(function)
    named = {k: p for k, p in parameters.items() if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)}
    open_ended = any(p.kind is p.VAR_KEYWORD for p in parameters.values())
    keys = [key for key in named if key not in supplied or key in arguments]
    for key, value in arguments.items():
        if key in named:
            _check_type(value, named[key].annotation, place.below(key), name)
        elif not open_ended:
            raise UnknownNameError("key", f"{place.below(key)}", [f"{place.below(k)}" for k in keys], name)
    lacking = [k for k in keys if k not in arguments and named[k].default is inspect.Parameter.empty]
    if lacking:
        listed = ", ".join(str(place.below(key)) for key in lacking)
        group = f" Keys of one that is complete: --cfg job -p {place.key.partition('.')[0]}." if place.key else ""
        raise ConfigError(f"{name} needs {listed}; the configuration has no such key.{group}")


def _parameters(function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(function, eval_str=True).parameters
    except NameError:  # an annotation that only exists for the type checker
        return inspect.signature(function).parameters


def _check_type(value: object, hint: object, place: Place, name: str) -> None:
    if isinstance(value, Mapping) and "_target_" in value:
        _check_class(str(value["_target_"]), hint, place, name)
        return
    if isinstance(value, Mapping) and _objects(hint) is not None:
        for child, content in value.items():
            _check_type(content, _objects(hint), place.below(child), name)
        return
    if _has_target(value):
        return
    if not _is_plain(hint):
        _check_object(value, hint, place, name)
        return
    if not _fits(value, hint):
        given = "null" if value is None else repr(value)
        whole = isinstance(value, float) and value.is_integer() and _fits(int(value), hint)
        remedy = f" Write {place}={value:.0f}." if whole else ""
        raise ConfigError(f"{place} is {given}; {name} expects {expected(hint)}.{remedy}")


def _fits(value: object, hint: object) -> bool:
    if isinstance(value, str) and not _takes_text(hint):  # a str is a sequence of str, but never meant as one
        return False
    try:
        check_type(value, hint, collection_check_strategy=CollectionCheckStrategy.ALL_ITEMS)
    except TypeCheckError:
        return False
    return True


def _objects(hint: object) -> object:
    """The class of a mapping's values, or None where a type hint is no mapping to objects of a class."""
    if typing.get_origin(hint) not in (dict, Mapping):
        return None
    _, values = typing.get_args(hint)
    return values if inspect.isclass(values) and values is not object and not _is_plain(values) else None


def _check_class(target: str, hint: object, place: Place, name: str) -> None:
    """Check that what a `_target_` builds is what is expected, where both are classes that say so."""
    built = locate(target, str(place))
    if not inspect.isclass(built) or not inspect.isclass(hint) or typing.get_origin(hint) is not None:
        return
    if not getattr(hint, "_is_protocol", False) and not issubclass(built, hint):
        raise ConfigError(f"{place}: _target_ {target!r} is no {hint.__name__}, which {name} expects there.")


def _check_object(value: object, hint: object, place: Place, name: str) -> None:
    """Check a value that should have been built from a `_target_`, but names none."""
    if inspect.isclass(hint) and hint is not inspect.Parameter.empty and isinstance(value, YAML):
        raise ConfigError(
            f"{place} names no class: its yaml lacks the line _target_: package.module.Name, from which {name} expects "
            f"{_a(hint.__name__)}."
        )


def _a(noun: str) -> str:
    return f"{'an' if noun[0] in 'AEIO' else 'a'} {noun}"


def _takes_text(hint: object) -> bool:
    """Whether a plain type hint admits a string as such."""
    if typing.get_origin(hint) in (types.UnionType, typing.Union):
        return any(map(_takes_text, typing.get_args(hint)))
    return hint in (str, Any, object) or typing.get_origin(hint) is typing.Literal


def _is_plain(hint: object) -> bool:
    """Whether a type hint speaks only of what yaml can hold; others are the target's own business."""
    origin = typing.get_origin(hint)
    if origin is typing.Literal:
        return True
    if origin in CONTAINERS or origin is typing.Union:
        return all(_is_plain(argument) for argument in typing.get_args(hint))
    return hint in PLAIN


def _has_target(value: object) -> bool:
    if isinstance(value, Mapping):
        return "_target_" in value or any(map(_has_target, value.values()))
    return isinstance(value, list) and any(map(_has_target, value))
