//! Command-line options of `simplify` and `lod`, and their conversion to options of the library.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::time::Duration;

use clap::Args;
use indicatif::ProgressBar;
use mesh_core::{Topology, TriMesh};
use mesh_work::{Attributes, Choices, ConstraintChoices, Length, SceneTarget, parse_length};
use serde::Serialize;
use simplify::{
    AttributeOptions, ErrorCheck, FitNorm, Options, Phase, PlacementRule, Preset, Progress,
    Protect, Rejection, Rejections, Shortfall, Simplified, Target,
};

use crate::args::{
    MOST_ELEMENTS, parse_angle, parse_count, parse_elements, parse_narrow_angle,
    parse_not_negative, parse_seconds, parse_seed,
};
use crate::console::Console;
use crate::counted::counted;
use crate::failure::Failure;
use crate::given::Given;
use crate::interrupt;

/// When to stop.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Targets (the first that is reached ends the run)")]
pub(crate) struct Targets {
    /// Stop with this many faces, or one fewer; for example 3000 or 3k
    #[arg(long, value_name = "N", value_parser = parse_elements)]
    faces: Option<usize>,
    /// Stop with this many vertices; for example 1500 or 1.5k
    #[arg(long, value_name = "N", value_parser = parse_elements)]
    vertices: Option<usize>,
    /// Stop at this share of the faces; for example 0.1 or 10% [default: 50% if no target is given]
    #[arg(long, value_name = "R", value_parser = parse_ratio)]
    ratio: Option<f64>,
    /// Find the most faces whose file has at most this size, for example 5MB or 300k. K, M and G are powers of 1000; KiB,
    /// MiB and GiB are powers of 1024. This takes several runs. Companion files, such as pictures, are not counted
    #[arg(long, value_name = "SIZE", value_parser = parse_file_size, conflicts_with_all = ["faces", "vertices", "ratio"])]
    pub(crate) bytes: Option<u64>,
    /// Largest distance between input and result, in both directions. If this is the only target, fast,
    /// default and quality give the same mesh
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    max_error: Option<Length>,
    /// Stop before a collapse that costs more than this, in the unit of the metric
    #[arg(long, value_name = "C", value_parser = parse_not_negative)]
    max_cost: Option<f64>,
    /// Time limit of the collapses in seconds
    #[arg(long, value_name = "SECONDS", alias = "time", value_parser = parse_seconds)]
    time_limit: Option<Duration>,
}

impl Targets {
    /// Whether no target is given. Then half of the faces stay.
    pub(crate) fn is_empty(&self) -> bool {
        let Self { faces, vertices, ratio, bytes, max_error, max_cost, time_limit } = self;
        let counts = faces.is_some() || vertices.is_some() || ratio.is_some() || bytes.is_some();
        !counts && max_error.is_none() && max_cost.is_none() && time_limit.is_none()
    }

    /// Prints the default target if none is given.
    pub(crate) fn explain(&self, console: &Console) {
        if self.is_empty() {
            console.message(format_args!(
                "no target is given: half of the faces stay (--ratio, --faces or --max-error sets another target)"
            ));
        }
    }

    /// The share of the faces to stop at.
    fn ratio(&self) -> Option<f64> {
        self.ratio.or(self.is_empty().then_some(0.5))
    }

    /// The targets for a mesh that is larger than memory.
    pub(crate) fn regional_limits(&self) -> Result<Target, Failure> {
        let Self { faces, vertices, bytes, max_error, max_cost, time_limit, .. } = self;
        let others = [
            (bytes.is_some(), "--bytes"),
            (vertices.is_some(), "--vertices"),
            (max_error.is_some(), "--max-error"),
            (max_cost.is_some(), "--max-cost"),
            (time_limit.is_some(), "--time-limit"),
        ];
        match others.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, name)) => Err(beyond_regions(name)),
            None => Ok(Target { faces: *faces, ratio: self.ratio(), ..Target::default() }),
        }
    }

    /// Whether there is a largest error.
    pub(crate) fn limits_error(&self) -> bool {
        self.max_error.is_some()
    }

    /// The targets for a scene.
    pub(crate) fn of_scene(&self, relative: bool) -> SceneTarget {
        SceneTarget { faces: self.faces, ratio: self.ratio(), max_error: self.max_error, relative }
    }

    /// The targets for a mesh, lengths in its units.
    pub(crate) fn goals(&self, mesh: &TriMesh, relative: bool) -> Result<Goals, Failure> {
        let limits = Target {
            faces: self.faces,
            vertices: self.vertices,
            ratio: self.ratio(),
            cost: self.max_cost,
            collapses: None,
            time: self.time_limit,
        };
        let max_error = self
            .max_error
            .map(|length| length.on(mesh, relative))
            .transpose()
            .map_err(Failure::refused)?;
        Ok(Goals { limits, max_error })
    }
}

