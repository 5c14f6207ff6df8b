//! `curvmesh distance`: the distance between two surfaces, or of points.

use std::path::{Path, PathBuf};

use glam::DVec3;
use mesh_core::build::{BuildReport, Repair, Weld};
use mesh_io::Model;
use mesh_metric::{
    CertifiedBounds, CertifyOptions, CompareOptions, Comparison, OneSided, SignedDistance,
    SignedSide, Surface, Worst, compare, compare_one_way, compare_signed_until, hausdorff_bounds,
};
use mesh_view::{Field, Lines, On, Page};
use out_of_core::DiskMesh;
use serde::Serialize;

use crate::args::{is_standard, parse_count, parse_seed};
use crate::colormap::{COLOR_OPTIONS, ColorOptions, opaque};
use crate::console::Console;
use crate::failure::Failure;
use crate::given::Given;
use crate::load::{Loading, Seconds, no_surface, surface_or_points};
use crate::replaced::Replaced;
use crate::save::{SAVE_OPTIONS, SaveOptions, check_folder_of, check_target, save};
use crate::session::{Outcome, Session};
use crate::streaming::{Streaming, with_bar};
use crate::task::{Report, copy_pictures};
use crate::text::printable;
use crate::view::{self, Look, name_of};
use mesh_work::{Length, Loaded, diagonal, is_point_cloud, parse_length};

/// Measure the distance between two surfaces in both directions, or of points from a surface
///
/// Mean and root mean square are weighted by area, and come from samples. The maximum is over
/// samples, edges and vertices. All are in model units. The surfaces need not be manifolds.
///
/// A file without faces is a point cloud. The distance of its points from a surface is measured in
/// this direction only. Two point clouds are measured in both directions, to the nearest points.
///
///     curvmesh distance scan.ply simplified.ply
///     curvmesh distance scan.ply simplified.ply --exact 0.01% --json
///     curvmesh distance simplified.ply scan.ply -o errors.ply
///     curvmesh distance scan-points.ply part.stl --signed
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
    /// Also prove bounds of the Hausdorff distance that differ by at most this; percentages refer to the
    /// diagonal of A
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    exact: Option<Length>,
    /// Also give distances a sign, negative inside. For a closed surface, the winding number decides;
    /// otherwise the pseudonormal at the closest point: points behind the surface count as inside. Numbers
    /// and colours of -o and --view have the sign as well
    #[arg(long)]
    signed: bool,
    /// Seed of the random numbers of the samples
    #[arg(long, value_name = "SEED", default_value_t = 1, value_parser = parse_seed)]
    seed: u64,
    /// Write A with the distance of every vertex from B as a colour and a number; `-` is the standard
    /// output
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
    /// What the two files are: a surface or points.
    kinds: [&'static str; 2],
    /// From A to B; absent if A is a surface and B has points only.
    #[serde(skip_serializing_if = "Option::is_none")]
    forward: Option<Direction>,
    /// From B to A; absent if B is a surface and A has points only.
    #[serde(skip_serializing_if = "Option::is_none")]
    backward: Option<Direction>,
    /// Whether only one direction was measured.
    one_sided: bool,
    mean: f64,
    rms: f64,
    max: f64,
    bbox_diagonal: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    samples: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    hausdorff: Option<Bounds>,
}

#[derive(Clone, Serialize)]
struct Direction {
    mean: f64,
    rms: f64,
    max: f64,
    max_at: [f64; 3],
    #[serde(skip_serializing_if = "Option::is_none")]
    signed: Option<Signed>,
}

/// Distances that are negative inside.
#[derive(Clone, Serialize)]
struct Signed {
    /// How the sign was decided.
    by: &'static str,
    mean: f64,
    min: f64,
    max: f64,
    /// The share of the area, or of the points, that is inside.
    inside: f64,
}

impl From<SignedSide> for Signed {
    fn from(side: SignedSide) -> Self {
        let SignedSide { rule, mean, min, max, inside } = side;
        Self { by: rule.name(), mean, min, max, inside }
    }
}

