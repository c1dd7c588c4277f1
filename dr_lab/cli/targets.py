"""Finding the Python object behind a `_target_`, without letting a configuration run arbitrary code."""

import importlib
import os
from collections.abc import Callable, Collection
from typing import Any

from dr_lab.errors import ConfigError, UnknownNameError
from dr_lab.extras import MissingLibraryError, lacking

TRUST_VARIABLE = "DR_LAB_TRUST"
# dr_lab's, and what Hydra builds for a sweep.
TRUSTED = ("dr_lab", "hydra_plugins", "hydra._internal.core_plugins", "optuna.samplers", "optuna.pruners")


def trusted() -> frozenset[str]:
    """Packages whose objects a configuration may build: those of `TRUSTED`, and those the user's shell names.

    The list comes from the environment and not from the configuration, because the file to guard against is a
    configuration: someone else's experiment or run folder.
    """
    named = os.environ.get(TRUST_VARIABLE, "").split(",")
    return frozenset({*TRUSTED, *(name.strip() for name in named if name.strip())})


def of_the_user(module: str) -> bool:
    """Whether a module belongs to a package that the user's shell names as trusted."""
    return any(f"{module}.".startswith(f"{package}.") for package in trusted() - {*TRUSTED})


def locate(target: str, where: str, beside: Collection[str] = ()) -> Callable[..., Any]:
    """The callable that a `_target_` names.

    Args:
        target: dotted path, e.g. ``"dr_lab.physics.model.load"``.
        where: the key that holds it, for messages.
        beside: packages that are trusted there, beside the others.

    Raises:
        ConfigError: its package is not trusted, it cannot be imported, or it cannot be called.
        UnknownNameError: its module has no such name.
    """
    allowed = trusted().union(beside)
    _require_trust(target, target, where, allowed)
    found = _import(target, where)
    # A trusted module may have imported something else: dr_lab.errors.difflib is not dr_lab's.
    _require_trust(str(getattr(found, "__module__", "")), target, where, allowed)
    if not callable(found):
        raise ConfigError(f"{where}: _target_ {target!r} is a {type(found).__name__}, expected a class or function.")
    return found


def _require_trust(module: str, target: str, where: str, allowed: Collection[str]) -> None:
    if not any(f"{module}.".startswith(f"{package}.") for package in allowed):
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
        if (library := lacking(error)) is not None:
            raise MissingLibraryError(f"{where}={target}", library) from error
        cause = f"{type(error).__name__}: {error}"
        raise ConfigError(
            f"{where}: _target_ {target!r} cannot be imported. {cause}{_on_path(error, module)}"
        ) from error
    if not hasattr(loaded, name):
        origins = {n: f"{getattr(value, '__module__', '')}." for n, value in vars(loaded).items() if n[0] != "_"}
        public = [n for n, origin in origins.items() if origin.startswith(f"{module}.")]  # a package shows its modules'
        raise UnknownNameError("name", name, public, f"{module} ({where}._target_)")
    return getattr(loaded, name)


def _on_path(error: Exception, module: str) -> str:
    """Where Python looks, where it is the user's own module that it does not find."""
    package = module.partition(".")[0]
    if not isinstance(error, ModuleNotFoundError) or error.name != package or not of_the_user(package):
        return ""
    return f". Say in which folder {package} lies: PYTHONPATH=FOLDER {TRUST_VARIABLE}={package} dr-lab …"
