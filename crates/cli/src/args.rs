//! Command-line options of all commands.

use std::num::NonZero;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::time::Duration;

use clap::builder::{PathBufValueParser, TypedValueParser};
use clap::{Args, ValueEnum};
use curvpatch::Params;
use dcurv::VertexArea;
use mesh_core::build::{Repair, Weld};
use mesh_io::Format;
use mesh_work::Length;

/// Options of every command.
#[derive(Debug, Args)]
pub(crate) struct Common {
    /// Print only JSON to stdout: one object, also for an error. Many files give one line per file, and
    /// one for the run
    #[arg(long, global = true)]
    pub(crate) json: bool,
    /// Number of threads [default: one per core]; results do not depend on it
    #[arg(long, global = true, value_name = "N", value_parser = parse_threads)]
    pub(crate) threads: Option<NonZero<usize>>,
    /// Print only errors to stderr, no messages and no progress
    #[arg(long, short, global = true)]
    pub(crate) quiet: bool,
}

/// Reads the name of a page.
pub(crate) fn parse_page() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new()
        .try_map(|path| named_after_content(path, &["html", "htm"], "a page is written as HTML"))
}

/// Reads the name of a picture.
pub(crate) fn parse_picture() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new()
        .try_map(|path| named_after_content(path, &["png", "svg"], "a picture is PNG or SVG"))
}

/// Refuses an extension that says something else than the content; a name may have none.
fn named_after_content(path: PathBuf, extensions: &[&str], what: &str) -> Result<PathBuf, String> {
    let is_one = |extension: &std::ffi::OsStr| {
        extensions.iter().any(|known| extension.eq_ignore_ascii_case(known))
    };
    match path.extension() {
        Some(extension) if !is_one(extension) => {
            let better = path.with_extension(extensions.first().unwrap_or(&""));
            Err(format!("{what}; name it {}", better.display()))
        }
        _ => Ok(path),
    }
}

/// Reads a count within a range, with k or M for thousands or millions.
pub(crate) fn parse_count(text: &str, range: RangeInclusive<usize>) -> Result<usize, String> {
    let (number, unit) = match text.strip_suffix(['k', 'K']) {
        Some(number) => (number, 1e3),
        None => (text.strip_suffix(['m', 'M']).unwrap_or(text), 1e6),
    };
    let count = if number == text {
        text.parse().ok()
    } else {
        // Up to 2^53, every whole number is exact in this type.
        let count = number.parse::<f64>().map(|number| (number * unit).round()).ok();
        count
            .filter(|count| (0.0..=9_007_199_254_740_992.0).contains(count))
            .map(|count| count as usize)
    };
    count.filter(|count| range.contains(count)).ok_or_else(|| {
        let (start, end) = range.into_inner();
        let such = if end < 1_500_000 { "" } else { ", such as 3000, 3k or 1.5M" };
        format!("expected a number from {start} to {end}{such}")
    })
}

/// No mesh has more vertices or faces than this, in memory or on disk.
pub(crate) const MOST_ELEMENTS: usize =
    if cfg!(target_pointer_width = "64") { (1_u64 << 41) as usize } else { usize::MAX };

/// Reads a number of faces or vertices.
pub(crate) fn parse_elements(text: &str) -> Result<usize, String> {
    parse_count(text, 0..=MOST_ELEMENTS)
}

/// Reads a whole number that is no count, such as a seed or the number of a face.
pub(crate) fn parse_whole<T: TryFrom<u64>>(
    text: &str,
    range: RangeInclusive<u64>,
) -> Result<T, String> {
    let number = text.parse::<u64>().ok().filter(|number| range.contains(number));
    let number = number.and_then(|number| T::try_from(number).ok());
    let (start, end) = range.into_inner();
    number.ok_or_else(|| format!("expected a whole number from {start} to {end}"))
}

