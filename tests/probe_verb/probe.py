"""A verb for tests of sweeps: takes as long as it is told, can go on where it was, fails or dies as a file says."""

import json
import os
import time
from pathlib import Path

from dr_lab.bounds import Natural
from dr_lab.errors import DataError
from dr_lab.files import write_text
from dr_lab.sweeps.progress import tell

RESUMES_FROM = "steps.txt"
STEPS = 4


def probe(value: float, seconds: float, size: Natural, trouble: str, resume: str | None, run_dir: Path) -> None:
    """Write what (value − 3)² is, in steps; `trouble` may hold ``fails_<value>`` and ``dies_<value>``."""
    done = 0 if resume is None else int((Path(resume) / RESUMES_FROM).read_text(encoding="utf-8"))
    score = (value - 3.0) ** 2
    for step in range(done, STEPS):
        time.sleep(seconds / STEPS)
        tell(step, {"score": score * (STEPS - step)})
        if step == 1 and (Path(trouble) / f"dies_{value:g}").exists():
            os._exit(9)
        if step == 2 and (Path(trouble) / f"fails_{value:g}").exists():
            raise DataError(f"{value:g} is refused.\nA second line.")
        write_text(run_dir / RESUMES_FROM, str(step + 1))
    write_text(run_dir / "filling.txt", "x" * size)
    figures = {"score": score, "other": abs(value), "begun_at_step": done}
    write_text(run_dir / "report.json", json.dumps(figures))
