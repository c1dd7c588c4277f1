"""A model as MJCF text."""

from pathlib import Path

import mujoco

from dr_lab.physics.compiling import written
from dr_lab.physics.model import Model
from dr_lab.trajectory import Array


def mjcf(model: Model, z: Array) -> str:
    """The model at context z as MJCF text; meshes and pictures stay where they are, and the text says where that is."""
    spec = model.spec_at(z)
    _keep_assets(spec)
    return written(spec)


def _keep_assets(spec: mujoco.MjSpec) -> None:
    """Let the files that a spec names be found from any folder."""
    base = Path(spec.modelfiledir).absolute()
    if any(asset.file for asset in (*spec.meshes, *spec.hfields, *spec.skins)):
        spec.compiler.meshdir = str(base / spec.compiler.meshdir)
    if any(texture.file or any(texture.cubefiles) for texture in spec.textures):
        spec.compiler.texturedir = str(base / spec.compiler.texturedir)
