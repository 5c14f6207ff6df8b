//! `curvmesh repair`: makes an oriented 2-manifold of triangles from any readable mesh.

use std::fmt;
use std::path::{Path, PathBuf};

use clap::{Arg, ValueEnum};
use mesh_core::build::{BuildReport, Repair as Repairs, Weld, build};
use mesh_core::fill::{FillOptions, FillReport};
use mesh_core::measure::cracks::{Cracks, cracks};
use mesh_io::Model;
use mesh_work::{Loaded, repaired_scene};
use serde::Serialize;

use crate::args::{MOST_ELEMENTS, REPAIRS, all_repairs, is_standard, parse_count};
use crate::batch::{Job, check_output};
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::given::Given;
use crate::load::{Made, Seconds, assemble, tell_cracks};
use crate::scene::{Merging, tell_lost, tell_repairs};
use crate::session::{Outcome, Session};
use crate::task::{Done, Task};
use crate::text::printable;
use crate::watertight::{Hole, Written, holes_of};

/// Make an oriented manifold of triangles out of anything that can be read
///
/// All repairs are made. If options name some, only the named ones are made; --weld says how vertices are
/// merged. All repairs are reported. The written file is read again: the report says whether it is
/// watertight, and why holes are open. A scene that is written as glTF or GLB stays whole, unless holes are
/// filled or it is for printing.
///
///     curvmesh repair parts.stl -o whole.obj
///     curvmesh repair scan.ply -o closed.ply --weld 0.001% --fill-holes 100
///     curvmesh repair figure.obj -o figure.stl --for printing
///     curvmesh repair broken/ -o whole/
#[derive(Debug, clap::Args)]
#[command(
    verbatim_doc_comment,
    mut_arg("output", |output| output.required(true)),
    mut_args(name_heading)
)]
pub(crate) struct Repair {
    #[command(flatten)]
    job: Job,
    /// Then fill holes of up to this number of edges, or `all`, including the outline of an open surface. New
    /// faces may cross others
    #[arg(long, value_name = "EDGES|all", value_parser = parse_holes, help_heading = "Holes")]
    fill_holes: Option<FillOptions>,
    /// What the result is for. `printing`: drop debris, fill all holes, turn components outward, and separate
    /// parts that touch by a millionth of the size, so that STL readers do not join them
    #[arg(id = "for", long = "for", value_enum, value_name = "PURPOSE")]
    purpose: Option<Purpose>,
    /// With `--for printing`: drop components whose diagonal is below this share of the diagonal of the model
    #[arg(long, value_name = "SHARE", default_value = "1%", value_parser = parse_share, requires = "for")]
    debris: f64,
    #[command(flatten)]
    merging: Merging,
}

/// Uses of a repaired mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Purpose {
    Printing,
}

fn parse_share(text: &str) -> Result<f64, String> {
    let (digits, unit) = match text.strip_suffix('%') {
        Some(digits) => (digits, 100.0),
        None => (text, 1.0),
    };
    let share = digits.parse::<f64>().ok().map(|share| share / unit);
    share
        .filter(|share| (0.0..1.0).contains(share))
        .ok_or_else(|| "expected a share from 0 to below 1, like 0.01 or 1%".to_owned())
}

/// This command makes all repairs unless some are named.
fn name_heading(option: Arg) -> Arg {
    if option.get_help_heading() == Some(REPAIRS) {
        option.help_heading("Repairs (all unless some are named)")
    } else {
        option
    }
}

fn parse_holes(text: &str) -> Result<FillOptions, String> {
    let max_edges = match text {
        "all" => None,
        _ => Some(
            parse_count(text, 0..=MOST_ELEMENTS)
                .map_err(|expected| format!("{expected}, or `all`"))?,
        ),
    };
    Ok(FillOptions { max_edges, ..FillOptions::default() })
}