impl From<&OneSided> for Direction {
    fn from(side: &OneSided) -> Self {
        let OneSided { mean, rms, max, worst, .. } = *side;
        Self { mean, rms, max, max_at: worst.from.to_array(), signed: None }
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
    let [a, b] = [&options.first, &options.second]
        .map(|path| Seconds::time(&mut seconds.load, || Part::read(path, options, console)));
    let (a, b) = (a?, b?);
    options.check_points(&a, &b, given)?;
    let size = || diagonal(Some(a.surface.bounding_box().diagonal()));
    let relative = options.loading.relative;
    let exact = options.exact.map(|length| length.in_units(relative, size));
    let exact = exact.transpose().map_err(Failure::refused)?;
    let spinner = console.spinner("measuring");
    let (of_a, of_b) = (a.solid(options, console)?, b.solid(options, console)?);
    let signs = [(&a, &of_a), (&b, &of_b)].map(|(part, solid)| part.signs(solid.as_ref()));
    let [to_a, to_b] = signs;
    let (to_a, to_b) = (to_a?, to_b?);
    let results = Seconds::time(&mut seconds.compute, || {
        measure(options, exact, [(&a, to_a.as_ref()), (&b, to_b.as_ref())])
    });
    spinner.finish_and_clear();
    if let Some(output) = &options.output {
        let mut model = a.model.clone();
        Seconds::time(&mut seconds.compute, || {
            let distances = distances(model.soup.positions(), &b.surface, to_b.as_ref());
            color(&mut model, distances, options, console);
        });
        Seconds::time(&mut seconds.save, || save(output, &model, &options.save, console))?;
        let pictures = model.file_pictures();
        copy_pictures(&options.first, output, &options.save, &pictures, console);
    }
    let mut report = Report::new(console, &options.first, a.counts(), results, seconds);
    if let Some(output) = &options.output {
        report = report.with_output(output);
    }
    if options.look.is_wanted() {
        let page = page(options, [(&a, to_a.as_ref()), (&b, to_b.as_ref())], &report.results)?;
        options.look.write(page, &report, console)?;
    }
    report.done(console, summary(&report.results), String::new())?.print(console)?;
    Ok(Outcome::Done)
}

/// One of the two files.
struct Part<'a> {
    path: &'a Path,
    model: Model,
    /// The surface, or the points.
    surface: Surface,
    is_cloud: bool,
}

impl<'a> Part<'a> {
    fn read(path: &'a Path, options: &Distance, console: &Console) -> Result<Self, Failure> {
        let model = options.loading.finite_content(path, console)?;
        let (surface, is_cloud) =
            (surface_or_points(path, &model, console)?, is_point_cloud(&model.soup));
        Ok(Self { path, model, surface, is_cloud })
    }

    fn counts(&self) -> [usize; 2] {
        [self.model.soup.vertex_count(), self.model.soup.face_count()]
    }

    fn kind(&self) -> &'static str {
        if self.is_cloud { "points" } else { "surface" }
    }

    /// The mesh that decides about signs, if they are asked for and this is a surface.
    fn solid(&self, options: &Distance, console: &Console) -> Result<Option<Loaded>, Failure> {
        if !options.signed || self.is_cloud {
            return Ok(None);
        }
        let mut joined = Repair::strict();
        joined.weld = Weld::Exact;
        let solid = Loaded::build_with_needed_repairs(self.model.clone(), &joined);
        let solid = solid.map_err(|source| Failure::Build {
            path: self.path.to_owned(),
            source: Box::new(source),
            joined: true,
        })?;
        let repairs = solid.report.repairs().filter(|(what, _)| *what != BuildReport::MERGED);
        let repairs: Vec<String> =
            repairs.map(|(what, count)| format!("{what}: {count}")).collect();
        if !repairs.is_empty() {
            let (name, repairs) = (printable(self.path.display()), repairs.join(", "));
            console.message(format_args!("{name}: repaired to decide about signs: {repairs}"));
        }
        Ok(Some(solid))
    }

    fn signs<'s>(&self, solid: Option<&'s Loaded>) -> Result<Option<SignedDistance<'s>>, Failure> {
        let signs = solid.map(|solid| SignedDistance::negative_inside(&solid.mesh));
        signs.transpose().map_err(|error| no_surface(self.path, error))
    }
}

