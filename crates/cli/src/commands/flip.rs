//! `curvmesh flip`: edge flips that lower a curvature cost.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::Path;

use dcurv::{CurvatureOptions, Curvatures, VertexArea};
use dtri_flip::{
    Anneal, CostName, FlipError, FlipOptions, FlipReport, Phase, Progress, Rebuild, Rejections,
    ShapeConstraint, Ties,
};
use glam::DVec3;
use indicatif::ProgressBar;
use mesh_core::{TriMesh, VertexId};
use mesh_view::{Lines, Page};
use mesh_work::Seams;
use serde::Serialize;

use crate::args::{AreaName, parse_angle, parse_count, parse_seconds, parse_seed, parse_whole};
use crate::batch::{Job, check_output};
use crate::console::Console;
use crate::counted::counted;
use crate::decimal::Decimal;
use crate::failure::Failure;
use crate::given::Given;
use crate::interrupt::{self, Interruption, KEEP_PARTIAL};
use crate::load::Seconds;
use crate::session::{Outcome, Session};
use crate::task::{Done, Report, Task};
use crate::view::{self, Look, name_of};

/// Optimise the triangulation by edge flips; vertices do not move
///
/// Borders between texture charts, groups and materials are kept. The output has no normals, because
/// flips change them.
///
/// Without -o, only the numbers are printed.
///
///     curvmesh flip rocker-arm.obj -o better.ply --cost f2
///     curvmesh flip part.stl -o part.obj --cost f2 --feature-angle 40
///     curvmesh flip scan.ply -o scan.glb --cost f1 --look-ahead 2 --no-intersections
///     curvmesh flip scan.ply -o lowest.ply --cost f2 --rebuild-effort 10 --time-limit 60
///     curvmesh flip scans/ -o flipped/ --cost f2 --seed 7 --anneal-steps 50
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Flip {
    #[command(flatten)]
    job: Job,
    #[command(flatten)]
    optimise: Optimise,
    #[command(flatten)]
    interruption: Interruption,
    #[command(flatten)]
    look: Look,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Optimisation")]
struct Optimise {
    /// The cost to minimise
    ///
    /// - f1: integral of H²                   - f2: integral of |H|
    /// - f3: integral of |k1| + |k2|          - gauss: sum of |K|
    /// - area: total area                     - delaunay: sum of cotangents of all angles
    /// - willmore: virtual Willmore energy of Brink, Alboul, Rodrigues 2006
    /// - willmore-potential: Willmore energy
    /// - gauss-extrinsic: total absolute extrinsic curvature of Alboul and van Damme
    #[arg(
        long, value_name = "COST", verbatim_doc_comment,
        default_value = "f2", value_parser = |s: &str| s.parse::<CostName>(),
    )]
    cost: CostName,
    /// Area of a vertex, for f1 and f3
    #[arg(long, value_enum, default_value_t)]
    area: AreaName,
    /// Where no single flip lowers the cost, try sequences of up to K flips; at most 6. Each further flip
    /// multiplies the time by about 6
    #[arg(long, value_name = "K", default_value_t = 1, value_parser = |text: &str| parse_count(text, 1..=MAX_LOOK_AHEAD))]
    look_ahead: usize,
    /// Leave local minima by ruin and recreate: remove the vertices of a patch and insert each where it
    /// costs least. Ends when each vertex was removed N times without improvement; 10 is typical
    #[arg(long, value_name = "N", value_parser = |text: &str| parse_count(text, 0..=MOST_TRIES))]
    rebuild_effort: Option<usize>,
    /// Largest number of vertices that --rebuild-effort removes at once
    #[arg(
        long, value_name = "N", default_value_t = Rebuild::default().largest,
        value_parser = |text: &str| parse_count(text, MIN_PATCH..=MOST_LARGEST),
    )]
    rebuild_largest: usize,
    /// Leave local minima by simulated annealing with N trial flips per edge and round; 50 is typical
    #[arg(long, value_name = "N", value_parser = |text: &str| parse_count(text, 0..=MOST_TRIES))]
    anneal_steps: Option<usize>,
    #[arg(long, hide = true, conflicts_with_all = ["anneal_steps", "seed"], value_parser = parse_anneal)]
    anneal: Option<Anneal>,
    /// Keep edges with a larger dihedral angle than this
    #[arg(long, value_name = "DEGREES", value_parser = parse_angle)]
    feature_angle: Option<f64>,
    /// Constraint on the shape of new faces [default: convex for area and delaunay, else keep-shape]
    ///
    /// - unrestricted: as in the papers; faces may fold back and become slivers
    /// - keep-shape: no new face folds back, no new slivers
    /// - convex: as keep-shape, and the two faces of the edge form a convex quadrilateral
    #[arg(
        long, value_name = "CONSTRAINT", verbatim_doc_comment,
        value_parser = |s: &str| s.parse::<ShapeConstraint>(),
    )]
    shape_constraint: Option<ShapeConstraint>,
    /// Reject flips that turn a face by more than this
    #[arg(long, value_name = "DEGREES", value_parser = parse_angle)]
    max_fold: Option<f64>,
    /// Reject flips that would make the surface cross itself
    #[arg(long)]
    no_intersections: bool,
    /// Break ties in a random order instead of by edge number
    #[arg(long)]
    random_ties: bool,
    #[arg(long, hide = true, conflicts_with_all = ["random_ties", "seed"])]
    tie_seed: Option<u64>,
    /// Seed of the random numbers of --rebuild-effort, --anneal-steps and --random-ties
    #[arg(long, value_name = "SEED", default_value_t = 1, value_parser = parse_seed)]
    seed: u64,
    /// Stop after N flips
    #[arg(long, value_name = "N", value_parser = |text: &str| parse_whole::<u64>(text, 0..=u64::MAX))]
    max_flips: Option<u64>,
    /// Stop after this time
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    time_limit: Option<std::time::Duration>,
}

