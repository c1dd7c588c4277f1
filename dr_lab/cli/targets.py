"""Finding the Python object behind a `_target_`, without letting a configuration run arbitrary code."""

import importlib
import os
from collections.abc import Callable
from typing import Any

from dr_lab.errors import ConfigError, UnknownNameError

TRUST_VARIABLE = "DR_LAB_TRUST"


def trusted() -> frozenset[str]:
    """Top-level packages whose objects a configuration may build: dr_lab, and those the user's shell names.

    The list comes from the environment and not from the configuration, because the file to guard against is a
    configuration: someone else's experiment or run folder.
    """
    named = os.environ.get(TRUST_VARIABLE, "").split(",")
    return frozenset({"dr_lab", *(name.strip() for name in named if name.strip())})


def locate(target: str, where: str) -> Callable[..., Any]:
    """The callable that a `_target_` names.

    Args:
        target: dotted path, e.g. ``"dr_lab.physics.model.load"``.
        where: the key that holds it, for messages.

    Raises:
        ConfigError: its package is not trusted, it cannot be imported, or it cannot be called.
        UnknownNameError: its module has no such name.
    """
    _require_trust(target, target, where)
    found = _import(target, where)
    # A trusted module may have imported something else: dr_lab.errors.difflib is not dr_lab's.
    _require_trust(str(getattr(found, "__module__", "")), target, where)
    if not callable(found):
        raise ConfigError(f"{where}: _target_ {target!r} is a {type(found).__name__}, expected a class or function.")
    return found


def _require_trust(module: str, target: str, where: str) -> None:
    allowed = trusted()
    if module.partition(".")[0] not in allowed:
        names = ", ".join(sorted(allowed))
        raise ConfigError(
            f"{where}: _target_ {target!r} is outside the trusted packages ({names}). "
            f"If the code is yours: {TRUST_VARIABLE}=your_package dr-lab …"
        )


def _import(target: str, where: str) -> object:
    module, _, name = target.rpartition(".")
    if not module:
        raise ConfigError(f"{where}: _target_ {target!r} names no module; expected package.module.Name.")
    try:
        loaded = importlib.import_module(module)
    except Exception as error:
        cause = f"{type(error).__name__}: {error}"
        raise ConfigError(f"{where}: _target_ {target!r} cannot be imported. {cause}") from error
    if not hasattr(loaded, name):
        public = [
            n for n, value in vars(loaded).items() if getattr(value, "__module__", None) == module and n[0] != "_"
        ]
        raise UnknownNameError("name", name, public, f"{module} ({where}._target_)")
    return getattr(loaded, name)
