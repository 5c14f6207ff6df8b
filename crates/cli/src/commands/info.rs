//! `curvmesh info`: counts, topology, defects and sizes.

use std::fmt;
use std::path::{Path, PathBuf};

use mesh_core::PolygonSoup;
use mesh_core::build::{BuildError, Repair, Weld, count_seam_edges};
use mesh_core::diagnose::{Diagnosis, diagnose};
use mesh_core::measure::SoupMeasures;
use mesh_io::{Format, Model};
use out_of_core::Statistics;
use serde::Serialize;

use crate::args::is_standard;
use crate::batch::run_on;
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::load::{Loading, Made, Seconds, assemble};
use crate::scene_tree::SceneTree;
use crate::session::{Outcome, Session};
use crate::streaming::{Streaming, with_bar};
use crate::task::{Done, Report, Task};

/// Count the parts and defects of a mesh, and measure it
///
/// Works on any file that can be read, and reports it as it is, defects included. Copies of a vertex
/// count as one in glTF, which makes them at seams; `--weld none` counts them apart. With repairs, it
/// reports the repaired mesh; with `--weld` alone, the welded file with its other defects. A glTF
/// scene is shown as a tree.
///
///     curvmesh info scan.ply
///     curvmesh info scans/
///     curvmesh info parts.stl --lenient --json
///     curvmesh info huge.ply --memory 1GiB
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Info {
    /// Files to read, and folders: all mesh files in a folder and in the folders below are read. `-`
    /// is the standard input
    #[arg(value_name = "IN", required = true)]
    inputs: Vec<PathBuf>,
    #[command(flatten)]
    loading: Loading,
    #[command(flatten)]
    streaming: Streaming,
}

#[derive(Serialize)]
struct Results {
    triangles: usize,
    quadrilaterals: usize,
    larger_polygons: usize,
    edges: usize,
    boundary_edges: usize,
    boundary_loops: usize,
    /// Boundary edges that lie on others, which most commands join; null where it is not known.
    seam_edges: Option<usize>,
    components: usize,
    edge_components: usize,
    euler_characteristic: i64,
    closed: bool,
    manifold: bool,
    oriented: bool,
    /// Components that are inside out, vertices at equal positions joined; null where it is not known.
    inside_out: Option<usize>,
    non_manifold_edges: usize,
    non_manifold_vertices: usize,
    inconsistent_edges: usize,
    duplicate_faces: usize,
    degenerate_faces: usize,
    repeated_vertex_faces: usize,
    zero_area_faces: usize,
    sliver_faces: usize,
    unreferenced_vertices: usize,
    non_finite_vertices: usize,
    /// Copies of vertices in a format that splits vertices; they are joined, and not among the vertices.
    joined_vertices: usize,
    /// Null if no vertex in use is finite, like the sizes below.
    bbox_min: Option<[f64; 3]>,
    bbox_max: Option<[f64; 3]>,
    area: Option<f64>,
    /// Only a closed, oriented mesh encloses a volume; null for others.
    volume: Option<f64>,
    /// The scene of a glTF file.
    #[serde(skip_serializing_if = "Option::is_none")]
    scene: Option<SceneTree>,
}

pub(crate) fn run(options: &Info, session: &Session) -> Result<Outcome, Failure> {
    run_on(&options.inputs, session, &|task, console| one(options, task, console))
}

fn one(options: &Info, task: &Task, console: &Console) -> Result<Done, Failure> {
    let input = &task.input;
    let mut seconds = Seconds::default();
    if options.streaming.is_needed(&[input], &options.loading)? {
        let statistics = statistics(options, input, console, &mut seconds)?;
        let results = results(&statistics.measures, &statistics.diagnosis);
        return report(task, &statistics.diagnosis, results, seconds, console);
    }
    let is_gltf = matches!(options.loading.format(input)?, Some(Format::Gltf | Format::Glb));
    let is_scene = is_gltf && !is_standard(input);
    let (soup, joined_vertices) = Seconds::time(&mut seconds.load, || {
        let model = if is_scene {
            options.loading.read_beside_scene(input, console)
        } else {
            options.loading.read(input, console)
        };
        subject(&options.loading, input, model?, is_gltf, console)
    })?;
    let diagnosis = Seconds::time(&mut seconds.compute, || diagnose(&soup))
        .map_err(|source| rejected(input, source))?;
    let scene = is_scene.then(|| options.loading.scene(input, console)).transpose()?;
    let scene = scene.as_ref().map(SceneTree::of);
    let seam_edges = Some(count_seam_edges(&soup));
    let results = results(&soup.measure(), &diagnosis);
    let results = Results { scene, seam_edges, joined_vertices, ..results };
    report(task, &diagnosis, results, seconds, console)
}

