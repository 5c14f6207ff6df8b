//! `cargo run --release -p benches -- preset-study`: whether a more careful preset has a larger mean error than a
//! cheaper one.
//!
//! The mean is that of `curvmesh distance`: the average of the means over both surfaces. Models and generated parts are
//! simplified to several shares of their faces with the presets from `draft` to `extreme`. A cell is a preset beside
//! the next cheaper one, for a mesh and a share. It is violated if its mean is more than 2 % larger, unless both are
//! below a millionth of the diagonal. A cheaper preset whose collapses end early, with more faces, is not compared.

use std::path::PathBuf;

use comfy_table::Table;
use mesh_core::{Repair, TriMesh, build};
use mesh_metric::{CompareOptions, Surface, compare};
use postconditions::kinds;
use simplify::{Options, Preset, simplify};

use crate::job_set::JobSet;
use xtask_common::{Failure, Numbers, progress_bar};

/// What to simplify, and how.
#[derive(Debug, clap::Args)]
pub(crate) struct PresetStudy {
    /// The folder with the meshes; without it, only generated parts
    #[arg(long, value_name = "DIR", env = "CURVMESH_MODELS")]
    models: Option<PathBuf>,
    /// Which meshes, by file name; by default the meshes of the jobs `usual` of benches/jobs.toml
    #[arg(long, value_name = "FILE", value_delimiter = ',')]
    meshes: Vec<String>,
    /// Number of generated parts; kinds repeat with other sizes
    #[arg(long, value_name = "N", default_value_t = 20)]
    parts: usize,
    /// Seed of the sizes of the parts
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Cells along the sides of the parts, relative to the usual number
    #[arg(long, value_name = "FACTOR", default_value_t = 2.0)]
    density: f64,
    /// How many faces are left, as shares of the input
    #[arg(long, value_name = "SHARE", value_delimiter = ',', default_value = "0.5,0.3,0.1,0.02")]
    ratios: Vec<f64>,
    /// Which presets, the cheapest first
    #[arg(
        long, value_name = "PRESET", value_delimiter = ',',
        default_value = "draft,fast,default,quality,extreme",
        value_parser = |s: &str| s.parse::<Preset>(),
    )]
    presets: Vec<Preset>,
    /// Results with more faces are made without extreme, which takes minutes there
    #[arg(long, value_name = "FACES", default_value_t = 3_000)]
    most_for_extreme: usize,
    /// The folder for the numbers (preset-study.csv), made anew
    #[arg(long, value_name = "DIR", default_value = "target/preset-study")]
    out: PathBuf,
}

/// The kinds of generated meshes that CAD programs make.
const PARTS: [&str; 16] = [
    "box",
    "plate",
    "extrusion",
    "cylinder",
    "cone",
    "disc",
    "pipe bend",
    "thick pipe",
    "flat grid with holes",
    "folded sheet",
    "steps",
    "voxels",
    "marched plate",
    "thin wall",
    "touching boxes",
    "apart",
];

/// The largest factor of a mean beside that of the cheaper preset.
const MARGIN: f64 = 1.02;
/// Means below this part of the diagonal come from the rounding of coordinates.
const NOTHING: f64 = 1e-6;

const HEADER: [&str; 7] = ["mesh", "faces", "ratio", "preset", "left", "mean", "max"];

/// The result of one preset.
struct Row {
    preset: Preset,
    left: usize,
    /// Mean and largest distance, relative to the diagonal.
    mean: f64,
    max: f64,
}

/// Simplifies all meshes, and prints the violated cells.
pub(crate) fn run(options: &PresetStudy) -> Result<(), Failure> {
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let path = options.out.join("preset-study.csv");
    if path.exists() {
        std::fs::remove_file(&path).map_err(Failure::writing(&path))?;
    }
    let (mut numbers, _) = Numbers::open(path, &HEADER, |_| None::<()>)?;
    let (meshes, sampling) = (meshes(options)?, CompareOptions::default());
    let bar = progress_bar(meshes.len() * options.ratios.len() * options.presets.len());
    let (mut table, mut cells, mut violated) = (Table::new(), 0, 0);
    table.load_preset(comfy_table::presets::UTF8_HORIZONTAL_ONLY);
    table.set_header(["mesh", "faces", "share", "preset", "mean / diagonal", "beside", "ratio"]);
    for (name, mesh) in &meshes {
        let original = Surface::new(mesh).map_err(Failure::mesh)?;
        let faces = mesh.topology().face_count();
        for &ratio in &options.ratios {
            let mut rows: Vec<Row> = Vec::new();
            for &preset in &options.presets {
                bar.set_message(format!("{name} {ratio} {preset}"));
                bar.inc(1);
                if preset == Preset::Extreme
                    && ratio * faces as f64 > options.most_for_extreme as f64
                {
                    continue;
                }
                let row = measure(mesh, &original, (ratio, preset), &sampling)?;
                numbers.add(&row.record(name, faces, ratio))?;
                rows.push(row);
            }
            for pair in rows.windows(2) {
                let [cheap, careful] = pair else { continue };
                cells += 1;
                if careful.is_worse(cheap) {
                    violated += 1;
                    table.add_row([
                        name.clone(),
                        faces.to_string(),
                        format!("{} %", 100.0 * ratio),
                        careful.preset.to_string(),
                        format!("{:.3e}", careful.mean),
                        cheap.preset.to_string(),
                        format!("{:.3}", careful.mean / cheap.mean),
                    ]);
                }
            }
        }
    }
    bar.finish_and_clear();
    println!("{table}\n{violated} of {cells} cells are violated");
    Ok(())
}

