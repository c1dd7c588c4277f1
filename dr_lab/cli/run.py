"""Handing a verb to Hydra, and every failure to the user as one message."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import hydra

from dr_lab.cli.compose import HYDRA_VERSION, prepare
from dr_lab.cli.explain import explain
from dr_lab.cli.flags import require_known_flags, runs_jobs
from dr_lab.cli.hydra_node import checked_at_composition
from dr_lab.cli.overrides import composed
from dr_lab.cli.positional import is_plain, spelt_out
from dr_lab.cli.task import Task
from dr_lab.cli.verb_help import verb_help
from dr_lab.stopping import stop_if_asked

TRACEBACK_VARIABLE = "HYDRA_FULL_ERROR"


def run(verb: str, arguments: list[str], folders: tuple[Path, ...]) -> int:
    """Run a verb with Hydra's whole command line.

    Args:
        verb: name of a root configuration.
        arguments: what follows the verb, without ``--config-dir``.
        folders: configuration folders, first searched first; the last one ships with dr_lab.

    Returns:
        The exit code: 0, 2 where the user can mend the cause, 1 for a fault of dr_lab.

    Raises:
        Exception: any failure, with its traceback, where ``HYDRA_FULL_ERROR=1``.
    """
    traceback_wanted = os.environ.get(TRACEBACK_VARIABLE) == "1"
    try:
        if "--help" in arguments or "-h" in arguments:
            # Names of files and flags do not change the help; overrides do.
            overrides = [word for word in arguments if not (word.startswith("-") or is_plain(word))]
            print(verb_help(verb, overrides, folders))
            return 0
        require_known_flags(arguments, verb)
        arguments = spelt_out(verb, arguments, folders)
        with _environment(RUST_LOG="error"):  # Rerun's reader logs what becomes a note in the report
            _hand_to_hydra(verb, arguments, folders, traceback_wanted)
    except BrokenPipeError:
        raise
    except Exception as error:
        stop_if_asked()
        if traceback_wanted:
            raise
        message, code = explain(error, verb, folders)
        print(f"dr-lab {verb}: {message}", file=sys.stderr)
        return code
    return 0


def _hand_to_hydra(verb: str, arguments: list[str], folders: tuple[Path, ...], traceback_wanted: bool) -> None:
    """Let Hydra read the arguments; what it refuses for a name with a dot is respelt once for each such name."""
    prepare(folders)
    task = Task(verb, folders, traceback_wanted)
    main = hydra.main(version_base=HYDRA_VERSION, config_path=str(folders[-1]), config_name=verb)(task)

    def run(spelt: list[str]) -> None:
        # What is only shown may be wrong.
        checking = checked_at_composition() if runs_jobs(spelt) else nullcontext()
        sys.argv = [sys.argv[0], *spelt]
        # Hydra then raises its errors instead of printing them and exiting: all take the same way to the user.
        with _environment(**{TRACEBACK_VARIABLE: "1"}), checking:
            main()

    composed(arguments, run)
    for failure in task.failures:
        raise failure


@contextmanager
def _environment(**values: str) -> Iterator[None]:
    """Set environment variables for the time of a block."""
    before = {name: os.environ.get(name) for name in values}
    os.environ.update(values)
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