/// Reads the seed of random numbers.
pub(crate) fn parse_seed(text: &str) -> Result<u64, String> {
    parse_whole(text, 0..=u64::MAX)
}

/// Reads the number of an element, a level or a cell.
pub(crate) fn parse_index<T: TryFrom<u64>>(text: &str) -> Result<T, String> {
    parse_whole(text, 0..=u64::from(u32::MAX))
}

/// More threads take long to start, and only wait for cores.
const MOST_THREADS: usize = 1024;

fn parse_threads(text: &str) -> Result<NonZero<usize>, String> {
    let count = parse_count(text, 1..=MOST_THREADS)?;
    NonZero::new(count).ok_or_else(|| "expected at least one thread".to_owned())
}

/// Whether a path is `-`, the standard input or output.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The area that belongs to a vertex.
#[derive(Clone, Copy, Debug, Default, ValueEnum)]
pub(crate) enum AreaName {
    /// The part of each triangle that is nearer to this vertex than to its other two
    #[default]
    Voronoi,
    /// A third of every triangle
    Barycentric,
}

impl From<AreaName> for VertexArea {
    fn from(name: AreaName) -> Self {
        match name {
            AreaName::Voronoi => Self::Voronoi,
            AreaName::Barycentric => Self::Barycentric,
        }
    }
}

/// How the curvature of faces is computed from normal sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum EstimatorPreset {
    /// As Szilvási-Nagy 2010 prints it
    Paper,
    /// With less error and noise: fitted normals, circles through three points, Euler's formula
    #[default]
    Robust,
}

impl EstimatorPreset {
    pub(crate) fn params(self) -> Params {
        match self {
            Self::Paper => Params::paper(),
            Self::Robust => Params::robust(),
        }
    }
}

/// The heading of [`RepairOptions`].
pub(crate) const REPAIRS: &str = "Repairs (as far as the command needs them, unless --strict)";

/// Which repairs are made. A command that needs an oriented 2-manifold makes one, by repairs that leave no choice.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = REPAIRS)]
pub(crate) struct RepairOptions {
    /// Refuse a mesh that is not an oriented 2-manifold, instead of repairing it
    ///
    /// Without this option, a command that needs an oriented 2-manifold drops degenerate and duplicate triangles and
    /// vertices at infinite or undefined positions, cuts the surface where it is not a manifold, and makes the
    /// orientation of neighbours agree. It says so in one line.
    /// A mesh that needs no repair stays as it is. With this option, only the repairs that are named are made.
    #[arg(long, conflicts_with = "lenient")]
    pub(crate) strict: bool,
    /// Make all repairs below, needed or not, and merge vertices at equal positions
    #[arg(long)]
    pub(crate) lenient: bool,
    /// Merge vertices: `exact` at equal positions, `seams` where open edges lie on each other, a length within that distance
    ///
    /// `none` merges no vertices.
    /// Commands that work on a surface merge them without being asked: `exact` in files that split vertices, such as
    /// glTF, and `seams` in others, where patches may have vertices of their own.
    #[arg(long, value_name = "none|seams|exact|LENGTH")]
    pub(crate) weld: Option<WeldName>,
    /// Drop faces that refer to vertices that do not exist
    #[arg(long)]
    pub(crate) drop_out_of_range: bool,
    /// Drop vertices at infinite or undefined positions, and the faces at them
    #[arg(long)]
    pub(crate) drop_not_finite: bool,
    /// Drop triangles that use a vertex twice
    #[arg(long)]
    pub(crate) drop_degenerate: bool,
    /// Keep only the first of all faces with the same vertices
    #[arg(long)]
    pub(crate) drop_duplicates: bool,
    /// Reverse faces until neighbours agree and components face outward
    ///
    /// The volume of a closed component decides; nested shells alternate between solid and cavity. For an open
    /// component, the side that is visible from outside decides. Sheets for which neither decides stay as they are.
    #[arg(long)]
    pub(crate) reorient: bool,
    /// Cut the surface apart along edges with more than two faces and at pinched vertices
    #[arg(long)]
    pub(crate) cut_non_manifold: bool,
    /// Drop vertices that no face uses
    #[arg(long)]
    pub(crate) drop_unreferenced: bool,
}

