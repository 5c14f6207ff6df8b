//! `curvmesh.Scene`: glTF documents that are kept whole.

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Arc;

use ::simplify::Progress;
use mesh_core::build::BuildReport;
use mesh_io::{
    Compression, Format, Lost, Quantization, ReadOptions, Scene, WriteError, WriteOptions,
};
use mesh_work::{
    MeshOfScene, SceneBudget, SceneRules, SceneSteps, SceneTarget, scene_levels,
    simplify_scene as simplify_meshes,
};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyList};

use crate::failure::{Ended, Failure, choose};
use crate::host::{Call, State, Watch, run};
use crate::length::{Given, length};
use crate::mesh::{MeshData, read_options, weld_of, written};
use crate::repair_warning;
use crate::simplify::{ChoicesGiven, RulesGiven, state};

/// A scene, and what is known of its file.
struct Kept {
    scene: Scene,
    /// Messages of the reader.
    notes: Vec<String>,
    /// What the reader lost.
    lost: Vec<String>,
    /// The limits that it was read with, which hold for its mesh as well.
    max_memory: Option<u64>,
    allow_empty: bool,
}

/// The compiled part of `curvmesh.Scene`. It never changes.
#[pyclass(frozen, weakref, module = "curvmesh._core")]
pub(crate) struct SceneData(Arc<Kept>);

const FORMATS: &[(&str, Format)] = &[("gltf", Format::Gltf), ("glb", Format::Glb)];

fn texts(lost: &[Lost]) -> Vec<String> {
    lost.iter().map(Lost::to_string).collect()
}

fn bytes(scene: &Scene, format: Format) -> Result<Vec<u8>, WriteError> {
    let mut bytes = Vec::new();
    scene.write_to(&mut bytes, format)?;
    Ok(bytes)
}

impl SceneData {
    fn new(scene: Scene, max_memory: Option<u64>, allow_empty: bool) -> Self {
        let (notes, lost) = (scene.notes().to_vec(), texts(scene.lost()));
        Self(Arc::new(Kept { scene, notes, lost, max_memory, allow_empty }))
    }

    /// Another scene of the same file.
    fn with(&self, scene: Scene) -> Self {
        let Kept { notes, lost, max_memory, allow_empty, .. } = &*self.0;
        Self(Arc::new(Kept {
            scene,
            notes: notes.clone(),
            lost: lost.clone(),
            max_memory: *max_memory,
            allow_empty: *allow_empty,
        }))
    }

    fn shared(&self) -> Self {
        Self(Arc::clone(&self.0))
    }

    /// Refuses a result without any mesh of triangles, as the program does.
    fn check_some(&self, meshes: usize) -> Result<(), Failure> {
        if meshes > 0 || self.0.allow_empty {
            return Ok(());
        }
        let message =
            "the scene has no triangles; read it with allow_empty=True to keep it as it is";
        Err(Failure::cannot(message).text("cure", "allow_empty=True"))
    }
}

#[pymethods]
impl SceneData {
    /// The scene of bytes that were written by `scene_bytes`, for a pickle.
    #[staticmethod]
    fn load(
        py: Python<'_>,
        content: &[u8],
        notes: Vec<String>,
        lost: Vec<String>,
        max_memory: Option<u64>,
        allow_empty: bool,
    ) -> PyResult<Self> {
        // The size was accepted when the scene was read; the same content can take other bytes here.
        let options = ReadOptions {
            size: Some(content.len() as u64),
            max_memory: Some(u64::MAX),
            allow_empty: true,
            ..ReadOptions::default()
        };
        let scene = py.detach(|| Scene::read_from(&mut &*content, &options));
        let scene = scene.map_err(|error| {
            Failure::new("CurvmeshError", format!("the pickle is damaged: {error}")).raise(py)
        })?;
        Ok(Self(Arc::new(Kept { scene, notes, lost, max_memory, allow_empty })))
    }

    /// Whether both are written as the same bytes.
    fn equals(&self, py: Python<'_>, other: &Self) -> PyResult<bool> {
        if Arc::ptr_eq(&self.0, &other.0) {
            return Ok(true);
        }
        let equal = py.detach(|| {
            let [a, b] = [self, other].map(|scene| bytes(&scene.0.scene, Format::Glb));
            Ok::<_, WriteError>(a? == b?)
        });
        equal.map_err(|error| Failure::from(error).raise(py))
    }

    /// The names in a list of the document; `None` for an element without a name.
    fn names(&self, list: &str) -> Vec<Option<String>> {
        let items = self.0.scene.json().get(list).and_then(|items| items.as_array());
        let name = |item: &serde_json::Value| {
            let name = item.as_str().or_else(|| item.get("name").and_then(|name| name.as_str()));
            name.map(str::to_owned)
        };
        items.into_iter().flatten().map(name).collect()
    }