/// Statistics of a streamed mesh.
fn statistics(
    options: &Info,
    input: &Path,
    console: &Console,
    seconds: &mut Seconds,
) -> Result<Statistics, Failure> {
    let Info { loading, streaming, .. } = options;
    Streaming::check(loading)?;
    let scratch = streaming.scratch(None)?;
    let disk_mesh = Seconds::time(&mut seconds.load, || {
        streaming.disk_mesh(&scratch, "mesh", input, loading, console)
    })?;
    Seconds::time(&mut seconds.compute, || with_bar(console, |see| disk_mesh.statistics(see)))
}

fn report(
    task: &Task,
    diagnosis: &Diagnosis,
    results: Results,
    seconds: Seconds,
    console: &Console,
) -> Result<Done, Failure> {
    let counts = [diagnosis.vertices, diagnosis.faces];
    let report = task.report(console, counts, results, seconds);
    report.done(console, report.to_string(), String::new())
}

fn rejected(input: &Path, source: BuildError) -> Failure {
    Failure::Build { path: input.to_owned(), source: Box::new(source), joined: false }
}

/// The file as it is or welded, or the mesh that repairs make of it. Copies of a vertex in glTF, which has no other way to
/// write seams, are joined as all other commands do; also returns their number.
fn subject(
    loading: &Loading,
    input: &Path,
    model: Model,
    is_gltf: bool,
    console: &Console,
) -> Result<(PolygonSoup, usize), Failure> {
    let mut repair = loading.repairs(&model)?;
    let joins = is_gltf && loading.repair.weld.is_none() && !loading.repair.strict;
    if joins && repair.weld == Weld::None {
        repair.weld = Weld::Exact;
    }
    let vertices = model.soup.vertex_count();
    let mut only_weld = Repair::strict();
    only_weld.weld = repair.weld;
    if repair != only_weld || loading.repair.strict {
        let loaded = assemble(input, model, &repair, (Made::AsTold, false), console)?;
        let model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
        return Ok((model.soup, 0));
    }
    let soup = model.soup;
    let targets = repair.weld.targets(&soup).map_err(|source| rejected(input, source))?;
    let soup = match targets {
        Some(targets) => soup.merged(&targets),
        None => soup,
    };
    let joined = if joins { vertices - soup.vertex_count() } else { 0 };
    Ok((soup, joined))
}

fn results(measures: &SoupMeasures, found: &Diagnosis) -> Results {
    let bounds = measures.bounds;
    let finite = |value: f64| value.is_finite().then_some(value);
    let encloses = found.is_closed() && found.is_oriented();
    Results {
        triangles: found.triangles,
        quadrilaterals: found.quadrilaterals,
        larger_polygons: found.larger_polygons,
        edges: found.edges,
        boundary_edges: found.boundary_edges,
        boundary_loops: found.boundary_loops,
        seam_edges: None,
        components: found.components,
        edge_components: found.edge_components,
        euler_characteristic: found.euler_characteristic,
        closed: found.is_closed(),
        manifold: found.is_manifold(),
        oriented: found.is_oriented(),
        inside_out: found.inside_out,
        non_manifold_edges: found.non_manifold_edges,
        non_manifold_vertices: found.non_manifold_vertices,
        inconsistent_edges: found.inconsistent_edges,
        duplicate_faces: found.duplicate_faces,
        degenerate_faces: found.degenerate_faces(),
        repeated_vertex_faces: found.repeated_vertex_faces,
        zero_area_faces: found.zero_area_faces,
        sliver_faces: found.slivers,
        unreferenced_vertices: found.unreferenced_vertices,
        non_finite_vertices: found.non_finite_vertices,
        bbox_min: bounds.map(|b| b.min.to_array()),
        bbox_max: bounds.map(|b| b.max.to_array()),
        area: bounds.and_then(|_| finite(measures.area)),
        volume: bounds.and_then(|_| finite(measures.volume)).filter(|_| encloses),
        joined_vertices: 0,
        scene: None,
    }
}

