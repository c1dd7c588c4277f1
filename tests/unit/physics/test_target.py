import mujoco
import numpy as np
import pytest

from dr_lab.errors import ModelError, UnknownNameError
from dr_lab.physics.address import FieldEdit
from dr_lab.physics.target import Target

XML = """
<mujoco model="toy">
  <worldbody>
    <body name="arm">
      <inertial mass="2" pos="0 0 -1" diaginertia="3 2 1"/>
      <joint name="hinge" axis="0 1 0" damping="0.5 0.1 0"/>
      <geom name="rod" size="0.1" contype="0" conaffinity="0"/>
    </body>
    <body name="bare"><joint name="slide" type="slide"/><geom name="ball" size="0.2"/></body>
  </worldbody>
  <actuator>
    <motor name="motor" joint="hinge" gear="7" forcerange="-5 5"/>
    <motor name="skew" joint="hinge" forcerange="-5 4"/>
    <dcmotor name="servo" joint="slide" motorconst="1" resistance="1" input="pos" controller="10 0 1 0 0 18"/>
    <intvelocity name="drive" joint="slide" kp="40" kv="3" actrange="-1 1"/>
  </actuator>
</mujoco>
"""


def spec() -> mujoco.MjSpec:
    return mujoco.MjSpec.from_string(XML)


@pytest.mark.parametrize(
    ("text", "nominal"),
    [
        ("body.arm.mass", 2.0),
        ("body.arm.inertia_scale", 1.0),
        ("body.arm.ipos[2]", -1.0),
        ("joint.hinge.damping", 0.5),
        ("geom.ball.size[0]", 0.2),
        ("actuator.motor.gear[0]", 7.0),
        ("actuator.motor.force_limit", 5.0),
        ("actuator.servo.gainprm[7]", 18.0),
        ("actuator.drive.kp", 40.0),
        ("actuator.drive.kv", 3.0),
        ("option.gravity[2]", -9.81),
    ],
)
def test_reads_back_what_the_file_says_and_what_it_wrote(text: str, nominal: float) -> None:
    target, one = Target.parse(text), spec()
    assert target.read(one) == pytest.approx(nominal)
    if "scale" not in text:
        target.write(one, 3.25)
        assert target.read(one) == pytest.approx(3.25)


def test_mass_takes_the_inertia_along() -> None:
    one = spec()
    Target.parse("body.arm.mass").write(one, 4.0)
    model = one.compile()
    assert model.body("arm").mass[0] == pytest.approx(4.0)
    np.testing.assert_allclose(model.body("arm").inertia, [6, 4, 2])


@pytest.mark.parametrize("text", ["body.sheet.mass", "body.sheet.inertia_scale"])
def test_a_sheet_stays_a_body_at_every_mass(text: str) -> None:
    """Of 13 of these values rounding would take A + B below C, which MuJoCo refuses."""
    sheet = spec()
    body = sheet.worldbody.add_body(name="sheet", mass=0.7, inertia=[0.013, 0.0204, 0.0334], explicitinertial=True)
    body.add_joint(name="turn")
    for value in np.linspace(0.2, 2.0, 1000):
        one = sheet.copy()
        Target.parse(text).write(one, float(value))
        first, second, third = one.body("sheet").inertia
        assert first + second >= third
        assert third == pytest.approx(
            np.asarray(sheet.body("sheet").inertia)[2] * value / Target.parse(text).read(sheet)
        )


def test_linear_damping_leaves_the_polynomial_alone() -> None:
    one = spec()
    Target.parse("joint.hinge.damping").write(one, 0.9)
    np.testing.assert_allclose(one.joint("hinge").damping, [0.9, 0.1, 0.0])


@pytest.mark.parametrize(
    "text",
    [
        "body.arm.mass",
        "joint.hinge.damping",
        "actuator.motor.gear[0]",
        "actuator.motor.force_limit",
        "actuator.servo.gainprm[7]",
        "actuator.drive.kp",
        "actuator.drive.kv",
        "body.arm.ipos[2]",
    ],
)
def test_compiled_fields_hold_what_recompiling_gives(text: str) -> None:
    target, one = Target.parse(text), spec()
    nominal = target.read(one)
    before = one.compile()
    target.write(one, 1.5 * nominal)
    after = one.compile()
    for edit in target.fields(before):
        assert isinstance(edit, FieldEdit)
        old, new = getattr(before, edit.field)[edit.index], getattr(after, edit.field)[edit.index]
        np.testing.assert_allclose(new, old * 1.5 if edit.relative else 1.5 * nominal)


def test_a_force_limit_is_symmetric() -> None:
    one = spec()
    Target.parse("actuator.motor.force_limit").write(one, 2.0)
    np.testing.assert_array_equal(one.compile().actuator("motor").forcerange, [-2.0, 2.0])
    with pytest.raises(ModelError, match=r"'skew' has forcerange \[-5, 4\]; expected \[-F, F\]"):
        Target.parse("actuator.skew.force_limit").read(one)


def test_the_gains_of_what_is_no_position_servo_are_refused() -> None:
    with pytest.raises(ModelError, match=r"'motor' has gainprm\[0\] 1 and biasprm\[1\] 0; .* Take a <position>"):
        Target.parse("actuator.motor.kp").read(spec())


def test_sizes_must_be_recompiled() -> None:
    assert Target.parse("geom.ball.size[0]").fields(spec().compile()) == ()


@pytest.mark.parametrize("text", ["mass", "body.arm.mass[x]", "body.arm.ipos[3]"])
def test_malformed_targets_are_refused(text: str) -> None:
    with pytest.raises(ModelError):
        Target.parse(text)


def test_names_are_suggested() -> None:
    with pytest.raises(UnknownNameError, match="Did you mean 'arm'"):
        Target.parse("body.arn.mass").read(spec())
    with pytest.raises(UnknownNameError, match="damping"):
        Target.parse("joint.hinge.dampin")


def test_mass_needs_an_explicit_inertial() -> None:
    with pytest.raises(ModelError, match="inertial"):
        Target.parse("body.bare.mass").read(spec())


@pytest.mark.parametrize(("angle", "factor"), [("degree", np.pi / 180), ("radian", 1.0)])
def test_a_spring_reference_is_in_radians_whatever_the_file_is_in(angle: str, factor: float) -> None:
    one = mujoco.MjSpec.from_string(
        f'''<mujoco><compiler angle="{angle}"/><worldbody><body name="b">
          <inertial mass="1" pos="0 0 0" diaginertia="1 1 1"/>
          <joint name="hinge" axis="0 1 0" stiffness="1" springref="0.5"/>
          <joint name="slide" type="slide" stiffness="1" springref="0.5"/>
        </body></worldbody></mujoco>'''
    )
    hinge, slide = (Target.parse(f"joint.{name}.springref") for name in ("hinge", "slide"))
    assert hinge.read(one) == pytest.approx(0.5 * factor)
    assert slide.read(one) == pytest.approx(0.5)
    hinge.write(one, 0.25)
    slide.write(one, 0.75)
    np.testing.assert_allclose(one.compile().qpos_spring, [0.25, 0.75])
