//! `curvmesh info`: counts, topology, defects and sizes.

use std::fmt;
use std::path::PathBuf;

use mesh_core::PolygonSoup;
use mesh_core::build::{BuildError, Repair, Weld, weld_exact, weld_within};
use mesh_core::diagnose::{Diagnosis, diagnose};
use serde::Serialize;

use crate::args::RepairOptions;
use crate::console::Console;
use crate::failure::Failure;
use crate::load::{Seconds, load, read};

/// Count the parts and defects of a mesh, and measure it
///
/// Works on anything that can be read, sound or not, and reports the file as it is. With repairs,
/// it reports the repaired mesh; with `--weld` alone, the welded file, sound or not.
///
///     curvmesh info scan.ply
///     curvmesh info parts.stl --lenient --json
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Info {
    /// The file to read
    #[arg(value_name = "IN")]
    input: PathBuf,
    #[command(flatten)]
    repair: RepairOptions,
}

#[derive(Serialize)]
struct Report {
    command: &'static str,
    input: String,
    vertices: usize,
    faces: usize,
    triangles: usize,
    quadrilaterals: usize,
    larger_polygons: usize,
    edges: usize,
    boundary_edges: usize,
    boundary_loops: usize,
    components: usize,
    edge_components: usize,
    euler_characteristic: i64,
    closed: bool,
    manifold: bool,
    oriented: bool,
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
    /// Null without a finite vertex in use, as are the sizes below.
    bbox_min: Option<[f64; 3]>,
    bbox_max: Option<[f64; 3]>,
    area: Option<f64>,
    /// Only a closed, oriented mesh encloses a volume; null for others.
    volume: Option<f64>,
    seconds: Seconds,
}

pub(crate) fn run(options: &Info, console: &Console) -> Result<(), Failure> {
    let mut seconds = Seconds::default();
    let soup = Seconds::time(&mut seconds.load, || subject(options, console))?;
    let input = options.input.display().to_string();
    let diagnosis = Seconds::time(&mut seconds.compute, || diagnose(&soup))
        .map_err(|source| too_large(options, source))?;
    let report = report(input, &soup, &diagnosis, seconds.summed());
    console.result(&report, &report)
}

fn too_large(options: &Info, source: BuildError) -> Failure {
    Failure::Build { path: options.input.clone(), source: Box::new(source) }
}

/// The file as it is or welded, or the mesh that repairs make of it.
fn subject(options: &Info, console: &Console) -> Result<PolygonSoup, Failure> {
    let repair = options.repair.repair();
    let mut only_weld = Repair::strict();
    only_weld.weld = repair.weld;
    if repair != only_weld {
        let loaded = load(&options.input, &options.repair, console)?;
        return Ok(loaded.to_model(&loaded.provenance.corner_source)?.soup);
    }
    let soup = read(&options.input, console)?.soup;
    Ok(match repair.weld {
        Weld::Exact => soup.merged(&weld_exact(soup.positions())),
        Weld::Distance(distance) => soup.merged(&weld_within(soup.positions(), distance)),
        Weld::None => soup,
    })
}

fn report(input: String, soup: &PolygonSoup, found: &Diagnosis, seconds: Seconds) -> Report {
    let measures = soup.measure();
    let bounds = measures.bounds;
    let finite = |value: f64| value.is_finite().then_some(value);
    let encloses = found.is_closed() && found.is_oriented();
    Report {
        command: "info",
        input,
        vertices: found.vertices,
        faces: found.faces,
        triangles: found.triangles,
        quadrilaterals: found.quadrilaterals,
        larger_polygons: found.larger_polygons,
        edges: found.edges,
        boundary_edges: found.boundary_edges,
        boundary_loops: found.boundary_loops,
        components: found.components,
        edge_components: found.edge_components,
        euler_characteristic: found.euler_characteristic,
        closed: found.is_closed(),
        manifold: found.is_manifold(),
        oriented: found.is_oriented(),
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
        seconds,
    }
}

impl fmt::Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "{}", self.input)?;
        writeln!(f, "  vertices     {}", self.vertices)?;
        writeln!(
            f,
            "  faces        {} (triangles {}, quadrilaterals {}, larger {}; counts below are of triangles)",
            self.faces, self.triangles, self.quadrilaterals, self.larger_polygons
        )?;
        writeln!(f, "  edges        {}", self.edges)?;
        writeln!(
            f,
            "  boundary     {} edges in {} loops",
            self.boundary_edges, self.boundary_loops
        )?;
        writeln!(f, "  components   {} ({} through edges)", self.components, self.edge_components)?;
        writeln!(f, "  Euler char.  {}", self.euler_characteristic)?;
        let is = |yes: bool, word: &str| if yes { word.to_owned() } else { format!("not {word}") };
        writeln!(
            f,
            "  surface      {}, {}, {}",
            is(self.closed, "closed"),
            is(self.manifold, "manifold"),
            is(self.oriented, "consistently oriented")
        )?;
        for (count, what) in self.defects() {
            if count > 0 {
                writeln!(f, "  defect       {count} {what}")?;
            }
        }
        if let (Some(min), Some(max)) = (self.bbox_min, self.bbox_max) {
            writeln!(f, "  box          {min:?} to {max:?}")?;
        }
        if let Some(area) = self.area {
            write!(f, "  area         {area}")?;
        }
        if let Some(volume) = self.volume {
            write!(f, "\n  volume       {volume}")?;
        }
        Ok(())
    }
}

impl Report {
    /// Counts of what repairs can cure, and the repair.
    fn defects(&self) -> [(usize, &'static str); 9] {
        [
            (self.non_manifold_edges, "edges of more than two faces (--cut-non-manifold)"),
            (self.non_manifold_vertices, "pinched vertices (--cut-non-manifold)"),
            (self.inconsistent_edges, "edges whose faces disagree on what is outside (--reorient)"),
            (self.duplicate_faces, "duplicate faces (--drop-duplicates)"),
            (self.repeated_vertex_faces, "faces that use a vertex twice (--drop-degenerate)"),
            (self.zero_area_faces, "faces of zero area"),
            (self.sliver_faces, "slivers, a thousand times longer than high"),
            (self.unreferenced_vertices, "vertices that no face uses (--drop-unreferenced)"),
            (self.non_finite_vertices, "vertices at infinite or undefined positions"),
        ]
    }
}
