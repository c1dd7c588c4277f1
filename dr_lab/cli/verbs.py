"""The verbs: each is a root configuration ``conf/<verb>.yaml`` whose leading comment says what it does."""

from pathlib import Path

from dr_lab.cli.folders import shipped

FOOTER = """
  dr-lab <verb> --help                              its groups, options and keys
  dr-lab close model=furuta measurements=furuta     an example that comes with dr_lab
  dr-lab view                                       the newest run, in the Rerun viewer
  eval "$(dr-lab -sc install=bash)"                 tab completion (bash, zsh or fish)
  dr-lab --version
"""


def description(path: Path) -> list[str]:
    """The leading comment of a configuration file, without the ``@package`` line, one string a line.

    Args:
        path: a yaml file.
    """
    lines: list[str] = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        if not line.startswith("# @package"):
            lines.append(line.lstrip("#").strip())
    return lines


def summary(path: Path) -> str:
    """The first line of a file's leading comment, or nothing."""
    return next(iter(description(path)), "")


def verbs() -> dict[str, str]:
    """What each verb does, by verb."""
    return {path.stem: summary(path) for path in sorted(shipped().glob("*.yaml"))}


def overview() -> str:
    """The text of ``dr-lab --help``."""
    known = verbs()
    width = max(map(len, known)) + 2
    lines = [f"  {verb:<{width}}{text}" for verb, text in known.items()]
    head = "Find why a MuJoCo model disagrees with its robot, mend it, and see both side by side."
    return "\n".join([head, "", "  dr-lab <verb> [group=option ...] [key=value ...]", "", *lines, FOOTER.rstrip()])
