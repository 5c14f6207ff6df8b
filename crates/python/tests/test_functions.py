"""Costs, cost modifiers and constraints written in Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import curvmesh as cm


def area(triangles: Any) -> Any:
    a, b, c = triangles[:, 0], triangles[:, 1], triangles[:, 2]
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


def cotangents(triangles: Any) -> Any:
    total = np.zeros(len(triangles))
    for i in range(3):
        a, b, c = (triangles[:, (i + k) % 3] for k in range(3))
        u, w = b - a, c - a
        total += (u * w).sum(axis=1) / np.linalg.norm(np.cross(u, w), axis=1)
    return total


def mean(edges: Any) -> Any:
    """A quarter of the length times the absolute dihedral angle: |H| at both ends."""
    a, b, c, d = (edges[:, k] for k in range(4))
    e = b - a
    n, m = np.cross(e, c - a), np.cross(d - a, e)
    sine = np.linalg.norm(np.cross(n, m), axis=1)
    return 0.5 * np.linalg.norm(e, axis=1) * np.abs(np.arctan2(sine, (n * m).sum(axis=1)))


@pytest.mark.parametrize(
    "function, name",
    [
        (cm.FaceCost(area, 2), "area"),
        (cm.FaceCost(cotangents, 0), "delaunay"),
        (cm.EdgeCost(mean, 1), "f2"),
    ],
)
def test_a_flip_cost_of_ones_own_is_the_built_in_one(function: Any, name: Any, bumpy: cm.Mesh) -> None:
    small = cm.simplify(bumpy, faces=800, preset="fast").mesh
    ours, theirs = cm.flip(small, cost=function), cm.flip(small, cost=name)
    ratio = (ours.cost_before / theirs.cost_before, ours.cost_after / theirs.cost_after)
    assert ratio[0] == pytest.approx(ratio[1], rel=1e-9)
    assert ours.flips == theirs.flips
    assert ours.mesh == theirs.mesh


def test_functions_get_many_candidates_at_a_time(bumpy: cm.Mesh) -> None:
    sizes: list[int] = []

    def counted(triangles: Any) -> Any:
        sizes.append(len(triangles))
        return area(triangles)

    small = cm.simplify(bumpy, faces=2000, preset="fast").mesh
    flipped = cm.flip(small, cost=cm.FaceCost(counted, 2))
    assert flipped.flips > 50
    assert len(sizes) < 20 * flipped.flips and max(sizes) >= 32


def test_a_collapse_cost_of_ones_own(bumpy: cm.Mesh) -> None:
    asked: list[int] = []

    def length(edges: cm.Edges) -> Any:
        asked.append(len(edges.lengths))
        assert edges.vertices.shape == (len(edges.lengths), 2)
        return edges.lengths

    small = cm.simplify(bumpy, faces=1000, cost=length, placement="midpoint")
    assert small.mesh.face_count == 1000
    assert asked[0] == 3 * bumpy.face_count // 2
    assert len(asked) == 1 + len(small.log)
    # Short edges are collapsed first, so the remaining ones have similar lengths.
    edges = small.mesh.vertices[small.mesh.faces]
    lengths = np.linalg.norm(edges - np.roll(edges, 1, axis=1), axis=2)
    assert lengths.max() / lengths.min() < 8
    small.mesh.validate()


def test_a_modifier_of_nothing_changes_nothing(bumpy: cm.Mesh) -> None:
    def nothing(edges: cm.Edges) -> Any:
        return np.zeros(len(edges.lengths))

    def everything(edges: cm.Edges) -> Any:
        return np.ones(len(edges.lengths), bool)

    # With this many faces, the metric is used from the first collapse without functions, too.
    plain = cm.simplify(bumpy, faces=2000, fit_rounds=0)
    for options in ({"cost_modifier": nothing}, {"constraint": everything}):
        found = cm.simplify(bumpy, faces=2000, **options)  # type: ignore[arg-type]
        assert found.mesh == plain.mesh


def test_the_norm_of_a_fit(bumpy: cm.Mesh) -> None:
    usual = cm.simplify(bumpy, faces=700)
    for norm in ("l1", "l2", "max"):
        found = cm.simplify(bumpy, faces=700, norm=norm)
        assert found.fit is not None and found.fit.norm == norm
        assert (found.mesh == usual.mesh) == (norm == "l2")
    with pytest.raises(cm.OptionError, match="not fitted"):
        cm.simplify(bumpy, faces=700, preset="fast", norm="l1")


def test_the_time_of_annealing(bumpy: cm.Mesh) -> None:
    def distances(**options: Any) -> Any:
        made = cm.simplify(bumpy, faces=300, preset="extreme", **options).mesh
        return cm.distance(bumpy, made)

    whole, none = distances(), distances(anneal_time=0)
    assert whole.forward.mean < none.forward.mean
    with pytest.raises(cm.OptionError, match="anneal_time"):
        cm.simplify(bumpy, faces=300, anneal_time=1)
    with pytest.raises(cm.OptionError, match="anneal_time"):
        cm.simplify(bumpy, faces=300, preset="extreme", anneal_time=-1)


def test_a_modifier_and_a_constraint(bumpy: cm.Mesh) -> None:
    def left(mesh: cm.Mesh) -> int:
        return int((mesh.vertices[:, 0] < 0).sum())

    def dearer(edges: cm.Edges) -> Any:
        return np.where(edges.midpoints[:, 0] < 0, 1e6, 0)

    def painted(edges: cm.Edges) -> Any:
        return (edges.vertices % 3 != 0).any(axis=1)

    plain = cm.simplify(bumpy, faces=2500)
    assert left(cm.simplify(bumpy, faces=2500, cost_modifier=dearer).mesh) > 1.2 * left(plain.mesh)
    kept = cm.simplify(bumpy, faces=300, constraint=painted)
    assert kept.refused["other"] > 0
    kept.mesh.validate()


@pytest.mark.parametrize("answer", [lambda e: 1 / 0, lambda e: [1.0], lambda e: "no"])
def test_exceptions_of_functions_come_back(answer: Any, bumpy: cm.Mesh) -> None:
    for option in ("cost", "cost_modifier", "constraint"):
        with pytest.raises((ZeroDivisionError, ValueError)):
            cm.simplify(bumpy, faces=500, **{option: answer})
    with pytest.raises((ZeroDivisionError, ValueError)):
        cm.flip(bumpy, cost=cm.FaceCost(answer, 2))


def test_subdivision_says_what_it_leaves_out() -> None:
    ball = cm.shapes.sphere(1)
    assert cm.subdivide(ball).notes == []
    ball.vertex_data["normals"] = ball.vertices
    ball.corner_data["normals"] = ball.vertices[ball.corners]
    notes = cm.subdivide(ball).notes
    assert len(notes) == 2 and all("normals of" in note and "subdivision" in note for note in notes)