    /// The document as JSON.
    fn json(&self) -> String {
        self.0.scene.json().to_string()
    }

    /// The numbers of vertices and triangles that are drawn.
    #[getter]
    fn counts(&self, py: Python<'_>) -> (u64, u64) {
        let [vertices, faces] = py.detach(|| self.0.scene.counts());
        (vertices, faces)
    }

    #[getter]
    fn notes(&self) -> Vec<String> {
        self.0.notes.clone()
    }

    #[getter]
    fn lost(&self) -> Vec<String> {
        self.0.lost.clone()
    }

    #[getter]
    fn max_memory(&self) -> Option<u64> {
        self.0.max_memory
    }

    #[getter]
    fn allow_empty(&self) -> bool {
        self.0.allow_empty
    }
}

/// Reads a scene from a file or bytes.
#[pyfunction]
#[pyo3(signature = (call, path=None, data=None, *, format=None, external="folder", max_memory=None, allow_empty=false))]
#[allow(clippy::too_many_arguments, reason = "one per option of Python")]
pub(crate) fn read_scene(
    py: Python<'_>,
    call: &Call,
    path: Option<PathBuf>,
    data: Option<Vec<u8>>,
    format: Option<&str>,
    external: &str,
    max_memory: Option<u64>,
    allow_empty: bool,
) -> PyResult<SceneData> {
    let options = read_options(format, external, max_memory, allow_empty)
        .map_err(|failure| failure.raise(py))?;
    run(py, call, move |_| {
        let scene = match (&path, &data) {
            (Some(path), _) => Scene::read(path, &options),
            (None, data) => {
                let bytes = data.as_deref().unwrap_or_default();
                let options = ReadOptions { size: Some(bytes.len() as u64), ..options };
                Scene::read_from(&mut &*bytes, &options)
            }
        };
        Ok(SceneData::new(scene.map_err(Failure::from)?, max_memory, allow_empty))
    })
}

/// Writes a scene to a file, whole or not at all.
#[pyfunction]
#[pyo3(signature = (call, path, scene, *, format=None, compress="none", quantize=None))]
pub(crate) fn write_scene<'py>(
    py: Python<'py>,
    call: &Call,
    path: PathBuf,
    scene: &SceneData,
    format: Option<&str>,
    compress: &str,
    quantize: Option<u8>,
) -> PyResult<Bound<'py, PyDict>> {
    let compressions = [("none", Compression::None), ("meshopt", Compression::Meshopt)];
    let options = || -> Result<WriteOptions, Failure> {
        Ok(WriteOptions {
            format: format.map(|name| choose("format", name, FORMATS)).transpose()?,
            compression: choose("compress", compress, &compressions)?,
            quantization: quantize.map(Quantization::with_bits),
            ..WriteOptions::default()
        })
    };
    let options = options().map_err(|failure| failure.raise(py))?;
    let scene = scene.shared();
    let report = run(py, call, move |_| {
        scene.0.scene.write(&path, &options).map_err(|error| Ended::from(Failure::from(error)))
    })?;
    written(py, &report)
}

/// A scene as the content of a file.
#[pyfunction]
pub(crate) fn scene_bytes<'py>(
    py: Python<'py>,
    call: &Call,
    scene: &SceneData,
    format: &str,
) -> PyResult<Bound<'py, PyBytes>> {
    let format = choose("format", format, FORMATS).map_err(|failure| failure.raise(py))?;
    let scene = scene.shared();
    let content =
        run(py, call, move |_| Ok(bytes(&scene.0.scene, format).map_err(Failure::from)?))?;
    Ok(PyBytes::new(py, &content))
}

/// All meshes of a scene as they are drawn, in one mesh.
#[pyfunction]
pub(crate) fn scene_mesh(
    py: Python<'_>,
    call: &Call,
    scene: &SceneData,
    join: Option<bool>,
) -> PyResult<MeshData> {
    let scene = scene.shared();
    run(py, call, move |watch| {
        let content = bytes(&scene.0.scene, Format::Glb).map_err(Failure::from)?;
        watch.check()?;
        let options = ReadOptions {
            format: Some(Format::Glb),
            size: Some(content.len() as u64),
            max_memory: scene.0.max_memory,
            allow_empty: scene.0.allow_empty,
            ..ReadOptions::default()
        };
        let model = mesh_io::read_from(&mut &content[..], &options).map_err(Failure::from)?;
        Ok(MeshData::new(model, weld_of(Some(join.unwrap_or(true)))))
    })
}

