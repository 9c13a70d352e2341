"""Pairs of outlines that may touch, and laws with the stiffness of MuJoCo's constraints."""

from __future__ import annotations

from typing import Any

import numpy

from .outlines import MAX_CORNERS, ROUNDING_M, facet, gap
from .planar import GROUND, Body, Contact, Law, Outline
from .projection import Projection
from .read import load_mujoco

# Force on a contact point at which a law has the stiffness of MuJoCo's contact, N.
CONTACT_LOAD_N = 10.0
# Load at which a stop has the stiffness of MuJoCo's limit, N·m or N.
STOP_LOAD = 1.0
# Roundings over the depth of contacts under this load; impacts are deeper.
_DEPTHS = 1.5
_LARGEST_ROUNDING_M = 2e-3
# MuJoCo's damping has no equivalent in a law of impacts: values of the shipped scenes of real grippers.
CONTACT_DAMPING = "3 s/m"
STOP_DAMPING = ("0.2 s/rad", "3 s/m")
BRISTLE_DAMPING = "100 N*s/m"
# Contact points of a scene, at most (1000, with a reserve).
_MAX_POINTS = 900
# Outlines of the hand that are nearer at the start slide along each other, m: their contact would act at rounding errors.
_TOUCHING_M = 1e-6
# Pairs named in a line of the report.
_NAMED = 4


def impedance(solimp: Any, depth: float) -> float:
    """MuJoCo's impedance d at a depth: dmin, dmax, width, midpoint and power of a sigmoid."""
    low, high, width, middle, power = (float(value) for value in solimp[:5])
    low, high = (min(max(value, 1e-4), 0.9999) for value in (low, high))
    x = min(abs(depth) / width, 1.0) if width > 1e-15 else 1.0
    middle, power = min(max(middle, 1e-4), 0.9999), max(power, 1.0)
    if power == 1.0 or x in (0.0, 1.0):
        y = x
    elif x <= middle:
        y = (x / middle) ** power * middle
    else:
        y = 1.0 - ((1.0 - x) / (1.0 - middle)) ** power * (1.0 - middle)
    return low + y * (high - low)


def compliance(work: Projection, solref: Any, solimp: Any, inverse: float, load: float) -> tuple[float, float]:
    """Stiffness of a constraint, load over depth, and the depth under the load.

    The depth r solves (1 - d(r)) A F = d(r)² k r, with A the inverse of the effective mass (`inverse`) and
    k = 1/(dmax² timeconst² dampratio²).
    """
    largest = min(max(float(solimp[1]), 1e-4), 0.9999)
    if solref[0] > 0.0:
        constant = _time_constant(work, solref)
        k = 1.0 / (largest**2 * constant**2 * max(float(solref[1]), 1e-15) ** 2)
    else:
        k = -float(solref[0]) / largest**2
    inverse, k = max(inverse, 1e-15), max(k, 1e-15)

    def excess(depth: float) -> float:
        d = impedance(solimp, depth)
        return d**2 * k * depth - (1.0 - d) * inverse * load

    low, high = 0.0, 1e-9
    while excess(high) < 0.0:
        high *= 2.0
    for _ in range(200):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if excess(middle) < 0.0 else (low, middle)
    return load / high, high


def taut_cable(work: Projection, solref: Any, solimp: Any, inverse: float) -> tuple[float, float]:
    """Stiffness and damping of a cable at the end of its range: those of MuJoCo's limit at a static load of 1 N.

    The force F of a limit at the depth r satisfies (1 - d) A F = d (b r' + d k r), with b = 2/(dmax timeconst).
    """
    stiffness, depth = compliance(work, solref, solimp, inverse, STOP_LOAD)
    largest, d = min(max(float(solimp[1]), 1e-4), 0.9999), impedance(solimp, depth)
    b = -float(solref[1]) / largest if solref[0] <= 0.0 else 2.0 / (largest * _time_constant(work, solref))
    return stiffness, d * b / ((1.0 - d) * max(inverse, 1e-15))


