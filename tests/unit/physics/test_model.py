from pathlib import Path

import mujoco
import numpy as np
import pytest

from dr_lab.errors import ConfigError, ModelError, UnknownNameError
from dr_lab.physics.model import Model, from_spec, load
from dr_lab.physics.simulator import Simulator

ARM = """<mujoco><worldbody><body name="arm">
  <inertial mass="1" pos="0 0 -1" diaginertia="1 1 1"/><joint name="hinge" axis="0 1 0"/>
</body></worldbody></mujoco>"""
XML = """
<mujoco model="toy">
  <option timestep="0.01"/>
  <worldbody>
    <body name="arm">
      <inertial mass="2" pos="0 0 -1" diaginertia="3 2 1"/>
      <joint name="hinge" axis="0 1 0" damping="0.5"/>
    </body>
  </worldbody>
</mujoco>
"""
DAMPING = {"hinge.damping": {"target": "joint.hinge.damping", "unit": "N·m·s/rad", "low": 0.0, "high": 2.0}}
MASS = {"arm.mass": {"target": "body.arm.mass", "unit": "kg", "low": 1.0, "high": 4.0}}


def model() -> Model:
    return from_spec("toy", mujoco.MjSpec.from_string(XML), {**MASS, **DAMPING})


def test_nominal_is_read_from_the_file() -> None:
    np.testing.assert_allclose(model().space.nominal, [2.0, 0.5])


def test_edits_do_not_accumulate() -> None:
    one, z = model(), np.array([3.0, 1.0])
    first = one.compile(z)
    second = one.compile(z)
    assert first.body("arm").mass[0] == second.body("arm").mass[0] == 3.0
    np.testing.assert_array_equal(first.body("arm").inertia, second.body("arm").inertia)
    assert one.nominal().body("arm").mass[0] == 2.0


def test_a_parameter_that_changes_nothing_is_an_error() -> None:
    spec = mujoco.MjSpec.from_string(XML)
    spec.body("arm").add_geom(name="picture", size=[0.1, 0, 0], mass=0.0)
    with pytest.raises(ModelError, match="changes nothing"):  # an explicit mass makes the density idle
        from_spec(
            "toy", spec, {"idle": {"target": "geom.picture.density", "unit": "kg/m³", "low": 1.0, "high": 2000.0}}
        )


def test_a_parameter_neither_of_whose_bounds_compiles_changes_something() -> None:
    inertia = {"target": "body.arm.inertia[0]", "unit": "kg·m²", "low": 0.1, "high": 10.0}  # beside 2 and 1 kg·m²
    free = from_spec("toy", mujoco.MjSpec.from_string(XML), {"arm.inertia": inertia})
    for bound in (free.space.low, free.space.high):
        with pytest.raises(ModelError, match="does not compile"):
            free.compile(bound)


def test_mujocos_message_is_kept(tmp_path: Path) -> None:
    path = tmp_path / "bad.xml"
    path.write_text(XML.replace('mass="2"', 'mass="-2"'))
    with pytest.raises(ModelError, match="does not compile"):
        load("bad", path, {})
    path.write_text("<mujoco><worldbody><body><wrong/></body></worldbody></mujoco>")
    with pytest.raises(ModelError, match="wrong"):
        load("bad", path, {})


def test_a_missing_file_says_so(tmp_path: Path) -> None:
    with pytest.raises(ModelError, match="there is no MJCF file"):
        load("none", tmp_path / "none.xml", {})


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"unit": "kg", "low": 1.0, "high": 2.0}, "no 'target'"),
        ({"target": "body.arm.mass", "unit": "kg", "low": 3.0, "high": 4.0}, "lies outside"),
        ({"target": "body.arm.mass", "unit": "kg", "low": 4.0, "high": 1.0}, "ordered"),
        ({"target": "body.arm.mass", "unit": "kg", "low": "light", "high": 1.0}, "not a number"),
    ],
)
def test_wrong_declarations_name_the_parameter(entry: dict[str, object], message: str) -> None:
    with pytest.raises(ModelError, match=message) as caught:
        from_spec("toy", mujoco.MjSpec.from_string(XML), {"arm.mass": entry})
    assert "arm.mass" in str(caught.value)


def test_unknown_elements_are_listed() -> None:
    entry = {"target": "joint.hing.damping", "unit": "1", "low": 0.0, "high": 1.0}
    with pytest.raises(UnknownNameError, match="hinge"):
        from_spec("toy", mujoco.MjSpec.from_string(XML), {"d": entry})


