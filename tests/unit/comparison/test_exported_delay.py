"""What acts beside an exported file."""

from pathlib import Path

import numpy as np
import pytest
from effect_machines import block, placed

from dr_lab.comparison.export import write_model
from dr_lab.physics.simulator import Simulator


@pytest.mark.parametrize(("delay", "beside"), [(0.0211, 1), (0.0013, 2)])
def test_a_delay_that_the_file_has_acts_once(tmp_path: Path, delay: float, beside: int) -> None:
    """MuJoCo delays by 21.1 ms, not by 1.3 ms; a late reading is in no file, so that what the file lacks acts."""
    model = block().with_effect(placed(block(), "actuator_delay", "drive"))
    model = model.with_effect(placed(block(), "sensor_time_offset", "rail"))
    z = np.array([delay, 0.003])
    read, _ = write_model(tmp_path / "model.xml", model, z)
    assert len(read.effects) == beside
    controls = np.where(np.arange(80) < 10, 0.0, 4.0)[None, :, None]
    still, before = np.zeros((1, 1, 1)), np.zeros((1, 40, 1))
    replays = (Simulator(each.replayed(), 1, threads=1) for each in (model, read))
    contexts = (z[None], np.zeros((1, 0)))
    found, again = (
        replay.replay(context, still, still, controls, before).qpos[0, -1, 0]
        for replay, context in zip(replays, contexts, strict=True)
    )
    assert found == pytest.approx(0.5 * 2.0 * (70 * 0.002 - delay) ** 2, abs=1e-8)
    assert again == pytest.approx(found, abs=2e-6)  # straight lines between commands blur the edge
