//! `curvmesh patch`: smooth patches from face-based curvature, one or a whole cover.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::path::Path;

use clap::ValueEnum;
use curvpatch::{
    Cover, CoverCandidates, CoverMethod, CoverOptions, CoverPatch, CurvatureEstimator, Params,
    Shape, SizeOptions, patch_color,
};
use glam::DVec3;
use mesh_core::{FaceId, Handle, TriMesh, as_u32};
use mesh_io::Format;
use mesh_view::{Exhibit, Field, Layout, Lines, On, Page, Section};
use mesh_work::{
    Length, PatchMesh, PatchWorkError, cover_model, parse_length, patch_of_radius, patch_within,
    splat_model,
};
use serde::Serialize;

use crate::args::{EstimatorPreset, FormatName, parse_index};
use crate::batch::{Job, check_output};
use crate::console::Console;
use crate::counted::counted;
use crate::decimal::Decimal;
use crate::failure::Failure;
use crate::given::Given;
use crate::load::{Loading, Seconds};
use crate::save::{SAVE_OPTIONS, SaveOptions, make_folder_of, save_bytes};
use crate::session::{Outcome, Session};
use crate::task::{Done, Report, Task};
use crate::view::{self, Look, name_of};

/// Replace the mesh by smooth surface patches made from face-based curvature
///
/// Without --face, patches within the tolerance cover the mesh; faces that no patch covers stay
/// triangles, drawn in grey. With --face, there is one patch: with the given radius, or as large as
/// the tolerance allows.
///
/// The output has the patches as triangles, coloured by patch. A .json file is a record from which
/// every patch can be made again exactly. --as splats writes one oriented elliptical disc per patch
/// to a PLY file.
///
///     curvmesh patch scan.ply -o cover.ply --tolerance 1%
///     curvmesh patch scan.ply -o cover.json --tolerance 0.2 --shape ellipse
///     curvmesh patch scan.ply -o discs.ply --tolerance 0.5% --as splats
///     curvmesh patch cow.obj -o one.glb --face 1200 --radius 0.4 --shape ellipse
///     curvmesh patch scans/ -o covers/ --tolerance 1% --to glb
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment, mut_arg("output", |output| output.required(true)))]
pub(crate) struct Patch {
    #[command(flatten)]
    job: Job,
    #[command(flatten)]
    what: What,
    /// What to write [default: a record for .json, otherwise a mesh]
    #[arg(long = "as", value_enum, value_name = "CONTENT")]
    content: Option<Content>,
    #[command(flatten)]
    look: Look,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Patches")]
struct What {
    /// The largest distance between patches and mesh
    #[arg(
        long,
        value_name = "LENGTH",
        value_parser = parse_length,
        default_value = "1%",
        conflicts_with = "radius"
    )]
    tolerance: Length,
    /// Make one patch, at this face; triangles are numbered from 0, after repairs
    #[arg(long, value_name = "N", value_parser = parse_index::<usize>)]
    face: Option<usize>,
    /// The radius of the one patch
    #[arg(long, value_name = "LENGTH", requires = "face", value_parser = parse_length)]
    radius: Option<Length>,
    /// The outline of patches
    #[arg(long, value_enum, default_value_t)]
    shape: ShapeName,
    /// How curvature is estimated
    #[arg(long, value_enum, default_value_t)]
    preset: EstimatorPreset,
    /// How the patches of a cover are selected
    #[arg(long = "cover", value_enum, default_value_t, conflicts_with = "face")]
    method: MethodName,
    /// Keep patches inside the boundary of the mesh
    #[arg(long, conflicts_with = "radius")]
    no_overhang: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum ShapeName {
    /// Equal arcs in both principal directions
    Circle,
    /// Equal angles, up to 2.5 times longer where the surface is flatter
    Ellipse,
    /// Equal rise over the tangent plane
    Sagitta,
    /// For each patch, the circle or the ellipse, whichever covers more
    #[default]
    Best,
}