def _time_constant(work: Projection, solref: Any) -> float:
    constant = float(solref[0])
    return constant if work.is_disabled("REFSAFE") else max(constant, 2.0 * float(work.model.opt.timestep))


def law_name(work: Projection, law: Law) -> str:
    """Key of a law, which is added if no other is equal; names follow when all laws are known."""
    law.name = f"{law.comment}|{law.stiffness}|{law.friction}"
    if all(other.name != law.name for other in work.mechanism.laws):
        work.mechanism.laws.append(law)
    return law.name


def stop_law(work: Projection, solref: Any, solimp: Any, inverse: float, is_linear: bool, factor: float = 1.0) -> str:
    """Key of the law of a stop with the stiffness of MuJoCo's limit, to three digits.

    factor: change of the limited length over that of the coordinate on which the stop acts.
    """
    stiffness = factor**2 * compliance(work, solref, solimp, inverse, STOP_LOAD / abs(factor))[0]
    unit, kind = ("N", "slides") if is_linear else ("N*m", "hinges")
    comment = f"stops of {kind}: MuJoCo's static penetration at {STOP_LOAD:g} {unit}; its damping has no equivalent"
    return law_name(work, Law("", float(f"{stiffness:.3g}"), None, comment, is_linear))


def rounding_of(work: Projection, geoms: list[int]) -> float:
    """Radius of corners with which the contacts of free bodies are not deeper than their outlines are round, m."""
    deepest = 0.0
    for first, second, settings in _pairs(work, geoms):
        if any(work.is_object(int(work.model.geom_bodyid[geom])) for geom in (first, second)):
            deepest = max(deepest, _compliance(work, first, second, settings)[1])
    if _DEPTHS * deepest > _LARGEST_ROUNDING_M:
        text = f"they yield by up to {1e3 * deepest:.2g} mm under {CONTACT_LOAD_N:g} N, more than corners are round"
        remedy = "give the geoms a smaller solref, or the laws of the scene a larger stiffness"
        work.report.warn("contacts with free bodies", f"{text}: {remedy}")
    return min(max(ROUNDING_M, round(_DEPTHS * deepest, 4)), _LARGEST_ROUNDING_M)


def add_contacts(work: Projection) -> None:
    """Contacts of free bodies with everything that MuJoCo lets touch them, and of the hand with itself where its outlines
    neither overlap at the start nor lie side by side.
    """
    overlapping: list[str] = []
    inside: list[str] = []
    apart: list[str] = []
    own: list[tuple[int, int, dict[str, Any]]] = []
    of_objects: list[tuple[float, int, int, dict[str, Any]]] = []
    lost = {"torsional and rolling friction": False, "margins of geoms": False}
    for first, second, settings in _pairs(work, list(work.outlines)):
        (body_a, a), (body_b, b) = work.outlines[first], work.outlines[second]
        is_of_object = any(body is not None and body.is_free for body in (body_a, body_b))
        names = f"{_full_name(body_a, a)} and {_full_name(body_b, b)}"
        distance = gap(a, _pose(body_a), b, _pose(body_b))
        if not is_of_object:
            if min(a.depth[1], b.depth[1]) <= max(a.depth[0], b.depth[0]):
                apart.append(names)
                continue
            if distance <= _TOUCHING_M:
                overlapping.append(f"{names} ({max(-1e3 * distance, 0.0) + 0.0:.3g} mm)")
                continue
        elif distance < -1e-3:
            inside.append(f"{names} ({abs(1e3 * distance):.3g} mm)")
            continue
        if a.type == "ellipse" and b.type == "ellipse":
            # Two ellipses cannot touch; the object keeps its own.
            body, outline = (body_b, b) if body_a is not None and body_a.is_free else (body_a, a)
            deviation = facet(outline, work.rounding)
            text = f"a polygon of {MAX_CORNERS} corners in place of an ellipse, because two ellipses cannot touch"
            work.report.changed(_full_name(body, outline), f"{text}; it deviates by up to {1e6 * deviation:.0f} µm")
        lost["torsional and rolling friction"] |= settings["condim"] > 3
        lost["margins of geoms"] |= settings["margin"] != 0.0
        if is_of_object:
            of_objects.append((distance, first, second, settings))
        else:
            own.append((first, second, settings))
    points, far = 0, []
    for _, first, second, settings in sorted(of_objects, key=lambda pair: pair[0]):
        count = sum(_points(work.outlines[g][1]) for g in (first, second))
        if points + count > _MAX_POINTS:
            far.append(" and ".join(_full_name(*work.outlines[g]) for g in (first, second)))
        else:
            points += count
            _add(work, first, second, settings)
    count = sum(_points(work.outlines[g][1]) for first, second, _ in own for g in (first, second))
    if points + count > _MAX_POINTS:
        work.report.lost(
            "contacts of the hand with itself",
            f"{len(own)} pairs with {count} points, more than a scene may contain; they pass through each other",
        )
    else:
        for first, second, settings in own:
            _add(work, first, second, settings)
    _report_pairs(work, "contacts that touch or overlap at the start", overlapping, "they pass through each other")
    remedy = "place the object elsewhere (a cube of --cube: --cube-at), or open the hand by a key frame"
    _report_pairs(work, "contacts of the object that overlap at the start", inside, f"they pass through each other; {remedy}")
    _report_pairs(work, "contacts beyond the largest number", far, "they are farthest apart at the start, and pass through each other")
    _report_pairs(work, "contacts side by side", apart, "they overlap in the projection only, and pass each other")
    for what in (name for name, is_lost in lost.items() if is_lost):
        work.report.lost("contacts", f"{what} have no equivalent")


