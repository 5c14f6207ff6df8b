"""Pictures, pages, and the display in notebooks."""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import curvmesh as cm


def test_a_picture_shows_values(bumpy: cm.Mesh, tmp_path: Path) -> None:
    k = cm.curvature(bumpy)
    picture = cm.render(bumpy, k.mean, size=(200, 160), label="H", range=(-1.0, 1.0))
    assert picture.pixels.shape[0] == 160 and picture.pixels.shape[1] > 200
    assert picture.range == (-1.0, 1.0)
    assert len(np.unique(picture.pixels.reshape(-1, 4), axis=0)) > 500
    picture.save(tmp_path / "picture.png")
    assert (tmp_path / "picture.png").read_bytes().startswith(b"\x89PNG")
    of_faces = cm.render(bumpy, np.arange(bumpy.face_count), size=(90, 90), bar=False)
    assert of_faces.pixels.shape == (90, 90, 4)
    sheet = cm.render(bumpy, direction=["front", "top"], size=(80, 80), transparent=True)
    assert sheet.pixels.shape[1] > 160 and (sheet.pixels[..., 3] == 0).any()
    with pytest.raises(cm.ArrayError):
        cm.render(bumpy, [1.0, 2.0])
    for options in ({"direction": "below"}, {"colormap": "grey"}, {"range": "some"}, {"values": "none"}):
        with pytest.raises(cm.OptionError):
            cm.render(bumpy, **options)  # type: ignore[arg-type]


def test_a_picture_has_its_axis_up(bumpy: cm.Mesh) -> None:
    def pixels(**options: Any) -> Any:
        return cm.render(bumpy, size=(120, 120), **options).pixels.astype(float)

    def difference(a: Any, b: Any) -> float:
        return float(abs(a - b).mean())

    usual = pixels()
    assert (usual == pixels(direction=(0.4, 0.3, 1.0), up=(0.0, 1.0, 0.0))).all()
    standing = pixels(up="z")
    assert difference(standing, pixels(direction=(0.4, -1.0, 0.3), up=(0.0, 0.0, 1.0))) < 0.1
    assert difference(standing, usual) > 1.0
    assert difference(pixels(direction="top", up="z"), pixels(direction=(0, 0, 1), up=(0, 1, 0))) < 0.1
    x, y = np.meshgrid(np.linspace(-1, 1, 9), np.linspace(-1, 1, 9), indexing="ij")
    corners = np.stack([x, y, 0.2 * np.sin(3 * x)], axis=-1).reshape(-1, 3)
    first = (9 * np.arange(8)[:, None] + np.arange(8)).reshape(-1)
    faces = np.stack([first, first + 9, first + 10, first, first + 10, first + 1], axis=-1).reshape(-1, 3)
    field = cm.Mesh(corners, faces)
    guessed, fixed = (cm.render(field, size=(90, 90), up=up).pixels for up in ("auto", "z"))
    assert (guessed == fixed).all()
    for options in ({"up": "north"}, {"up": (0, 0, 0)}, {"direction": "top", "up": (0, 0, 1)}):
        with pytest.raises(cm.OptionError, match="up"):
            cm.render(bumpy, **options)


def test_integers_are_labels(bumpy: cm.Mesh) -> None:
    """Labels 2 and 5 have the colours of their numbers, and no colour in between."""
    side = bumpy.vertices[:, 0] > 0
    zones = np.where(side, 5, 2)
    picture = cm.render(bumpy, zones, size=(200, 200), transparent=True)
    assert picture.range is None
    red, green, blue, cover = picture.pixels[:, :200].reshape(-1, 4).astype(float).T
    inside = (cover == 255) & (red + green + blue > 60)
    is_green = (red < 3) & (abs(blue / np.maximum(green, 1) - 115 / 158) < 0.06)
    is_red = (blue < 3) & (abs(green / np.maximum(red, 1) - 94 / 213) < 0.06)
    assert is_green[inside].sum() > 4000 and is_red[inside].sum() > 4000
    # Samples of both are averaged along the line between them.
    assert (is_green | is_red)[inside].mean() > 0.97
    for options in ({"colormap": "viridis"}, {"range": "full"}, {"log": True}):
        assert cm.render(bumpy, zones, size=(90, 90), **options).range == (2.0, 5.0)
    assert cm.render(bumpy, zones + 2**60, size=(90, 90)).range is not None, "too large to tell apart"
    assert cm.render(bumpy, zones.astype(float), size=(90, 90)).range == (2.0, 5.0)
    bumpy = bumpy.copy()
    bumpy.face_data["part"] = np.arange(bumpy.face_count, dtype=np.uint16) % 3
    assert cm.render(bumpy, "part", size=(90, 90)).range is None
    page = cm.view(bumpy, values={"zone": zones, "side": side, "x": bumpy.vertices[:, 0]}).html
    labels = {name: value for value, name in re.findall(r'"label":(true|false),"name":"(\w+)"', page)}
    assert labels == {"part": "true", "zone": "true", "side": "true", "x": "false"}


