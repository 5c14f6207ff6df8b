//! `curvmesh compare`: versions of a surface, measured against one reference.

use std::path::{Path, PathBuf};

use mesh_io::Model;
use mesh_metric::{
    CertifyOptions, CompareOptions, Comparison, Surface, compare, compare_one_way,
    hausdorff_bounds, normal_deviation,
};
use mesh_view::{Page, Section};
use serde::Serialize;

use crate::args::{is_standard, parse_count, parse_seed};
use crate::colormap::{COLOR_OPTIONS, ColorOptions};
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::load::{Loading, Seconds, no_surface, surface_or_points};
use crate::session::{Outcome, Session};
use crate::task::Report;
use crate::text::printable;
use crate::view::{self, Look, name_of};
use mesh_work::{Length, is_point_cloud, parse_length};

/// Compare versions of a surface with the original, in one table and on one page
///
/// Each file gets a row: its faces, its mean, root mean square and largest distance from the
/// reference (both directions, in % of the diagonal of the reference), and the mean angle between
/// normals. The surfaces need not be manifolds. A file without faces is a point cloud: the distance
/// of its points from a surface is measured in this direction only.
///
///     curvmesh compare scan.ply small.ply smaller.ply
///     curvmesh compare scan.ply ours.ply theirs.ply --exact 0.01% --view compare.html
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Compare {
    /// The reference, for example the original; `-` is the standard input
    #[arg(value_name = "REF")]
    reference: PathBuf,
    /// The surfaces to compare with it
    #[arg(value_name = "FILE", required = true)]
    others: Vec<PathBuf>,
    /// Samples in each direction, uniform by area
    #[arg(long, value_name = "N", default_value_t = 200_000, value_parser = |text: &str| parse_count(text, 1..=MOST_SAMPLES))]
    samples: usize,
    /// Also prove an upper bound of the Hausdorff distance, at most this much above a lower bound;
    /// percentages refer to the diagonal of the reference
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    exact: Option<Length>,
    /// Seed of the random numbers of the samples
    #[arg(long, value_name = "SEED", default_value_t = 1, value_parser = parse_seed)]
    seed: u64,
    #[command(flatten)]
    colors: ColorOptions,
    #[command(flatten)]
    loading: Loading,
    #[command(flatten)]
    look: Look,
}

/// All samples are in memory.
const MOST_SAMPLES: usize = 20_000_000;

#[derive(Serialize)]
struct Results {
    bbox_diagonal: f64,
    samples: usize,
    files: Vec<Row>,
}

/// A file against the reference; distances in model units.
#[derive(Serialize)]
struct Row {
    file: String,
    vertices: usize,
    faces: usize,
    mean: f64,
    rms: f64,
    max: f64,
    /// Whether only one of the two has faces: then its distance from the points is not measured.
    one_sided: bool,
    /// In degrees; null if a surface has no area.
    normal_deviation: Option<f64>,
    /// A proved upper bound of the Hausdorff distance.
    #[serde(skip_serializing_if = "Option::is_none")]
    proved_max: Option<f64>,
}

/// A file that was read.
struct Version<'a> {
    path: &'a Path,
    model: Model,
    /// The surface, or the points.
    surface: Surface,
    is_cloud: bool,
}

pub(crate) fn run(options: &Compare, session: &Session) -> Result<Outcome, Failure> {
    let Compare { reference, others, loading, look, .. } = options;
    if !look.is_wanted() {
        session.given.refuse(&COLOR_OPTIONS, "without --view nothing is coloured")?;
    }
    if [reference].into_iter().chain(others).filter(|path| is_standard(path)).count() > 1 {
        return Err(Failure::usage("the standard input `-` can be one of the files only"));
    }
    let console = &session.console;
    let mut seconds = Seconds::default();
    let original = Seconds::time(&mut seconds.load, || Version::read(reference, loading, console))?;
    let versions: Result<Vec<_>, _> = Seconds::time(&mut seconds.load, || {
        others.iter().map(|path| Version::read(path, loading, console)).collect()
    });
    let versions = versions?;
    if original.is_cloud || versions.iter().any(|version| version.is_cloud) {
        for (is_given, name) in [(options.exact.is_some(), "--exact"), (look.is_wanted(), "--view")]
        {
            if is_given {
                let text = format!("{name} is for surfaces, but a file has points only");
                return Err(Failure::usage(text));
            }
        }
    }
    if original.is_cloud || versions.iter().all(|version| version.is_cloud) {
        let why = "points are measured themselves, not sampled";
        session.given.refuse(&["samples", "seed"], why)?;
    }
    let diagonal = original.surface.bounding_box().diagonal();
    let size = || mesh_work::diagonal(Some(diagonal));
    let exact = options.exact.map(|length| length.in_units(loading.relative, size));
    let exact = exact.transpose().map_err(Failure::refused)?;
    let spinner = console.spinner("measuring");
    let files = Seconds::time(&mut seconds.compute, || {
        versions.iter().map(|version| version.row(&original, exact, options)).collect()
    });
    spinner.finish_and_clear();
    let results = Results { bbox_diagonal: diagonal, samples: options.samples, files };
    let counts = original.counts();
    let report = Report::new(console, reference, counts, results, seconds);
    if look.is_wanted() {
        let page = page(options, &original, &versions, &report.results)?;
        look.write(page, &report, console)?;
    }
    report.done(console, table(&original, &report.results), String::new())?.print(console)?;
    Ok(Outcome::Done)
}

impl<'a> Version<'a> {
    fn read(path: &'a Path, loading: &Loading, console: &Console) -> Result<Self, Failure> {
        let model = loading.finite_content(path, console)?;
        let (surface, is_cloud) =
            (surface_or_points(path, &model, console)?, is_point_cloud(&model.soup));
        Ok(Self { path, model, surface, is_cloud })
    }

