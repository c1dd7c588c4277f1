import mujoco
import numpy as np
import pytest
from effect_machines import CONF, catalogue_effect, hanging, placed, scales_of, with_effect

from dr_lab.effects.effect import place
from dr_lab.effects.rigid_payload import RigidPayload
from dr_lab.errors import UnknownNameError
from dr_lab.physics.model import Model, from_spec, load
from dr_lab.physics.pseudo_inertia import Inertial, second_moments
from dr_lab.trajectory import Array

VALUES = {"mass": 1.2, "side": -0.02, "along": 0.1, "spread_x": 0.03, "spread_y": 0.02, "spread_z": 0.05}


def arm() -> Model:
    return load("seven", CONF / "model/strangers/seven.xml", {})


def flange(names: tuple[str, ...]) -> RigidPayload:
    one = catalogue_effect("rigid_payload")
    assert isinstance(one, RigidPayload)
    return RigidPayload(**{**vars(one), "flanges": names})


def total(model: mujoco.MjModel, *names: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, centre and second moments about it of bodies that are welded together, in the frame of the first."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    first = model.body(names[0]).id
    turn, origin = data.xmat[first].reshape(3, 3), data.xpos[first]
    parts = []
    for body in (model.body(name) for name in names):
        axes = turn.T @ data.ximat[body.id].reshape(3, 3)
        inertia = axes @ np.diag(body.inertia) @ axes.T
        parts.append((float(body.mass[0]), turn.T @ (data.xipos[body.id] - origin), second_moments(inertia)))
    mass = sum(part[0] for part in parts)
    centre = sum((m * c for m, c, _ in parts), np.zeros(3)) / mass
    spread = sum((s + m * np.outer(c - centre, c - centre) for m, c, s in parts), np.zeros((3, 3)))
    return mass, centre, spread


def test_it_sits_where_the_joints_feel_all_of_it() -> None:
    assert catalogue_effect("rigid_payload").sites(arm().nominal()) == ("link4", "link5", "link6", "link7")
    assert catalogue_effect("rigid_payload").sites(hanging().nominal()) == ()


def test_it_adds_mass_centre_and_inertia_in_the_axes_of_the_joint() -> None:
    model = with_effect(arm(), "rigid_payload", "link7", **VALUES, distance=0.04, skew_xy=0.01)
    plain, loaded = total(arm().nominal(), "link7"), total(model, "link7", "rigid_payload@link7")
    mass = loaded[0] - plain[0]
    assert mass == pytest.approx(1.2)
    first = np.array([0.01, 0.005, 0.0]) / np.hypot(0.01, 0.005)  # link7's centre lies there across its joint
    axes = np.stack([first, np.cross([0, 0, 1], first), [0, 0, 1]], axis=1)
    centre = axes @ [0.04, -0.02, 0.1]
    np.testing.assert_allclose((loaded[0] * loaded[1] - plain[0] * plain[1]) / mass, centre, atol=1e-12)
    root = np.array([[0.03, 0.01, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.05]])
    about_origin = [s + m * np.outer(c, c) for m, c, s in (loaded, plain)]
    expected = 1.2 * (axes @ root @ root.T @ axes.T + np.outer(centre, centre))
    np.testing.assert_allclose(about_origin[0] - about_origin[1], expected, atol=1e-12)


def test_no_value_gives_a_body_that_cannot_exist() -> None:
    rng, machine = np.random.default_rng(2), arm()
    model = machine.with_effect(placed(machine, "rigid_payload", "link6"))
    unit: Array = np.concatenate([rng.uniform(0, 1, (40, 10)), rng.integers(0, 2, (40, 10)).astype(np.float64)])
    for z in model.space.from_unit(unit):
        body = model.compile(z).body("rigid_payload@link6")
        tensor = Inertial(body.mass, body.ipos[None], body.inertia[None], body.iquat[None]).tensor[0]
        assert np.linalg.eigvalsh(second_moments(tensor))[0] >= -1e-12 * max(body.inertia.max(), 1e-12)


def test_a_flat_body_can_exist() -> None:
    """A sheet has A + B = C, and short of that by the last bit MuJoCo compiles nothing."""
    rng, machine = np.random.default_rng(0), arm()
    model = machine.with_effect(placed(machine, "rigid_payload", "link7"))
    for spread in rng.uniform(0.01, 0.1, (150, 3)):
        flat = {"mass": 1.0, "spread_x": spread[0], "spread_y": spread[1], "spread_z": 0.0, "skew_xy": spread[2]}
        model.compile(model.space.vector({f"rigid_payload@link7.{name}": value for name, value in flat.items()}))


def test_without_its_further_parameters_it_acts_as_a_payload() -> None:
    case = RigidPayload.holds["payload"]
    ours = with_effect(arm(), "rigid_payload", "link6", mass=0.4, distance=0.07, **dict.fromkeys(case.further, 0.0))
    theirs = with_effect(arm(), "payload", "link6", mass=0.4, distance=0.07)
    angles = {"qpos": np.linspace(-1, 1, 7), "qvel": np.linspace(1, 2, 7)}
    found = []
    for model in (ours, theirs):
        data = mujoco.MjData(model)
        data.qpos[:], data.qvel[:] = angles["qpos"], angles["qvel"]
        mujoco.mj_forward(model, data)
        found.append(data.qacc.copy())
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9)


def test_at_a_flange_it_sits_in_the_axes_of_the_site() -> None:
    spec = mujoco.MjSpec.from_file(str(CONF / "model/strangers/seven.xml"))
    spec.body("link7").add_site(name="gripper", pos=[0, 0, 0.107], quat=[0.6, 0.0, 0.8, 0.0])
    machine = from_spec("seven", spec, {})
    effect, nominal = flange(("gripper",)), machine.nominal()
    assert effect.sites(nominal)[-1] == "gripper"
    model = machine.with_effect(place(effect, nominal, "gripper", scales_of(machine)))
    names = {f"rigid_payload@gripper.{name}": value for name, value in {**VALUES, "distance": 0.04}.items()}
    compiled = model.compile(model.space.vector(names))
    data, other = mujoco.MjData(compiled), mujoco.MjData(nominal)
    mujoco.mj_forward(compiled, data)
    mujoco.mj_forward(nominal, other)
    turn = other.site("gripper").xmat.reshape(3, 3)
    np.testing.assert_allclose(
        data.body("rigid_payload@gripper").xipos, other.site("gripper").xpos + turn @ [0.04, -0.02, 0.1], atol=1e-12
    )
    with pytest.raises(UnknownNameError, match="Did you mean 'gripper'"):
        flange(("griper",)).sites(nominal)


def test_bounds_are_as_wide_as_the_machine_is_heavy() -> None:
    one = placed(arm(), "rigid_payload", "link7")
    assert len(one.parameters) == 10
    assert one.parameters[0].high == pytest.approx(17.5)
    assert all(0 < start["rigid_payload@link7.mass"] < 2 for start in one.starts)
