"""Checking a composed configuration against the signatures that it will call, before any work is done."""

import collections.abc
import inspect
import types
import typing
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Any

from omegaconf import DictConfig, OmegaConf

from dr_lab.bounds import Bound
from dr_lab.cli.expected import expected
from dr_lab.cli.place import Place, interpolated
from dr_lab.cli.targets import locate
from dr_lab.errors import ConfigError, DrLabError, UnknownNameError

INSTRUCTIONS = ("_target_", "_args_", "_convert_", "_partial_", "_recursive_")
PLAIN = (bool, int, float, str, type(None), Any)
YAML = (dict, list, str, int, float, type(None))
_INFINITE = (".inf", "-.inf")  # as a yaml file has it; in an override it is a text
CONTAINERS = (list, dict, collections.abc.Sequence, collections.abc.Mapping, typing.Literal, types.UnionType)


def check(
    cfg: DictConfig, workflow: Callable[..., Any], verb: str, supplied: Collection[str], unused: Collection[str] = ()
) -> None:
    """Check the whole of a job's configuration, and tell all that is wrong at once.

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
    _tell(chain(_in_call(plain, workflow, f"dr-lab {verb}", top, supplied), _in_targets(plain, top)))


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
    _tell(_in_targets(value, place))


def _tell(faults: Iterator[tuple[Place, DrLabError]]) -> None:
    """Raise what is wrong, each key once: a value that several others take is wrong in one place."""
    by_place: dict[str, DrLabError] = {}
    for place, fault in faults:
        by_place.setdefault(place.key, fault)
    if len(by_place) > 1:
        raise ConfigError("\n".join(map(str, by_place.values())))
    for fault in by_place.values():
        raise fault


def _in_targets(value: object, place: Place) -> Iterator[tuple[Place, DrLabError]]:
    """What is wrong with the targets below a value."""
    if isinstance(value, Mapping):
        if "_target_" in value:
            yield from _in_target(value, place)
        for key, child in value.items():
            yield from _in_targets(child, place.below(key))
    elif isinstance(value, list):
        for index, child in enumerate(value):
            yield from _in_targets(child, place.item(index))


def _in_target(node: Mapping[str, Any], place: Place) -> Iterator[tuple[Place, DrLabError]]:
    target = node["_target_"]
    try:
        function = locate(str(target), str(place))
    except DrLabError as fault:
        yield place, fault
        return
    arguments = {key: value for key, value in node.items() if key not in INSTRUCTIONS}
    incomplete = node.get("_partial_", False) or "_args_" in node
    supplied = _parameters(function) if incomplete else ()
    yield from _in_call(arguments, function, str(target), place, supplied)


def _in_call(
    arguments: Mapping[str, Any], function: Callable[..., Any], name: str, place: Place, supplied: Collection[str]
) -> Iterator[tuple[Place, DrLabError]]:
    """What is wrong with keyword arguments by a signature: some unknown, some missing, plain ones of the wrong type."""
    parameters = _parameters(function)
    named = {k: p for k, p in parameters.items() if p.kind not in (p.VAR_KEYWORD, p.VAR_POSITIONAL)}
    open_ended = any(p.kind is p.VAR_KEYWORD for p in parameters.values())
    keys = [key for key in named if key not in supplied or key in arguments]
    for key, value in arguments.items():
        if key in named:
            yield from _in_value(value, named[key].annotation, place.below(key), name)
        elif not open_ended:
            there = place.below(key)
            yield there, UnknownNameError("key", f"{there}", [f"{place.below(k)}" for k in keys], name)
    lacking = [k for k in keys if k not in arguments and named[k].default is inspect.Parameter.empty]
    if lacking:
        listed = ", ".join(str(place.below(key)) for key in lacking)
        more = (
            f"Keys of one that is complete: --cfg job -p {place.key.partition('.')[0]}."
            if place.key
            else f"Options of a group bring it, of which none is chosen; {name} --help lists them."
        )
        yield place, ConfigError(f"{name} needs {listed}; the configuration has no such key. {more}")


def _parameters(function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    try:
        return inspect.signature(function, eval_str=True).parameters
    except NameError:  # an annotation that only exists for the type checker
        return inspect.signature(function).parameters


def _in_value(value: object, hint: object, place: Place, name: str) -> Iterator[tuple[Place, DrLabError]]:
    """What is wrong with a value by its type hint, and by the bounds that are stated there."""
    bounds: Sequence[object] = ()
    if typing.get_origin(hint) is typing.Annotated:
        hint, *bounds = typing.get_args(hint)
    if isinstance(value, Mapping) and "_target_" in value:
        fault = _of_class(str(value["_target_"]), hint, place, name)
    elif isinstance(value, Mapping) and _objects(hint) is not None:
        for child, content in value.items():
            yield from _in_value(content, _objects(hint), place.below(child), name)
        return
    elif _has_target(value):
        return
    elif not _is_plain(hint):
        fault = _of_object(value, hint, place, name)
    else:
        fault = _of_bounds(value, bounds, place) if _fits(value, hint) else _of_plain(value, hint, place)
    if fault is not None:
        yield place, ConfigError(fault)


def _of_bounds(value: object, bounds: Iterable[object], place: Place) -> str | None:
    """What is wrong with a number, or a list of numbers, by its bounds."""
    if not isinstance(value, int | float | list):
        return None
    stated = (bound for bound in bounds if isinstance(bound, Bound))
    return next((bound.fault(str(place), value) for bound in stated if not bound.holds(value)), None)


def _of_plain(value: object, hint: object, place: Place) -> str:
    """What to say of a value of the wrong type, with what was probably meant."""
    given = "null" if value is None else repr(value)
    remedy = ""
    if isinstance(value, float) and value.is_integer() and _fits(int(value), hint):
        remedy = f" Write {place}={value:.0f}."
    elif value in _INFINITE and _fits(float("inf"), hint):
        remedy = f" On the command line write {place}={str(value).replace('.', '')}; {value} is how a yaml file has it."
    elif isinstance(value, str) and _fits([value], hint):
        remedy = f" Write '{place}=[{value}]'."
    return f"{place} is {given}; expected {expected(hint)}.{remedy}"


def _fits(value: object, hint: object) -> bool:
    if isinstance(value, str) and not _takes_text(hint):  # a str is a sequence of str, but never meant as one
        return False
    from typeguard import CollectionCheckStrategy, TypeCheckError, check_type  # noqa: PLC0415  --help need not wait for it

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


def _of_class(target: str, hint: object, place: Place, name: str) -> str | None:
    """What is wrong with what a `_target_` builds, where it and what is expected are classes that say so."""
    try:
        built = locate(target, str(place))
    except DrLabError as fault:
        return str(fault)
    if not inspect.isclass(built) or not inspect.isclass(hint) or typing.get_origin(hint) is not None:
        return None
    if getattr(hint, "_is_protocol", False) or issubclass(built, hint):
        return None
    return f"{place}: _target_ {target!r} is no {hint.__name__}, which {name} expects there."


def _of_object(value: object, hint: object, place: Place, name: str) -> str | None:
    """What is wrong with a value that should have been built from a `_target_`, but names none."""
    if typing.get_origin(hint) is Callable and isinstance(value, YAML):
        given = "null" if value is None else repr(value)
        return (
            f"{place} is {given}; {name} expects a section there, which it calls (_target_ and _partial_: true). Set "
            f"one of its keys, {place}.KEY=…; --cfg job -p {place} shows them where nothing stands in its place."
        )
    if not inspect.isclass(hint) or hint is inspect.Parameter.empty or not isinstance(value, YAML):
        return None
    return (
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
