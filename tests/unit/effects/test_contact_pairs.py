from itertools import combinations

import mujoco
import numpy as np
import pytest
from effect_machines import CONF, catalogue_effect, with_effect

from dr_lab.effects.contact_pairs import explicit_pairs, meeting
from dr_lab.physics.effect_parts import SpecEdit
from dr_lab.physics.model import from_spec, load

CROWD = """<mujoco>
  <default><geom contype="1" conaffinity="1" gap="0.5"/></default>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" friction="0.5 0.01 0.001" solref="0.03 0.8" margin="0.001"
          adhesion="0.2"/>
    <body name="trunk" pos="0 0 0.1"><freejoint/>
      <geom name="trunk" type="box" size="0.1 0.1 0.1" friction="0.3 0.02 0.0005" solmix="2" solimp="0.8 0.9 0.01"
            margin="0.002" condim="4"/>
      <geom name="picture" contype="0" conaffinity="0" size="0.2"/>
      <body name="arm" pos="0.12 0 0"><joint axis="0 1 0"/><geom name="arm" size="0.05" priority="1" solref="-900 -20"/>
        <body name="glued"><geom name="glued" size="0.06" solmix="0"/></body>
        <body name="hand" pos="0.1 0 0"><joint axis="0 1 0"/><geom name="hand" size="0.05" solref="-500 -30"/></body>
      </body>
    </body>
    <body name="ball" pos="0 0 0.25"><freejoint/><geom name="ball" size="0.06" contype="2" conaffinity="1"/></body>
    <body name="other" pos="0.1 0 0.25"><freejoint/><geom name="other" size="0.06" friction="2 0.1 0.1"/></body>
    <body name="ghost" pos="0.1 0 0.2"><freejoint/><geom name="ghost" size="0.06" contype="4" conaffinity="4"/></body>
  </worldbody>
  <contact>
    <exclude body1="ball" body2="trunk"/>
    <pair geom1="other" geom2="floor" friction="0.9 0.8 0.1 0.1 0.1" solref="0.01 2" margin="2"/>
  </contact>
</mujoco>"""
FIELDS = ("dist", "friction", "solref", "solimp", "dim", "includemargin")


def contacts(model: mujoco.MjModel) -> dict[frozenset[int], list[tuple[float, ...]]]:
    """All that MuJoCo makes of the contacts of the initial position, by geoms."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    found: dict[frozenset[int], list[tuple[float, ...]]] = {}
    for contact in data.contact:
        row = tuple(float(v) for field in FIELDS for v in np.ravel(getattr(contact, field)))
        found.setdefault(frozenset(map(int, contact.geom)), []).append(row)
    return found


@pytest.mark.parametrize("body", ["trunk", "arm", "glued", "hand", "ball", "other", "ghost"])
def test_explicit_pairs_are_the_contacts_that_mujoco_makes(body: str) -> None:
    spec = mujoco.MjSpec.from_string(CROWD)
    plain = contacts(spec.copy().compile())
    pairs = explicit_pairs(spec, body)
    named = contacts(spec.compile())
    assert plain.keys() == named.keys()
    for geoms, rows in plain.items():
        np.testing.assert_allclose(sorted(named[geoms]), sorted(rows), rtol=1e-12, atol=1e-15)
    assert len(explicit_pairs(spec, body)) == len(pairs) == len({frozenset((p.geomname1, p.geomname2)) for p in pairs})


def test_geoms_meet_where_mujoco_looks_for_contacts() -> None:
    model = mujoco.MjModel.from_xml_string(CROWD)
    name = {model.geom(i).name: i for i in range(model.ngeom)}

    def partners(body: str) -> set[str]:
        own = {model.geom(g).name for g in range(model.ngeom) if model.body(model.geom(g).bodyid[0]).name == body}
        met = {model.geom(g).name for pair in meeting(model, model.body(body).id) for g in pair}
        return met - own

    assert partners("trunk") == {"floor", "hand", "other"}  # not the arm, its child, nor the excluded ball
    assert partners("hand") == {"floor", "trunk", "ball", "other"}
    assert partners("ball") == {"floor", "arm", "glued", "hand", "other"}
    assert partners("ghost") == set()
    assert name["picture"] not in {g for pair in meeting(model, model.body("trunk").id) for g in pair}
    touching = contacts(model).keys()
    every = {frozenset(p) for b in range(1, model.nbody) for p in meeting(model, b)}
    assert touching <= every <= {frozenset(p) for p in combinations(range(model.ngeom), 2)}


def test_two_effects_share_the_pairs_of_a_body() -> None:
    hopper = load("hopper", CONF / "model" / "hopper.xml", {})
    once = with_effect(hopper, "contact_friction", "foot", factor=0.5)
    spec = once and hopper.spec.copy()
    for name, values in (
        ("contact_friction", {"factor": 0.5}),
        ("contact_stiffness", {"time_constant": 2.0, "damping_ratio": 0.5}),
    ):
        effect = catalogue_effect(name)
        assert isinstance(effect, SpecEdit)
        effect.edit(spec, "foot", values)
    both = spec.compile()
    assert both.npair == once.npair
    np.testing.assert_array_equal(both.pair_friction, once.pair_friction)
    np.testing.assert_allclose(both.pair_solref, np.tile([0.04, 0.5], (both.npair, 1)))


def test_sites_are_the_ends_of_chains_and_what_touches_from_the_start() -> None:
    hopper = load("hopper", CONF / "model" / "hopper.xml", {})
    crowd = from_spec("crowd", mujoco.MjSpec.from_string(CROWD), {})
    effect = catalogue_effect("contact_stiffness")
    assert effect.sites(hopper.nominal()) == ("foot",)
    assert effect.sites(crowd.nominal()) == ("trunk", "arm", "glued", "hand", "ball", "other")
    assert effect.sites(load("cartpole", CONF / "model" / "cartpole.xml", {}).nominal()) == ()