/// All settings of a run, with the defaults of the cost. The map of locked edges is left out.
#[derive(Serialize)]
struct Settings {
    /// Only for costs that divide by areas of vertices.
    #[serde(skip_serializing_if = "Option::is_none")]
    area: Option<VertexArea>,
    #[serde(flatten)]
    options: FlipOptions,
}

#[derive(Serialize)]
struct Results {
    cost: String,
    settings: Settings,
    cost_before: f64,
    cost_after: f64,
    flips: u64,
    /// The volumes of a closed mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    volume_before: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    volume_after: Option<f64>,
    stop: String,
    locked_edges: usize,
    rebuilt: u64,
    rejected: BTreeMap<&'static str, u64>,
}

pub(crate) fn run(options: &Flip, session: &Session) -> Result<Outcome, Failure> {
    options.optimise.check_given(&session.given)?;
    if options.interruption.keep_partial && options.job.output.is_none() {
        session.given.refuse(&[KEEP_PARTIAL], "without -o there is no output file")?;
    }
    check_output(&options.job, &session.given)?;
    options.look.check(&options.job.inputs)?;
    options.job.run(session, &|task, console| one(options, task, console))
}

fn one(options: &Flip, task: &Task, console: &Console) -> Result<Done, Failure> {
    let mut seconds = Seconds::default();
    let mut loaded = task.load(&options.job.loading, &mut seconds, console)?;
    let seams = Seams::find(loaded.mesh.topology(), &loaded.provenance, &loaded.model);
    if seams.count() > 0 {
        console.message(format_args!("{} border edges are kept", seams.count()));
    }
    let before = options.look.is_wanted().then(|| loaded.mesh.clone());
    let volume_before = volume(&loaded.mesh);
    let flip_options = options.optimise.options(&seams);
    let flipped = Seconds::time(&mut seconds.compute, || {
        optimise(&mut loaded.mesh, &options.optimise, &flip_options, console)
    })?;
    if task.output.is_some() {
        let corners = seams.corner_source(loaded.mesh.topology());
        let mut model = loaded.to_model(&corners).map_err(Failure::model)?;
        model.vertex_normals = None;
        model.corner_normals = None;
        task.save(&model, &options.job.save, &mut seconds, console)?;
    }
    let volume_after = volume(&loaded.mesh);
    if let (Some(old), Some(new)) = (volume_before, volume_after)
        && (new - old).abs() > TOLD_CHANGE * old.abs()
    {
        let share = 100.0 * (new - old) / old.abs();
        console.message(format_args!(
            "the flips change the volume by {share:.1} %; --feature-angle 1 keeps the edges that bend, and with them the shape"
        ));
    }
    let volumes = [volume_before, volume_after];
    let results = Results::new(&options.optimise, &flip_options, &flipped, volumes);
    let report = task.report(console, loaded.counts(), results, seconds);
    if let Some(before) = &before {
        options.look.write(page(&task.input, before, &loaded.mesh), &report, console)?;
    }
    let Results { cost, cost_before, cost_after, .. } = &report.results;
    let brief = format!("{cost} {} -> {}", Decimal(*cost_before), Decimal(*cost_after));
    report.done(console, summary(&report), brief)
}

