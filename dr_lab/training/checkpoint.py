"""Checkpoints: one file that is complete or not there, and that cannot run code when it is read."""

import pickle
import zipfile
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import torch
from numpy._core import multiarray
from torch import Tensor

from dr_lab.errors import DataError, DrLabError
from dr_lab.files import atomic

# What arrays are made of when they are read; everything else that torch does not know by itself is refused.
_ARRAYS = [
    bytes,  # of an empty array
    np.ndarray,
    np.dtype,
    multiarray._reconstruct,
    multiarray.scalar,
    *(type(np.dtype(kind)) for kind in (np.float64, np.float32, np.int64, np.int32, np.uint8, np.bool_)),
]
# What is raised for a file that is damaged or something else.
_DAMAGED = (OSError, RuntimeError, EOFError, LookupError, ValueError, pickle.UnpicklingError, zipfile.BadZipFile)


def save(path: Path, state: Mapping[str, Any]) -> None:
    """Write tensors, arrays, numbers, text and what is nested of them.

    Args:
        path: the file to write or replace.
        state: as the parts of a run give it.

    Raises:
        DrLabError: the folder cannot be written to, or the disk is full.
    """
    with atomic(path) as temporary:
        try:
            torch.save(dict(state), temporary)
        except (OSError, RuntimeError) as error:  # torch has no other for a full disk
            raise DrLabError(
                f"Cannot write the checkpoint {path}: {str(error).partition(chr(10))[0]} It takes a folder with room, "
                "e.g. hydra.run.dir=FOLDER."
            ) from error


def load(path: Path) -> dict[str, Any]:
    """Read what `save` wrote, on whatever device it was then; tensors are on the CPU.

    Raises:
        DataError: there is no such file, or it is no checkpoint.
    """
    try:
        file = path.open("rb")
    except OSError as error:
        raise DataError(
            f"Cannot read the checkpoint {path}: {error.strerror}. Give the folder of a training run."
        ) from error
    with file:
        try:
            return _read(file)
        except _DAMAGED as error:
            cause = str(error).partition("\n")[0].rstrip(".")
            raise DataError(
                f"Cannot read the checkpoint {path}: it is damaged, cut short or something else ({cause}). Give the "
                "folder of a training run, copied whole."
            ) from error


def _read(file: BinaryIO) -> dict[str, Any]:
    with zipfile.ZipFile(file) as archive:
        damaged = archive.testzip()  # torch itself takes what a flipped bit has made of a tensor
    if damaged is not None:
        raise EOFError(f"the checksum of {damaged} does not fit")
    file.seek(0)
    with torch.serialization.safe_globals(_ARRAYS):
        return torch.load(file, map_location="cpu", weights_only=True)


def not_finite(state: object, name: str) -> Iterator[str]:
    """Names of the tensors in a state that hold NaN or infinite numbers.

    Args:
        state: a tensor, or mappings, lists and tuples nested around some; all else is passed over.
        name: of the state, before those in it.
    """
    if isinstance(state, Mapping | list | tuple):
        for key, value in state.items() if isinstance(state, Mapping) else enumerate(state):
            yield from not_finite(value, f"{name}.{key}")
    elif isinstance(state, Tensor) and not state.isfinite().all():
        yield name