/// In place of a size that is infinite, or not 0 but less than the smallest number.
const NO_NUMBER: &str = "too large or too small for a number";

impl fmt::Display for Report<Results> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let found = &self.results;
        writeln!(f, "{}", self.subject())?;
        let joined = match found.joined_vertices {
            0 => String::new(),
            count => format!(
                " (without {}, which other commands join as well; --weld none keeps them apart)",
                counted(count, "copies")
            ),
        };
        writeln!(f, "  vertices     {}{joined}", self.vertices)?;
        writeln!(
            f,
            "  faces        {} (triangles {}, quadrilaterals {}, larger {}; counts below are of triangles)",
            self.faces, found.triangles, found.quadrilaterals, found.larger_polygons
        )?;
        writeln!(f, "  edges        {}", found.edges)?;
        writeln!(
            f,
            "  boundary     {} in {}",
            counted(found.boundary_edges, "edges"),
            counted(found.boundary_loops, "loops")
        )?;
        writeln!(
            f,
            "  components   {} ({} through edges)",
            found.components, found.edge_components
        )?;
        writeln!(f, "  Euler char.  {}", found.euler_characteristic)?;
        let is = |yes: bool, word: &str| if yes { word.to_owned() } else { format!("not {word}") };
        writeln!(
            f,
            "  surface      {}, {}, {}",
            is(found.closed, "closed"),
            is(found.manifold, "manifold"),
            is(found.oriented, "consistently oriented")
        )?;
        for (count, what) in found.defects() {
            if count > 0 {
                writeln!(f, "  defect       {}", counted(count, what))?;
            }
        }
        if let (Some(min), Some(max)) = (found.bbox_min, found.bbox_max) {
            writeln!(f, "  box          {min:?} to {max:?}")?;
        }
        if found.bbox_min.is_some() {
            let area = found.area.map_or(NO_NUMBER.to_owned(), |area| format!("{area:?}"));
            write!(f, "  area         {area}")?;
        }
        match found.volume {
            Some(volume) => write!(f, "\n  volume       {volume:?}")?,
            None if found.closed && found.oriented => write!(f, "\n  volume       {NO_NUMBER}")?,
            None => {}
        }
        if let Some(scene) = &found.scene {
            write!(f, "\n{scene}")?;
        }
        Ok(())
    }
}

impl Results {
    /// Counts of repairable defects, and the repair for each.
    fn defects(&self) -> [(usize, &'static str); 11] {
        [
            (
                self.seam_edges.unwrap_or(0),
                "boundary edges on other boundary edges; most commands join them (--weld seams)",
            ),
            (self.non_manifold_edges, "edges of more than two faces (--cut-non-manifold)"),
            (self.non_manifold_vertices, "pinched vertices (--cut-non-manifold)"),
            (self.inconsistent_edges, "edges whose faces have opposite orientations (--reorient)"),
            (self.inside_out.unwrap_or(0), "inside-out components (--reorient)"),
            (self.duplicate_faces, "duplicate faces (--drop-duplicates)"),
            (self.repeated_vertex_faces, "faces with a repeated vertex (--drop-degenerate)"),
            (self.zero_area_faces, "faces of zero area"),
            (self.sliver_faces, "slivers, a thousand times longer than high"),
            (self.unreferenced_vertices, "vertices that no face uses (--drop-unreferenced)"),
            (
                self.non_finite_vertices,
                "vertices at infinite or undefined positions; most commands drop them (--drop-not-finite)",
            ),
        ]
    }
}