/// Counts of defects and repairs.
#[derive(Serialize)]
struct Results {
    vertices_out: usize,
    faces_out: usize,
    unchanged: bool,
    triangulated_polygons: usize,
    welded_vertices: usize,
    dropped_out_of_range: usize,
    not_finite_vertices: usize,
    dropped_not_finite: usize,
    dropped_degenerate: usize,
    dropped_duplicates: usize,
    reversed_faces: usize,
    cut_edges: usize,
    split_vertices: usize,
    dropped_vertices: usize,
    zero_area_faces: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    holes: Option<Holes>,
    /// Components that were inside out and were turned as a whole.
    turned_components: usize,
    /// Components whose outside is undecided; they keep their orientation.
    undecided_components: usize,
    /// Only for `--for printing`.
    #[serde(skip_serializing_if = "Option::is_none")]
    printing: Option<Printing>,
    /// Absent for the standard output, which cannot be read again.
    #[serde(skip_serializing_if = "Option::is_none")]
    written: Option<Written>,
}

/// Changes for printing.
#[derive(Serialize)]
struct Printing {
    dropped_components: usize,
    turned_components: usize,
    separated_vertices: usize,
}

/// Counts of holes.
#[derive(Serialize)]
struct Holes {
    filled: usize,
    new_faces: usize,
    new_vertices: usize,
    left: usize,
}

impl From<&FillReport> for Holes {
    fn from(report: &FillReport) -> Self {
        Self {
            filled: report.filled.len(),
            new_faces: report.new_faces(),
            new_vertices: report.new_vertices(),
            left: report.left.len(),
        }
    }
}

pub(crate) fn run(options: &Repair, session: &Session) -> Result<Outcome, Failure> {
    check_output(&options.job, &session.given)?;
    options.job.run(session, &|task, console| one(options, task, &session.given, console))
}

/// Further options that need one mesh.
const NEEDING_ONE: [&str; 2] = ["fill_holes", "for"];

fn one(options: &Repair, task: &Task, given: &Given, console: &Console) -> Result<Done, Failure> {
    let loading = &options.job.loading;
    let written = task.written(&options.job.save);
    let at = (given, console);
    if options.merging.keeps_scene(&task.input, written, loading, &NEEDING_ONE, at)? {
        of_scene(options, task, console)
    } else {
        of_mesh(options, task, console)
    }
}

/// The repairs that are asked for, lengths already in units of the file.
fn asked(options: &Repair, named: Repairs) -> Repairs {
    let repair = &options.job.loading.repair;
    if repair.names_some() {
        return named;
    }
    let mut all = all_repairs();
    if repair.weld.is_some() {
        all.weld = named.weld;
    }
    all
}

/// Repairs each mesh of a scene.
fn of_scene(options: &Repair, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let loading = &options.job.loading;
    let scene = Seconds::time(&mut seconds.load, || loading.scene(&task.input, console))?;
    let repairs = asked(options, loading.repair.repair(Weld::None));
    let made = Seconds::time(&mut seconds.compute, || repaired_scene(&scene, &repairs));
    let failed = |error| Failure::scene(&task.input, task.output.as_deref(), error);
    let made = made.map_err(failed)?;
    let name = printable(task.input.display());
    tell_repairs(&name, made.repairs.iter(), console);
    tell_lost(&name, &made.lost, console);
    task.save_scene(&made.scene, &options.job.save, &mut seconds, console)?;
    let results = made
        .repairs
        .iter()
        .map(|found| Results::new(found, [found.vertices_out, found.faces_out], None));
    let results = results
        .reduce(|sum, next| sum.and(&next))
        .unwrap_or_else(|| Results::new(&BuildReport::default(), [0; 2], None));
    let counts = scene.counts().map(|count| count as usize);
    finished(options, task, counts, (results, Vec::new()), seconds, console)
}

