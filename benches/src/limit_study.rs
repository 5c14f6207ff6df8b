//! `cargo run --release -p benches -- limit-study`: how far simplified meshes are from the best possible ones.
//!
//! For smooth surfaces the least distance that n triangles can have is known to first order; see `bound`. Fine meshes
//! of surfaces with known distances are simplified by the presets, and by other programs if given. The distances of the
//! results from the exact surface are measured.

mod bound;
mod measure;
mod surfaces;

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use mesh_core::{Repair, TriMesh, build};
use mesh_metric::Surface;
use simplify::{FitNorm, Options, Preset, RefineOptions, simplify};

pub use bound::{Distances, of_one_triangle};
pub use measure::distances;
pub use surfaces::{Fineness, Shape};
use xtask_common::plot::{Axis, Plot, Series};
use xtask_common::progress_bar;
use xtask_common::{Failure, Numbers};

/// What to simplify, and how.
#[derive(Debug, clap::Args)]
pub struct LimitStudy {
    /// Which surfaces; all of them by default
    #[arg(long, value_name = "SURFACE", value_delimiter = ',')]
    surfaces: Vec<Shape>,
    /// To how many faces
    #[arg(long, value_name = "N", value_delimiter = ',', default_value = "500,2000,8000")]
    faces: Vec<usize>,
    /// Which presets
    #[arg(
        long, value_name = "PRESET", value_delimiter = ',',
        default_value = "fast,default,quality,extreme",
        value_parser = |s: &str| s.parse::<Preset>(),
    )]
    presets: Vec<Preset>,
    /// What the presets make small that fit the result
    #[arg(
        long, value_name = "NORM", value_delimiter = ',', default_value = "l2",
        value_parser = parse_norm,
    )]
    norms: Vec<FitNorm>,
    /// Where the random numbers of the fit start: a row for each
    #[arg(long, value_name = "SEED", value_delimiter = ',')]
    seeds: Vec<u64>,
    /// Other programs, each as NAME=COMMAND: {in} and {out} in the command are PLY files, {faces} the
    /// number of faces. Given again for each
    #[arg(long, value_name = "NAME=COMMAND", value_parser = Peer::parse)]
    peer: Vec<Peer>,
    /// Coarser meshes to begin with, 500 faces and fewer samples only
    #[arg(long, conflicts_with = "faces")]
    quick: bool,
    /// The folder for the table (limit-study.txt), the plots (limit-study-SURFACE.svg) and the numbers
    /// (limit-study.csv). What is in the numbers already is not computed again
    #[arg(long, value_name = "DIR", default_value = "target/limit-study")]
    out: PathBuf,
}

fn parse_norm(text: &str) -> Result<FitNorm, String> {
    let found = FitNorm::ALL.iter().find(|norm| norm.name() == text);
    found.copied().ok_or_else(|| "expected l1, l2 or max".into())
}

/// The options with another seed.
fn seeded(mut options: Options, seed: u64) -> Options {
    options.refine.seed = seed;
    options.refine.tuning.max_error.fit.seed = seed;
    options
}

/// Another program.
#[derive(Clone, Debug)]
struct Peer {
    name: String,
    command: Vec<String>,
}

impl Peer {
    fn parse(text: &str) -> Result<Self, String> {
        let (name, command) = text.split_once('=').ok_or("expected NAME=COMMAND")?;
        let command: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
        let has = |what: &str| command.iter().any(|word| word.contains(what));
        match (name.is_empty(), command.is_empty()) {
            (false, false) if has("{in}") && has("{out}") && has("{faces}") => {
                Ok(Self { name: name.to_owned(), command })
            }
            _ => Err("expected NAME=COMMAND with {in}, {out} and {faces} in the command".into()),
        }
    }

