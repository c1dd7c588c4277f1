"""Who only compares logs never waits for, nor needs, a library of neural networks."""

import subprocess
import sys

LIGHT = (
    "cli",
    "comparison",
    "diagnosis",
    "effects",
    "html",
    "measurements",
    "notebook",
    "physics",
    "plants",
    "proposal",
    "recorders",
)
VERBS = ("add", "benchmark", "close", "compare", "diagnose", "fit", "init", "record", "view")
CODE = """
import importlib, pkgutil, sys

class Refuse:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in ("torch", "torchrl", "tensordict"):
            raise ModuleNotFoundError(f"refused {name}", name=name)

sys.meta_path.insert(0, Refuse())
for name in sys.argv[1:]:
    package = importlib.import_module(f"dr_lab.{name}")
    for module in pkgutil.walk_packages(getattr(package, "__path__", []), package.__name__ + "."):
        importlib.import_module(module.name)
"""


def test_packages_import_without_torch() -> None:
    modules = [*LIGHT, *(f"workflows.{verb}" for verb in VERBS)]
    done = subprocess.run([sys.executable, "-c", CODE, *modules], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
