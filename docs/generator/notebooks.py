"""The notebooks of examples/ as pages: text between ``# %% [markdown]`` and ``# %%``, code behind ``# %%``."""

import re
from pathlib import Path

from generator.text import code

EXAMPLES = Path(__file__).parents[2] / "examples"
_CELL = re.compile(r"^# %%", re.MULTILINE)


def pages() -> dict[str, str]:
    """Markdown by path below ``generated/``."""
    names = sorted(path.stem for path in EXAMPLES.glob("*.py"))
    found = {f"notebooks/{name}.md": page(EXAMPLES / f"{name}.py") for name in names}
    told = (
        "Each is a Python file with cells (`# %%`), which VS Code, PyCharm and Jupyter with Jupytext open as a "
        "notebook and plain Python runs. The slow tests run all of them."
    )
    lines = ["# Notebooks", "", told, "", "```{toctree}", "", *names, "```", ""]
    return {"notebooks/index.md": "\n".join(lines), **found}


def page(path: Path) -> str:
    """A notebook as Markdown.

    Args:
        path: a Python file in percent format.
    """
    lines = []
    for cell in _CELL.split(path.read_text(encoding="utf-8"))[1:]:
        head, _, body = cell.partition("\n")
        if "[markdown]" in head:
            lines += [re.sub(r"^# ?", "", body, flags=re.MULTILINE).strip(), ""]
        else:
            lines += code(body.strip(), "python")
    return "\n".join([*lines, f"Download: {{download}}`{path.name} <../../../examples/{path.name}>`", ""])
