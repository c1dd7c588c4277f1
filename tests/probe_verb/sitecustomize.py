"""Adds the verb `probe` to dr_lab in every process that has this folder on its PYTHONPATH, a launcher's workers too."""

import os
import resource
from pathlib import Path

import dr_lab.workflows
from dr_lab.cli import folders

dr_lab.workflows.__path__.append(str(Path(__file__).parent))
folders.PACKAGE = Path(os.environ["PROBE_HOME"]) / "dr_lab"
if "PROBE_FILE_LIMIT" in os.environ:  # bytes that a file may have, as on a disk that is full after them
    most = int(os.environ["PROBE_FILE_LIMIT"])
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