impl RepairOptions {
    /// Whether any repair is asked for, or `--strict`.
    pub(crate) fn any(&self) -> bool {
        self.strict || self.repair(Weld::Exact) != Repair::strict()
    }

    /// Whether any repair other than a weld is asked for.
    pub(crate) fn names_some(&self) -> bool {
        Self { weld: None, ..self.clone() }.any()
    }

    /// The repairs. A weld that is given as a length becomes `within`.
    pub(crate) fn repair(&self, within: Weld) -> Repair {
        let mut repair = if self.lenient { all_repairs() } else { Repair::strict() };
        match self.weld {
            None => {}
            Some(WeldName::None) => repair.weld = Weld::None,
            Some(WeldName::Seams) => repair.weld = Weld::Seams,
            Some(WeldName::Exact) => repair.weld = Weld::Exact,
            Some(WeldName::Within(_)) => repair.weld = within,
        }
        repair.drop_out_of_range |= self.drop_out_of_range;
        repair.drop_not_finite |= self.drop_not_finite;
        repair.drop_degenerate |= self.drop_degenerate;
        repair.drop_duplicates |= self.drop_duplicates;
        repair.reorient |= self.reorient;
        repair.cut_non_manifold |= self.cut_non_manifold;
        repair.drop_unreferenced |= self.drop_unreferenced;
        repair
    }
}

/// Every repair.
pub(crate) fn all_repairs() -> Repair {
    let mut all = Repair::lenient();
    all.drop_not_finite = true;
    all
}

/// Which vertices are merged, as it was given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum WeldName {
    None,
    Seams,
    Exact,
    Within(Length),
}

impl FromStr for WeldName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "none" => Ok(Self::None),
            "seams" => Ok(Self::Seams),
            "exact" => Ok(Self::Exact),
            _ => text.parse().map(Self::Within).map_err(|_| {
                "expected `none`, `seams`, `exact` or a distance, like 0.001 or 0.01%".to_owned()
            }),
        }
    }
}

/// Degrees to radians.
pub(crate) fn parse_angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if (0.0..=180.0).contains(&degrees) => Ok(degrees.to_radians()),
        _ => Err("expected an angle from 0 to 180 degrees".into()),
    }
}

/// An angle that all three of a triangle can have, in degrees, to radians.
pub(crate) fn parse_narrow_angle(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(degrees) if degrees > 0.0 && degrees < 60.0 => Ok(degrees.to_radians()),
        _ => Err("expected an angle above 0 and below 60 degrees".into()),
    }
}

/// The longest time limit: 30 years. A clock cannot add any number.
const MOST_SECONDS: f64 = 1e9;

pub(crate) fn parse_seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|seconds| (0.0..=MOST_SECONDS).contains(seconds));
    let duration = seconds.and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    duration.ok_or_else(|| format!("expected a number of seconds from 0 to {MOST_SECONDS}"))
}

/// A number that is finite and not negative.
pub(crate) fn parse_not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value >= 0.0 && value.is_finite() => Ok(value),
        _ => Err("expected a number that is not negative".into()),
    }
}

/// A file format by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum FormatName {
    Obj,
    Ply,
    Stl,
    Off,
    Gltf,
    Glb,
}

impl From<FormatName> for Format {
    fn from(name: FormatName) -> Self {
        match name {
            FormatName::Obj => Self::Obj,
            FormatName::Ply => Self::Ply,
            FormatName::Stl => Self::Stl,
            FormatName::Off => Self::Off,
            FormatName::Gltf => Self::Gltf,
            FormatName::Glb => Self::Glb,
        }
    }
}
