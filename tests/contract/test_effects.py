"""What every effect of the catalogue promises, at every site of every model."""

from functools import cache

import mujoco
import numpy as np
import pytest
from effect_machines import CONF, NAMES, catalogue_effect, field_sizes, model_bytes, replayed

from dr_lab.diagnosis.windows.channels import available
from dr_lab.effects.effect import PlacedEffect, Scales, place
from dr_lab.physics.model import Model, from_spec, load
from dr_lab.trajectory import Array

SECONDS = 0.15
SMALL = """<mujoco model="two_joints">
  <compiler angle="radian"/>
  <option timestep="0.002" integrator="implicitfast"/>
  <worldbody><body name="cart">
    <inertial mass="1" pos="0 0 0" diaginertia="0.01 0.01 0.01"/>
    <joint name="rail" type="slide" axis="1 0 0" damping="0.5" stiffness="2" springref="0.1"/>
    <body name="rod">
      <joint name="hinge" axis="0 1 0" damping="0.01"/>
      <geom type="capsule" size="0.01" fromto="0 0 0 0 0 -0.4" density="1500"/>
    </body>
  </body></worldbody>
  <actuator>%s</actuator>
</mujoco>"""
MOTOR = SMALL % '<motor name="drive" joint="rail" gear="2"/>'
SMALL_ONES = {
    "two_joints_motor": MOTOR,
    "two_joints_dcmotor": SMALL % '<dcmotor name="drive" joint="rail" motorconst="0.5 0.5" resistance="1"/>',
    "two_joints_in_air": SMALL.replace("<option ", '<option density="1.2" ')
    % '<motor name="drive" joint="rail" gear="2"/><motor name="turn" joint="hinge"/>',
    "two_joints_with_friction": MOTOR.replace('damping="0.01"', 'damping="0.01" frictionloss="0.02"'),
    "two_joints_servo": SMALL % '<position name="drive" joint="rail" kp="50" kv="3"/>',
}
UNSEEN = {
    ("ball", "payload", "ball", "mass"),  # all masses fall alike
    # these joints do not come to rest
    ("arm", "soft_friction", "shoulder_lift", "softness"),
    ("arm", "soft_friction", "wrist_1", "softness"),
    ("ball", "soft_friction", "ball", "softness"),
}
# A spring that softens pushes the foot away, the harder the farther it is.
RUN_AWAY = {("hopper", "hardening_spring", "rootz")}
# Between them they have all kinds of sites; the other models are left to the slow tests.
ARCHETYPES = (
    "cube",  # a free body with contacts and sensors
    "furuta",  # two hinges and a DC motor
    "hopper",  # slides, hinges, contacts and three motors
    "two_joints_in_air",  # a medium, and a motor at each joint
    "two_joints_servo",  # a position servo at a slide, and a hinge without motor
    "two_joints_with_friction",  # dry friction of the model's own
)
MODELS = (*SMALL_ONES, *sorted(path.stem for path in (CONF / "model").glob("*.xml")))


@cache
def machine(name: str) -> Model:
    if name in SMALL_ONES:
        return from_spec(name, mujoco.MjSpec.from_string(SMALL_ONES[name]), {})
    return load(name, CONF / "model" / f"{name}.xml", {})


@cache
def scales(name: str) -> Scales:
    """A second's motion of the machine, were it to accelerate at 10 rad/s² or m/s²."""
    compiled = machine(name).nominal()
    joints = [compiled.joint(i) for i in range(compiled.njnt)]
    torque = {joint.name: 10.0 * float(compiled.dof_M0[joint.dofadr[0]]) for joint in joints}
    names = tuple(torque)
    command = {compiled.actuator(i).name: 1.0 for i in range(compiled.nactuator)}
    places = {joint.name: float(compiled.qpos0[joint.qposadr[0]]) for joint in joints}
    lowest, highest = ({name: place + end for name, place in places.items()} for end in (-0.5, 0.5))
    return Scales(lowest, highest, dict.fromkeys(names, 2.0), torque, command)


@cache
def places(models: tuple[str, ...] = MODELS) -> tuple[tuple[str, str, str], ...]:
    """Every effect at every site of the models."""
    compiled = {model: machine(model).nominal() for model in models}
    return tuple(
        (model, effect, site)
        for model in models
        for effect in NAMES
        for site in catalogue_effect(effect).sites(compiled[model])
    )