impl Distance {
    /// Refuses options that do not suit points.
    fn check_points(&self, a: &Part<'_>, b: &Part<'_>, given: &Given) -> Result<(), Failure> {
        if self.signed && b.is_cloud {
            return Err(Failure::usage(
                "--signed needs a surface to measure to, but B has points only; exchange A and B if A is a surface",
            ));
        }
        if !a.is_cloud && !b.is_cloud {
            return Ok(());
        }
        if self.exact.is_some() {
            return Err(Failure::usage("--exact is for two surfaces, but a file has points only"));
        }
        if self.look.is_wanted() {
            return Err(Failure::usage(
                "--view shows surfaces, but a file has points only; write the points with -o, which colours them",
            ));
        }
        given.refuse(&["samples", "seed"], "points are measured themselves, not sampled")?;
        if self.output.is_some() && !a.is_cloud {
            return Err(Failure::usage(
                "-o would write distances of the surface A from points, which are not measured in this direction; exchange A and B",
            ));
        }
        Ok(())
    }
}

/// Distances from a surface, with signs if there are any.
fn distances(points: &[DVec3], to: &Surface, signs: Option<&SignedDistance<'_>>) -> Vec<f64> {
    match signs {
        Some(signs) => signs.distances(points),
        None => to.distances(points),
    }
}