def _report_pairs(work: Projection, name: str, pairs: list[str], effect: str) -> None:
    if pairs:
        work.report.lost(name, f"{_some(pairs)}: {effect}")


def _some(pairs: list[str]) -> str:
    """The first pairs, and the number of the others."""
    return "; ".join(pairs[:_NAMED]) + (f" and {len(pairs) - _NAMED} more" if len(pairs) > _NAMED else "")


def _full_name(body: Body | None, outline: Outline) -> str:
    return f"{body.name if body else GROUND}.{outline.name}"


def _pose(body: Body | None) -> tuple[Any, float]:
    return (body.at, body.angle) if body else ((0.0, 0.0), 0.0)


def _points(outline: Outline) -> int:
    """Number of points with which an outline touches."""
    return {"disc": 1, "ellipse": 1, "capsule": 2, "box": 4, "half_plane": 0}.get(outline.type, len(outline.points))


def _pairs(work: Projection, candidates: list[int]) -> list[tuple[int, int, dict[str, Any]]]:
    """Pairs of geoms that MuJoCo lets touch each other, with their settings."""
    model = work.model
    if work.is_disabled("CONTACT") or work.is_disabled("CONSTRAINT"):
        return []
    found: dict[tuple[int, int], dict[str, Any]] = {}
    for k in range(model.npair):
        names = ("solref", "solimp", "friction", "margin")
        settings = {name: getattr(model, f"pair_{name}")[k] for name in names} | {"condim": int(model.pair_dim[k])}
        settings["friction"] = float(settings["friction"][0])
        found[_ordered(model.pair_geom1[k], model.pair_geom2[k])] = settings
    excluded = {int(signature) for signature in model.exclude_signature}
    geoms = [g for g in candidates if model.geom_contype[g] or model.geom_conaffinity[g]]
    for index, first in enumerate(geoms):
        for second in geoms[index + 1 :]:
            if _may_touch(work, first, second, excluded):
                found.setdefault(_ordered(first, second), _mixed(work, first, second))
    groups = {geom: int(work.group[model.geom_bodyid[geom]]) for geom in candidates}
    return [(*pair, settings) for pair, settings in sorted(found.items()) if all(g in groups for g in pair) and groups[pair[0]] != groups[pair[1]]]


def _ordered(a: int, b: int) -> tuple[int, int]:
    return (int(a), int(b)) if a < b else (int(b), int(a))


