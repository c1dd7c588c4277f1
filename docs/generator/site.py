"""All generated pages, written anew at every build."""

import shutil
from pathlib import Path

from dr_lab.files import write_text
from generator import effects, groups, notebooks


def pages(*, figures: bool) -> dict[str, str]:
    """Markdown by path below ``generated/``.

    Args:
        figures: whether pages show plots.
    """
    return {**effects.pages(figures=figures), **groups.pages(), **notebooks.pages()}


def write(folder: Path, *, figures: bool) -> None:
    """Write the pages, and their plots.

    Args:
        folder: whose content they replace.
        figures: whether plots are drawn, which needs matplotlib.
    """
    shutil.rmtree(folder, ignore_errors=True)
    for name, text in pages(figures=figures).items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        write_text(folder / name, text)
    if figures:
        from generator.figure import draw  # noqa: PLC0415  matplotlib is no library of dr_lab
        from generator.signature import signature  # noqa: PLC0415

        for name, effect in effects.catalogue().items():
            draw(signature(effect), effects.figure_path(folder, name))