fn of_mesh(options: &Repair, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let loading = &options.job.loading;
    let mut loaded = Seconds::time(&mut seconds.load, || {
        let model = loading.read(&task.input, console)?;
        loading.check_faces(&task.input, &model)?;
        let mut repairs = asked(options, loading.repairs(&model)?);
        if loading.repair.weld.is_none()
            && (options.purpose.is_some() || options.fill_holes.is_some())
        {
            close_cracks(&task.input, &model, &mut repairs, console);
        }
        let loaded = assemble(&task.input, model, &repairs, (Made::AsTold, false), console)?;
        loading.check_left(&task.input, loaded)
    })?;
    let (filled, printing) = Seconds::time(&mut seconds.compute, || finish(options, &mut loaded))?;
    if loading.repair.weld.is_none() {
        tell_cracks(&task.input, &loaded, console);
    }
    let found = &loaded.report;
    let model = loaded.to_model(&loaded.provenance.corner_source).map_err(Failure::model)?;
    task.save(&model, &options.job.save, &mut seconds, console)?;
    let holes = filled.as_ref().map(Holes::from);
    let results = Results { printing, ..Results::new(found, loaded.counts(), holes) };
    let counts = [found.vertices_in, found.faces_in];
    let open = holes_of(&loaded, filled.as_ref());
    finished(options, task, counts, (results, open), seconds, console)
}

/// Joins narrow gaps between boundaries, before holes are filled: filled, they would become walls inside the body.
fn close_cracks(input: &Path, model: &Model, repairs: &mut Repairs, console: &Console) {
    // Errors are those of the build that follows.
    let Ok(built) = build(&model.soup, repairs) else { return };
    if let Some(Cracks { vertices, width }) = cracks(&built.mesh) {
        repairs.weld = Weld::Distance(2.0 * width);
        console.message(format_args!(
            "{}: joining {} within {:.1e} of others, which are gaps, not holes; --weld exact keeps them apart",
            printable(input.display()),
            counted(vertices, "boundary vertices"),
            2.0 * width
        ));
    }
}

/// Reads the written file again, and reports.
fn finished(
    options: &Repair,
    task: &Task,
    counts: [usize; 2],
    (results, open): (Results, Vec<Hole>),
    mut seconds: Seconds,
    console: &Console,
) -> Result<Done, Failure> {
    let output = task.output.as_ref().filter(|path| !is_standard(path));
    let judge = |path: &PathBuf| Written::judge(path, options.job.save.format_of(path), open);
    let written = Seconds::time(&mut seconds.load, || output.map(judge).transpose())?;
    let report = task.report(console, counts, Results { written, ..results }, seconds);
    let mut brief = report.results.to_string();
    let mut text = format!("{}: {brief}", report.subject());
    if let Some(written) = &report.results.written {
        brief.push_str(if written.watertight { ", watertight" } else { ", not watertight" });
        text.push_str(&written.to_string());
    }
    report.done(console, text, brief)
}

/// Fills holes and prepares for printing, if asked for.
fn finish(
    options: &Repair,
    loaded: &mut Loaded,
) -> Result<(Option<FillReport>, Option<Printing>), Failure> {
    let Some(Purpose::Printing) = options.purpose else {
        return Ok((options.fill_holes.as_ref().map(|holes| loaded.fill_holes(holes)), None));
    };
    let dropped_components = loaded.drop_debris(options.debris).map_err(Failure::refused)?;
    let holes = options.fill_holes.unwrap_or_default();
    let filled = loaded.fill_holes(&holes);
    let turned_components = loaded.turn_outward().map_err(Failure::refused)?;
    let separated_vertices = loaded.separate_touching().map_err(Failure::refused)?;
    let printing = Printing { dropped_components, turned_components, separated_vertices };
    Ok((Some(filled), Some(printing)))
}

