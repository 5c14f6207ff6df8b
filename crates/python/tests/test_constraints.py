"""Constraints of simplification, judged by brute force."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import curvmesh as cm


def marked() -> cm.Mesh:
    """A sphere with a kept pole, kept faces at the other pole, and importance along x."""
    ball = cm.shapes.sphere(4)
    points, faces = ball.vertices, ball.faces
    centres = points[faces].mean(axis=1)
    return cm.Mesh(
        points,
        faces,
        vertex_data={
            "pole": (points[:, 2] > 0.95).astype(np.uint8),
            "weight": np.where(points[:, 0] > 0, 50.0, 1.0),
        },
        face_data={"patch": (centres[:, 2] < -0.95).astype(np.int32)},
    )


def places(points: Any) -> set[tuple[float, ...]]:
    return {tuple(point) for point in points.tolist()}


def triangles(mesh: cm.Mesh) -> set[frozenset[tuple[float, ...]]]:
    return {frozenset(tuple(point) for point in corners) for corners in mesh.vertices[mesh.faces].tolist()}


@pytest.mark.parametrize("preset", ["draft", "default", "quality"])
def test_marked_elements_stay(preset: Any) -> None:
    ball = marked()
    small = cm.simplify(ball, ratio=0.1, preset=preset, keep="pole").mesh
    pole = ball.vertices[np.asarray(ball.vertex_data["pole"]) > 0]
    assert len(pole) > 20 and places(pole) <= places(small.vertices)
    small = cm.simplify(ball, ratio=0.1, preset=preset, keep="patch").mesh
    patch = np.asarray(ball.face_data["patch"]) > 0
    kept = {frozenset(map(tuple, corners)) for corners in ball.vertices[ball.faces[patch]].tolist()}
    assert len(kept) > 20 and kept <= triangles(small)


def test_limits_hold_and_a_target_that_they_exclude_is_reported() -> None:
    ball = marked()
    done = cm.simplify(ball, faces=40, max_edge="10%", min_angle=20.0, max_valence=8)
    corners = done.mesh.vertices[done.mesh.faces]
    sides = np.roll(corners, -1, axis=1) - corners
    lengths = np.linalg.norm(sides, axis=2)
    diagonal = np.linalg.norm(np.ptp(ball.vertices, axis=0))
    assert lengths.max() <= 0.1 * diagonal * (1 + 1e-9)
    cosines = -(sides * np.roll(sides, 1, axis=1)).sum(axis=2) / (lengths * np.roll(lengths, 1, axis=1))
    assert np.degrees(np.arccos(cosines)).min() >= 20 - 1e-6
    assert np.bincount(done.mesh.faces.ravel()).max() <= 8
    shortfall = done.shortfall
    assert shortfall is not None and shortfall.wanted_faces == 40 and shortfall.held_by["max_edge"] > 0
    assert "target not reached" in repr(done)
    assert cm.simplify(ball, faces=500).shortfall is None


def test_important_parts_keep_more_vertices() -> None:
    small = cm.simplify(marked(), ratio=0.05, weight="weight").mesh
    assert (small.vertices[:, 0] > 0).mean() > 2 / 3


@pytest.mark.parametrize(
    "options, message",
    [
        ({"keep": "nothing"}, "pole"),
        ({"weight": "patch"}, "per vertex"),
        ({"max_edge": 0.0}, "max_edge"),
        ({"min_angle": 60.0}, "min_angle"),
        ({"max_valence": 2}, "max_valence"),
    ],
)
def test_constraints_that_mean_nothing_are_refused(options: Any, message: str) -> None:
    with pytest.raises(cm.OptionError, match=message):
        cm.simplify(marked(), ratio=0.5, **options)


def test_small_charts_make_room_for_the_shape() -> None:
    ball = cm.shapes.sphere(4)
    faces = np.arange(ball.face_count)
    # Sixteen faces with the same label are a triangle of the icosahedron after two subdivisions.
    labels = (faces // 16).astype(np.int32)
    patchwork = cm.Mesh(ball.vertices, ball.faces, face_data={"label": labels})
    merged = cm.simplify(patchwork, faces=200)
    assert merged.mesh.face_count <= 200
    assert merged.charts is not None and merged.charts.after < merged.charts.before
    kept = cm.simplify(patchwork, faces=200, keep_seams=True)
    assert kept.charts is None and kept.mesh.face_count > 200
    assert kept.shortfall is not None
    values = np.asarray(merged.mesh.face_data["label"])
    assert set(values.tolist()) <= set(labels.tolist())
