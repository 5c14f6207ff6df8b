//! `curvmesh distance`: the distance between two surfaces.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mesh_io::{Model, Scalars};
use mesh_metric::{
    CertifiedBounds, CertifyOptions, CompareOptions, Comparison, OneSided, Surface, compare,
    hausdorff_bounds,
};
use mesh_view::{Lines, Page};
use out_of_core::DiskMesh;
use serde::Serialize;

use crate::args::{is_standard, parse_count};
use crate::colormap::{COLOR_OPTIONS, ColorOptions, opaque};
use crate::console::Console;
use crate::failure::Failure;
use crate::load::{Loading, Seconds, surface};
use crate::save::{SAVE_OPTIONS, SaveOptions, check_folder_of, check_target, save};
use crate::session::{Outcome, Session};
use crate::streaming::{Streaming, with_bar};
use crate::task::Report;
use crate::view::{self, Look, name_of};
use mesh_work::{Length, diagonal, parse_length};

/// Measure the distance between two surfaces, from each to the other
///
/// Mean and root mean square are over the area, from samples; the maximum is over samples, edges
/// and vertices. All are in model units. Neither surface need be a manifold.
///
///     curvmesh distance scan.ply simplified.ply
///     curvmesh distance scan.ply simplified.ply --exact 0.01% --json
///     curvmesh distance simplified.ply scan.ply -o errors.ply
///     curvmesh distance huge.ply simplified.ply --memory 1GiB
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Distance {
    /// The first surface; `-` is the standard input, for one of the two
    #[arg(value_name = "A")]
    first: PathBuf,
    /// The second surface
    #[arg(value_name = "B")]
    second: PathBuf,
    /// Samples in each direction, uniform by area
    #[arg(long, value_name = "N", default_value_t = 1_000_000, value_parser = |text: &str| parse_count(text, 0..=MOST_SAMPLES))]
    samples: usize,
    /// Also prove bounds of the Hausdorff distance, at most this far apart; shares are of the diagonal
    /// of A
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    exact: Option<Length>,
    /// Where the random numbers of the samples start
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    seed: u64,
    /// Write A with the distance of every vertex from B as colours and as a number; `-` is the
    /// standard output
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    #[command(flatten)]
    colors: ColorOptions,
    #[command(flatten)]
    save: SaveOptions,
    #[command(flatten)]
    loading: Loading,
    #[command(flatten)]
    look: Look,
    #[command(flatten)]
    streaming: Streaming,
}

#[derive(Serialize)]
struct Results {
    other: String,
    other_vertices: usize,
    other_faces: usize,
    forward: Direction,
    backward: Direction,
    mean: f64,
    rms: f64,
    max: f64,
    bbox_diagonal: f64,
    samples: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    hausdorff: Option<Bounds>,
}

#[derive(Serialize)]
struct Direction {
    mean: f64,
    rms: f64,
    max: f64,
    max_at: [f64; 3],
}

impl From<&OneSided> for Direction {
    fn from(side: &OneSided) -> Self {
        Self { mean: side.mean, rms: side.rms, max: side.max, max_at: side.worst.from.to_array() }
    }
}

/// Samples are made block by block, but each takes time.
const MOST_SAMPLES: usize = 10_000_000_000;

#[derive(Serialize)]
struct Bounds {
    lower: f64,
    upper: f64,
    converged: bool,
}

impl Bounds {
    /// A sample can give a larger lower bound.
    fn new(proved: CertifiedBounds, found: &Comparison, [a, b]: [&Surface; 2]) -> Self {
        let proved = proved.raised_by(&found.forward, a, b).raised_by(&found.backward, b, a);
        Self { lower: proved.lower, upper: proved.upper, converged: proved.converged }
    }
}

