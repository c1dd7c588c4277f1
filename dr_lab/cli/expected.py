"""What a type hint asks of a value in a yaml file, in words."""

import types
import typing
from collections.abc import Mapping
from typing import Any

WORDS = {
    bool: "true or false",
    int: "a whole number",
    float: "a number",
    str: "a text",
    type(None): "null",
    Any: "anything",
    object: "anything",
}


def expected(hint: object) -> str:
    """What is expected, e.g. ``{name: [a number, …], …} or null``.

    Args:
        hint: one that speaks only of what yaml can hold.
    """
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if origin is typing.Literal:
        return " or ".join(map(repr, arguments))
    if origin in (types.UnionType, typing.Union):
        return " or ".join(map(expected, arguments))
    if origin in (dict, Mapping):
        return f"{{name: {expected(arguments[1])}, …}}"
    if origin is not None:
        return f"[{expected(arguments[0])}, …]"
    return {dict: "{name: anything, …}", **WORDS}.get(hint, "[anything, …]")  # pyright: ignore[reportArgumentType]
