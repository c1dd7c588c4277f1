"""A headless viewer, and one run of the demo that several tests look at."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path

import pytest
from rerun.experimental import ViewerClient

from dr_lab.__main__ import main
from dr_lab.errors import DrLabError
from dr_lab.recorders.viewer import headless_viewer

# The demo with few rivals and few windows: the whole of it takes minutes.
QUICK = ("effect=[coulomb_friction,viscous_friction,actuator_delay]", "windows.seconds=7.2")


@pytest.fixture(scope="session")
def demo_run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Run folder of ``dr-lab close`` on the logs in examples/furuta."""
    folder = tmp_path_factory.mktemp("runs") / "demo"
    assert main(["close", *QUICK, f"hydra.run.dir={folder}"]) == 0
    return folder


@cache
def _has_vulkan() -> bool:
    try:
        with headless_viewer() as client:
            return client.get_state().viewer_version is not None
    except DrLabError:
        return False


@pytest.fixture
def viewer() -> Iterator[ViewerClient]:
    """A fresh viewer: a layout that a test changes stays with the application."""
    if not _has_vulkan():
        pytest.skip("no Vulkan driver: apt-get install libvulkan1 mesa-vulkan-drivers")
    with headless_viewer() as client:
        yield client