@cache
def quick() -> tuple[tuple[str, str, str], ...]:
    """Every effect at its first site of each archetype; all other places are left to the slow tests."""
    firsts = {(model, effect): site for model, effect, site in reversed(places(ARCHETYPES))}
    return tuple(place for place in places(ARCHETYPES) if firsts[place[:2]] == place[2])


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Ask for every place, or, where slow tests are left out, only for the few: 8 000 tests are slow to list, too."""
    if "site" in metafunc.fixturenames:
        few = {*quick()}
        slow = [] if "not slow" in metafunc.config.option.markexpr else [p for p in places() if p not in few]
        asked = [*quick(), *(pytest.param(*place, marks=pytest.mark.slow) for place in slow)]
        metafunc.parametrize(("model", "effect", "site"), asked)


@cache
def put(model: str, effect: str, site: str) -> tuple[Model, PlacedEffect]:
    one = place(catalogue_effect(effect), machine(model).nominal(), site, scales(model))
    return machine(model).with_effect(one), one


def commands(model: Model) -> tuple[Array, Array]:
    """Controls of a window and of the time before it."""
    compiled = model.nominal()
    steps, before = round(SECONDS / compiled.opt.timestep), round(0.06 / compiled.opt.timestep)
    time = np.arange(-before, steps) * compiled.opt.timestep
    wave = np.sin(30.0 * time[:, None] + np.arange(compiled.nu))[None]
    return wave[:, before:], wave[:, :before]


def vectors(model: Model, one: PlacedEffect) -> Array:
    """Absent and every start away from it, shape (1 + starts, n)."""
    return np.array([model.space.nominal, *(model.space.vector(start) for start in one.starts)])


def at_ends(model: Model) -> Array:
    """Absent but for one parameter at its farther bound, one after the other, shape (n, n)."""
    space = model.space
    far = np.where(space.high - space.nominal >= space.nominal - space.low, space.high, space.low)
    return np.where(np.eye(len(far), dtype=bool), far, space.nominal)


def shows(model: Model, index: int, begins: Array, low: float) -> bool:
    """Whether a parameter's upper bound looks different from a lower value, from anywhere."""
    lower, upper = begins.copy(), begins.copy()
    lower[:, index], upper[:, index] = low, model.space.high[index]
    return signals(model, lower) != signals(model, upper)


def probe(time: Array) -> Array:
    """A motion of which every sensor transform shows."""
    return (0.3 + np.sin(9.0 * time) + 0.2 * time)[..., None]


def reported(model: Model, z: Array) -> Array:
    """What the sensors of all channels report of the probe under each context, shape (c, channels · times)."""
    time, begin = np.linspace(0.05, SECONDS, 20)[None, None], np.array([[0.7]])
    rows = [model.reading(z, name, probe, begin)(time) for name in available(model.nominal())]
    return np.concatenate([np.broadcast_to(row[..., 0], (len(z), 1, 20)) for row in rows], axis=2)[:, 0]


def signals(model: Model, z: Array) -> list[bytes]:
    """What a measurement sees under each context: the motion, and what sensors make of it."""
    paths = replayed(model, z, *commands(model))
    return [path.tobytes() + seen.tobytes() for path, seen in zip(paths, reported(model, z), strict=True)]


def test_catalogue_states_what_it_is() -> None:
    for name in NAMES:
        effect = catalogue_effect(name)
        assert effect.name == name
        assert effect.family in {"friction", "transmission", "actuator", "inertia", "environment", "sensing", "open"}
        assert effect.law
        assert effect.fingerprint
        assert set(effect.confused_with) <= set(NAMES) - {name}


def test_every_effect_sits_somewhere_in_the_fast_run() -> None:
    assert {effect for _, effect, _ in quick()} == set(NAMES)


def test_the_archetypes_have_all_kinds_of_sites() -> None:
    compiled = [machine(name).nominal() for name in ARCHETYPES]
    assert {int(kind) for model in compiled for kind in model.jnt_type} >= {
        int(mujoco.mjtJoint.mjJNT_FREE),
        int(mujoco.mjtJoint.mjJNT_SLIDE),
        int(mujoco.mjtJoint.mjJNT_HINGE),
    }
    laws = {law for model in compiled for law in zip(model.actuator_gaintype, model.actuator_biastype, strict=True)}
    assert laws >= {
        (int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtBias.mjBIAS_NONE)),  # motor
        (int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtBias.mjBIAS_AFFINE)),  # servo
        (int(mujoco.mjtGain.mjGAIN_DCMOTOR), int(mujoco.mjtBias.mjBIAS_DCMOTOR)),
    }
    assert max(model.nsensor for model in compiled) > 0
    assert max(model.nu for model in compiled) > 1


def test_bounds_are_finite_wide_and_contain_the_starts(model: str, effect: str, site: str) -> None:
    _, one = put(model, effect, site)
    bounds = {p.name: p for p in one.parameters}
    for parameter in one.parameters:
        assert parameter.span > 0
        assert parameter.unit
        assert parameter.name.startswith(f"{effect}@{site}.")
    for start in one.starts:
        assert all(bounds[name].low <= value <= bounds[name].high for name, value in start.items())


def test_absent_leaves_the_motion(model: str, effect: str, site: str) -> None:
    """Bit for bit; a payload's body alone changes the order of sums, by rounding."""
    extended, _ = put(model, effect, site)
    plain = machine(model)
    with_it = replayed(extended, extended.space.nominal[None], *commands(extended))
    without = replayed(plain, np.empty((1, 0)), *commands(plain))
    np.testing.assert_allclose(with_it, without, rtol=0, atol=1e-9 if effect == "payload" else 0)
    bare = reported(plain, np.empty((1, 0)))
    np.testing.assert_allclose(reported(extended, extended.space.nominal[None]), bare, rtol=0, atol=1e-12)
    found, known = extended.nominal(), plain.nominal()
    assert (found.nq, found.nv, found.nu) == (known.nq, known.nv, known.nu)