/// When to stop, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SceneTargetsGiven {
    faces: Option<usize>,
    ratio: Option<f64>,
    max_error: Option<Given>,
    relative: bool,
}

/// The levels of a scene, as they come from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SceneStepsGiven {
    ratios: Vec<f64>,
    faces: Vec<usize>,
    errors: Vec<Given>,
    relative: bool,
    together: bool,
}

/// How the meshes are simplified, as it comes from Python.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct SceneRulesGiven {
    choices: ChoicesGiven,
    attributes: RulesGiven,
    keep_seams: bool,
    per: String,
    poses: usize,
}

impl SceneRulesGiven {
    fn rules(&self, target: SceneTarget) -> Result<SceneRules, Failure> {
        let budgets = [
            ("scene", SceneBudget::Scene),
            ("node", SceneBudget::Node),
            ("mesh", SceneBudget::Mesh),
        ];
        Ok(SceneRules {
            target,
            budget: choose("per", &self.per, &budgets)?,
            choices: self.choices.choices()?,
            attributes: self.attributes.rules()?,
            keep_seams: self.keep_seams,
            poses: self.poses,
            ..SceneRules::default()
        })
    }
}

fn check_ratio(option: &str, ratio: f64) -> Result<(), Failure> {
    if (0.0..=1.0).contains(&ratio) {
        return Ok(());
    }
    Err(Failure::option(format!("{option} is {ratio}; it must be from 0 to 1")))
}

/// The progress over all meshes, which are simplified one after the other.
struct Course {
    meshes: usize,
    done: usize,
    collapses: usize,
}

impl Course {
    fn of(scene: &Scene) -> Self {
        Self { meshes: scene.mesh_count().max(1), done: 0, collapses: 0 }
    }

    fn state(&mut self, now: &Progress) -> State {
        // Within a mesh the number of collapses never goes back.
        self.done += usize::from(now.collapses < self.collapses);
        self.collapses = now.collapses;
        let of_mesh = state(now);
        let fraction = (self.done as f64 + of_mesh.fraction) / self.meshes as f64;
        State { fraction: fraction.min(1.0), ..of_mesh }
    }

    fn tell(&mut self, now: &Progress, watch: &Watch) -> ControlFlow<()> {
        watch.tell(self.state(now))
    }
}

/// The repairs of all meshes, in the order in which they are met.
fn repairs<'r>(reports: impl Iterator<Item = &'r BuildReport>) -> Vec<(&'static str, usize)> {
    let mut all: Vec<(&'static str, usize)> = Vec::new();
    for (what, count) in reports.flat_map(BuildReport::repairs) {
        match all.iter_mut().find(|(known, _)| *known == what) {
            Some((_, sum)) => *sum += count,
            None => all.push((what, count)),
        }
    }
    all
}

fn dict<'py>(py: Python<'py>, counts: &[(&str, usize)]) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    counts.iter().try_for_each(|(name, count)| found.set_item(name, count))?;
    Ok(found)
}

/// Simplifies all meshes of a scene.
#[pyfunction]
pub(crate) fn simplify_scene<'py>(
    py: Python<'py>,
    call: &Call,
    scene: &SceneData,
    targets: SceneTargetsGiven,
    rules: SceneRulesGiven,
) -> PyResult<(SceneData, Bound<'py, PyDict>)> {
    let rules = || -> Result<SceneRules, Failure> {
        targets.ratio.map_or(Ok(()), |ratio| check_ratio("ratio", ratio))?;
        let SceneTargetsGiven { faces, ratio, max_error, relative } = targets;
        let max_error = length("max_error", max_error)?;
        rules.rules(SceneTarget { faces, ratio, max_error, relative })
    };
    let rules = rules().map_err(|failure| failure.raise(py))?;
    let given = scene.shared();
    let (made, repairs) = run(py, call, move |watch| {
        let mut course = Course::of(&given.0.scene);
        let observe = &mut |now: &Progress| course.tell(now, watch);
        let made = simplify_meshes(&given.0.scene, &rules, observe).map_err(Failure::from)?;
        given.check_some(made.meshes.len())?;
        let repairs = repairs(made.meshes.iter().map(|mesh| &mesh.repairs));
        repair_warning::put_of_scene(&repairs);
        Ok((made, repairs))
    })?;
    let lost = made.losses();
    let meshes = PyList::empty(py);
    for mesh in &made.meshes {
        meshes.append(mesh_of_scene(py, mesh)?)?;
    }
    let found = PyDict::new(py);
    found.set_item("meshes", meshes)?;
    found.set_item("lost", texts(&lost))?;
    found.set_item("repairs", dict(py, &repairs)?)?;
    found.set_item("missed_faces", made.missed_faces)?;
    Ok((scene.with(made.scene), found))
}

