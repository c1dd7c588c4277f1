"""What makes tests cheaper and changes nothing that they see: texts are parsed once, cycles looked for less often."""

import gc
import io
import os
import pickle
from functools import wraps
from pathlib import Path
from typing import IO, Any

from omegaconf import DictConfig, ListConfig, OmegaConf

_parsed: dict[str, bytes] = {}


def parse_once() -> None:
    """Let ``OmegaConf.load`` give copies of what it made of the same text: Hydra loads some 30 files for a command."""
    load = OmegaConf.load

    def loaded_text(file_: IO[Any]) -> DictConfig | ListConfig:
        source = file_.read()
        if source not in _parsed:
            file_.seek(0)
            _parsed[source] = pickle.dumps(load(file_))
        return pickle.loads(_parsed[source])

    @wraps(load)
    def loaded(file_: str | Path | IO[Any]) -> DictConfig | ListConfig:
        if isinstance(file_, str | Path):
            with open(os.path.abspath(file_), encoding="utf-8") as file:
                return loaded_text(file)
        return loaded_text(file_) if isinstance(file_, io.TextIOBase) and file_.seekable() else load(file_)

    OmegaConf.load = staticmethod(loaded)


def look_for_cycles_rarely() -> None:
    """Let Python look for cycles after 50 000 new objects and not after 700."""
    gc.set_threshold(50_000, 20, 20)


def keep_what_is_loaded() -> None:
    """Spare Python from going through all modules and tests whenever it looks for cycles: they stay to the end."""
    gc.collect()
    gc.freeze()
