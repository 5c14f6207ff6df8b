//! `cargo run --release -p benches -- tolerance-study`: the number of faces that each preset needs for a certified
//! largest error, and the number of faces at which the run of the quick one first exceeds it.
//!
//! Every mesh is simplified within tolerances relative to the diagonal of its bounding box. The recorded distance is
//! certified independently, from the result and the input alone.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::time::Instant;

use mesh_core::{Repair, TriMesh, build};
use mesh_metric::{CertifyOptions, Surface, hausdorff_bounds};
use simplify::{ErrorCheck, Options, Preset, simplify};

use crate::job_set::JobSet;
use xtask_common::{Failure, Numbers, progress_bar};

/// What to simplify, and how.
#[derive(Clone, Debug, clap::Args)]
pub(crate) struct ToleranceStudy {
    /// The folder with the meshes
    #[arg(long, value_name = "DIR", env = "CURVMESH_MODELS")]
    models: PathBuf,
    /// Which meshes, by file name; by default the meshes of the jobs `tolerance` of benches/jobs.toml
    #[arg(long, value_name = "FILE", value_delimiter = ',')]
    meshes: Vec<String>,
    /// The largest errors, in percent of the diagonal of the bounding box; by default the errors of the jobs
    #[arg(long, value_name = "PERCENT", value_delimiter = ',')]
    tolerances: Vec<f64>,
    /// Which presets, by default the presets of the jobs; extreme, paper-l1 and paper-l2 take much longer
    #[arg(
        long, value_name = "PRESET", value_delimiter = ',',
        value_parser = |s: &str| s.parse::<Preset>(),
    )]
    presets: Vec<Preset>,
    /// The folder for the table (tolerance-study.txt) and the numbers (tolerance-study.csv). What is in
    /// the numbers already is not computed again
    #[arg(long, value_name = "DIR", default_value = "target/tolerance-study")]
    out: PathBuf,
}

const HEADER: [&str; 8] =
    ["mesh", "faces", "percent", "preset", "decimated", "faces_left", "upper_per_limit", "seconds"];

/// The way of simplifying a mesh.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
struct Way {
    preset: Preset,
    is_decimated: bool,
}

impl std::fmt::Display for Way {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}{}", self.preset, if self.is_decimated { "" } else { ", not decimated" })
    }
}

impl ToleranceStudy {
    /// The options with what the jobs say where they say nothing.
    fn completed(&self) -> Result<Self, Failure> {
        let JobSet { meshes, max_errors, tools, .. } = JobSet::of_name("tolerance")?;
        let mut options = self.clone();
        if options.meshes.is_empty() {
            options.meshes = meshes;
        }
        if options.tolerances.is_empty() {
            options.tolerances = max_errors;
        }
        if options.presets.is_empty() {
            let presets = tools.iter().map(|name| name.parse::<Preset>());
            options.presets = presets.collect::<Result<_, _>>().map_err(Failure::numbers)?;
        }
        Ok(options)
    }

    fn ways(&self) -> Vec<Way> {
        let plain = Way { preset: Preset::Fast, is_decimated: false };
        let all = self.presets.iter().map(|&preset| Way::usual(preset));
        std::iter::once(plain).chain(all).collect()
    }
}

impl Way {
    fn usual(preset: Preset) -> Self {
        let is_decimated =
            Options::preset(preset).within(1.0, ErrorCheck::Certified).tolerance.decimate;
        Self { preset, is_decimated }
    }
}

/// One number of the study.
struct Row {
    mesh: String,
    /// Faces of the input.
    faces: usize,
    percent: f64,
    way: Way,
    left: usize,
    /// The certified upper bound of the distance divided by the allowed error.
    upper: f64,
    seconds: f64,
}