/// The models and the parts.
fn meshes(options: &PresetStudy) -> Result<Vec<(String, TriMesh)>, Failure> {
    let mut meshes = Vec::new();
    if let Some(models) = &options.models {
        let names = match &options.meshes[..] {
            [] => JobSet::of_name("usual")?.meshes,
            names => names.to_vec(),
        };
        for name in &names {
            let soup = mesh_io::read(models.join(name)).map_err(Failure::mesh)?.soup;
            let mesh = build(&soup, &Repair::lenient()).map_err(Failure::mesh)?.mesh;
            meshes.push((name.clone(), mesh));
        }
    }
    for number in 0..options.parts {
        let name = PARTS[number % PARTS.len()];
        let seed = options.seed.wrapping_add(number as u64);
        meshes.push((format!("{name} {seed}"), part(name, seed, options.density)?));
    }
    Ok(meshes)
}

/// A generated part.
fn part(name: &str, seed: u64, density: f64) -> Result<TriMesh, Failure> {
    let kind = (0..kinds::count()).find(|&kind| kinds::name(kind) == name);
    let kind = kind.ok_or_else(|| Failure::Usage(format!("there is no kind {name}")))?;
    let soup = kinds::mesh(kind, seed, density);
    Ok(build(&soup, &Repair::lenient()).map_err(Failure::mesh)?.mesh)
}

fn measure(
    mesh: &TriMesh,
    original: &Surface,
    (ratio, preset): (f64, Preset),
    sampling: &CompareOptions,
) -> Result<Row, Failure> {
    let mut options = Options::preset(preset);
    options.target.ratio = Some(ratio);
    let result = simplify(mesh, &options).map_err(Failure::mesh)?.mesh;
    let surface = Surface::new(&result).map_err(Failure::mesh)?;
    let compared = compare(original, &surface, sampling);
    let diagonal = original.bounding_box().diagonal();
    Ok(Row {
        preset,
        left: result.topology().face_count(),
        mean: compared.mean() / diagonal,
        max: compared.hausdorff() / diagonal,
    })
}

impl Row {
    /// Whether the mean is larger than that of a cheaper preset, which has no more faces.
    fn is_worse(&self, cheaper: &Self) -> bool {
        self.mean > MARGIN * cheaper.mean && self.mean > NOTHING && cheaper.left <= self.left + 1
    }

    fn record(&self, name: &str, faces: usize, ratio: f64) -> [String; 7] {
        [
            name.to_owned(),
            faces.to_string(),
            ratio.to_string(),
            self.preset.to_string(),
            self.left.to_string(),
            format!("{:.4e}", self.mean),
            format!("{:.4e}", self.max),
        ]
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    /// For each of these parts, a careful preset alone has a larger mean error than the next cheaper preset.
    const DIFFICULT: [(&str, u64, f64); 9] = [
        ("box", 96, 0.02),
        ("extrusion", 82, 0.1),
        ("cone", 100, 0.3),
        ("disc", 101, 0.02),
        ("pipe bend", 102, 0.1),
        ("thick pipe", 103, 0.1),
        ("flat grid with holes", 88, 0.02),
        ("steps", 106, 0.02),
        ("thin wall", 109, 0.02),
    ];

    #[test]
    fn no_preset_is_worse_than_a_cheaper_one() {
        let presets = [Preset::Fast, Preset::Default, Preset::Quality];
        let sampling = CompareOptions { samples: 50_000, ..CompareOptions::default() };
        for (name, seed, ratio) in DIFFICULT {
            let mesh = part(name, seed, 1.0).unwrap();
            let original = Surface::new(&mesh).unwrap();
            let rows = presets
                .map(|preset| measure(&mesh, &original, (ratio, preset), &sampling).unwrap());
            for pair in rows.windows(2) {
                let [cheap, careful] = [&pair[0], &pair[1]].map(|row| row.record(name, 0, ratio));
                assert!(!pair[1].is_worse(&pair[0]), "{cheap:?} {careful:?}");
            }
        }
    }

    #[test]
    fn all_parts_are_kinds_that_are_there() {
        assert!(PARTS.iter().all(|name| part(name, 1, 1.0).is_ok()));
        assert!(part("teapot", 1, 1.0).is_err());
    }

    #[test]
    fn a_cell_is_judged_by_mean_and_faces() {
        let row = |left, mean| Row { preset: Preset::Fast, left, mean, max: 1.0 };
        let cheap = row(10, 1e-3);
        assert!(row(10, 1.021e-3).is_worse(&cheap) && row(11, 1.021e-3).is_worse(&cheap));
        assert!(!row(10, 1.019e-3).is_worse(&cheap));
        // The cheaper one did not reach the target.
        assert!(!row(8, 2e-3).is_worse(&cheap));
        assert!(!row(10, 0.9e-6).is_worse(&row(10, 1e-9)));
    }
}
