"""Tab completion of the verb; after it, Hydra completes groups, options and keys."""

import os
from collections.abc import Sequence

from dr_lab.cli.verbs import verbs

FLAGS = ("-sc", "--shell-completion")
FOLDER_FLAGS = ("-cd", "--config-dir")
LINE_VARIABLE = "COMP_LINE"


def complete(arguments: Sequence[str]) -> list[str] | None:
    """Answer the shell where the verb is being typed; otherwise say which command lets Hydra answer.

    Args:
        arguments: those of ``dr-lab``, beginning with a completion flag. The line typed so far is in ``COMP_LINE``.

    Returns:
        None when the verbs were printed or the shell itself completes a folder; otherwise the arguments of ``dr-lab``
        to run, beginning with the verb, which has been taken out of ``COMP_LINE``.
    """
    known = verbs()
    _, *words = os.environ.get(LINE_VARIABLE, "").split(" ")
    asked = any(word.startswith("query=") for word in arguments)
    if asked and len(words) <= 1:
        print(" ".join(verb for verb in known if verb.startswith("".join(words))))
        return None
    if asked and (words[-2] in FOLDER_FLAGS or words[-1].startswith("-")):
        return None
    verb = words[0] if asked and words[0] in known else next(iter(known))
    flags, rest = _folder_flags(words[1:])
    os.environ[LINE_VARIABLE] = " ".join(["dr-lab", *rest])
    return [verb, *arguments, *flags]


def _folder_flags(words: list[str]) -> tuple[list[str], list[str]]:
    """Take each ``--config-dir FOLDER`` out of the words; the groups of those that there are are completed, too."""
    flags: list[str] = []
    rest: list[str] = []
    typed = iter(words)
    for word in typed:
        flag, equals, folder = word.partition("=")
        if flag not in FOLDER_FLAGS:
            rest.append(word)
            continue
        folder = os.path.expanduser(folder if equals else next(typed, ""))
        flags += [flag, folder] if os.path.isdir(folder) else []
    return flags, rest
