"""An exported model finds its meshes and pictures from any folder."""

import struct
import zlib
from pathlib import Path

import mujoco
import pytest

from dr_lab.comparison.export import write_model
from dr_lab.physics.model import load

XML = """<mujoco>
  <compiler%s/>
  <asset>
    <mesh name="wedge" file="wedge.obj"/>
    <texture name="skin" type="2d" file="skin.png"/><material name="skin" texture="skin"/>
  </asset>
  <worldbody><body><joint name="hinge"/><geom type="mesh" mesh="wedge" material="skin"/></body></worldbody>
</mujoco>"""
WEDGE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"


def png() -> bytes:
    """One red pixel."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", 1, 1, 8, 2, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0\xff\0\0")) + chunk(b"IEND", b"")
    )


@pytest.mark.parametrize(
    ("settings", "meshes", "pictures"), [("", "", ""), (' meshdir="shapes" texturedir="skins"', "shapes", "skins")]
)
def test_files_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, settings: str, meshes: str, pictures: str
) -> None:
    mine, run, elsewhere = (tmp_path / name for name in ("mine", "run", "elsewhere"))
    for folder in (mine / meshes, mine / pictures, run, elsewhere):
        folder.mkdir(parents=True, exist_ok=True)
    (mine / meshes / "wedge.obj").write_text(WEDGE)
    (mine / pictures / "skin.png").write_bytes(png())
    (mine / "robot.xml").write_text(XML % settings)
    monkeypatch.chdir(mine)
    model = load("robot", "robot.xml", {})
    exported, _ = write_model(run / "model.xml", model, model.space.nominal)
    monkeypatch.chdir(elsewhere)
    again = mujoco.MjModel.from_xml_path(str(run / "model.xml"))
    assert (again.nmesh, again.ntex) == (exported.nominal().nmesh, exported.nominal().ntex) == (1, 1)


def test_a_model_without_files_names_no_folder(tmp_path: Path) -> None:
    (tmp_path / "plain.xml").write_text("<mujoco><worldbody><geom size='1'/></worldbody></mujoco>")
    model = load("plain", tmp_path / "plain.xml", {})
    write_model(tmp_path / "model.xml", model, model.space.nominal)
    assert "dir=" not in (tmp_path / "model.xml").read_text(encoding="utf-8")
