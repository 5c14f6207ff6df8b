//! Kim, Kim, Levin 2002: simplification by a discrete curvature norm.

mod error_curves;
mod head;
mod norm_levels;
mod rotorcraft;
mod single_metrics;
mod thin_parts;
mod visual;

use mesh_core::TriMesh;
use mesh_metric::{CompareOptions, Comparison, Surface, compare};
use simplify::{
    CollapseOptions, FinishOptions, Metric, Options, PlacementRule, Simplified, simplify,
};

use super::Step;
use super::item::{Item, Outcome};
use crate::failure::Failure;

pub(super) const STEPS: [Step; 5] = [
    Step { name: "Fig. 4", compute: norm_levels::compute },
    Step { name: "Sec. 4.2", compute: single_metrics::compute },
    Step { name: "Fig. 5 and 7 (a)", compute: thin_parts::compute },
    Step { name: "Fig. 6", compute: visual::compute },
    Step { name: "Fig. 7 (b)", compute: error_curves::compute },
];

/// The scan of the statue's head that the paper has too.
const IGEA: &str = "igea.ply";
/// The leeway of results of long chains of decisions: rounding may turn one of them, and the rest
/// follows.
const CHAINS: f64 = 0.02;

/// Distance only: the quadrics of the paper's first reference, as published.
fn distance_only() -> Options {
    let collapse = CollapseOptions {
        metric: Metric::Classic,
        curvature_weight: 0.0,
        placement: PlacementRule::Optimal,
        ..CollapseOptions::default()
    };
    Options { collapse, finish: FinishOptions::default(), ..Options::default() }
}

/// The same, raised where a collapse changes the curvature.
fn with_curvature(weight: f64) -> Options {
    let mut options = distance_only();
    options.collapse.curvature_weight = weight;
    options
}

/// The same with the new vertex where the paper puts it.
fn butterfly(mut options: Options) -> Options {
    options.collapse.placement = PlacementRule::Butterfly;
    options
}

fn simplified(mesh: &TriMesh, options: Options, faces: usize) -> Result<Simplified, Failure> {
    simplify(mesh, &options.to_faces(faces)).map_err(Failure::mesh)
}

/// Several face counts from one run: that of the fewest faces, stopped early.
fn levels(mesh: &TriMesh, options: Options, faces: &[usize]) -> Result<Vec<TriMesh>, Failure> {
    let fewest = faces.iter().copied().min().unwrap_or(0);
    let run = simplified(mesh, options, fewest)?;
    let level = |&faces: &usize| {
        let count = run.log.count_for_faces(faces);
        let mut level = run.log.replay(mesh, count).map_err(Failure::mesh)?;
        level.compact();
        Ok(level)
    };
    faces.iter().map(level).collect()
}

/// Results whose mean errors are within this factor are similar; within the other, roughly.
const SIMILAR: f64 = 1.25;
const ROUGHLY: f64 = 2.5;

/// Whether the results of two norms are similar, from the mean errors by L2 over those by L1.
fn add_similarity_claim(item: &mut Item, name: &str, ratios: [f64; 3]) {
    let within = |factor: f64| ratios.iter().all(|r| (1.0 / factor..factor).contains(r));
    let outcome = match (within(SIMILAR), within(ROUGHLY)) {
        (true, _) => Outcome::Holds,
        (false, true) => Outcome::InPart,
        (false, false) => Outcome::Fails,
    };
    let how =
        format!("the mean error by L2 over that by L1 at the three levels is {}", list(ratios));
    item.claim(name, outcome, how);
}

fn list(ratios: [f64; 3]) -> String {
    ratios.map(|ratio| format!("{ratio:.2}")).join(", ")
}

/// An original to measure distances from, as the paper does with Metro.
struct Original {
    surface: Surface,
    diagonal: f64,
    /// How many samples are taken on either surface.
    samples: usize,
}

impl Original {
    fn new(mesh: &TriMesh) -> Result<Self, Failure> {
        Self::with_samples(mesh, 100_000)
    }

    fn with_samples(mesh: &TriMesh, samples: usize) -> Result<Self, Failure> {
        let surface = Surface::new(mesh).map_err(Failure::mesh)?;
        Ok(Self { diagonal: surface.bounding_box().diagonal(), surface, samples })
    }

    /// Both directions, from samples that lie uniformly on either surface.
    fn compare(&self, mesh: &TriMesh) -> Result<Comparison, Failure> {
        self.compare_by(mesh, CompareOptions::default())
    }

    fn compare_by(&self, mesh: &TriMesh, options: CompareOptions) -> Result<Comparison, Failure> {
        let surface = Surface::new(mesh).map_err(Failure::mesh)?;
        let options = CompareOptions { samples: self.samples, ..options };
        Ok(compare(&self.surface, &surface, &options))
    }

    /// The mean distance in percent of the diagonal of the bounding box.
    fn mean_percent(&self, mesh: &TriMesh) -> Result<f64, Failure> {
        // Points on edges and at vertices count for the largest distance only.
        let faces_only = CompareOptions { vertices: false, edges: false, ..Default::default() };
        Ok(self.percent(self.compare_by(mesh, faces_only)?.mean()))
    }

    fn percent(&self, length: f64) -> f64 {
        100.0 * length / self.diagonal
    }
}