/// A change of the volume above this share is told. On coarse curved surfaces, better edges change it by some per cent.
const TOLD_CHANGE: f64 = 0.05;

/// The volume of a closed mesh.
fn volume(mesh: &TriMesh) -> Option<f64> {
    mesh.topology().is_closed().then(|| mesh.volume())
}

/// A page with both meshes and the edges that differ.
fn page(input: &Path, before: &TriMesh, after: &TriMesh) -> Page {
    let new_edges = |mesh: &TriMesh, other: &TriMesh| -> Vec<[DVec3; 2]> {
        let topology = mesh.topology();
        let is_new = |[a, b]: &[VertexId; 2]| other.topology().find_half_edge(*a, *b).is_none();
        let ends = topology.edges().map(|e| topology.edge_vertices(e)).filter(is_new);
        ends.map(|ends| ends.map(|v| mesh.position(v))).collect()
    };
    let exhibit = |name: &str, mesh: &TriMesh, other: &TriMesh, color: [u8; 3]| {
        let curvatures = Curvatures::of(mesh, &CurvatureOptions::default());
        let mut exhibit = view::mesh(name, mesh)
            .with_vertex_values("mean_curvature", &curvatures.map(|c| c.mean().value()))
            .with_vertex_values("gaussian_curvature", &curvatures.map(|c| c.gaussian().value()));
        view::set_units(&mut exhibit.fields);
        exhibit.lines.push(Lines {
            name: "Flipped edges".into(),
            color,
            width: 2.5,
            segments: new_edges(mesh, other),
            shown: true,
        });
        exhibit
    };
    let exhibits = vec![
        exhibit("before", before, after, [200, 30, 40]),
        exhibit("after", after, before, [0, 120, 60]),
    ];
    let mut page = Page::new(format!("{}: flips", name_of(input)), exhibits);
    page.start.color = Some("plain".into());
    page.start.edges = Some(true);
    page
}

impl Optimise {
    /// Refuses options without effect.
    fn check_given(&self, given: &Given) -> Result<(), Failure> {
        if self.rebuild_effort.is_none() {
            given.refuse(&["rebuild_largest"], "it needs --rebuild-effort")?;
            if self.anneal_steps.is_none() && !self.random_ties {
                let cure = "it needs --rebuild-effort, --anneal-steps or --random-ties";
                given.refuse(&["seed"], cure)?;
            }
        }
        if !self.uses_areas() {
            given.refuse(&["area"], "only the costs f1 and f3 use it")?;
        }
        Ok(())
    }

    /// Whether the cost divides by areas of vertices.
    fn uses_areas(&self) -> bool {
        matches!(self.cost, CostName::F1 | CostName::F3)
    }

    /// The options of the library.
    fn options(&self, seams: &Seams) -> FlipOptions {
        FlipOptions {
            look_ahead: self.look_ahead,
            rebuild: self.rebuilding(),
            anneal: self.annealing(),
            feature_angle: self.feature_angle,
            locked: Some(seams.edges.clone()),
            shape: self.shape_constraint,
            max_fold: self.max_fold,
            forbid_intersections: self.no_intersections,
            ties: self.ties(),
            max_flips: self.max_flips,
            time_limit: self.time_limit,
            ..FlipOptions::default()
        }
    }

