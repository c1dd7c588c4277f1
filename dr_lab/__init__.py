"""dr_lab: find why a simulator disagrees with its robot, fix it, and randomise around the rest."""

from typing import TYPE_CHECKING

from dr_lab.version import __version__

if TYPE_CHECKING:
    from dr_lab.control import load_controller
    from dr_lab.notebook import NotebookComparison as Comparison
    from dr_lab.notebook import evaluate, record, train

__all__ = ["Comparison", "__version__", "evaluate", "load_controller", "record", "train"]

_OF_NOTEBOOKS = {"Comparison": "NotebookComparison", "evaluate": "evaluate", "record": "record", "train": "train"}


def __dir__() -> list[str]:
    """What a notebook offers to complete."""
    return sorted({*globals(), *__all__})


def __getattr__(name: str) -> object:
    """Import what notebooks and control loops use when it is first asked for, so that ``import dr_lab`` stays light."""
    if name in _OF_NOTEBOOKS:
        from dr_lab import notebook  # noqa: PLC0415  Hydra and MuJoCo take half a second

        return getattr(notebook, _OF_NOTEBOOKS[name])
    if name == "load_controller":
        from dr_lab.control import load_controller  # noqa: PLC0415  PyTorch takes two seconds

        return load_controller
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
