"""Distances of point clouds, and signed distances, compared with closed forms."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import curvmesh as cm

POINTS = np.array([[0.3, 0.3, 0.1], [0.5, 0.5, -0.05], [0.7, 0.2, 0.02], [2.0, 0.5, 0.0]])


def cloud(points: Any = POINTS) -> cm.Mesh:
    return cm.Mesh(points, np.zeros((0, 3), dtype=np.int32))


def square() -> cm.Mesh:
    corners = np.array([[-1.0, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    return cm.Mesh(corners, np.array([[0, 1, 2], [0, 2, 3]]))


def test_points_are_measured_to_a_surface_and_not_back() -> None:
    found = cm.distance(cloud(), square())
    assert found.backward is None and found.forward is not None
    assert found.mean == found.forward.mean == pytest.approx(np.mean([0.1, 0.05, 0.02, 1]))
    assert found.max == pytest.approx(1) and found.forward.max_at == (2.0, 0.5, 0.0)
    assert found.of_vertices == pytest.approx([0.1, 0.05, 0.02, 1])
    other_way = cm.distance(square(), cloud())
    assert other_way.forward is None and other_way.backward is not None and other_way.max == found.max
    assert "B to A" not in repr(found)


def test_clouds_are_measured_in_both_directions() -> None:
    a, b = np.random.default_rng(1).normal(size=(2, 50, 3))
    found = cm.distance(cloud(a), cloud(b))
    table = np.linalg.norm(a[:, None] - b[None], axis=2)
    assert found.forward is not None and found.backward is not None
    assert found.forward.mean == pytest.approx(table.min(axis=1).mean())
    assert found.backward.max == pytest.approx(table.min(axis=0).max())


def test_signs_are_negative_inside_and_the_rule_is_named() -> None:
    ball, smaller = cm.shapes.sphere(4), cm.shapes.sphere(4, radius=0.9)
    found = cm.distance(smaller, ball, samples=10_000, signed=True)
    assert found.forward is not None and found.forward.signed is not None
    assert found.forward.signed.by == "winding_number" and found.forward.signed.inside == 1
    assert found.forward.signed.mean == pytest.approx(-0.1, abs=5e-3)
    assert found.backward is not None and found.backward.signed is not None
    assert found.backward.signed.mean == pytest.approx(0.1, abs=5e-3)
    open_one = cm.distance(cloud(), square(), signed=True).forward
    assert open_one is not None and open_one.signed is not None
    assert open_one.signed.by == "pseudonormal" and open_one.signed.min == pytest.approx(-0.05)
    plain = cm.distance(ball, smaller, samples=100).forward
    assert plain is not None and plain.signed is None


@pytest.mark.parametrize(
    "first, second, options, message",
    [
        (square(), cloud(), {"signed": True}, "signed"),
        (cloud(), square(), {"exact": "1%"}, "exact"),
    ],
)
def test_options_without_meaning_for_points_are_refused(first: Any, second: Any, options: Any, message: str) -> None:
    with pytest.raises(cm.OptionError, match=message):
        cm.distance(first, second, **options)