/// Distances between surfaces that are larger than memory.
fn passing(options: &Distance, console: &Console) -> Result<Outcome, Failure> {
    let Distance { first, second, loading, streaming, .. } = options;
    let others = [
        (options.exact.is_some(), "--exact"),
        (options.output.is_some(), "-o"),
        (options.look.is_wanted(), "--view"),
        (options.signed, "--signed"),
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
    let sides = [Some((&found.forward).into()), Some((&found.backward).into())];
    let results = Results::new(options, sides, counts(&b), a.summary().size(), ["surface"; 2]);
    let report = Report::new(console, first, counts(&a), results, seconds);
    report.done(console, summary(&report.results), String::new())?.print(console)?;
    Ok(Outcome::Done)
}

/// A surface that errors inside faces exceed by this factor at least is shown with the values of its faces first.
const HIDDEN: f64 = 1.05;

/// Both surfaces, each with its distance from the other, at vertices and inside faces, and the point of the largest
/// distance.
fn page(
    options: &Distance,
    [(a, to_a), (b, to_b)]: [(&Part<'_>, Option<&SignedDistance<'_>>); 2],
    found: &Results,
) -> Result<Page, Failure> {
    let mut exhibits = Vec::new();
    let mut is_hidden = false;
    for (part, other, signs, direction) in
        [(a, b, to_b, &found.forward), (b, a, to_a, &found.backward)]
    {
        let mut exhibit =
            view::content(&name_of(part.path), part.path, &part.model, &options.loading)?;
        let values = distances(&exhibit.positions, &other.surface, signs);
        let largest = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let at_vertices = Field {
            signed: signs.is_some(),
            unit: view::MODEL_UNITS.into(),
            ..Field::new("distance", On::Vertices, values)
        };
        let in_faces = view::largest_distances(&exhibit, &other.surface, view::ON_FACES)
            .map_err(|error| no_surface(part.path, error))?;
        is_hidden |= in_faces.values.iter().any(|&value| value > HIDDEN * largest);
        let fields = [at_vertices, in_faces];
        exhibit.fields.retain(|field| fields.iter().all(|new| new.name != field.name));
        exhibit.fields.splice(0..0, fields);
        if let Some(direction) = direction {
            let worst = DVec3::from_array(direction.max_at);
            exhibit.lines.push(Lines::dots("Largest distance", [214, 0, 110], &[worst]));
        }
        exhibits.push(exhibit);
    }
    let title = exhibits.iter().map(|e| &*e.name).collect::<Vec<_>>().join(" and ");
    let first = exhibits.first().and_then(|exhibit| exhibit.fields.get(usize::from(is_hidden)));
    let color = first.map(Field::key);
    let mut page = Page::new(format!("{title}: distance"), exhibits);
    page.start.color = color;
    page.start.map = options.colors.colormap;
    page.start.range = options.colors.given_range();
    Ok(page)
}

fn measure(
    options: &Distance,
    exact: Option<f64>,
    [(a, to_a), (b, to_b)]: [(&Part<'_>, Option<&SignedDistance<'_>>); 2],
) -> Results {
    let kinds = [a.kind(), b.kind()];
    let new = |sides| {
        let diagonal = a.surface.bounding_box().diagonal();
        Results::new(options, sides, b.counts(), diagonal, kinds)
    };
    let points = CompareOptions::for_points();
    let one_way = |from: &Part<'_>, to: &Part<'_>, signs| {
        let found = compare_one_way(&from.surface, &to.surface, &points);
        Some(Direction::new(&found, &from.surface, signs, &points))
    };
    match [a.is_cloud, b.is_cloud] {
        [true, true] => return new([one_way(a, b, None), one_way(b, a, None)]),
        [true, false] => return new([one_way(a, b, to_b), None]),
        [false, true] => return new([None, one_way(b, a, to_a)]),
        [false, false] => {}
    }
    let sampling = options.sampling();
    let found: Comparison = compare(&a.surface, &b.surface, &sampling);
    let forward = Direction::new(&found.forward, &a.surface, to_b, &sampling);
    let backward = Direction::new(&found.backward, &b.surface, to_a, &sampling);
    let certified = exact.map(|tolerance| {
        let certify = CertifyOptions { tolerance, ..CertifyOptions::default() };
        let bounds = hausdorff_bounds(&a.surface, &b.surface, &certify);
        Bounds::new(bounds, &found, [&a.surface, &b.surface])
    });
    Results { hausdorff: certified, ..new([Some(forward), Some(backward)]) }
}

impl Direction {
    /// The distances from a surface, and the signed ones at the same points.
    fn new(
        found: &OneSided,
        from: &Surface,
        signs: Option<&SignedDistance<'_>>,
        options: &CompareOptions,
    ) -> Self {
        let signed = signs.and_then(|signs| compare_signed_until(from, signs, options, &|| false));
        Self { signed: signed.map(Signed::from), ..found.into() }
    }
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
        [forward, backward]: [Option<Direction>; 2],
        [other_vertices, other_faces]: [usize; 2],
        bbox_diagonal: f64,
        kinds: [&'static str; 2],
    ) -> Self {
        let side = |side: &Direction| {
            let worst = Worst { from: DVec3::from_array(side.max_at), to: DVec3::NAN };
            OneSided { mean: side.mean, rms: side.rms, max: side.max, worst, samples: 0 }
        };
        let sides = [&forward, &backward].map(|direction| direction.as_ref().map(side));
        let known = sides[0].or(sides[1]).map(|either| Comparison {
            forward: sides[0].unwrap_or(either),
            backward: sides[1].unwrap_or(either),
        });
        let of = |value: fn(&Comparison) -> f64| known.as_ref().map_or(f64::NAN, value);
        Self {
            other: options.second.display().to_string(),
            other_vertices,
            other_faces,
            kinds,
            one_sided: forward.is_none() || backward.is_none(),
            mean: of(Comparison::mean),
            rms: of(Comparison::rms),
            max: of(Comparison::hausdorff),
            forward,
            backward,
            bbox_diagonal,
            samples: (kinds == ["surface"; 2]).then_some(options.samples),
            hausdorff: None,
        }
    }
}

/// Gives every vertex its distance from the other surface as a number and a colour.
fn color(model: &mut Model, distances: Vec<f64>, options: &Distance, console: &Console) {
    let scale = options.colors.scale(options.signed, distances.clone());
    let mut replaced = Replaced::default();
    replaced.take(&mut model.vertex_colors);
    model.vertex_colors = Some(distances.iter().map(|&d| opaque(scale.color(d))).collect());
    replaced.set(&mut model.vertex_scalars, "distance", distances);
    replaced.tell(&options.first, console);
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
    let directions = [("A to B", &found.forward), ("B to A", &found.backward)];
    for (name, side) in directions {
        text += &side.as_ref().map_or_else(String::new, |side| line(name, of(side)));
    }
    if found.one_sided {
        let [points, surface] = if found.forward.is_some() { ["A", "B"] } else { ["B", "A"] };
        text += &format!(
            "  one direction only: {points} has points, which may cover only a part of the surface {surface}\n"
        );
    } else {
        text += &line("both  ", [found.mean, found.rms, found.max]);
    }
    for (name, side) in directions {
        let Some(Signed { by, mean, min, max, inside }) =
            side.as_ref().and_then(|side| side.signed.as_ref())
        else {
            continue;
        };
        let (by, inside) = (by.replace('_', " "), 100.0 * inside);
        text += &format!(
            "  {name}, negative inside by the {by}: mean {mean:.6e}, from {min:.6e} to {max:.6e}, {inside:.2} % inside\n"
        );
    }
    if let Some(Bounds { lower, upper, converged }) = found.hausdorff {
        let remark = if converged { "" } else { "; the limit of work was reached" };
        text += &format!("  Hausdorff distance between {lower:.9e} and {upper:.9e}{remark}\n");
    }
    text.trim_end().to_owned()
}
