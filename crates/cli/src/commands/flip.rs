//! `curvmesh flip`: edge flips that lower a curvature cost.

use std::ops::ControlFlow;

use dtri_flip::{Anneal, CostName, FlipOptions, FlipReport, Phase, Progress, Refused, Ties};
use indicatif::ProgressBar;
use mesh_core::TriMesh;
use serde::Serialize;

use crate::args::{AreaName, parse_angle, parse_seconds};
use crate::console::Console;
use crate::failure::Failure;
use crate::job::{Job, Report};
use crate::load::Seconds;
use crate::seams::Seams;

/// Optimise the triangulation by edge flips; the vertices stay where they are
///
/// Borders between texture charts, groups and materials are kept; normals are left out of the
/// output, since flips change them.
///
///     curvmesh flip rocker-arm.obj -o better.ply --cost f2
///     curvmesh flip part.stl -o part.obj --cost f2 --feature-angle 40 --lenient
///     curvmesh flip scan.ply -o scan.glb --cost f1 --look-ahead 2 --no-intersections
#[derive(Debug, clap::Args)]
#[command(verbatim_doc_comment)]
pub(crate) struct Flip {
    #[command(flatten)]
    job: Job,
    #[command(flatten)]
    optimise: Optimise,
}

#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Optimisation")]
struct Optimise {
    /// What to lower: f1, f2, f3, gauss, area, delaunay, willmore or willmore-potential
    #[arg(long, value_name = "COST", value_parser = |s: &str| s.parse::<CostName>())]
    cost: CostName,
    /// The area that belongs to a vertex, for f1 and f3
    #[arg(long, value_enum, default_value_t)]
    area: AreaName,
    /// Where no single flip helps, try up to this many in a row
    #[arg(long, value_name = "K", default_value_t = 1)]
    look_ahead: usize,
    /// Leave the local minimum by simulated annealing; STEPS are tries per edge and round
    #[arg(long, value_name = "SEED[,STEPS]", value_parser = parse_anneal)]
    anneal: Option<Anneal>,
    /// Keep edges whose faces meet at a larger angle than this
    #[arg(long, value_name = "DEGREES", value_parser = parse_angle)]
    feature_angle: Option<f64>,
    /// Refuse flips that turn a face by more than this
    #[arg(long, value_name = "DEGREES", value_parser = parse_angle)]
    max_fold: Option<f64>,
    /// Refuse flips that would make the surface cross itself
    #[arg(long)]
    no_intersections: bool,
    /// Break ties in a random order made from this seed, not by edge number
    #[arg(long, value_name = "SEED")]
    tie_seed: Option<u64>,
    /// Stop after so many flips
    #[arg(long, value_name = "N")]
    max_flips: Option<u64>,
    /// Stop after so many seconds
    #[arg(long, value_name = "SECONDS", value_parser = parse_seconds)]
    time_limit: Option<std::time::Duration>,
}

#[derive(Serialize)]
struct Results {
    cost: String,
    cost_before: f64,
    cost_after: f64,
    flips: u64,
    stop: String,
    locked_edges: usize,
    refused: RefusedCounts,
}

#[derive(Serialize)]
struct RefusedCounts {
    valence_three: u64,
    diagonal_exists: u64,
    fold: u64,
    intersection: u64,
    cycle: u64,
}

pub(crate) fn run(options: &Flip, console: &Console) -> Result<(), Failure> {
    let mut seconds = Seconds::default();
    let mut loaded = options.job.load(&mut seconds, console)?;
    let seams = Seams::find(loaded.mesh.topology(), &loaded.provenance, &loaded.model);
    if seams.count() > 0 {
        console.message(format_args!("{} edges are borders that stay", seams.count()));
    }
    let flipped = Seconds::time(&mut seconds.compute, || {
        optimise(&mut loaded.mesh, &options.optimise, &seams, console)
    })?;
    let corners = seams.corner_source(loaded.mesh.topology());
    let mut model = loaded.to_model(&corners)?;
    model.corner_normals = None;
    model.vertex_normals = None;
    options.job.save(&model, &mut seconds, console)?;
    let results = Results::new(&options.optimise, &flipped);
    let report = Report::new("flip", &options.job.source.input, loaded.counts(), results, seconds)
        .with_output(&options.job.output);
    console.result(&report, summary(&report))
}

fn optimise(
    mesh: &mut TriMesh,
    options: &Optimise,
    seams: &Seams,
    console: &Console,
) -> Result<FlipReport, Failure> {
    let flip_options = FlipOptions {
        look_ahead: options.look_ahead,
        anneal: options.anneal,
        feature_angle: options.feature_angle,
        locked: Some(seams.edges.clone()),
        max_fold: options.max_fold,
        forbid_intersections: options.no_intersections,
        ties: options.tie_seed.map_or(Ties::EdgeId, Ties::Seeded),
        max_flips: options.max_flips,
        time_limit: options.time_limit,
        ..FlipOptions::default()
    };
    let bar = console.progress(mesh.topology().edge_count() as u64, "flipping");
    let result =
        options.cost.optimise(mesh, options.area.into(), &flip_options, &mut |now| show(&bar, now));
    bar.finish_and_clear();
    result.map_err(|error| Failure::Usage(error.to_string()))
}

/// What is left to do shrinks; the bar shows what is done of the most there ever was.
fn show(bar: &ProgressBar, now: Progress) -> ControlFlow<()> {
    bar.set_message(match now.phase {
        Phase::Greedy => "flipping",
        _ => "annealing",
    });
    let most = bar.length().unwrap_or(0).max(now.waiting);
    bar.set_length(most);
    bar.set_position(most - now.waiting);
    ControlFlow::Continue(())
}

impl Results {
    fn new(options: &Optimise, flipped: &FlipReport) -> Self {
        let Refused { valence_three, diagonal_exists, fold, intersection, cycle, .. } =
            flipped.refused;
        Self {
            cost: options.cost.to_string(),
            cost_before: flipped.cost_before,
            cost_after: flipped.cost_after,
            flips: flipped.flips,
            stop: flipped.stop.to_string(),
            locked_edges: flipped.locked_edges,
            refused: RefusedCounts { valence_three, diagonal_exists, fold, intersection, cycle },
        }
    }
}

fn summary(report: &Report<Results>) -> String {
    let Results { cost, cost_before, cost_after, flips, stop, .. } = &report.results;
    let (file, seconds) = (report.subject(), report.seconds.compute);
    format!(
        "{file}: {cost} {cost_before:.6} -> {cost_after:.6} with {flips} flips in {seconds:.3} s ({stop})"
    )
}

fn parse_anneal(text: &str) -> Result<Anneal, String> {
    let usage = || "expected a seed, or a seed and tries per edge, like 7 or 7,200".to_owned();
    let (seed, steps) =
        text.split_once(',').map_or((text, None), |(seed, steps)| (seed, Some(steps)));
    let mut anneal = Anneal { seed: seed.parse().map_err(|_| usage())?, ..Anneal::default() };
    if let Some(steps) = steps {
        anneal.steps_per_edge = steps.parse().map_err(|_| usage())?;
    }
    Ok(anneal)
}