def _may_touch(work: Projection, first: int, second: int, excluded: set[int]) -> bool:
    model = work.model
    types, affinities = model.geom_contype, model.geom_conaffinity
    if not (types[first] & affinities[second] or types[second] & affinities[first]):
        return False
    bodies = sorted(int(model.geom_bodyid[g]) for g in (first, second))
    if (bodies[0] << 16) + bodies[1] in excluded:
        return False
    welds = [int(model.body_weldid[body]) for body in bodies]
    if welds[0] == welds[1]:
        return False
    parents = [int(model.body_weldid[model.body_parentid[weld]]) for weld in welds]
    if work.is_disabled("FILTERPARENT"):
        return True
    return not ((welds[0] == parents[1] and welds[0] != 0) or (welds[1] == parents[0] and welds[1] != 0))


def _mixed(work: Projection, first: int, second: int) -> dict[str, Any]:
    """Settings of a pair of geoms: those of the higher priority, or their mean, with the larger friction."""
    model = work.model
    priorities = model.geom_priority[first], model.geom_priority[second]
    margin = float(max(model.geom_margin[first], model.geom_margin[second]))
    if priorities[0] != priorities[1]:
        geom = first if priorities[0] > priorities[1] else second
        settings = {name: getattr(model, f"geom_{name}")[geom] for name in ("solref", "solimp")}
        return settings | {"friction": float(model.geom_friction[geom, 0]), "margin": margin, "condim": int(model.geom_condim[geom])}
    weights = [float(model.geom_solmix[g]) for g in (first, second)]
    part = weights[0] / sum(weights) if min(weights) >= 1e-15 else (0.5 if max(weights) < 1e-15 else float(weights[0] >= 1e-15))
    references = model.geom_solref[first], model.geom_solref[second]
    standard = references[0][0] > 0.0 and references[1][0] > 0.0
    solref = part * references[0] + (1.0 - part) * references[1] if standard else numpy.minimum(*references)
    solimp = part * model.geom_solimp[first] + (1.0 - part) * model.geom_solimp[second]
    friction = float(max(model.geom_friction[first, 0], model.geom_friction[second, 0]))
    return {
        "solref": solref,
        "solimp": solimp,
        "friction": friction,
        "margin": margin,
        "condim": int(max(model.geom_condim[first], model.geom_condim[second])),
    }


def _compliance(work: Projection, first: int, second: int, settings: dict[str, Any]) -> tuple[float, float]:
    """Stiffness of a contact point in space, and its depth under the load.

    The edges of a pyramidal cone of friction share the load: they make the contact stiffer by the factor
    (condim - 1) impratio / (mu² (1 + mu²)), exactly.
    """
    model, mu, condim = work.model, settings["friction"], settings["condim"]
    inverse = sum(float(model.body_invweight0[model.geom_bodyid[g], 0]) for g in (first, second))
    if model.opt.cone == load_mujoco().mjtCone.mjCONE_PYRAMIDAL and condim > 1 and mu > 0.0:
        inverse *= mu**2 * (1.0 + mu**2) / ((condim - 1) * float(model.opt.impratio))
    return compliance(work, settings["solref"], settings["solimp"], inverse, CONTACT_LOAD_N)


def _add(work: Projection, first: int, second: int, settings: dict[str, Any]) -> None:
    model, types = work.model, load_mujoco().mjtGeom
    stiffness = _compliance(work, first, second, settings)[0]
    # Two flat faces touch in four points in space, and in two in the plane.
    flat = {int(types.mjGEOM_BOX), int(types.mjGEOM_MESH), int(types.mjGEOM_PLANE)}
    is_flat = all(int(model.geom_type[g]) in flat for g in (first, second))
    stiffness *= 2.0 if is_flat else 1.0
    friction = settings["friction"] if settings["condim"] > 1 else 0.0
    comment = f"MuJoCo's static penetration at {CONTACT_LOAD_N:g} N per point" + (", two points for each of the plane" if is_flat else "")
    law = law_name(work, Law("", float(f"{stiffness:.3g}"), friction, comment))
    (body_a, a), (body_b, b) = work.outlines[first], work.outlines[second]
    work.mechanism.contacts.append(Contact((_full_name(body_a, a), _full_name(body_b, b)), law))