impl ShapeName {
    fn shapes(self) -> Vec<Shape> {
        match self {
            Self::Circle => vec![Shape::Circle],
            Self::Ellipse => vec![Shape::Ellipse],
            Self::Sagitta => vec![Shape::EqualSagitta],
            Self::Best => vec![Shape::Circle, Shape::Ellipse],
        }
    }
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum MethodName {
    /// Always the patch that adds the largest area
    Greedy,
    /// One pass by descending area
    Sequential,
    /// Both methods; the cover with fewer patches
    #[default]
    Best,
}

impl From<MethodName> for CoverMethod {
    fn from(name: MethodName) -> Self {
        match name {
            MethodName::Greedy => Self::Greedy,
            MethodName::Sequential => Self::Sequential,
            MethodName::Best => Self::Best,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Content {
    /// The patches as triangles, and the triangles that stay
    Mesh,
    /// Frames, curvatures, arcs, errors and faces of all patches, as JSON
    Record,
    /// One oriented elliptical disc per patch, as points of a PLY file
    Splats,
}

/// All settings, with the preset expanded.
#[derive(Serialize)]
struct Settings {
    params: Params,
    #[serde(flatten)]
    patches: PatchSettings,
}

/// The settings of one patch or of a cover.
#[derive(Serialize)]
#[serde(untagged)]
enum PatchSettings {
    Cover(CoverOptions),
    Within { face: usize, size: SizeOptions, shapes: Vec<Shape> },
    OfRadius { face: usize, radius: f64, shapes: Vec<Shape> },
}

#[derive(Serialize)]
struct Results {
    settings: Settings,
    patches: usize,
    covered_faces: usize,
    uncovered_faces: usize,
    /// In model units; null when a radius was given instead.
    tolerance: Option<f64>,
    max_error: f64,
    /// How far patches stick out beyond the boundary of the mesh, in model units.
    overhang: f64,
    method: &'static str,
}

/// Patches, how they were made, and the tolerance for cutting them into triangles.
struct Made {
    settings: Settings,
    cover: Cover,
    cut: f64,
}

pub(crate) fn run(options: &Patch, session: &Session) -> Result<Outcome, Failure> {
    options.check_given(&session.given)?;
    options.look.check(&options.job.inputs)?;
    let save = &options.job.save;
    let extension = |input: &Path| match options.content {
        Some(Content::Record) => Some("json"),
        Some(Content::Splats) => Some("ply"),
        _ => save.format_of(input).map(Format::extension),
    };
    options.job.run_as(session, &extension, &|task, console| one(options, task, console))
}

fn one(options: &Patch, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let loaded = task.load(&options.job.loading, &mut seconds, console)?;
    let mesh = &loaded.mesh;
    let relative = options.job.loading.relative;
    let made = Seconds::time(&mut seconds.compute, || options.what.make(mesh, relative, console))?;
    write(options, task, mesh, &made, &mut seconds, console)?;
    let page = match options.look.is_wanted() {
        true => Some(page(&task.input, &options.job.loading, mesh, &made)?),
        false => None,
    };
    let Made { settings, cover, .. } = made;
    let results = Results {
        settings,
        patches: cover.patches.len(),
        covered_faces: cover.covered_faces(),
        uncovered_faces: cover.residual.len(),
        tolerance: options.what.radius.is_none().then_some(cover.tolerance),
        max_error: cover.max_error(),
        overhang: cover.overhang(),
        method: options.what.method_name(&cover),
    };
    let report = task.report(console, loaded.counts(), results, seconds);
    if let Some(page) = page {
        options.look.write(page, &report, console)?;
    }
    let Results { patches, covered_faces, .. } = report.results;
    let brief = format!(
        "{} for {covered_faces} of {}",
        counted(patches, "patches"),
        counted(report.faces, "faces")
    );
    report.done(console, summary(&report), brief)
}

/// Up to this number of patches are also shown one by one.
const MOST_ALONE: usize = 60;

/// Up to this number of patches are listed.
const MOST_LISTED: usize = 1000;

/// The mesh in the colours of the patches, the cover, and the patches one by one with frame and arcs.
fn page(input: &Path, loading: &Loading, mesh: &TriMesh, made: &Made) -> Result<Page, Failure> {
    let Made { cover, cut, .. } = made;
    let whole = cover_model(mesh, cover, *cut).map_err(failed)?;
    let mut together = view::content("cover", input, &whole, loading)?;
    let mut under = view::mesh("mesh", mesh);
    let number = |patch: &Option<u32>| patch.map_or(f64::NAN, f64::from);
    let numbers = cover.patch_of_face.as_slice().iter().map(number).collect();
    under.fields.push(Field::labels("patch", On::Faces, numbers));
    let color = |patch: &Option<u32>| patch.map_or([196, 38, 46], patch_color);
    let colors = cover.patch_of_face.as_slice().iter().map(color);
    under.face_colors = Some(colors.map(|[r, g, b]| [r, g, b, 255]).collect());
    let curves: Vec<Vec<Lines>> = cover.patches.iter().map(|p| curves(&p.fit.patch)).collect();
    for kind in 0..curves.first().map_or(0, Vec::len) {
        let segments = curves.iter().flat_map(|lines| lines[kind].segments.iter().copied());
        let lines = Lines { segments: segments.collect(), ..curves[0][kind].clone() };
        together.lines.push(lines.clone());
        under.lines.push(lines);
    }
    // Patches can reach far beyond the mesh, so the mesh comes first.
    let mut exhibits = vec![under, together];
    for (index, (patch, lines)) in cover.patches.iter().zip(curves).take(MOST_ALONE).enumerate() {
        let part = patch.fit.patch.tessellate(*cut).map_err(Failure::refused)?;
        let [r, g, b] = patch_color(as_u32(index));
        let [k1, k2] = patch.fit.patch.curvatures();
        exhibits.push(Exhibit {
            name: format!("patch {index}"),
            face_colors: Some(vec![[r, g, b, 255]; part.triangles.len()]),
            fields: vec![Field::labels(
                "patch",
                On::Faces,
                vec![index as f64; part.triangles.len()],
            )],
            positions: part.positions,
            triangles: part.triangles,
            lines,
            is_part: true,
            facts: vec![
                ("k1".into(), Decimal(k1).to_string()),
                ("k2".into(), Decimal(k2).to_string()),
                ("covers faces".into(), patch.faces.len().to_string()),
                ("largest error".into(), Decimal(patch.errors.max()).to_string()),
            ],
            ..Exhibit::default()
        });
    }
    let mut page = Page::new(format!("{}: patches", name_of(input)), exhibits);
    page.layout = Layout::One;
    page.start.color = Some("face:patch".into());
    page.report.push(rows(cover));
    Ok(page)
}

/// A row for each patch, whose number shows it alone.
fn rows(cover: &Cover) -> Section {
    let count = cover.patches.len();
    let row = |(index, patch): (usize, &CoverPatch)| {
        let [k1, k2] = patch.fit.patch.curvatures();
        let numbers = [k1, k2, patch.errors.max()].map(|x| format!("{x:.4}"));
        let [k1, k2, error] = numbers;
        vec![index.to_string(), patch.faces.len().to_string(), k1, k2, error]
    };
    let mut text = "The number of a patch shows its faces alone, and all again.".to_owned();
    if count > MOST_LISTED {
        text += &format!(" Of {count} patches the first {MOST_LISTED} are listed.");
    }
    if count > MOST_ALONE {
        text += &format!(" The first {MOST_ALONE} are also meshes of their own under \"Show\".");
    }
    Section {
        title: "Patches".into(),
        text,
        header: ["patch", "faces", "k1", "k2", "largest error"].map(str::to_owned).into(),
        lines: cover.patches.iter().enumerate().take(MOST_LISTED).map(row).collect(),
        labels: Some("face:patch".into()),
        ..Section::default()
    }
}

/// The rim of a patch, its principal arcs, and the axes of its frame.
fn curves(patch: &curvpatch::Patch) -> Vec<Lines> {
    const PIECES: u32 = 48;
    let turn = |i: u32| TAU * f64::from(i) / f64::from(PIECES);
    let rim: Vec<DVec3> = (0..=PIECES).map(|i| patch.point(1.0, turn(i))).collect();
    let arc = |phi: f64| -> Vec<DVec3> {
        let at = |i: u32| {
            let u = 2.0 * f64::from(i) / f64::from(PIECES) - 1.0;
            patch.point(u.abs(), if u < 0.0 { phi + 0.5 * TAU } else { phi })
        };
        (0..=PIECES).map(at).collect()
    };
    let center = patch.point(0.0, 0.0);
    let [l1, l2] = patch.arcs();
    let axis = |i: usize| [center, center + 0.5 * l1.min(l2) * patch.frame()[i]];
    // Hidden at first: the lines of all patches together hide the mesh.
    let lines = |name, color, points: &[DVec3]| Lines {
        shown: false,
        ..Lines::through(name, color, points)
    };
    vec![
        lines("Rims", [30, 30, 36], &rim),
        lines("Arcs of k1", [200, 30, 40], &arc(0.0)),
        lines("Arcs of k2", [25, 80, 190], &arc(0.25 * TAU)),
        lines("Normals", [0, 120, 60], &axis(2)),
    ]
}

impl Patch {
    fn content(&self, output: Option<&Path>) -> Content {
        let extension = output.and_then(Path::extension);
        self.content.unwrap_or(match extension {
            Some(extension) if extension.eq_ignore_ascii_case("json") => Content::Record,
            _ => Content::Mesh,
        })
    }

    /// Refuses options without effect, and an output that cannot hold the content.
    fn check_given(&self, given: &Given) -> Result<(), Failure> {
        let output = self.job.output.as_deref();
        match self.content(output) {
            Content::Mesh => check_output(&self.job, given),
            Content::Record => given.refuse(&SAVE_OPTIONS, "the record is JSON"),
            Content::Splats => {
                let format = match self.job.save.to {
                    Some(name) => Some(Format::from(name)),
                    None => output.and_then(Format::from_extension),
                };
                match format {
                    // A folder, or the standard output.
                    None if output.is_some_and(|path| path.extension().is_none()) => Ok(()),
                    Some(Format::Ply) => Ok(()),
                    _ => Err(Failure::usage(
                        "splats go to PLY only; name the output .ply, or add --to ply",
                    )),
                }
            }
        }
    }
}

impl What {
    fn make(&self, original: &TriMesh, relative: bool, console: &Console) -> Result<Made, Failure> {
        let params = self.preset.params();
        let sized = PatchMesh::new(original).map_err(Failure::refused)?;
        let mesh = sized.mesh();
        let estimator = CurvatureEstimator::new(mesh, params)
            .map_err(|error| Failure::Usage(error.to_string()))?;
        let shapes = self.shape.shapes();
        let units = |length: Length| length.on(original, relative).map_err(Failure::refused);
        let (patches, cover, cut) = match (self.face, self.radius) {
            (Some(face), Some(radius)) => {
                let radius = units(radius)?;
                let at = face_of(mesh, face)?;
                let cover = patch_of_radius(&estimator, at, sized.length(radius), &shapes)
                    .map_err(failed)?;
                (PatchSettings::OfRadius { face, radius, shapes }, cover, 2e-3 * radius)
            }
            (Some(face), None) => {
                let tolerance = units(self.tolerance)?;
                let overhang = !self.no_overhang;
                let of = |tolerance| SizeOptions { overhang, ..SizeOptions::new(tolerance) };
                let size = of(sized.length(tolerance));
                let cover = patch_within(&estimator, face_of(mesh, face)?, size, &shapes)
                    .map_err(failed)?;
                let size = of(tolerance);
                (PatchSettings::Within { face, size, shapes }, cover, 0.5 * tolerance)
            }
            (None, _) => {
                let tolerance = units(self.tolerance)?;
                let options = self.cover_options(sized.length(tolerance));
                let cover = cover(&estimator, &options, console)?;
                let patches = PatchSettings::Cover(self.cover_options(tolerance));
                (patches, cover, 0.5 * tolerance)
            }
        };
        let cover = sized.restore(cover).map_err(failed)?;
        Ok(Made { settings: Settings { params, patches }, cover, cut })
    }

    fn cover_options(&self, tolerance: f64) -> CoverOptions {
        let defaults = CoverOptions::new(tolerance);
        CoverOptions {
            size: SizeOptions { overhang: !self.no_overhang, ..defaults.size },
            shapes: self.shape.shapes(),
            method: self.method.into(),
            ..defaults
        }
    }

    fn method_name(&self, cover: &Cover) -> &'static str {
        match (self.face, cover.method) {
            (Some(_), _) => "single",
            (None, CoverMethod::Sequential) => "sequential",
            (None, _) => "greedy",
        }
    }
}

fn cover(
    estimator: &CurvatureEstimator<'_>,
    options: &CoverOptions,
    console: &Console,
) -> Result<Cover, Failure> {
    let faces = estimator.mesh().topology().face_count();
    let bar = console.progress(faces as u64, "fitting");
    let candidates = CoverCandidates::find_with_progress(estimator, options, &mut |progress| {
        bar.set_position(progress.settled as u64);
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    let candidates = candidates.map_err(|error| Failure::Usage(error.to_string()))?;
    Ok(candidates.choose(options.method))
}

fn failed(error: PatchWorkError) -> Failure {
    match error {
        PatchWorkError::Option(error) => Failure::Usage(error.to_string()),
        other => Failure::refused(other),
    }
}

fn face_of(mesh: &TriMesh, index: usize) -> Result<FaceId, Failure> {
    let count = mesh.topology().face_count();
    if index < count {
        return Ok(FaceId::from_index(index));
    }
    Err(Failure::Usage(format!("there is no face {index}; the mesh has {count}, counted from 0")))
}

fn write(
    options: &Patch,
    task: &Task,
    mesh: &TriMesh,
    made: &Made,
    seconds: &mut Seconds,
    console: &Console,
) -> Result<(), Failure> {
    let Made { cover, cut, .. } = made;
    let Some(output) = &task.output else { return Ok(()) };
    let save = &options.job.save;
    match options.content(Some(output)) {
        Content::Mesh => {
            task.save(&cover_model(mesh, cover, *cut).map_err(failed)?, save, seconds, console)
        }
        Content::Record => Seconds::time(&mut seconds.save, || {
            if task.makes_folder {
                make_folder_of(output)?;
            }
            let record = serde_json::to_string(&cover.record()).map_err(Failure::json)?;
            save_bytes(output, format!("{record}\n").as_bytes())
        }),
        Content::Splats => {
            let format = Some(FormatName::Ply);
            let save = SaveOptions { to: format, ..*save };
            task.save(&splat_model(&cover.splats()), &save, seconds, console)
        }
    }
}

fn summary(report: &Report<Results>) -> String {
    let Results { patches, covered_faces, tolerance, max_error, overhang, .. } = &report.results;
    let kept = match tolerance {
        Some(tolerance) => format!("tolerance {}, ", Decimal(*tolerance)),
        None => String::new(),
    };
    let text = format!(
        "{}: {} for {covered_faces} of {} in {:.3} s ({kept}largest error {})",
        report.subject(),
        counted(*patches, "patches"),
        counted(report.faces, "faces"),
        report.seconds.compute,
        Decimal(*max_error),
    );
    if *overhang == 0.0 {
        return text;
    }
    let cure = if tolerance.is_some() { "; --no-overhang keeps them inside" } else { "" };
    let overhang = Decimal(*overhang);
    format!("{text}\n  patches stick out up to {overhang} beyond the boundary of the mesh{cure}")
}
