"""A small CSV log: a joint that swings, by hand."""

from pathlib import Path

import numpy as np


def csv(path: Path, **columns: object) -> Path:
    names = list(columns)
    rows = np.broadcast_arrays(*[np.asarray(c, dtype=float) for c in columns.values()])
    text = "\n".join(",".join(f"{v:.9g}" for v in row) for row in zip(*rows, strict=True))
    path.write_text(",".join(names) + "\n" + text + "\n")
    return path


TIME = np.linspace(0.0, 4.0, 2000, endpoint=False)
ANGLE = 1.2 * np.cos(5 * TIME)
Q = {"q.position": {"column": "q", "unit": "rad"}}
U = {"m": {"column": "u", "unit": "V"}}