/// When to stop, in the units of the mesh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Goals {
    pub(crate) limits: Target,
    pub(crate) max_error: Option<f64>,
}

/// How to simplify.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Simplification")]
pub(crate) struct Policy {
    /// Named set of options; single options below override it
    ///
    /// - draft:         fastest; quadrics without refinement
    /// - fast:          quadrics that keep the volume, without refinement
    /// - default:       quadrics and curvature, then a short fit to the input
    /// - quality:       a long fit, reduction of the largest errors, some redistributed faces
    /// - extreme:       as quality, then simulated annealing; many times slower
    /// - thin-features: as default, with a large weight of curvature, which keeps thin parts
    /// - quadrics:      quadrics of Garland and Heckbert 1997, without refinement
    /// - paper-l1, paper-l2: the curvature norms of Kim, Kim, Levin 2002, as published; faces may fold
    /// - paper-l1-guarded, paper-l2-guarded: the same, but no face folds or becomes a sliver
    #[arg(
        long, value_name = "PRESET", default_value_t, verbatim_doc_comment,
        value_parser = |s: &str| s.parse::<Preset>(),
    )]
    pub(crate) preset: Preset,
    /// Position of the vertex that remains after a collapse [default: as in the preset]
    ///
    /// - optimal-volume:    least cost among the positions that keep the volume
    /// - optimal:           least cost
    /// - endpoint:          the better end, so that the vertices are a subset of the input vertices
    /// - midpoint:          the middle of the edge
    /// - butterfly:         the point of butterfly subdivision
    /// - curvature-optimal: least change of the curvature norm, a slow search; for presets paper-...
    #[arg(
        long, value_name = "PLACEMENT", verbatim_doc_comment,
        value_parser = |s: &str| s.parse::<PlacementRule>(),
    )]
    placement: Option<PlacementRule>,
    /// Weight of the curvature factor, which raises the cost where curvature changes; 0 for none
    /// [default: as in the preset]
    #[arg(long, value_name = "W", value_parser = parse_not_negative)]
    curvature_weight: Option<f64>,
    /// Number of fitting rounds; 0 skips the fit. With 4 or more, one round is left out if at least 20 %
    /// of the faces remain [default: as in the preset]
    #[arg(long, value_name = "N", value_parser = |text: &str| parse_count(text, 0..=MOST_ROUNDS))]
    fit_rounds: Option<usize>,
    /// Error norm that fitting minimises [default: l2]
    ///
    /// - l1:  the mean distance
    /// - l2:  the root mean square distance
    /// - max: the largest distance; the mean rises
    #[arg(long, value_name = "NORM", verbatim_doc_comment, value_parser = |s: &str| s.parse::<FitNorm>())]
    norm: Option<FitNorm>,
    /// Time limit of annealing in seconds (presets quality and extreme)
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    anneal_time: Option<Duration>,
    /// Keep every boundary vertex where it is
    #[arg(long)]
    lock_boundary: bool,
    /// Keep edges with a larger dihedral angle than this as feature lines
    #[arg(long, value_name = "DEGREES", value_parser = parse_angle)]
    feature_angle: Option<f64>,
    /// Reject collapses, moves and flips that would make faces cross that did not cross before
    #[arg(long)]
    no_intersections: bool,
    /// Small components: `free` lets them shrink to nothing, `keep` keeps at least a tetrahedron of each,
    /// and N keeps at least N vertices of each
    #[arg(long, value_name = "free|keep|N", default_value = "free", value_parser = parse_components)]
    components: Components,
    /// Prove the distance from the input, and that it is within --max-error
    #[arg(long)]
    verify: bool,
    /// Seed of the random numbers of fitting
    #[arg(long, value_name = "SEED", default_value_t = 1, value_parser = parse_seed)]
    seed: u64,
}

/// The vertices that every component keeps, if any.
#[derive(Clone, Copy, Debug)]
struct Components(Option<usize>);