    /// Runs the program on a mesh.
    fn simplify(&self, mesh: &TriMesh, faces: usize, folder: &Path) -> Result<TriMesh, Failure> {
        let (input, output) = (folder.join("peer-in.ply"), folder.join("peer-out.ply"));
        mesh_io::write(&input, mesh, &mesh_io::WriteOptions::default()).map_err(Failure::mesh)?;
        let fill = |word: &String| {
            word.replace("{in}", &input.to_string_lossy())
                .replace("{out}", &output.to_string_lossy())
                .replace("{faces}", &faces.to_string())
        };
        let words: Vec<String> = self.command.iter().map(fill).collect();
        let (program, arguments) = words.split_first().map_or(("", &[][..]), |(p, a)| (p, a));
        let status = Command::new(program).args(arguments).status();
        match status {
            Ok(status) if status.success() => {}
            Ok(status) => return Err(Failure::Usage(format!("{}: {status}", self.name))),
            Err(error) => return Err(Failure::Usage(format!("{}: {error}", self.name))),
        }
        let model = mesh_io::read(&output).map_err(Failure::mesh)?;
        Ok(build(&model.soup, &Repair::lenient()).map_err(Failure::mesh)?.mesh)
    }
}

const HEADER: [&str; 8] =
    ["surface", "faces", "program", "faces_left", "mean_n", "rms_n", "max_n", "seconds"];

/// One line of the study.
#[derive(Clone, Debug)]
pub struct Row {
    surface: String,
    faces: usize,
    /// The preset or other program.
    pub program: String,
    /// Faces of the result.
    pub left: usize,
    /// Distances times faces.
    pub scaled: Distances,
    seconds: f64,
}

/// Runs the rows that are missing in the file of numbers, prints the table and draws the plots.
pub fn run(options: &LimitStudy) -> Result<(), Failure> {
    std::fs::create_dir_all(&options.out).map_err(Failure::writing(&options.out))?;
    let path = options.out.join("limit-study.csv");
    let (mut numbers, mut rows) = Numbers::open(path, &HEADER, Row::parse)?;
    let known: HashSet<_> = rows.iter().map(Row::key).collect();
    let bar = progress_bar(options.runs());
    let mut limits = Vec::new();
    for &shape in options.surfaces() {
        let mut mesh = shape.mesh(options.fineness())?;
        measure::balance(shape, &mut mesh);
        let fine = Surface::new(&mesh).map_err(Failure::mesh)?;
        limits.push((shape, of_one_triangle(shape, &mesh)));
        for &faces in options.faces() {
            for program in options.programs() {
                bar.set_message(format!("{shape} {faces} {}", program.name()));
                if !known.contains(&(shape.name().into(), faces, program.name().into())) {
                    let start = Instant::now();
                    let simplified = program.simplify(&mesh, faces, &options.out)?;
                    let seconds = start.elapsed().as_secs_f64();
                    let row =
                        Row::of(shape, faces, &program, &fine, (&simplified, seconds), options)?;
                    numbers.add(&row.record())?;
                    rows.push(row);
                }
                bar.inc(1);
            }
        }
    }
    bar.finish_and_clear();
    for (shape, limit) in &limits {
        let path = options.out.join(format!("limit-study-{}.svg", shape.name().replace(' ', "-")));
        let svg = plot(*shape, *limit, &options.points(*shape, &rows)).file();
        std::fs::write(&path, svg).map_err(Failure::writing(&path))?;
    }
    let text = table(options, &limits, &rows);
    let path = options.out.join("limit-study.txt");
    std::fs::write(&path, &text).map_err(Failure::writing(&path))?;
    print!("{text}");
    Ok(())
}

/// A preset or another program.
#[derive(Clone, Debug)]
enum Program {
    /// A preset by its name, with the norm if that is not the default.
    Preset(String, Box<Options>),
    Peer(Peer),
}

impl Program {
    fn name(&self) -> &str {
        match self {
            Self::Preset(name, _) => name,
            Self::Peer(peer) => &peer.name,
        }
    }

    fn simplify(&self, mesh: &TriMesh, faces: usize, folder: &Path) -> Result<TriMesh, Failure> {
        match self {
            Self::Preset(_, options) => {
                let options = options.as_ref().clone().to_faces(faces);
                Ok(simplify(mesh, &options).map_err(Failure::mesh)?.mesh)
            }
            Self::Peer(peer) => peer.simplify(mesh, faces, folder),
        }
    }
}

impl LimitStudy {
    fn surfaces(&self) -> &[Shape] {
        if self.surfaces.is_empty() { clap::ValueEnum::value_variants() } else { &self.surfaces }
    }

    fn faces(&self) -> &[usize] {
        if self.quick { &[500] } else { &self.faces }
    }

    fn fineness(&self) -> Fineness {
        if self.quick { Fineness::Quick } else { Fineness::Full }
    }

