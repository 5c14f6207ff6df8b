"""The package itself: modules form an acyclic graph, names are documented, types agree with the compiled part."""

from __future__ import annotations

import ast
import graphlib
import importlib
import inspect
import json
import multiprocessing
import pkgutil
import re
import subprocess
import sys
import typing
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import pytest

import curvmesh as cm
from curvmesh import _options

ROOT = Path(cm.__file__).parent


def imports_of(path: Path) -> set[str]:
    """The modules of the package that a module imports, at its top, in a function or for its types."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    here = path.relative_to(ROOT.parent).with_suffix("").parts
    package = here if path.name == "__init__.py" else here[:-1]
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.level:
            base = package[: len(package) - node.level + 1]
            stem = [*base, *(node.module.split(".") if node.module else [])]
            for alias in node.names:
                whole = ROOT.parent.joinpath(*stem, alias.name)
                is_module = whole.with_suffix(".py").exists() or whole.is_dir()
                found.add(".".join([*stem, alias.name] if is_module else stem))
    return found


def graph() -> dict[str, set[str]]:
    found = {}
    for path in ROOT.rglob("*.py"):
        parts = path.relative_to(ROOT.parent).with_suffix("").parts
        name = ".".join(parts[:-1] if parts[-1] == "__init__" else parts)
        found[name] = imports_of(path)
    return found


def test_modules_form_an_acyclic_graph() -> None:
    graphlib.TopologicalSorter(graph()).prepare()


def test_geometry_and_batch_stand_side_by_side() -> None:
    for name, imports in graph().items():
        if name.startswith("curvmesh._geometry"):
            beside = {"curvmesh.batch", "curvmesh.regions", "curvmesh._engines"}
            assert not any(other.startswith(tuple(beside)) for other in imports), name
        if name.startswith("curvmesh.batch"):
            assert "curvmesh.regions" not in imports


def test_methods_are_the_functions() -> None:
    ball = cm.shapes.sphere(3)
    assert ball.simplify(faces=100).mesh == cm.simplify(ball, faces=100).mesh
    assert ball.info() == cm.info(ball)
    assert (ball.curvature().mean == cm.curvature(ball).mean).all()
    assert ball.distance(ball.flip().mesh, samples=100).mean == cm.distance(ball, ball.flip(), samples=100).mean
    assert cm.Mesh.simplify is cm.simplify


@pytest.mark.parametrize("name", ["Preset", "Placement", "Norm", "Estimator", "FlipCost", "Area", "Outline"])
def test_literal_types_are_the_names_that_are_known(name: str) -> None:
    ball = cm.shapes.sphere(2)
    for value in typing.get_args(getattr(_options, name)):
        if name == "Preset":
            cm.lod(ball, faces=[100], preset=value)
        elif name == "Placement":
            preset: _options.Preset = "paper-l1" if value == "curvature-optimal" else "default"
            cm.simplify(ball, faces=200, preset=preset, placement=value)
        elif name == "Norm":
            cm.simplify(ball, faces=200, fit_rounds=1, norm=value)
        elif name == "Estimator":
            cm.curvature(ball, estimator=value)
        elif name == "FlipCost":
            cm.flip(ball, cost=value)
        elif name == "Area":
            cm.curvature(ball, area=value)
        else:
            cm.patch(ball, tolerance="5%", shape=value)


def test_the_stub_is_that_of_the_sources() -> None:
    import stubs

    if not (Path(stubs.__file__).parent.parent / "src").exists():
        pytest.skip("the sources are not here")
    assert stubs.stub() == (ROOT / "_core.pyi").read_text(encoding="utf-8"), "run python tests/stubs.py"


def test_the_program_is_in_the_package(tmp_path: Path) -> None:
    def run(*arguments: object) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "curvmesh", *map(str, arguments)]
        return subprocess.run(command, capture_output=True, text=True)

    cm.write(tmp_path / "a.ply", cm.shapes.sphere(3))
    small = tmp_path / "b.ply"
    done = run("simplify", tmp_path / "a.ply", "-o", small, "--faces", 300)
    assert done.returncode == 0, done.stderr
    assert cm.read(small) == cm.read(cm_written(tmp_path / "c.ply"))
    assert run("--version").stdout.startswith("curvmesh")
    wrong = run("simplify", tmp_path / "a.ply", "--json")
    assert wrong.returncode == 2 and json.loads(wrong.stdout)["error"]
    assert run("info", tmp_path / "none.ply").returncode == 3


def cm_written(path: Path) -> Path:
    cm.write(path, cm.simplify(cm.shapes.sphere(3), faces=300))
    return path


def test_the_package_is_pickled_across_processes() -> None:
    """Pools, joblib, Dask and Ray send meshes and results to other processes."""
    with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as pool:
        small = pool.submit(cm.simplify, cm.examples.globe(3), faces=300).result()
    assert small.mesh == cm.simplify(cm.examples.globe(3), faces=300).mesh


def test_the_recipe_of_conda_forge() -> None:
    """The recipe is valid, and agrees with the package."""
    rattler_build = pytest.importorskip("rattler_build")
    folder = Path(__file__).parents[1]
    recipe = rattler_build.Stage0Recipe.from_file(folder / "conda" / "recipe.yaml")
    compilers = {"c_stdlib": ["sysroot"], "c_compiler": ["gcc"], "rust_compiler": ["rust"]}
    (variant,) = recipe.render(rattler_build.VariantConfig(compilers))
    made = variant.recipe.to_dict()
    project = (folder / "pyproject.toml").read_text(encoding="utf-8")
    assert made["package"] == {"name": "curvmesh", "version": cm.__version__}
    (numpy,) = (line for line in made["requirements"]["run"] if line.startswith("numpy"))
    assert f'dependencies = ["{numpy.replace(" ", "")}"]' in project
    (maturin,) = (line for line in made["requirements"]["host"] if line.startswith("maturin"))
    assert f'requires = ["{maturin.replace(" ", "")}"]' in project
    oldest = made["context"]["python_min"]
    assert f'requires-python = ">={oldest}"' in project
    assert f"abi3-py{oldest.replace('.', '')}" in (folder / "Cargo.toml").read_text(encoding="utf-8")
    assert "noarch" not in made["build"] and made["build"]["python"]["version_independent"] is True
    about = made["about"]
    assert f'license = "{about["license"]}"' in project
    shipped = [name for name in about["license_file"] if not name.startswith("THIRDPARTY")]
    assert sorted(shipped) == ["LICENSE-APACHE", "LICENSE-MIT"]
    assert all((folder / name).exists() for name in shipped)
    imports = [name for test in made["tests"] for name in test.get("python", {}).get("imports", [])]
    assert imports == ["curvmesh", "curvmesh.batch"]


def documented() -> list[tuple[str, str]]:
    """The classes with attributes in their documentation, and the lines that name these."""
    found = []
    for module in pkgutil.walk_packages(cm.__path__, "curvmesh."):
        if module.name.rpartition(".")[2] in ("__main__", "pyvista"):
            continue
        for thing in vars(importlib.import_module(module.name)).values():
            if isinstance(thing, type) and thing.__module__ == module.name and "\nAttributes\n" in (inspect.getdoc(thing) or ""):
                section = (inspect.getdoc(thing) or "").partition("\nAttributes\n")[2].partition("\n\n")[0]
                found += [(thing.__name__, line) for line in section.splitlines()[1:] if not line.startswith(" ")]
    return found


def test_attributes_are_documented_with_name_and_type() -> None:
    """Also by help() of the terminal."""
    wrong = [place for place in documented() if re.fullmatch(r"\w+(, \w+)* : .+", place[1]) is None]
    assert not wrong and len(documented()) > 50