impl Policy {
    /// Refuses options without effect.
    pub(crate) fn check_given(&self, given: &Given) -> Result<(), Failure> {
        if !self.choices().fits() {
            given.refuse(&["seed"], "the result is not fitted, so there are no random numbers")?;
            given.refuse(&["norm"], "the result is not fitted: add --fit-rounds")?;
        }
        if !self.choices().anneals() {
            given.refuse(
                &["anneal_time"],
                "the result is not annealed: add --preset quality or extreme",
            )?;
        }
        Ok(())
    }

    /// How distances from the input are measured.
    pub(crate) fn check(&self) -> ErrorCheck {
        self.choices().check()
    }

    /// The options of the library, without a largest error.
    pub(crate) fn options(&self, mesh: &TriMesh, limits: Target) -> Options {
        self.choices().options(mesh, limits)
    }

    /// The options of the library for a mesh that is larger than memory.
    pub(crate) fn regional_options(&self, limits: Target) -> Result<Options, Failure> {
        if self.feature_angle.is_some() {
            return Err(beyond_regions("--feature-angle"));
        }
        if self.lock_boundary {
            return Err(beyond_regions("--lock-boundary"));
        }
        if self.no_intersections {
            return Err(beyond_regions("--no-intersections"));
        }
        if self.components.0.is_some() {
            return Err(beyond_regions("--components"));
        }
        Ok(self.choices().options_without_features(limits))
    }

    /// Whether the distance from the input is to be certified.
    pub(crate) fn proves(&self) -> bool {
        self.verify
    }

    /// Whether faces must not intersect if they did not before.
    pub(crate) fn forbids_intersections(&self) -> bool {
        self.no_intersections
    }

    /// The choices for the library.
    pub(crate) fn choices(&self) -> Choices {
        Choices {
            preset: self.preset,
            placement: self.placement,
            curvature_weight: self.curvature_weight,
            fit_rounds: self.fit_rounds,
            norm: self.norm,
            anneal_time: self.anneal_time,
            lock_boundary: self.lock_boundary,
            feature_angle: self.feature_angle,
            no_intersections: self.no_intersections,
            min_component_vertices: self.components.0,
            verify: self.verify,
            seed: self.seed,
        }
    }
}

/// What the result must keep, and limits on its faces.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Constraints (each can leave more faces than asked for)")]
pub(crate) struct Constraining {
    /// Keep the vertices and faces whose property of this name is not 0: vertices stay where they are,
    /// faces stay with their three corners
    #[arg(long, value_name = "PROPERTY")]
    keep: Option<String>,
    /// Importance of vertices: a property of at least 0, by which costs and errors near a vertex are
    /// multiplied
    #[arg(long, value_name = "PROPERTY")]
    weight: Option<String>,
    /// Make no edge longer than this; edges of the input may stay
    #[arg(long, value_name = "LENGTH", value_parser = parse_length)]
    max_edge: Option<Length>,
    /// Make no face with a smaller angle than this (below 60); faces of the input may stay
    #[arg(long, value_name = "DEGREES", value_parser = parse_narrow_angle)]
    min_angle: Option<f64>,
    /// Give no vertex more edges than this (at least 3), unless a vertex of the input in its place has more
    #[arg(long, value_name = "N", value_parser = |text: &str| parse_count(text, 3..=MOST_ELEMENTS))]
    max_valence: Option<usize>,
}

impl Constraining {
    /// The constraints for lengths of this kind.
    pub(crate) fn choices(&self, relative: bool) -> ConstraintChoices {
        let Self { keep, weight, max_edge, min_angle, max_valence } = self.clone();
        ConstraintChoices { keep, weight, max_edge, min_angle, max_valence, relative }
    }

    /// Refuses constraints on a mesh that is larger than memory.
    pub(crate) fn check_regional(&self) -> Result<(), Failure> {
        let Self { keep, weight, max_edge, min_angle, max_valence } = self;
        let given = [
            (keep.is_some(), "--keep"),
            (weight.is_some(), "--weight"),
            (max_edge.is_some(), "--max-edge"),
            (min_angle.is_some(), "--min-angle"),
            (max_valence.is_some(), "--max-valence"),
        ];
        match given.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, name)) => Err(beyond_regions(name)),
            None => Ok(()),
        }
    }
}

/// The option that causes a rejection; `None` for rules that always hold.
fn cause(rejection: Rejection) -> Option<&'static str> {
    Some(match rejection {
        Rejection::Locked => "locked vertices (--keep, --lock-boundary, meeting points of seams)",
        Rejection::Feature => {
            "seams and feature lines (--keep-seams, --no-attributes, --feature-angle)"
        }
        Rejection::Component => "--components",
        Rejection::Intersection => "--no-intersections",
        Rejection::TextureFold => "folds in the texture (--attribute-weight 0)",
        Rejection::MaxEdge => "--max-edge",
        Rejection::MinAngle => "--min-angle",
        Rejection::MaxValence => "--max-valence",
        _ => return None,
    })
}