def test_layout_is_the_same_at_every_value(model: str, effect: str, site: str) -> None:
    extended, _ = put(model, effect, site)
    low, nominal, high = (
        extended.compile(z) for z in (extended.space.low, extended.space.nominal, extended.space.high)
    )
    assert field_sizes(low) == field_sizes(nominal) == field_sizes(high)


def test_every_parameter_is_seen(model: str, effect: str, site: str) -> None:
    """From absent or a start, or where a parameter only shapes the effect, from where another one is at its end."""
    extended, one = put(model, effect, site)
    for index, parameter in enumerate(one.parameters):
        low = (extended.space.nominal if (model, effect, site) in RUN_AWAY else extended.space.low)[index]
        changes = any(shows(extended, index, z, low) for z in (vectors(extended, one), at_ends(extended)))
        assert changes != ((model, effect, site, parameter.name.rpartition(".")[2]) in UNSEEN), parameter.name


def test_absent_has_a_usable_slope_or_starts(model: str, effect: str, site: str) -> None:
    extended, one = put(model, effect, site)
    nominal = extended.space.nominal
    for index, parameter in enumerate(one.parameters):
        step = 1e-4 * parameter.span
        near = np.tile(nominal, (3, 1))
        near[1:, index] += step * np.array([1.0, 2.0])
        paths = replayed(extended, near, *commands(extended))
        seen = reported(extended, near)
        first, second = (np.abs(paths[k] - paths[0]).max() + np.abs(seen[k] - seen[0]).max() for k in (1, 2))
        assert np.isfinite([first, second]).all()
        if first > 1e-9:  # twice the step, about twice the change: no jump at absent
            assert 1.2 < second / first < 3.5, parameter.name
        elif first == 0:
            assert one.starts, parameter.name


def test_compiling_twice_gives_the_samemodel_bytes(model: str, effect: str, site: str) -> None:
    extended, one = put(model, effect, site)
    z = vectors(extended, one)[-1]
    first = model_bytes(extended.compile(z))
    extended.compile(extended.space.high)
    assert model_bytes(extended.compile(z)) == first


def test_exported_file_is_the_same_machine(model: str, effect: str, site: str) -> None:
    """Text keeps six digits; a second export of the file loses nothing more."""
    extended, one = put(model, effect, site)
    z = 0.5 * (extended.space.nominal + extended.space.high)
    spec = extended.spec_at(z)
    original = spec.compile()
    text = spec.to_xml()
    read = mujoco.MjSpec.from_string(text)
    again = read.compile()
    assert field_sizes(original) == field_sizes(again)
    paths = [_free_run(m) for m in (original, again)]
    moved = np.abs(paths[0] - paths[0][0]).max()
    assert np.abs(paths[0] - paths[1]).max() < 1e-3 * moved + 1e-9
    assert read.to_xml() == text
    assert one.effect.lacks or effect not in {"sensor_time_offset", "actuator_delay"}


def _free_run(model: mujoco.MjModel) -> Array:
    """Positions over 0.15 s under oscillating commands, from a start off the initial position."""
    data, path = mujoco.MjData(model), []
    mujoco.mj_integratePos(model, data.qpos, 0.2 * np.cos(np.arange(model.nv)), 1.0)
    data.qvel[:] = 0.5 * np.sin(np.arange(model.nv) + 1.0)
    for _ in range(round(SECONDS / model.opt.timestep)):
        path.append(data.qpos.copy())
        data.ctrl[:] = np.sin(30.0 * data.time + np.arange(model.nu))
        mujoco.mj_step(model, data)
    return np.array(path)


@pytest.mark.parametrize("name", [name for name in NAMES if catalogue_effect(name).shapes])
def test_what_only_shapes_an_effect_does_nothing_alone(name: str) -> None:
    """At the first site where the effect has them."""
    sites = ((model, site) for model in MODELS for site in catalogue_effect(name).sites(machine(model).nominal()))
    found = (put(model, name, site) for model, site in sites)
    extended, one = next((whole, one) for whole, one in found if len(one.parameters) > 1)
    shapes = [k for k, p in enumerate(one.parameters) if p.name not in one.absent]
    names = [p.name.rpartition(".")[2] for p in one.parameters]
    assert [names[k] for k in shapes] == [name for name in one.effect.shapes if name in names]
    corners = np.tile(extended.space.nominal, (3, 1))
    corners[1, shapes], corners[2, shapes] = extended.space.low[shapes], extended.space.high[shapes]
    paths = replayed(extended, corners, *commands(extended))
    np.testing.assert_allclose(paths[1:], paths[:1].repeat(2, axis=0), rtol=0, atol=1e-9)
