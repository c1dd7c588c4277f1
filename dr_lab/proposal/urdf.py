"""URDF files as MuJoCo takes them: meshes found where packages lie, and left out where they are not."""

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from pathlib import Path

import mujoco

from dr_lab.errors import ModelError
from dr_lab.physics.compiling import compiled

_PACKAGE = ("package://", "model://")
_READABLE = (".stl", ".obj", ".msh")  # meshes that MuJoCo reads


def read_urdf(path: Path) -> tuple[mujoco.MjSpec, tuple[str, ...]]:
    """A URDF file as a spec; its base is welded to the world, and links that are welded together are one.

    Shapes that are only looked at are left out, as MuJoCo does by default, and so are collision meshes that are not
    there or in a format that MuJoCo does not read.

    Args:
        path: the file.

    Returns:
        The spec, and what was left out or inferred, a sentence each.

    Raises:
        ModelError: it is no XML, or does not compile; a link that moves without mass is named with the remedy.
    """
    try:
        root = ET.fromstring(path.read_text(encoding="utf-8"))
    except (ET.ParseError, UnicodeDecodeError) as error:
        raise ModelError(f"{path} is no valid XML: {error}. Write a URDF or MJCF file; expand xacro first.") from error
    for link in root.iter("link"):
        for visual in link.findall("visual"):
            link.remove(visual)
    notes = [*_collision_meshes(root, path), *_massless(root, path)]
    extension = root.find("mujoco")
    extension = ET.SubElement(root, "mujoco") if extension is None else extension
    compiler = extension.find("compiler")
    compiler = ET.SubElement(extension, "compiler") if compiler is None else compiler
    compiler.attrib |= {"strippath": "false"}
    try:
        spec = mujoco.MjSpec.from_string(ET.tostring(root, encoding="unicode"))
        compiled(spec)  # in which MuJoCo fuses links that are welded together
    except ValueError as error:
        raise ModelError(f"{path} does not compile: {str(error).splitlines()[0]}. Correct it in the URDF.") from error
    return spec, tuple(notes)


def _collision_meshes(root: ET.Element, path: Path) -> Iterator[str]:
    """Let collision meshes be found; say which are left out."""
    for link in root.iter("link"):
        for collision in link.findall("collision"):
            mesh = collision.find("geometry/mesh")
            if mesh is None:
                continue
            file = _found(mesh.get("filename", ""), path)
            if file is None or file.suffix.lower() not in _READABLE:
                link.remove(collision)
                why = "is not there" if file is None else f"is {file.suffix}, MuJoCo reads {', '.join(_READABLE)}"
                yield f"Link {link.get('name')!r} makes no contact: its mesh {mesh.get('filename')} {why}."
            else:
                mesh.set("filename", str(file))


def _found(name: str, path: Path) -> Path | None:
    """Where a mesh lies: beside the URDF, or in its package, a folder that lies above the URDF or beside one above."""
    for scheme in _PACKAGE:
        if name.startswith(scheme):
            package, _, inside = name.removeprefix(scheme).partition("/")
            above = path.absolute().parents
            places = [*(folder / inside for folder in above if folder.name == package)]
            places += [folder / package / inside for folder in above]
            return next((each for each in places if each.is_file()), None)
    file = Path(name.removeprefix("file://"))
    file = file if file.is_absolute() else path.absolute().parent / file
    return file if file.is_file() else None


def _massless(root: ET.Element, path: Path) -> Iterator[str]:
    """Refuse links that move without mass; say which masses follow from shapes.

    A link counts together with what is welded to it.
    """
    welded = {joint: joint.get("type") == "fixed" for joint in root.findall("joint")}
    below: dict[str, list[str]] = {}
    moved: set[str] = set()
    for joint, fixed in welded.items():
        parent, child = (_link(joint, end, path) for end in ("parent", "child"))
        if fixed:
            below.setdefault(parent, []).append(child)
        else:
            moved.add(child)
    links = {link.get("name", ""): link for link in root.findall("link")}
    for name in sorted(moved):
        together = [links[each] for each in _welded(name, below) if each in links]
        if any(_mass(link) > 0 for link in together):
            continue
        if not any(link.find("collision") is not None for link in together):
            raise ModelError(
                f"{path}: link {name!r} moves but has no inertia: no <inertial> with a mass, and no collision shape to "
                "take one from. Give it an <inertial>; where it is only a frame, weld it (type fixed) or give its mass "
                "a gram."
            )
        yield (
            f"Link {name!r} has no <inertial>: its mass follows from its collision shapes at 1000 kg/m³, a guess. Give "
            "it an <inertial>."
        )


def _link(joint: ET.Element, end: str, path: Path) -> str:
    element = joint.find(end)
    if element is None or not element.get("link"):
        raise ModelError(f"{path}: joint {joint.get('name')!r} names no {end} link. Correct it in the URDF.")
    return str(element.get("link"))


def _welded(name: str, below: dict[str, list[str]]) -> list[str]:
    """A link and those that are welded to it, each once, also where a mistake welds them in a ring."""
    found = [name]
    for each in found:
        found += [child for child in below.get(each, []) if child not in found]
    return found


def _mass(link: ET.Element) -> float:
    mass = link.find("inertial/mass")
    try:
        return 0.0 if mass is None else float(mass.get("value", "0"))
    except ValueError:
        return 0.0