/// All settings of a run, with the preset expanded, for reports. Maps over the elements of the mesh are left out.
pub(crate) fn settings(options: &Options) -> Options {
    let Options { target, cost, placement, protect, refine, tolerance, attributes, record } =
        options;
    let &Protect { boundary, min_cosine, min_shape, .. } = protect;
    let &Protect { min_component_vertices, forbid_intersections, limits, .. } = protect;
    Options {
        target: *target,
        cost: *cost,
        placement: *placement,
        protect: Protect {
            boundary,
            min_cosine,
            min_shape,
            min_component_vertices,
            forbid_intersections,
            limits,
            ..Protect::nothing()
        },
        refine: *refine,
        tolerance: *tolerance,
        attributes: AttributeOptions { weight: attributes.weight, ..AttributeOptions::default() },
        record: *record,
    }
}

/// The fields of [`Targets`].
pub(crate) const OF_TARGETS: [&str; 7] =
    ["faces", "vertices", "ratio", "bytes", "max_error", "max_cost", "time_limit"];

/// Each round reads all samples. After a few dozen rounds, nothing moves.
const MOST_ROUNDS: usize = 1000;

/// The options of the steps after the collapses.
pub(crate) const OF_FITS: [&str; 4] = ["fit_rounds", "norm", "anneal_time", "seed"];

/// The reason why levels of detail do not use them.
pub(crate) const NOT_FITTED: &str = "levels are stages of a run, and not fitted";

/// The failure for an option that needs the whole mesh in memory.
fn beyond_regions(option: &str) -> Failure {
    Failure::usage(format!(
        "{option} needs the whole mesh in memory, which --memory does not allow; give more, or leave it out"
    ))
}

/// Shows the progress of the collapses towards their target and the current step after them. Returns whether to
/// continue.
pub(crate) fn show(bar: &ProgressBar, now: &Progress) -> ControlFlow<()> {
    let Progress { faces_before, faces, face_target, .. } = *now;
    if now.phase != Phase::Collapse {
        bar.set_message(now.phase.name());
        return interrupt::flow();
    }
    bar.set_length((faces_before - face_target.min(faces_before)) as u64);
    bar.set_position((faces_before - faces.min(faces_before)) as u64);
    interrupt::flow()
}

/// Refused edges by reason.
pub(crate) fn rejected(refusals: &Rejections) -> BTreeMap<&'static str, usize> {
    refusals.iter().map(|(reason, count)| (reason.name(), count)).collect()
}

/// A share: a number from 0 to 1, or a percentage.
pub(crate) fn parse_ratio(text: &str) -> Result<f64, String> {
    let (number, whole) = match text.strip_suffix('%') {
        Some(number) => (number.trim_end(), 100.0),
        None => (text, 1.0),
    };
    match number.parse::<f64>().map(|number| number / whole) {
        Ok(ratio) if (0.0..=1.0).contains(&ratio) => Ok(ratio),
        _ => Err("expected a number from 0 to 1, or a percentage such as 10%".into()),
    }
}

/// A size of a file, with K, M or G for powers of 1000, and KiB, MiB or GiB for powers of 1024.
fn parse_file_size(text: &str) -> Result<u64, String> {
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[number.len()..].to_ascii_lowercase()[..] {
        "" | "b" => 1.0,
        "k" | "kb" => 1e3,
        "m" | "mb" => 1e6,
        "g" | "gb" => 1e9,
        "kib" => 1024.0,
        "mib" => 1024.0 * 1024.0,
        "gib" => 1024.0 * 1024.0 * 1024.0,
        _ => f64::NAN,
    };
    // Up to 2^53, every whole number is exact in this type.
    match number.trim_end().parse::<f64>().map(|number| (number * unit).floor()) {
        Ok(bytes) if (1.0..=9_007_199_254_740_992.0).contains(&bytes) => Ok(bytes as u64),
        _ => Err("expected a size of a file, such as 5MB, 1.5M, 300k or 2MiB".into()),
    }
}

fn parse_components(text: &str) -> Result<Components, String> {
    match text {
        "free" => Ok(Components(None)),
        "keep" => Ok(Components(Some(4))),
        _ => parse_count(text, 0..=MOST_ELEMENTS)
            .map(|count| Components(Some(count)))
            .map_err(|expected| format!("{expected}, or `free` or `keep`")),
    }
}