    fn settings(&self, options: &FlipOptions) -> Settings {
        Settings {
            area: self.uses_areas().then(|| self.area.into()),
            options: FlipOptions { locked: None, ..self.cost.in_force(options) },
        }
    }

    fn rebuilding(&self) -> Option<Rebuild> {
        let (seed, largest) = (self.seed, self.rebuild_largest);
        self.rebuild_effort.map(|effort| Rebuild { seed, effort, largest })
    }

    fn annealing(&self) -> Option<Anneal> {
        let steps =
            |steps_per_edge| Anneal { seed: self.seed, steps_per_edge, ..Anneal::default() };
        self.anneal.or(self.anneal_steps.map(steps))
    }

    fn ties(&self) -> Ties {
        let seed = self.tie_seed.or(self.random_ties.then_some(self.seed));
        seed.map_or(Ties::EdgeId, Ties::Seeded)
    }
}

fn optimise(
    mesh: &mut TriMesh,
    options: &Optimise,
    flip_options: &FlipOptions,
    console: &Console,
) -> Result<FlipReport, Failure> {
    let bar = console.progress(mesh.topology().edge_count() as u64, "flipping");
    let result =
        options.cost.optimise(mesh, options.area.into(), flip_options, &mut |now| show(&bar, now));
    bar.finish_and_clear();
    result.map_err(|error| match error {
        FlipError::Scale(error) => Failure::refused(error),
        option => Failure::Usage(option.to_string()),
    })
}

/// Shows the completed share of the largest amount of remaining work so far.
fn show(bar: &ProgressBar, now: Progress) -> ControlFlow<()> {
    bar.set_message(match now.phase {
        Phase::Greedy => "flipping",
        Phase::Rebuilding => "rebuilding",
        _ => "annealing",
    });
    let most = bar.length().unwrap_or(0).max(now.remaining);
    bar.set_length(most);
    bar.set_position(most - now.remaining);
    interrupt::flow()
}

impl Results {
    fn new(
        options: &Optimise,
        flip_options: &FlipOptions,
        flipped: &FlipReport,
        [volume_before, volume_after]: [Option<f64>; 2],
    ) -> Self {
        Self {
            cost: options.cost.to_string(),
            settings: options.settings(flip_options),
            cost_before: flipped.cost_before,
            cost_after: flipped.cost_after,
            flips: flipped.flips,
            volume_before,
            volume_after,
            stop: flipped.stop.to_string(),
            locked_edges: flipped.locked_edges,
            rebuilt: flipped.rebuilt,
            rejected: rejected(&flipped.rejected),
        }
    }
}

/// Rejected flips by reason, without zero counts.
fn rejected(rejections: &Rejections) -> BTreeMap<&'static str, u64> {
    rejections.by_reason().into_iter().filter(|&(_, count)| count > 0).collect()
}

fn summary(report: &Report<Results>) -> String {
    let Results { cost, cost_before, cost_after, flips, stop, .. } = &report.results;
    let (file, seconds) = (report.subject(), report.seconds.compute);
    format!(
        "{file}: {cost} {} -> {} with {} in {seconds:.3} s ({stop})",
        Decimal(*cost_before),
        Decimal(*cost_after),
        counted(*flips, "flips")
    )
}

/// Largest look-ahead.
const MAX_LOOK_AHEAD: usize = 6;

/// Smallest patch.
const MIN_PATCH: usize = 3;

/// Larger values are typing errors.
const MOST_LARGEST: usize = 1_000_000;

/// Trials per edge or vertex. Runs with more would take too long.
const MOST_TRIES: usize = 1_000_000;

/// The old spelling `--anneal SEED[,STEPS]`.
fn parse_anneal(text: &str) -> Result<Anneal, String> {
    let usage = || "expected SEED or SEED,STEPS, for example 7 or 7,200".to_owned();
    let (seed, steps) =
        text.split_once(',').map_or((text, None), |(seed, steps)| (seed, Some(steps)));
    let mut anneal = Anneal { seed: seed.parse().map_err(|_| usage())?, ..Anneal::default() };
    if let Some(steps) = steps {
        anneal.steps_per_edge = steps.parse().map_err(|_| usage())?;
    }
    Ok(anneal)
}
