"""Held-out logs that lie within what the fitted ones cover."""

from pathlib import Path

import numpy as np
import pytest
from played_logs import write_log

from dr_lab.__main__ import main
from dr_lab.proposal.coverage import Reach, reach_of, within
from dr_lab.trajectory import Log, Signal

RAIL = """<mujoco model="it"><option timestep="0.002" integrator="RK4"/><worldbody><body name="a">
  <joint name="rail" type="slide" axis="1 0 0" stiffness="36" damping="0.1"/>
  <geom type="box" size="0.1 0.1 0.1" mass="1"/>
</body></worldbody></mujoco>"""


def swing(name: str, size: float, about: float = 0.0, rate: float = 6.0) -> Log:
    """about + size · sin(rate t): from about − size to about + size, at most at the speed size · rate."""
    time = np.arange(0.0, 5.0, 0.01)
    position = Signal("rail.position", "m", time, about + size * np.sin(rate * time))
    return Log(name, {"rail.position": position}, {})


@pytest.mark.parametrize(
    ("logs", "held", "expected"),
    [
        ([swing("a", 1.0), swing("b", 1.0), swing("c", 1.0)], ["c"], ("c",)),  # all alike: as it was
        ([swing("a", 0.2), swing("b", 0.5), swing("c", 1.0)], ["c"], ("b",)),  # the largest is fitted
        ([swing("a", 1.0), swing("b", 0.5), swing("c", 0.2)], ["c"], ("c",)),
        ([swing("a", 0.1, 0.2), swing("b", 0.1, 0.4), swing("c", 0.1, 0.6)], ["c"], ("b",)),  # between the others
        ([swing("a", 1.0), swing("b", 1.0), swing("c", 1.0, rate=20.0)], ["c"], ("b",)),  # the fastest is fitted
        ([swing(n, s) for n, s in zip("abcdef", (0.3, 0.4, 0.9, 0.5, 0.2, 1.0), strict=True)], ["c", "f"], ("c", "e")),
    ],
)
def test_a_log_that_reaches_farthest_is_fitted(logs: list[Log], held: list[str], expected: tuple[str, ...]) -> None:
    reach = reach_of(logs, 0.1)
    assert reach is not None
    assert within(reach, held, 0.1) == expected


def test_how_far_a_log_reaches_beyond_the_others() -> None:
    """To ±1 beside ±0.5 is a quarter of the whole on either side; twice the speed is half of the largest."""
    reach = reach_of([swing("a", 0.5), swing("b", 1.0)], 1e-3)
    assert reach is not None
    far = reach.far
    np.testing.assert_allclose(far[1] - far[0], [0.25, 0.25, 0.5], rtol=1e-3)
    np.testing.assert_allclose(reach.beyond(["b"]), [0.5], rtol=1e-3)
    assert reach.beyond(["a"]) == [0.0]


def test_each_joint_is_compared_by_itself() -> None:
    reach = Reach(("a", "b", "c"), np.array([[1.0, 0.2], [0.6, 0.6], [0.2, 1.0]]))
    assert within(reach, ["c"], 0.1) == ("b",)
    assert list(reach.beyond(["a", "c"])) == pytest.approx([0.4, 0.4])


def test_logs_of_sensors_alone_are_not_judged() -> None:
    time = np.arange(0.0, 1.0, 0.01)
    assert reach_of([Log("a", {"sensor.x": Signal("sensor.x", "m", time, time)}, {})] * 3, 0.1) is None


def test_init_says_how_the_held_out_logs_lie(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("it.xml").write_text(RAIL)
    rng = np.random.default_rng(0)
    paths = []
    for name, size in zip("abc", (0.2, 0.5, 1.0), strict=True):
        signal = swing(name, size).outputs["rail.position"]
        noise = rng.normal(scale=1e-4, size=len(signal.time))
        decay = np.exp(-0.05 * signal.time)  # damping 0.1 N·s/m of 1 kg
        paths.append(write_log(name, "t,rail_m", signal.time, signal.value * decay + noise))
    assert main(["init", "it.xml", *paths]) == 0
    assert "it: 3 logs, 1 held out within what the fitted ones cover, " in capsys.readouterr().out
    page = Path("mine/measurements/it.yaml").read_text(encoding="utf-8")
    assert "held_out: [b]  # never fitted; what models are judged by, within what the fitted ones cover" in page