/// The options that hold the mesh, with the number of collapses that each rejected.
pub(crate) fn reasons(shortfall: &Shortfall) -> Vec<String> {
    let reasons = shortfall.held_by.iter().filter_map(|&(rejection, count)| {
        cause(rejection).map(|cause| format!("{cause}: {} rejected", counted(count, "collapses")))
    });
    reasons.collect()
}

/// Says which target was not reached, and the options that hold the mesh.
pub(crate) fn tell_shortfall(shortfall: &Shortfall, topology: &Topology, console: &Console) {
    let wanted = match (shortfall.wanted_faces, shortfall.wanted_vertices) {
        (Some(faces), _) => counted(faces, "faces"),
        (None, vertices) => counted(vertices.unwrap_or_default(), "vertices"),
    };
    let reasons = reasons(shortfall);
    let reasons = if reasons.is_empty() {
        "every further collapse would fold the surface or change its topology".to_owned()
    } else {
        format!("{}; relax them for fewer faces", reasons.join("; "))
    };
    console.message(format_args!(
        "the target of {wanted} was not reached, {} left ({reasons})",
        counted(topology.face_count(), "faces")
    ));
}

/// Says how many faces of the result lie upside down on the input.
pub(crate) fn tell_turned_over(result: &Simplified, console: &Console) {
    let left = result.unfold.map_or(0, |unfold| unfold.turned_after);
    if left > 0 {
        let subject = if left == 1 { "face lies" } else { "faces lie" };
        console.message(format_args!(
            "{left} {subject} upside down on the input after refinement; more faces or another --preset may avoid that"
        ));
    }
}

/// Says how much is kept.
pub(crate) fn tell_kept(
    constraints: &ConstraintChoices,
    [vertices, faces]: [usize; 2],
    console: &Console,
) {
    if let Some(name) = &constraints.keep {
        let [vertices, faces] = [counted(vertices, "vertices"), counted(faces, "faces")];
        console.message(format_args!("{name} keeps {vertices} and {faces}"));
    }
}

/// All settings, with the preset expanded.
#[derive(Default, Serialize)]
pub(crate) struct Settings {
    #[serde(flatten)]
    options: Options,
    /// The property of the elements that stay.
    #[serde(skip_serializing_if = "Option::is_none")]
    keep: Option<String>,
    /// The property that holds the importance of vertices.
    #[serde(skip_serializing_if = "Option::is_none")]
    weight: Option<String>,
}

impl Settings {
    /// The settings of a run with these constraints.
    pub(crate) fn new(options: &Options, constraints: ConstraintChoices) -> Self {
        let ConstraintChoices { keep, weight, .. } = constraints;
        Self { options: settings(options), keep, weight }
    }
}

/// A target that was not reached.
#[derive(Serialize)]
pub(crate) struct Unreached {
    #[serde(skip_serializing_if = "Option::is_none")]
    wanted_faces: Option<usize>,
    #[serde(skip_serializing_if = "Option::is_none")]
    wanted_vertices: Option<usize>,
    faces: usize,
    vertices: usize,
    /// The numbers of rejected collapses, by reason.
    held_by: BTreeMap<&'static str, usize>,
}

impl Unreached {
    /// The shortfall of a result.
    pub(crate) fn new(shortfall: &Shortfall, topology: &Topology) -> Self {
        let used = topology.vertices().filter(|&v| !topology.is_isolated_vertex(v));
        Self {
            wanted_faces: shortfall.wanted_faces,
            wanted_vertices: shortfall.wanted_vertices,
            faces: topology.face_count(),
            vertices: used.count(),
            held_by: shortfall.held_by.iter().map(|(r, count)| (r.name(), *count)).collect(),
        }
    }
}

/// The number of charts between seams, before and after some were merged.
#[derive(Clone, Copy, Serialize)]
pub(crate) struct Charts {
    before: usize,
    after: usize,
}

impl Charts {
    /// The charts, if some were merged.
    pub(crate) fn of(attributes: &Attributes) -> Option<Self> {
        attributes.merged().map(|[before, after]| Self { before, after })
    }

    pub(crate) fn tell(self, console: &Console) {
        let Self { before, after } = self;
        console.message(format_args!(
            "charts of textures, materials and labels: {before} -> {after}; the borders of all would need more than a \
             fifth of the wanted faces (--keep-seams keeps them, --no-attributes leaves them out)"
        ));
    }
}
