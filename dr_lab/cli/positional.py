"""Words of a command line that stand for keys: ``dr-lab init robot.xml logs/*.mcap``."""

from collections.abc import Sequence
from pathlib import Path

import yaml

from dr_lab.cli.flags import values_of_flags
from dr_lab.cli.groups import LOADER

KEY = "positional"  # of a root configuration: the keys whose names may be left out, in order


def root_text(verb: str, folders: Sequence[Path]) -> str:
    """The root configuration of a verb as it is written.

    Args:
        verb: its name.
        folders: configuration folders, first searched first.
    """
    return next(path for folder in folders if (path := folder / f"{verb}.yaml").is_file()).read_text(encoding="utf-8")


def positional(verb: str, folders: Sequence[Path]) -> list[str]:
    """The keys of a verb whose names may be left out; the last takes all words that are left, as a list.

    Args:
        verb: name of a root configuration.
        folders: configuration folders, first searched first.
    """
    content = yaml.load(root_text(verb, folders), Loader=LOADER)
    return list(content.get(KEY, ()))


def spelt_out(verb: str, arguments: Sequence[str], folders: Sequence[Path]) -> list[str]:
    """The arguments with keys before the words that have none: names of files, which the shell may have expanded.

    Args:
        verb: name of a root configuration.
        arguments: what follows the verb.
        folders: configuration folders, first searched first.
    """
    keys = positional(verb, folders)
    if not keys:
        return list(arguments)
    of_flags = values_of_flags(arguments)
    told_apart = [(word, at not in of_flags and is_plain(word)) for at, word in enumerate(arguments)]
    words = [word for word, plain in told_apart if plain]
    first, last = words[: len(keys) - 1], words[len(keys) - 1 :]
    given = [f"{key}={_quoted(word)}" for key, word in zip(keys, first, strict=False)]
    if last:
        given.append(f"{keys[-1]}=[{','.join(map(_quoted, last))}]")
    return [*given, *(word for word, plain in told_apart if not plain)]


def is_plain(word: str) -> bool:
    """Whether a word names a file rather than a flag, a key with a value, or a key that goes (``~key``)."""
    if word.startswith("-") or (word.startswith("~") and not word.startswith("~/")):
        return False
    return "=" not in word or Path(word).exists()


def _quoted(word: str) -> str:
    """A text that Hydra's grammar takes whole."""
    return '"' + word.replace('"', r"\"") + '"'
