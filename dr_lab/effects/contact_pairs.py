"""Contacts of a body as explicit pairs of geoms, whose parameters can then be set one pair at a time."""

from typing import Any

import mujoco
import numpy as np

from dr_lab.trajectory import Array

Pair = tuple[int, int]
_GEOMS_OF = mujoco.mjtObj.mjOBJ_GEOM


def meeting(model: mujoco.MjModel, body: int) -> tuple[Pair, ...]:
    """Ids of the geoms that MuJoCo may bring into contact with those of a body, explicit pairs first.

    Source: MuJoCo 4.0, computation chapter ("Collision detection", selection), and exclude and pair of the XML
    reference.
    """
    explicit = [(int(a), int(b)) for a, b in zip(model.pair_geom1, model.pair_geom2, strict=True)]
    named = [pair for pair in explicit if body in model.geom_bodyid[list(pair)]]
    own = np.flatnonzero(model.geom_bodyid == body)
    every = ((min(int(a), b), max(int(a), b)) for a in own for b in range(model.ngeom))
    taken = {frozenset(pair) for pair in named}
    return (*named, *(p for p in dict.fromkeys(every) if frozenset(p) not in taken and _may_meet(model, *p)))


def _may_meet(model: mujoco.MjModel, a: int, b: int) -> bool:
    """Whether MuJoCo looks for contacts between two geoms that no pair names."""
    masks = model.geom_contype[[a, b]] & model.geom_conaffinity[[b, a]]
    low, high = sorted(int(model.geom_bodyid[geom]) for geom in (a, b))
    excluded = model.exclude_signature == (low << 16) + high
    return bool(masks.any()) and not excluded.any() and not _related(model, low, high)


def _related(model: mujoco.MjModel, a: int, b: int) -> bool:
    """Whether two bodies are welded together, or parent and child with neither welded to the world."""
    one, other = (int(model.body_weldid[body]) for body in (a, b))
    if one == other:
        return True
    above = [int(model.body_weldid[model.body_parentid[body]]) for body in (one, other)]
    kept = bool(model.opt.disableflags & int(mujoco.mjtDisableBit.mjDSBL_FILTERPARENT))
    return not kept and bool(one) and bool(other) and (one == above[1] or other == above[0])


def dimension(model: mujoco.MjModel, pair: Pair) -> int:
    """Dimension of the contacts of two geoms (`condim`)."""
    named = _named(model, pair)
    return int(model.pair_dim[named] if named is not None else _mixed(model, pair)["condim"])


def reference(model: mujoco.MjModel, pair: Pair) -> Array:
    """Solver reference of the contacts of two geoms (`solref`), shape (2,)."""
    named = _named(model, pair)
    return np.array(model.pair_solref[named] if named is not None else _mixed(model, pair)["solref"], dtype=float)


def explicit_pairs(spec: mujoco.MjSpec, body: str) -> list[Any]:
    """Pairs (MjsPair) of a body's geoms in a spec; contacts that have none yet get one that says the same."""
    for place, geom in enumerate(spec.geoms):
        geom.name = geom.name or f"geom_{place}@{body}"
    model = spec.copy().compile()
    pairs = []
    for a, b in meeting(model, model.body(body).id):
        names = [mujoco.mj_id2name(model, int(_GEOMS_OF), geom) for geom in (a, b)]
        known = [pair for pair in spec.pairs if {pair.geomname1, pair.geomname2} == set(names)]
        if not known:
            pair = spec.add_pair(geomname1=names[0], geomname2=names[1], solreffriction=[0.0, 0.0])
            for attribute, value in _mixed(model, (a, b)).items():
                setattr(pair, attribute, value)
            known = [pair]
        pairs += known
    return pairs


def _named(model: mujoco.MjModel, pair: Pair) -> int | None:
    """Row of the explicit pair of two geoms."""
    ends = np.sort(np.stack([model.pair_geom1, model.pair_geom2]), axis=0).T
    rows = np.flatnonzero((ends == sorted(pair)).all(axis=1))
    return int(rows[0]) if len(rows) else None


def _mixed(model: mujoco.MjModel, pair: Pair) -> dict[str, Any]:
    """Contact parameters that MuJoCo makes of two geoms.

    Source: MuJoCo 4.0, modeling chapter ("Contact parameters"), geom/adhesion.
    """
    both = list(pair)
    first, second = (int(p) for p in model.geom_priority[both])
    if first != second:
        best = both[int(second > first)]
        contact = {name: getattr(model, f"geom_{name}")[best] for name in ("solref", "solimp", "adhesion")}
        contact |= {"condim": int(model.geom_condim[best]), "friction": model.geom_friction[best]}
    else:
        weight = model.geom_solmix[both] / (model.geom_solmix[both].sum() or 1.0)
        weight = weight if weight.any() else np.full(2, 0.5)
        direct = (model.geom_solref[both] <= 0).any()
        contact = {
            "solref": model.geom_solref[both].min(axis=0) if direct else weight @ model.geom_solref[both],
            "solimp": weight @ model.geom_solimp[both],
            "adhesion": model.geom_adhesion[both].sum(),
            "condim": int(model.geom_condim[both].max()),
            "friction": model.geom_friction[both].max(axis=0),
        }
    contact["friction"] = contact["friction"][[0, 0, 1, 2, 2]]
    return contact | {"margin": model.geom_margin[both].sum(), "gap": model.geom_gap[both].sum()}
