"""A robot's description, wherever it lies: an MJCF or URDF file, a folder of them, or a name of robot_descriptions."""

import importlib
import importlib.util
import re
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import mujoco

from dr_lab.errors import DrLabError, ModelError, UnknownNameError
from dr_lab.physics.compiling import compiled
from dr_lab.physics.naming import name_elements
from dr_lab.proposal.urdf import read_urdf

_LIBRARY = "robot_descriptions"
_SUFFIXES = (".xml", ".mjcf", ".urdf")
_SCALAR = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
_DENSITY = 1000.0  # kg/m³, MJCF's default
_SCENE = "scene"  # files that put a robot into a room


@dataclass(frozen=True)
class Robot:
    """A robot as it was described.

    Attributes:
        name: fit for a file and a configuration.
        path: the file.
        spec: its elements all have names.
        urdf: whether the file is a URDF, which has no actuators and no time step.
        notes: what is left out or inferred, a sentence each.
    """

    name: str
    path: Path
    spec: mujoco.MjSpec
    urdf: bool
    notes: tuple[str, ...]

    @property
    def joints(self) -> tuple[str, ...]:
        """Hinges and slides, in the model's order."""
        return tuple(joint.name for joint in self.spec.joints if joint.type in _SCALAR)


def read_robot(given: str, name: str | None) -> Robot:
    """Read a robot's description.

    Args:
        given: an MJCF or URDF file, a folder that holds one (MuJoCo Menagerie's have scenes beside it), or a name of
            the package robot_descriptions, if that is installed.
        name: what it is to be called; None takes the description's own.

    Raises:
        ModelError: there is none, it cannot be read, does not compile, or nothing moves.
        UnknownNameError: robot_descriptions has no such name.
    """
    path = _file(given)
    urdf = _is_urdf(path)
    if urdf:
        spec, notes = read_urdf(path)
    else:
        spec, notes = _read_mjcf(path)
    own = path.stem if spec.modelname in ("", "MuJoCo Model") else spec.modelname
    name_elements(spec)
    robot = Robot(_plain(name or own), path, spec, urdf, notes)
    if not spec.joints:
        raise ModelError(f"{path} has no joint: nothing moves whose position a log could hold. Name another file.")
    return robot


def _file(given: str) -> Path:
    path = Path(given).expanduser()
    if path.is_file():
        return path
    if path.is_dir():
        return _in_folder(path)
    if path.suffix in _SUFFIXES or "/" in given:
        beside = sorted(each.name for each in path.parent.glob("*") if each.suffix in _SUFFIXES)
        there = f"{path.parent} holds {', '.join(beside) or 'no .xml or .urdf file'}" if path.parent.is_dir() else ""
        raise ModelError(f"There is no file {given!r}{'; ' if there else ''}{there}. Name an MJCF or URDF file.")
    return _described(given)


def _in_folder(folder: Path) -> Path:
    """The only description in a folder, scenes and files of another name than the folder's apart."""
    files = [each for each in sorted(folder.iterdir()) if each.suffix in _SUFFIXES]
    found = [each for each in files if not each.stem.startswith(_SCENE)]
    named = [each for each in found if folder.name.endswith(each.stem)]
    for choice in (found, named):
        if len(choice) == 1:
            return choice[0]
    listed = ", ".join(each.name for each in found)
    raise ModelError(f"{folder} holds {listed or 'no .xml or .urdf file'}. Name one file of a robot, not its folder.")


def _described(name: str) -> Path:
    if importlib.util.find_spec(_LIBRARY) is None:
        raise ModelError(
            f"There is no file or folder {name!r}. Name an MJCF or URDF file; names of {_LIBRARY} work after "
            f"pip install {_LIBRARY}."
        )
    known = importlib.import_module(f"{_LIBRARY}._descriptions").DESCRIPTIONS
    module = next((each for each in (name, f"{name}_mj_description", f"{name}_description") if each in known), None)
    if module is None:
        raise UnknownNameError("robot", name, known, _LIBRARY)
    try:
        found = importlib.import_module(f"{_LIBRARY}.{module}")
    except Exception as error:  # Git's own and the network's: descriptions are cloned when first asked for
        raise DrLabError(
            f"{_LIBRARY} could not fetch {module}: {error}. Clone it by hand and name its file."
        ) from error
    return Path(getattr(found, "MJCF_PATH", None) or found.URDF_PATH)


def _is_urdf(path: Path) -> bool:
    """By the first element: both kinds of file may end in .xml."""
    try:
        return next(ET.iterparse(path, ("start",)))[1].tag == "robot"
    except (ET.ParseError, StopIteration, UnicodeDecodeError, ValueError) as error:
        raise ModelError(f"{path} is no valid XML: {error}. Name an MJCF or URDF file; expand xacro first.") from error


def _read_mjcf(path: Path) -> tuple[mujoco.MjSpec, tuple[str, ...]]:
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        model = compiled(spec.copy())
    except ValueError as error:
        remedy = "Give moving bodies an <inertial>, or geoms with mass" if "mjMINVAL" in str(error) else "Correct it"
        raise ModelError(f"{path} does not compile: {error}. {remedy} in the MJCF.") from error
    guessed = [
        body.name
        for body in spec.bodies[1:]
        if body.name and model.body(body.name).dofnum[0] and not body.explicitinertial and _by_default(body)
    ]
    if not guessed:
        return spec, ()
    one = len(guessed) == 1
    return spec, (
        f"{'Body' if one else 'Bodies'} {', '.join(guessed)} {'has' if one else 'have'} no <inertial>: masses follow "
        "from the shapes at MJCF's default of 1000 kg/m³, which is a guess.",
    )


def _by_default(body: mujoco.MjsBody) -> bool:
    """Whether nothing but the default density says what a body weighs."""
    return bool(body.geoms) and all(geom.density == _DENSITY and not geom.mass > 0 for geom in body.geoms)


def _plain(name: str) -> str:
    return re.sub(r"\W+", "_", name).strip("_").lower() or "robot"
