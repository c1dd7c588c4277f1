"""The console script `dr-lab`: verbs, composed by Hydra, run as plain functions."""

import os
import sys
from collections.abc import Sequence

from dr_lab.cli.completion import FLAGS, complete
from dr_lab.cli.folders import split_config_dir
from dr_lab.cli.verbs import overview, verbs
from dr_lab.errors import DrLabError, UnknownNameError
from dr_lab.stopping import Terminated, signals_unwind
from dr_lab.version import __version__

FAILED = 2
INTERRUPTED = 130
TERMINATED = 143


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        argv: arguments after the program's name; None takes them from the process.

    Returns:
        The exit code: 0, 2 (the user can mend the cause), 1 (a fault of dr_lab), 130 (Ctrl-C) or 143 (SIGTERM).
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        with signals_unwind():
            code = _dispatch(arguments)
            sys.stdout.flush()  # so that a reader who has gone is noticed here, and not at exit
            return code
    except DrLabError as error:
        if os.environ.get("HYDRA_FULL_ERROR") == "1":
            raise
        print(f"dr-lab: {error}", file=sys.stderr)
        return FAILED
    except (KeyboardInterrupt, Terminated) as stop:
        # An object whose construction was cut short complains from its destructor, where nobody can act on it.
        sys.unraisablehook = lambda _: None
        code, told = (TERMINATED, "terminated") if isinstance(stop, Terminated) else (INTERRUPTED, "interrupted")
        print(f"\ndr-lab: {told}.", file=sys.stderr)
        return code
    except BrokenPipeError:
        # Whoever read the output, such as head, has gone; nothing may be written any more, at exit neither.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED


def _dispatch(arguments: list[str]) -> int:
    first = arguments[0] if arguments else "--help"
    if first in ("-h", "--help"):
        print(overview())
        return 0
    if first == "--version":
        print(f"dr_lab {__version__}")
        return 0
    if first in FLAGS:
        delegated = complete(arguments)
        return 0 if delegated is None else _dispatch(delegated)
    known = verbs()
    if first not in known:
        raise UnknownNameError("verb", first, known, "dr-lab")
    folders, rest = split_config_dir(arguments[1:])
    from dr_lab.cli.run import run  # noqa: PLC0415  Hydra takes a third of a second; --help answers without it

    return run(first, rest, folders)


if __name__ == "__main__":
    sys.exit(main())