    fn counts(&self) -> [usize; 2] {
        [self.model.soup.vertex_count(), self.model.soup.face_count()]
    }

    /// The distances in both directions; those of points from a surface stand for both.
    fn measure(&self, original: &Self, sampling: &CompareOptions) -> Comparison {
        let points = CompareOptions::for_points();
        let one_way = |from: &Self, to: &Self| compare_one_way(&from.surface, &to.surface, &points);
        let [forward, backward] = match [self.is_cloud, original.is_cloud] {
            [false, false] => return compare(&self.surface, &original.surface, sampling),
            [true, true] => [one_way(self, original), one_way(original, self)],
            [true, false] => [one_way(self, original); 2],
            [false, true] => [one_way(original, self); 2],
        };
        Comparison { forward, backward }
    }

    fn row(&self, original: &Self, exact: Option<f64>, options: &Compare) -> Row {
        let &Compare { samples, seed, .. } = options;
        let sampling = CompareOptions { samples, seed, ..CompareOptions::default() };
        let found = self.measure(original, &sampling);
        let angle = if self.is_cloud || original.is_cloud {
            f64::NAN
        } else {
            normal_deviation(&self.surface, &original.surface, samples, seed).to_degrees()
        };
        let proved_max = exact.map(|tolerance| {
            let certify = CertifyOptions { tolerance, ..CertifyOptions::default() };
            hausdorff_bounds(&self.surface, &original.surface, &certify).upper
        });
        let [vertices, faces] = self.counts();
        Row {
            file: self.path.display().to_string(),
            vertices,
            faces,
            mean: found.mean(),
            rms: found.rms(),
            max: found.hausdorff(),
            one_sided: self.is_cloud != original.is_cloud,
            normal_deviation: angle.is_finite().then_some(angle),
            proved_max,
        }
    }
}

/// All surfaces, the reference first, coloured by the distance from it in % of its diagonal. The reference has the distance
/// from the only other surface; of several, none would be the right one.
fn page(
    options: &Compare,
    original: &Version<'_>,
    others: &[Version<'_>],
    found: &Results,
) -> Result<Page, Failure> {
    let mut exhibits = Vec::new();
    let diagonal = original.surface.bounding_box().diagonal();
    let only = match others {
        [only] => Some(&only.surface),
        _ => None,
    };
    let to = [only].into_iter().chain(others.iter().map(|_| Some(&original.surface)));
    for (version, to) in [original].into_iter().chain(others).zip(to) {
        let name = name_of(version.path);
        let mut exhibit = view::content(&name, version.path, &version.model, &options.loading)?;
        let Some(to) = to else {
            exhibits.push(exhibit);
            continue;
        };
        let added = view::add_distances(&mut exhibit, to);
        added.map_err(|error| no_surface(version.path, error))?;
        for field in exhibit.fields.iter_mut().take(2) {
            field.unit = "% of the diagonal".into();
            field.values.iter_mut().for_each(|x| *x *= 100.0 / diagonal.max(f64::MIN_POSITIVE));
        }
        exhibits.push(exhibit);
    }
    let title = format!("{}: versions compared", name_of(original.path));
    let mut page = Page::new(title, exhibits);
    page.start.up = view::usual_up(original.path, &page.exhibits);
    page.start.color = Some("face:largest distance in face".into());
    page.start.map = options.colors.colormap;
    page.start.range = options.colors.given_range();
    let mut rows = rows(found).into_iter();
    page.report.push(Section {
        title: "Distances".into(),
        text: "Distances are in % of the diagonal of the first file.".into(),
        header: rows.next().unwrap_or_default(),
        lines: rows.collect(),
        ..Section::default()
    });
    Ok(page)
}

/// The heads of the table, and a row for each file.
fn rows(found: &Results) -> Vec<Vec<String>> {
    let percent = |distance: f64| {
        let share = 100.0 * distance / found.bbox_diagonal.max(f64::MIN_POSITIVE);
        format!("{share:.4}")
    };
    let is_proved = found.files.iter().any(|row| row.proved_max.is_some());
    let mut rows =
        vec![["file", "faces", "mean %", "rms %", "max %", "normals"].map(str::to_owned).to_vec()];
    rows[0].extend(is_proved.then(|| "proved max %".to_owned()));
    for row in &found.files {
        let angle =
            row.normal_deviation.map_or("unknown".into(), |angle| format!("{angle:.2}\u{b0}"));
        let [mean, rms, max] = [row.mean, row.rms, row.max].map(percent);
        let direction = if row.one_sided { " (one direction)" } else { "" };
        let file = format!("{}{direction}", printable(&row.file));
        let mut cells = vec![file, row.faces.to_string(), mean, rms, max, angle];
        cells.extend(row.proved_max.map(percent));
        rows.push(cells);
    }
    rows
}

fn table(original: &Version<'_>, found: &Results) -> String {
    let rows = rows(found);
    let widths: Vec<usize> = (0..rows[0].len())
        .map(|column| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0))
        .collect();
    let mut text = format!(
        "{}: {}; distances are in % of its diagonal\n",
        printable(original.path.display()),
        counted(original.counts()[1], "faces")
    );
    for row in &rows {
        let cells = row.iter().zip(&widths).enumerate().map(|(column, (cell, &width))| {
            if column == 0 { format!("  {cell:width$}") } else { format!("  {cell:>width$}") }
        });
        text += cells.collect::<String>().trim_end();
        text.push('\n');
    }
    text.trim_end().to_owned()
}