/// Runs the rows that are missing in the file of numbers, and prints the table.
pub(crate) fn run(options: &ToleranceStudy) -> Result<(), Failure> {
    let options = &options.completed()?;
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let path = options.out.join("tolerance-study.csv");
    let (mut numbers, mut rows) = Numbers::open(path, &HEADER, Row::parse)?;
    let known: HashSet<_> = rows.iter().map(Row::key).collect();
    let ways = options.ways();
    let bar = progress_bar(options.meshes.len() * options.tolerances.len() * ways.len());
    for name in &options.meshes {
        let mesh = load(&options.models.join(name))?;
        let original = Surface::new(&mesh).map_err(Failure::mesh)?;
        for &percent in &options.tolerances {
            for &way in &ways {
                bar.set_message(format!("{name} {percent} % {way}"));
                if !known.contains(&(name.clone(), percent.to_string(), way)) {
                    let row = measure(name, &mesh, &original, percent, way)?;
                    numbers.add(&row.record())?;
                    rows.push(row);
                }
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    let text = table(options, &rows);
    let path = options.out.join("tolerance-study.txt");
    std::fs::write(&path, &text).map_err(Failure::writing(&path))?;
    print!("{text}");
    Ok(())
}

fn load(path: &Path) -> Result<TriMesh, Failure> {
    let model = mesh_io::read(path).map_err(Failure::mesh)?;
    Ok(build(&model.soup, &Repair::lenient()).map_err(Failure::mesh)?.mesh)
}

/// Simplifies, and certifies the distance by a separate call.
fn measure(
    name: &str,
    mesh: &TriMesh,
    original: &Surface,
    percent: f64,
    way: Way,
) -> Result<Row, Failure> {
    let limit = percent / 100.0 * original.bounding_box().diagonal();
    let mut options = Options::preset(way.preset).within(limit, ErrorCheck::Certified);
    options.tolerance.decimate &= way.is_decimated;
    let start = Instant::now();
    let result = simplify(mesh, &options).map_err(Failure::mesh)?;
    let seconds = start.elapsed().as_secs_f64();
    let surface = Surface::new(&result.mesh).map_err(Failure::mesh)?;
    let tight = CertifyOptions { tolerance: 1e-3 * limit, ..CertifyOptions::default() };
    let upper = hausdorff_bounds(original, &surface, &tight).upper / limit;
    let faces = mesh.topology().face_count();
    let left = result.mesh.topology().face_count();
    Ok(Row { mesh: name.to_owned(), faces, percent, way, left, upper, seconds })
}

impl Row {
    fn key(&self) -> (String, String, Way) {
        (self.mesh.clone(), self.percent.to_string(), self.way)
    }

    fn record(&self) -> [String; 8] {
        [
            self.mesh.clone(),
            self.faces.to_string(),
            self.percent.to_string(),
            self.way.preset.to_string(),
            self.way.is_decimated.to_string(),
            self.left.to_string(),
            format!("{:.4}", self.upper),
            format!("{:.1}", self.seconds),
        ]
    }

    fn parse(record: &csv::StringRecord) -> Option<Self> {
        Some(Self {
            mesh: record.get(0)?.to_owned(),
            faces: record.get(1)?.parse().ok()?,
            percent: record.get(2)?.parse().ok()?,
            way: Way {
                preset: record.get(3)?.parse().ok()?,
                is_decimated: record.get(4)?.parse().ok()?,
            },
            left: record.get(5)?.parse().ok()?,
            upper: record.get(6)?.parse().ok()?,
            seconds: record.get(7)?.parse().ok()?,
        })
    }
}

/// A line per mesh and tolerance: faces, bound and seconds of each preset, and the ratio of the faces of the default to
/// the smallest number.
fn table(options: &ToleranceStudy, rows: &[Row]) -> String {
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::UTF8_HORIZONTAL_ONLY);
    let mut header = vec!["mesh".to_owned(), "%".to_owned()];
    let ways = options.ways();
    header.extend(ways.iter().map(ToString::to_string));
    header.push("default : smallest".to_owned());
    table.set_header(header);
    for name in &options.meshes {
        for percent in &options.tolerances {
            let found = |way: &Way| {
                let key = (name.clone(), percent.to_string(), *way);
                rows.iter().find(|row| row.key() == key)
            };
            let mut line = vec![name.clone(), percent.to_string()];
            line.extend(ways.iter().map(|way| {
                found(way).map_or_else(String::new, |row| {
                    format!("{} ({:.3}, {:.1} s)", row.left, row.upper, row.seconds)
                })
            }));
            let all = ways.iter().filter_map(found).map(|row| row.left);
            let ratio = found(&Way::usual(Preset::Default)).zip(all.min());
            line.push(ratio.map_or_else(String::new, |(row, least)| {
                format!("{:.3}", row.left as f64 / least.max(1) as f64)
            }));
            table.add_row(line);
        }
    }
    format!(
        "Faces within a largest error in percent of the diagonal (proved distance over that error, \
         time)\n{table}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::{Preset, Row, Way, measure};
    use mesh_core::{Repair, build};
    use mesh_metric::Surface;
    use mesh_shapes::Sphere;

    #[test]
    fn rows_survive_the_way_through_the_file() {
        let row = Row {
            mesh: "a,b.obj".into(),
            faces: 7,
            percent: 0.05,
            way: Way::usual(Preset::ThinFeatures),
            left: 5,
            upper: 0.5,
            seconds: 1.5,
        };
        let record = csv::StringRecord::from(row.record().to_vec());
        assert_eq!(Row::parse(&record).unwrap().record(), row.record());
    }

    #[test]
    fn the_bound_of_a_sphere_is_below_the_limit() {
        let soup = Sphere { radius: 1.0 }.icosphere(3).unwrap();
        let mesh = build(&soup, &Repair::strict()).unwrap().mesh;
        let original = Surface::new(&mesh).unwrap();
        let row = measure("sphere", &mesh, &original, 1.0, Way::usual(Preset::Default)).unwrap();
        assert!(row.upper <= 1.0 && row.left < row.faces / 2, "{:?}", row.record());
    }
}