def test_a_page_turns_meshes(bumpy: cm.Mesh, tmp_path: Path) -> None:
    small = cm.simplify(bumpy, faces=500)
    d = cm.distance(small.mesh, bumpy, samples=1000)
    page = cm.view(
        bumpy, small.mesh, values=[{}, {"distance": d.of_vertices}], color="distance", report={"faces": 500}
    )
    page.save(tmp_path / "page.html")
    text = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert text == page.html and "distance" in text and "<script" in text
    assert "://" not in text.replace("http://www.w3.org", "")
    framed = page._repr_html_()
    assert "<iframe" in framed and "<script" not in framed and framed.isascii()
    inside = re.search('srcdoc="(.*?)"', framed, re.DOTALL)
    assert inside is not None and html.unescape(inside[1]) == page.html
    k = cm.view(cm.curvature(bumpy))
    assert "shape_index" in k.html and "Direction of k1" in k.html
    broken = cm.Mesh(bumpy.vertices, np.vstack([bumpy.faces, bumpy.faces[:1]]))
    assert cm.view(broken).html
    for name in ("nothing", "component"):
        with pytest.raises(cm.OptionError):
            cm.view(bumpy, color=name)
    two = cm.Mesh(np.vstack([bumpy.vertices, bumpy.vertices + 5]), np.vstack([bumpy.faces, bumpy.faces + bumpy.vertex_count]))
    assert '"color":"face:component"' in cm.view(two, color="component").html
    assert '"up":"-z"' in cm.view(bumpy, up="-z").html
    with pytest.raises(cm.OptionError, match="up"):
        cm.view(bumpy, up="w")  # type: ignore[arg-type]
    with pytest.raises(cm.OptionError):
        cm.view()


def test_hostile_names_do_nothing() -> None:
    mesh = cm.shapes.octahedron()
    mesh.vertex_data["<script>alert(1)</script>"] = np.arange(6)
    assert "<script>alert" not in cm.view(mesh, names=["</title><script>alert(1)</script>"]).html
    assert "<script>" not in mesh._repr_html_()


def test_notebooks_show_meshes_and_reports(bumpy: cm.Mesh) -> None:
    shown = bumpy._repr_html_()
    assert "data:image/png;base64," in shown and "5,120" in shown
    broken = cm.Mesh(bumpy.vertices, np.vstack([bumpy.faces, bumpy.faces[:1]]))
    with pytest.warns(cm.RepairWarning):
        shown = broken._repr_html_()
    assert "drop_duplicates" in shown and "data:image" in shown
    points = np.array([[0, 0, np.nan], [1, 0, 0], [0, 1, 0]])
    nowhere = cm.Mesh(points, [[0, 1, 2]], check=False)
    assert "data:image" not in nowhere._repr_html_()
    small = cm.simplify(bumpy, faces=500)
    reports: list[Any] = [
        small,
        cm.curvature(bumpy),
        cm.flip(small.mesh),
        cm.distance(bumpy, small.mesh, samples=1000),
        cm.patch(small.mesh, tolerance="2%"),
        cm.info(bumpy),
        cm.repair(broken),
        cm.lod(bumpy, ratios=[0.5]),
    ]
    for report in reports:
        assert "<table>" in report._repr_html_() and len(repr(report)) > 20