    fn samples(&self) -> usize {
        if self.quick { measure::SAMPLES / 4 } else { measure::SAMPLES }
    }

    fn programs(&self) -> Vec<Program> {
        let with = |preset: Preset| {
            let options = Options::preset(preset);
            let norms = if options.refine.fit { &self.norms[..] } else { &[FitNorm::L2] };
            norms.iter().map(move |&norm| {
                let name = match norm {
                    FitNorm::L2 => preset.name().to_owned(),
                    other => format!("{preset} {}", other.name()),
                };
                let refine = RefineOptions { norm, ..options.refine };
                (name, Options { refine, ..options.clone() })
            })
        };
        let presets = self.presets.iter().flat_map(|&preset| with(preset));
        let seeded = presets.flat_map(|(name, options)| {
            if self.seeds.is_empty() {
                return vec![Program::Preset(name, Box::new(options))];
            }
            let seeds = self.seeds.iter().map(|&seed| {
                let name = format!("{name}, seed {seed}");
                Program::Preset(name, Box::new(seeded(options.clone(), seed)))
            });
            seeds.collect()
        });
        seeded.chain(self.peer.iter().cloned().map(Program::Peer)).collect()
    }

    fn runs(&self) -> usize {
        self.surfaces().len() * self.faces().len() * self.programs().len()
    }

    /// Per program, pairs of the number of faces and the mean distance times faces.
    fn points(&self, shape: Shape, rows: &[Row]) -> Vec<(String, Vec<[f64; 2]>)> {
        let of_program = |program: Program| {
            let of_row = |row: &&Row| row.surface == shape.name() && row.program == program.name();
            let point = |row: &Row| [row.left as f64, row.scaled.mean];
            (program.name().to_owned(), rows.iter().filter(of_row).map(point).collect())
        };
        self.programs().into_iter().map(of_program).collect()
    }
}

/// Mean distance times number of faces against the number of faces, with the limit as a line.
pub fn plot(shape: Shape, limit: Distances, points: &[(String, Vec<[f64; 2]>)]) -> Plot {
    let mut series: Vec<Series> =
        points.iter().map(|(name, points)| Series::new(name, points.clone())).collect();
    let all = || points.iter().flat_map(|(_, points)| points).map(|point| point[0]);
    let ends = [all().fold(f64::MAX, f64::min), all().fold(0.0, f64::max)];
    if shape.has_limit() && ends[0] <= ends[1] {
        let line = ends.map(|faces| [faces, limit.mean]).to_vec();
        series.push(Series { dashed: true, ..Series::new("limit", line) });
    }
    Plot { x: Axis::log("faces"), y: Axis::linear("mean distance x faces"), series }
}

impl Row {
    fn of(
        shape: Shape,
        faces: usize,
        program: &Program,
        fine: &Surface,
        (mesh, seconds): (&TriMesh, f64),
        options: &LimitStudy,
    ) -> Result<Self, Failure> {
        let left = mesh.topology().face_count();
        let Distances { mean, rms, max } = distances(shape, fine, mesh, options.samples())?;
        let n = left as f64;
        let scaled = Distances { mean: n * mean, rms: n * rms, max: n * max };
        let (surface, program) = (shape.name().to_owned(), program.name().to_owned());
        Ok(Self { surface, faces, program, left, scaled, seconds })
    }

    /// The rows in a file of numbers.
    pub fn all_of(text: &str) -> Vec<Self> {
        let mut reader = csv::Reader::from_reader(text.as_bytes());
        reader.records().filter_map(|record| Self::parse(&record.ok()?)).collect()
    }

    /// Whether the row is of this surface.
    #[must_use]
    pub fn is_of(&self, shape: Shape) -> bool {
        self.surface == shape.name()
    }

    fn key(&self) -> (String, usize, String) {
        (self.surface.clone(), self.faces, self.program.clone())
    }

    fn record(&self) -> [String; 8] {
        [
            self.surface.clone(),
            self.faces.to_string(),
            self.program.clone(),
            self.left.to_string(),
            format!("{:.6}", self.scaled.mean),
            format!("{:.6}", self.scaled.rms),
            format!("{:.6}", self.scaled.max),
            format!("{:.1}", self.seconds),
        ]
    }