fn mesh_of_scene<'py>(py: Python<'py>, mesh: &MeshOfScene) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    found.set_item("mesh", mesh.mesh)?;
    found.set_item("name", &mesh.name)?;
    found.set_item("times", mesh.times)?;
    found.set_item("scale", mesh.scale)?;
    found.set_item("faces_in", mesh.faces[0])?;
    found.set_item("faces_out", mesh.faces[1])?;
    found.set_item("vertices_out", mesh.vertices[1])?;
    found.set_item("rms", mesh.rms)?;
    found.set_item("max", mesh.max)?;
    found.set_item("error", mesh.bound.map(|bound| (bound.lower, bound.upper)))?;
    found.set_item("stop", mesh.stop.name())?;
    let shortfall = mesh.shortfall.as_ref().map(|shortfall| {
        let reasons = shortfall.held_by.iter();
        let held_by: Vec<(&str, usize)> = reasons.map(|(r, count)| (r.name(), *count)).collect();
        (shortfall.wanted_faces, shortfall.wanted_vertices, held_by)
    });
    found.set_item("shortfall", shortfall)?;
    found.set_item("charts", mesh.charts.map(|[before, after]| (before, after)))?;
    found.set_item("poses", mesh.deformed.map(|found| (found.poses, found.rms, found.max)))?;
    Ok(found)
}

/// Levels of detail of a scene, and one scene with all of them if it is asked for.
#[pyfunction]
pub(crate) fn lod_scene<'py>(
    py: Python<'py>,
    call: &Call,
    scene: &SceneData,
    steps: SceneStepsGiven,
    rules: SceneRulesGiven,
) -> PyResult<(Bound<'py, PyList>, Option<SceneData>, Bound<'py, PyDict>)> {
    let SceneStepsGiven { ratios, faces, errors, relative, together } = steps;
    let settings = || -> Result<_, Failure> {
        ratios.iter().try_for_each(|&ratio| check_ratio("a number of ratios", ratio))?;
        let errors = errors.iter().map(|e| e.length("errors")).collect::<Result<Vec<_>, _>>()?;
        Ok((errors, rules.rules(SceneTarget::default())?))
    };
    let (errors, rules) = settings().map_err(|failure| failure.raise(py))?;
    let steps = SceneSteps { ratios, faces, errors, relative };
    let given = scene.shared();
    let (made, all, repairs) = run(py, call, move |watch| {
        let mut course = Course::of(&given.0.scene);
        let observe = &mut |now: &Progress| course.tell(now, watch);
        let made = scene_levels(&given.0.scene, &steps, &rules, observe).map_err(Failure::from)?;
        watch.check()?;
        given.check_some(made.levels.first().map_or(0, |level| level.meshes.len()))?;
        let repairs = repairs(made.repairs.iter());
        repair_warning::put_of_scene(&repairs);
        let all = together.then(|| made.together()).transpose();
        // What is lost is lost in the levels as well.
        let all = all.map_err(Failure::from)?.map(|(scene, _)| scene);
        Ok((made, all, repairs))
    })?;
    let found = PyDict::new(py);
    found.set_item("lost", texts(&made.losses()))?;
    found.set_item("repairs", dict(py, &repairs)?)?;
    found.set_item("missed_faces", made.missed_faces.clone())?;
    found.set_item("shown_from", made.coverage.first().copied().unwrap_or(0.0))?;
    let levels = PyList::empty(py);
    for (level, &shown_from) in made.levels.into_iter().zip(made.coverage.iter().skip(1)) {
        let meshes = PyList::empty(py);
        for mesh in &level.meshes {
            let of = PyDict::new(py);
            of.set_item("mesh", mesh.mesh)?;
            of.set_item("name", &mesh.name)?;
            of.set_item("times", mesh.times)?;
            of.set_item("faces", mesh.faces[1])?;
            of.set_item("vertices", mesh.vertices)?;
            of.set_item("collapses", mesh.collapses)?;
            of.set_item("charts", mesh.charts)?;
            of.set_item("mean", mesh.mean)?;
            of.set_item("rms", mesh.rms)?;
            of.set_item("max", mesh.max)?;
            meshes.append(of)?;
        }
        let of = PyDict::new(py);
        of.set_item("meshes", meshes)?;
        of.set_item("mean", level.mean)?;
        of.set_item("rms", level.rms)?;
        of.set_item("max", level.max)?;
        of.set_item("shown_from", shown_from)?;
        of.set_item("scene", scene.with(level.scene))?;
        levels.append(of)?;
    }
    Ok((levels, all.map(|all| scene.with(all)), found))
}
