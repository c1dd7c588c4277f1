"""Libraries that only a part of dr_lab needs: which extra brings each, and what is said where one is missing."""

import shlex
import sys
from pathlib import Path

from dr_lab.errors import ConfigError

EXTRAS = {
    **dict.fromkeys(("onnx", "onnxruntime", "onnxscript", "optuna", "tensordict", "torch", "torchrl"), "train"),
    "Box2D": "box2d",
    "pinocchio": "strangers",
    "ray": "ray",
}
CHECKOUT = Path(__file__).resolve().parents[1]


class MissingLibraryError(ConfigError):
    """A library of an extra that is not installed; the message says which command installs it.

    Args:
        needed_by: what needs it, e.g. the verb ``train``.
        module: how it is imported; a key of `EXTRAS`.
        further: what else the user should know.
    """

    def __init__(self, needed_by: str, module: str, further: str = "") -> None:
        remedy = _installing(EXTRAS[module])
        super().__init__(f"{needed_by} needs {module}, which is not installed. Install it: {remedy}{further}")


def lacking(error: BaseException) -> str | None:
    """The library of an extra that an import failed for, or None where it failed for anything else."""
    return error.name if isinstance(error, ModuleNotFoundError) and error.name in EXTRAS else None


def _installing(extra: str) -> str:
    """The command that adds an extra to this installation; a checkout's own .venv has them all by its Makefile."""
    if Path(sys.prefix).resolve() == CHECKOUT / ".venv":
        return f"make -C {shlex.quote(str(CHECKOUT))} install"
    return f"pip install 'dr_lab[{extra}]'"