pub(crate) fn run(options: &Distance, session: &Session) -> Result<Outcome, Failure> {
    let given = &session.given;
    match &options.output {
        Some(output) => {
            check_target(output, &options.save, given)?;
            check_folder_of(output)?;
        }
        None => {
            given.refuse(&SAVE_OPTIONS, "without -o nothing is written")?;
            if !options.look.is_wanted() {
                given.refuse(&COLOR_OPTIONS, "without -o nothing is coloured")?;
            }
        }
    }
    if is_standard(&options.first) && is_standard(&options.second) {
        return Err(Failure::usage("the standard input `-` can be one of the two surfaces only"));
    }
    if options.streaming.is_needed(&[&options.first, &options.second], &options.loading)? {
        return passing(options, &session.console);
    }
    let console = &*session.console.beside(options.output.as_deref())?;
    let mut seconds = Seconds::default();
    let read = |path: &Path| {
        let model = options.loading.content(path, console)?;
        surface(path, &model).map(|surface| (model, surface))
    };
    let [a, b] = [&options.first, &options.second]
        .map(|path| Seconds::time(&mut seconds.load, || read(path)));
    let ((mut model, a), (other, b)) = (a?, b?);
    let size = || diagonal(Some(a.bounding_box().diagonal()));
    let relative = options.loading.relative;
    let exact = options.exact.map(|length| length.in_units(relative, size));
    let exact = exact.transpose().map_err(Failure::refused)?;
    let spinner = console.spinner("measuring");
    let results = Seconds::time(&mut seconds.compute, || measure(options, exact, [&a, &b], &other));
    spinner.finish_and_clear();
    if let Some(output) = &options.output {
        Seconds::time(&mut seconds.compute, || color(&mut model, &b, options, console));
        Seconds::time(&mut seconds.save, || save(output, &model, &options.save, console))?;
    }
    let counts = [model.soup.vertex_count(), model.soup.face_count()];
    let mut report = Report::new(console, &options.first, counts, results, seconds);
    if let Some(output) = &options.output {
        report = report.with_output(output);
    }
    if options.look.is_wanted() {
        let page = page(options, [(&model, &a), (&other, &b)], &report.results)?;
        options.look.write(page, &report, console)?;
    }
    report.done(console, summary(&report.results), String::new())?.print(console)?;
    Ok(Outcome::Done)
}

/// Distances between surfaces that are larger than memory.
fn passing(options: &Distance, console: &Console) -> Result<Outcome, Failure> {
    let Distance { first, second, loading, streaming, .. } = options;
    let others = [
        (options.exact.is_some(), "--exact"),
        (options.output.is_some(), "-o"),
        (options.look.is_wanted(), "--view"),
    ];
    if let Some((_, name)) = others.into_iter().find(|(is_given, _)| *is_given) {
        return Err(Failure::usage(format!(
            "{name} needs both surfaces in memory, which --memory does not allow; give more, or leave it out"
        )));
    }
    Streaming::check(loading)?;
    let mut seconds = Seconds::default();
    let scratch = streaming.scratch(None)?;
    let [a, b] = [("first", first), ("second", second)].map(|(name, path)| {
        Seconds::time(&mut seconds.load, || {
            streaming.disk_mesh(&scratch, name, path, loading, console)
        })
    });
    let (a, b) = (a?, b?);
    let found = Seconds::time(&mut seconds.compute, || {
        with_bar(console, |see| out_of_core::distance(&a, &b, &options.sampling(), see))
    })?;
    let counts = |disk_mesh: &DiskMesh| {
        [disk_mesh.summary().vertices, disk_mesh.summary().faces].map(|n| n as usize)
    };
    let results = Results::new(options, &found, counts(&b), a.summary().size(), None);
    let report = Report::new(console, first, counts(&a), results, seconds);
    report.done(console, summary(&report.results), String::new())?.print(console)?;
    Ok(Outcome::Done)
}