impl Results {
    /// The sums for two meshes.
    fn and(self, other: &Self) -> Self {
        Self {
            vertices_out: self.vertices_out + other.vertices_out,
            faces_out: self.faces_out + other.faces_out,
            unchanged: self.unchanged && other.unchanged,
            triangulated_polygons: self.triangulated_polygons + other.triangulated_polygons,
            welded_vertices: self.welded_vertices + other.welded_vertices,
            dropped_out_of_range: self.dropped_out_of_range + other.dropped_out_of_range,
            not_finite_vertices: self.not_finite_vertices + other.not_finite_vertices,
            dropped_not_finite: self.dropped_not_finite + other.dropped_not_finite,
            dropped_degenerate: self.dropped_degenerate + other.dropped_degenerate,
            dropped_duplicates: self.dropped_duplicates + other.dropped_duplicates,
            reversed_faces: self.reversed_faces + other.reversed_faces,
            cut_edges: self.cut_edges + other.cut_edges,
            split_vertices: self.split_vertices + other.split_vertices,
            dropped_vertices: self.dropped_vertices + other.dropped_vertices,
            zero_area_faces: self.zero_area_faces + other.zero_area_faces,
            turned_components: self.turned_components + other.turned_components,
            undecided_components: self.undecided_components + other.undecided_components,
            ..self
        }
    }

    fn new(
        found: &BuildReport,
        [vertices_out, faces_out]: [usize; 2],
        holes: Option<Holes>,
    ) -> Self {
        Self {
            vertices_out,
            faces_out,
            unchanged: found.is_unchanged(),
            triangulated_polygons: found.triangulated,
            welded_vertices: found.welded_vertices.count(),
            dropped_out_of_range: found.dropped_out_of_range.count(),
            not_finite_vertices: found.not_finite_vertices.count(),
            dropped_not_finite: found.dropped_not_finite.count(),
            dropped_degenerate: found.dropped_degenerate.count(),
            dropped_duplicates: found.dropped_duplicates.count(),
            reversed_faces: found.flipped_faces.count(),
            cut_edges: found.cut_edges.count(),
            split_vertices: found.split_vertices.count(),
            dropped_vertices: found.dropped_vertices.count(),
            zero_area_faces: found.zero_area_faces.count(),
            holes,
            turned_components: found.turned_components.count(),
            undecided_components: found.undecided_components,
            printing: None,
            written: None,
        }
    }
}

impl fmt::Display for Results {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [vertices, faces] = [(self.vertices_out, "vertices"), (self.faces_out, "faces")]
            .map(|(count, what)| counted(count, what));
        write!(f, "{vertices}, {faces}")?;
        if self.unchanged && self.holes.is_none() {
            f.write_str(", nothing to repair")?;
        }
        let counts = [
            (self.welded_vertices, "vertices merged"),
            (
                self.dropped_out_of_range
                    + self.dropped_not_finite
                    + self.dropped_degenerate
                    + self.dropped_duplicates,
                "faces dropped",
            ),
            (self.reversed_faces, "faces reversed"),
            (self.turned_components, "components turned outward"),
            (self.cut_edges, "edges cut"),
            (self.dropped_vertices + self.not_finite_vertices, "vertices dropped"),
        ];
        for (count, what) in counts.into_iter().filter(|&(count, _)| count > 0) {
            write!(f, ", {}", counted(count, what))?;
        }
        if let Some(Holes { filled, left, .. }) = &self.holes {
            write!(f, ", {}", counted(*filled, "holes filled"))?;
            if *left > 0 {
                write!(f, ", {left} left")?;
            }
        }
        if let Some(Printing { dropped_components, turned_components, separated_vertices }) =
            &self.printing
        {
            let counts = [
                (*dropped_components, "components of debris dropped"),
                (*turned_components, "filled components turned outward"),
                (*separated_vertices, "touching vertices moved apart"),
            ];
            for (count, what) in counts.into_iter().filter(|&(count, _)| count > 0) {
                write!(f, ", {}", counted(count, what))?;
            }
        }
        Ok(())
    }
}
