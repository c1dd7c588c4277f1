"""What is typed to look at a run."""

import re
import shlex
from pathlib import Path

from hydra.core.override_parser.types import Quote, QuotedString


def view_command(run: Path | str) -> str:
    """`dr-lab view` on a run's folder or recording: quoted for Hydra, to which signs are grammar, and the shell."""
    plain = re.fullmatch(r"[\w./ -]+", str(run), re.ASCII)
    value = str(run) if plain else QuotedString(str(run), Quote.single).with_quotes()
    return f"dr-lab view {shlex.quote(f'run={value}')}"