/// Both surfaces, each with its distance from the other and the point of the largest distance.
fn page(
    options: &Distance,
    [(first, a), (second, b)]: [(&Model, &Surface); 2],
    found: &Results,
) -> Result<Page, Failure> {
    let mut exhibits = Vec::new();
    let sides =
        [(&options.first, first, b, &found.forward), (&options.second, second, a, &found.backward)];
    for (path, model, other, direction) in sides {
        let mut exhibit = view::content(&name_of(path), path, model, &options.loading)?;
        let distance = view::distance_field(&exhibit, other);
        exhibit.fields.retain(|field| field.name != distance.name);
        exhibit.fields.insert(0, distance);
        let worst = DVec3::from_array(direction.max_at);
        exhibit.lines.push(Lines::dots("Largest distance", [214, 0, 110], &[worst]));
        exhibits.push(exhibit);
    }
    let title = exhibits.iter().map(|e| &*e.name).collect::<Vec<_>>().join(" and ");
    let mut page = Page::new(format!("{title}: distance"), exhibits);
    page.start.color = Some("vertex:distance".into());
    page.start.map = options.colors.colormap;
    page.start.range = options.colors.given_range();
    Ok(page)
}

fn measure(
    options: &Distance,
    exact: Option<f64>,
    [a, b]: [&Surface; 2],
    other: &Model,
) -> Results {
    let found: Comparison = compare(a, b, &options.sampling());
    let certified = exact.map(|tolerance| {
        let certify = CertifyOptions { tolerance, ..CertifyOptions::default() };
        Bounds::new(hausdorff_bounds(a, b, &certify), &found, [a, b])
    });
    let counts = [other.soup.vertex_count(), other.soup.face_count()];
    Results::new(options, &found, counts, a.bounding_box().diagonal(), certified)
}

impl Distance {
    /// The sampling of the surfaces.
    fn sampling(&self) -> CompareOptions {
        CompareOptions { samples: self.samples, seed: self.seed, ..CompareOptions::default() }
    }
}

impl Results {
    fn new(
        options: &Distance,
        found: &Comparison,
        [other_vertices, other_faces]: [usize; 2],
        bbox_diagonal: f64,
        hausdorff: Option<Bounds>,
    ) -> Self {
        Self {
            other: options.second.display().to_string(),
            other_vertices,
            other_faces,
            forward: (&found.forward).into(),
            backward: (&found.backward).into(),
            mean: found.mean(),
            rms: found.rms(),
            max: found.hausdorff(),
            bbox_diagonal,
            samples: options.samples,
            hausdorff,
        }
    }
}

/// Gives every vertex its distance from the other surface as a number and a colour.
fn color(model: &mut Model, to: &Surface, options: &Distance, console: &Console) {
    let distances = to.distances(model.soup.positions());
    let scale = options.colors.scale(false, distances.clone());
    model.vertex_colors = Some(distances.iter().map(|&d| opaque(scale.color(d))).collect());
    model.vertex_scalars.retain(|scalars| scalars.name != "distance");
    model.vertex_scalars.push(Scalars::new("distance", distances));
    console.message(options.colors.explain(&scale));
}

fn summary(found: &Results) -> String {
    let percent = 100.0 / found.bbox_diagonal.max(f64::MIN_POSITIVE);
    let line = |name: &str, [mean, rms, max]: [f64; 3]| {
        format!(
            "  {name}  {mean:.6e} ({:.4} %)  {rms:.6e} ({:.4} %)  {max:.6e} ({:.4} %)\n",
            mean * percent,
            rms * percent,
            max * percent
        )
    };
    let of = |side: &Direction| [side.mean, side.rms, side.max];
    let mut text =
        "distance  mean, root mean square, maximum (and in % of the diagonal of A)\n".to_owned();
    text += &line("A to B", of(&found.forward));
    text += &line("B to A", of(&found.backward));
    text += &line("both  ", [found.mean, found.rms, found.max]);
    if let Some(Bounds { lower, upper, converged }) = found.hausdorff {
        let remark = if converged { "" } else { "; the limit of work was reached" };
        text += &format!("  Hausdorff distance between {lower:.9e} and {upper:.9e}{remark}\n");
    }
    text.trim_end().to_owned()
}