    fn parse(record: &csv::StringRecord) -> Option<Self> {
        let number = |i: usize| record.get(i)?.parse::<f64>().ok();
        Some(Self {
            surface: record.get(0)?.to_owned(),
            faces: record.get(1)?.parse().ok()?,
            program: record.get(2)?.to_owned(),
            left: record.get(3)?.parse().ok()?,
            scaled: Distances { mean: number(4)?, rms: number(5)?, max: number(6)? },
            seconds: number(7)?,
        })
    }
}

/// A line per surface and number of faces: the ratios of mean, root mean square and largest distance to their limits;
/// without a limit, to the distances of the first program.
fn table(options: &LimitStudy, limits: &[(Shape, Distances)], rows: &[Row]) -> String {
    let mut table = comfy_table::Table::new();
    table.load_preset(comfy_table::presets::UTF8_HORIZONTAL_ONLY);
    let programs = options.programs();
    let names = programs.iter().map(|program| program.name().to_owned());
    table.set_header(["surface", "faces"].map(str::to_owned).into_iter().chain(names));
    for (shape, limit) in limits {
        for &faces in options.faces() {
            let find = |program: &Program| {
                let key = (shape.name().to_owned(), faces, program.name().to_owned());
                rows.iter().find(|row| row.key() == key)
            };
            let first = programs.first().and_then(find).map(|row| row.scaled);
            let Some(unit) = (if shape.has_limit() { Some(*limit) } else { first }) else {
                continue;
            };
            let mut line = vec![shape.name().to_owned(), faces.to_string()];
            line.extend(programs.iter().map(|program| {
                find(program).map_or_else(String::new, |row| {
                    let Distances { mean, rms, max } = row.scaled.over(unit);
                    format!("{mean:.3} {rms:.3} {max:.2} ({:.1} s)", row.seconds)
                })
            }));
            table.add_row(line);
        }
    }
    format!(
        "Mean, root mean square and largest distance from the surface over the least possible ones for \
         as many triangles (time).\nOn the rounded plate, which is flat or cylindrical almost everywhere, \
         the limit says nothing: there over those of the first program.\n{table}\n"
    )
}

#[cfg(test)]
mod tests {
    use super::{Distances, Fineness, Peer, Row, Shape, distances, of_one_triangle};
    use mesh_metric::Surface;
    use simplify::{Options, Preset, simplify};

    #[test]
    fn rows_survive_the_way_through_the_file() {
        let row = Row {
            surface: "saddle patch".into(),
            faces: 500,
            program: "other, with a comma".into(),
            left: 499,
            scaled: Distances { mean: 0.75, rms: 1.0, max: 2.5 },
            seconds: 1.5,
        };
        let record = csv::StringRecord::from(row.record().to_vec());
        assert_eq!(Row::parse(&record).unwrap().record(), row.record());
    }

    #[test]
    fn a_peer_needs_a_name_and_three_places() {
        assert_eq!(Peer::parse("a=b {in} {out} --to={faces}").unwrap().command.len(), 4);
        for wrong in ["", "a", "a=b", "a=b {in} {out}", "=b {in} {out} {faces}"] {
            assert!(Peer::parse(wrong).is_err(), "{wrong}");
        }
    }

    /// Nothing is below the limit, and the default is near it.
    #[test]
    fn the_default_is_above_the_limit_and_near_it() {
        for shape in [Shape::Sphere, Shape::Torus] {
            let mesh = shape.mesh(Fineness::Quick).unwrap();
            let fine = Surface::new(&mesh).unwrap();
            let limit = of_one_triangle(shape, &mesh);
            let options = Options::preset(Preset::Default).to_faces(500);
            let result = simplify(&mesh, &options).unwrap().mesh;
            let found = distances(shape, &fine, &result, 50_000).unwrap();
            let n = result.topology().face_count() as f64;
            let scaled = Distances { mean: n * found.mean, rms: n * found.rms, max: n * found.max };
            let ratio = scaled.over(limit);
            assert!((1.0..1.4).contains(&ratio.mean), "{shape} {ratio:?}");
            assert!((1.0..1.4).contains(&ratio.rms), "{shape} {ratio:?}");
            assert!((1.0..4.5).contains(&ratio.max), "{shape} {ratio:?}");
        }
    }
}
