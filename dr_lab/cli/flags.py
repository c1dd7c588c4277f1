"""Flags that neither dr_lab nor Hydra knows, told before Hydra prints its usage at them."""

from collections.abc import Sequence
from itertools import pairwise
from typing import NoReturn

from hydra._internal.utils import get_args_parser

from dr_lab.errors import ConfigError, UnknownNameError


def require_known_flags(arguments: Sequence[str], verb: str) -> None:
    """Check the flags among a command's arguments.

    Args:
        arguments: what follows the verb.
        verb: for messages.

    Raises:
        UnknownNameError: a flag that does not exist.
        ConfigError: a flag lacks its value or has a wrong one.
    """
    parser = get_args_parser()  # not public, but what hydra.main reads flags with
    flags = [flag for action in parser._actions for flag in action.option_strings if flag.startswith("--")]

    def refuse(message: str) -> NoReturn:
        raise ConfigError(f"{message}. Flags: {', '.join(sorted(flags))}.")

    parser.error = refuse
    _, unknown = parser.parse_known_args(list(arguments))
    for word in unknown:
        name = word.partition("=")[0]
        if name.lstrip("-") != name:
            raise UnknownNameError("flag", name, flags, f"dr-lab {verb} (settings have no dashes: key=value)")


def values_of_flags(arguments: Sequence[str]) -> set[int]:
    """Where among a command's arguments the values of flags stand, such as ``job`` behind ``--cfg``.

    Args:
        arguments: what follows the verb.
    """
    taking = {
        name: action for action in get_args_parser()._actions if action.nargs != 0 for name in action.option_strings
    }
    found = ((at, taking[flag], word) for at, (flag, word) in enumerate(pairwise(arguments), 1) if flag in taking)
    return {at for at, action, word in found if action.nargs is None or word in (action.choices or ())}


def runs_jobs(arguments: Sequence[str]) -> bool:
    """Whether a command runs something, rather than show it.

    Args:
        arguments: what follows the verb.
    """
    known, _ = get_args_parser().parse_known_args(list(arguments))
    return not (known.cfg or known.info or known.hydra_help or known.shell_completion)
