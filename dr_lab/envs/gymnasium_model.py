"""Models of gymnasium's MuJoCo machines, from the files that it is installed with."""

from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path

from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics import model
from dr_lab.physics.model import Model


def load(name: str, parameters: Mapping[str, Mapping[str, object]], derived: Mapping[str, str] | None = None) -> Model:
    """A machine of gymnasium's, e.g. ``hopper``.

    Args:
        name: name of its MJCF file without the ending.
        parameters: its free physics, as `dr_lab.physics.model.load` takes it.
        derived: what follows from it, likewise.

    Raises:
        ModelError: gymnasium is not installed.
        UnknownNameError: it has no such machine.
    """
    found = find_spec("gymnasium")
    if found is None or found.origin is None:
        raise ModelError(f"Model {name!r} comes with gymnasium, which is not installed: pip install 'gymnasium>=1.4'.")
    folder = Path(found.origin).parent / "envs" / "mujoco" / "assets"
    path = folder / f"{name}.xml"
    if not path.is_file():
        raise UnknownNameError("machine", name, [each.stem for each in folder.glob("*.xml")], "gymnasium")
    return model.load(name, path, parameters, derived)