def test_without_parameters_every_value_of_the_file_stands(tmp_path: Path) -> None:
    (tmp_path / "toy.xml").write_text(XML)
    fixed = load("toy", tmp_path / "toy.xml", None)
    assert fixed.space.names == ()
    assert fixed.compile(fixed.space.nominal).body("arm").mass[0] == 2.0


ROD = {
    "length": {"nominal": 2.0, "unit": "m", "low": 1.0, "high": 3.0},
    "arm.mass": {"nominal": 1.5, "unit": "kg", "low": 1.0, "high": 3.0},
}


def test_what_follows_from_parameters_is_written_by_field_and_by_compilation() -> None:
    derived = {"body.arm.mass": "arm.mass", "body.arm.inertia[0]": "arm.mass * length**2 / 12"}
    rod = from_spec("rod", mujoco.MjSpec.from_string(ARM), ROD, derived)
    z = np.array([[3.0, 2.0]])
    simulator = Simulator(rod, 1, threads=1)
    simulator.set_contexts(z)
    for compiled in (rod.compile(z[0]), simulator.batch.get_model(0)):
        # the mass takes the other moments along, from 1 kg
        np.testing.assert_allclose(compiled.body("arm").inertia, [2.0 * 9.0 / 12, 2.0, 2.0], rtol=1e-14)
    np.testing.assert_allclose(rod.nominal().body("arm").inertia[0], 0.5, rtol=1e-14)


@pytest.mark.parametrize(
    ("parameters", "derived", "error", "message"),
    [
        (ROD, {"body.arm.mass": "arm.weight"}, ConfigError, "'arm.weight', which is not known.*arm.mass"),
        (ROD, {"body.arm.mass": "arm.mass"}, ModelError, "'length' of model 'rod' changes nothing"),
        (ROD, {"body.am.mass": "arm.mass * length"}, UnknownNameError, "Did you mean 'arm'"),
        ({"length": {**ROD["length"], "target": "body.arm.mass"}}, {}, ModelError, "has target and nominal"),
        ({"length": {"unit": "m", "low": 1.0, "high": 3.0}}, {}, ModelError, "has no 'target'"),
    ],
)
def test_what_cannot_follow_is_refused(
    parameters: dict[str, dict[str, object]], derived: dict[str, str], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        from_spec("rod", mujoco.MjSpec.from_string(ARM), parameters, derived)


@pytest.mark.parametrize(
    ("low", "high"), [((-6.0, 1.0), (0.5, 8.0)), ((-6.0, 7.0), None), (None, (-4.0, 8.0)), ((-6.0, 1.0), (1.0, 8.0))]
)
def test_the_ends_of_a_force_range_never_meet(
    low: tuple[float, float] | None, high: tuple[float, float] | None
) -> None:
    """Bounds that would let them cross are refused, an end that is not free stays where the file has it."""
    ends = {
        f"end.{k}": {"target": f"actuator.motor.forcerange[{k}]", "unit": "N·m", "low": bound[0], "high": bound[1]}
        for k, bound in enumerate((low, high))
        if bound is not None
    }
    one = mujoco.MjSpec.from_string(ARM)
    one.add_actuator(name="motor", target=one.joints[0].name, trntype=mujoco.mjtTrn.mjTRN_JOINT, forcerange=[-4.0, 6.0])
    with pytest.raises(ModelError, match="so that the ends would cross"):
        from_spec("arm", one.copy(), ends)
    apart = {name: {**entry, **({"high": -1.0} if name == "end.0" else {"low": 1.0})} for name, entry in ends.items()}
    assert from_spec("arm", one, apart).space.names == tuple(ends)


@pytest.mark.parametrize(("joint", "refused"), [("sensor", True), ("sensor.x", True), ("sensors", False)])
def test_a_joint_whose_channels_would_pass_for_a_sensors_is_refused(joint: str, refused: bool) -> None:
    spec = mujoco.MjSpec.from_string(ARM.replace('"hinge"', f'"{joint}"'))
    if refused:
        with pytest.raises(ModelError, match=rf"joint '{joint}' cannot be told from a sensor.* Rename the joint"):
            from_spec("toy", spec, {})
    else:
        assert from_spec("toy", spec, {}).nominal().joint(0).name == joint
