//! Fig. 7 (b): the mean error against the number of faces: the paper's headline claim.

use mesh_core::TriMesh;
use rayon::prelude::*;
use simplify::{Options, Preset};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of};
use super::distances::{NOISE, Original};
use super::head;
use super::runs::{CHAINS, IGEA, butterfly, distance_only, levels, simplified, with_curvature};
use xtask_common::Failure;
use xtask_common::decimals::plain;
use xtask_common::plot::{Axis, Plot, Series};

/// The face counts of the curves, for Igea and for the made head.
const IGEA_FACES: [usize; 4] = [30_000, 10_000, 3_000, 1_000];
const MADE_FACES: [usize; 6] = [10_000, 5_000, 2_000, 1_000, 500, 250];
/// Those at which the weights of the curvature are compared.
const IGEA_WEIGHED: [usize; 3] = [30_000, 3_000, 1_000];
const MADE_WEIGHED: [usize; 3] = [5_000, 1_000, 500];
/// Weights of the curvature that are tried.
const WEIGHTS: [f64; 4] = [0.1, 0.3, 1.0, 3.0];
/// Other programs on Igea: mean distances measured the same way on results that the programs wrote.
const PEERS: [(&str, [(f64, f64); 3]); 3] = [
    ("CGAL, Lindstrom-Turk", [(30_000.0, 0.00401), (3_000.0, 0.02772), (1_000.0, 0.06749)]),
    ("MeshLab, quadrics", [(30_000.0, 0.00581), (3_000.0, 0.04009), (1_000.0, 0.09794)]),
    ("meshoptimizer", [(30_000.0, 0.00913), (3_000.0, 0.06352), (1_000.0, 0.15973)]),
];

pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "The mean distance between original and result, as Metro measures it: both ways, from \
         samples that are uniform by area. The paper's claim is that distance and curvature together \
         give a smaller error than the distance alone. Its curves are printed without numbers. The curvature \
         alone is shown as published and guarded against folds and slivers.",
    );
    item.stand_in("A head of 20,480 faces made of formulas; with models, Igea as in the paper.");
    item.how(
        &["simplify::simplify", "mesh_metric::compare"],
        &[
            "curvmesh simplify IN -o OUT --faces 3000 --preset quadrics",
            "curvmesh simplify IN -o OUT --faces 3000 --preset quadrics --curvature-weight 1",
            "curvmesh simplify IN -o OUT --faces 3000 --preset paper-l1",
            "curvmesh distance IN OUT --samples 100k",
        ],
    );
    let made = mesh_of(&head::head()?)?;
    let curves = Curves::of(&made, &MADE_FACES)?;
    curves.add(item, "made head", &[]);
    let weighed = weights(item, "made head", &made, MADE_WEIGHED)?;
    claim(item, "smaller error", &curves, &weighed);
    if !run.quick
        && let Some(igea) = run.model(item, IGEA)?
    {
        let curves = Curves::of(&igea, &IGEA_FACES)?;
        curves.add(item, "Igea", &PEERS);
        let weighed = weights(item, "Igea", &igea, IGEA_WEIGHED)?;
        claim(item, "smaller error, Igea", &curves, &weighed);
    }
    Ok(())
}

const NAMES: [&str; 7] = [
    "distance only",
    "distance and curvature",
    "distance only, butterfly",
    "distance and curvature, butterfly",
    "curvature only (L1), as published",
    "curvature only (L1), guarded",
    "curvmesh, default",
];

/// Means in percent of the diagonal, by way and face count.
struct Curves {
    faces: Vec<usize>,
    means: Vec<Vec<f64>>,
}

impl Curves {
    fn of(mesh: &TriMesh, faces: &[usize]) -> Result<Self, Failure> {
        let original = Original::new(mesh)?;
        let nested = [
            distance_only(),
            with_curvature(1.0),
            butterfly(distance_only()),
            butterfly(with_curvature(1.0)),
            Options::preset(Preset::PaperL1),
            Options::preset(Preset::PaperL1Guarded),
        ];
        let nested_means = nested.into_par_iter().rev().map(|options| {
            let levels = levels(mesh, options, faces)?;
            levels.iter().map(|level| original.mean_percent(level)).collect()
        });
        let mut means: Vec<Vec<f64>> = nested_means.rev().collect::<Result<_, Failure>>()?;
        // The default fits each result to the original, so that they are not nested.
        let fitted = faces.iter().map(|&faces| {
            let result = simplified(mesh, Options::preset(Preset::Default), faces)?;
            original.mean_percent(&result.mesh)
        });
        means.push(fitted.collect::<Result<_, Failure>>()?);
        Ok(Self { faces: faces.to_vec(), means })
    }

    fn add(&self, item: &mut Item, model: &str, peers: &[(&str, [(f64, f64); 3])]) {
        let mut series = Vec::new();
        let mut lines = Vec::new();
        for (name, means) in NAMES.iter().zip(&self.means) {
            for (faces, &mean) in self.faces.iter().zip(means) {
                item.number_within(format!("{model}, {name}, {faces} faces"), mean, CHAINS);
            }
            let points = self.faces.iter().zip(means).map(|(&f, &m)| [f as f64, m]).collect();
            series.push(Series::new(name, points));
            let cells = means.iter().map(|mean| format!("{mean:.5}"));
            lines.push([(*name).to_owned()].into_iter().chain(cells).collect());
        }
        for (name, points) in peers {
            let points = points.iter().map(|&(f, m)| [f, m]).collect();
            series.push(Series { dashed: true, ..Series::new(name, points) });
        }
        let plot = Plot {
            x: Axis::log("faces"),
            y: Axis::log("mean distance (% of the diagonal of the bounding box)"),
            series,
        };
        let dashed = if peers.is_empty() { "" } else { " Dashed: other programs, run by hand." };
        item.plot(&plot, format!("{model}: mean distance against the number of faces.{dashed}"));
        let counts = self.faces.iter().map(|&f| plain(f as f64));
        let header = ["way".to_owned()].into_iter().chain(counts);
        item.table(
            format!("{model}: mean distance in % of the diagonal, by number of faces."),
            header,
            lines,
        );
    }

    /// The mean of one way over that of another, at every face count.
    fn ratios(&self, way: usize, over: usize) -> Vec<f64> {
        self.means[way].iter().zip(&self.means[over]).map(|(a, b)| a / b).collect()
    }
}

fn claim(item: &mut Item, name: &str, curves: &Curves, weighed: &Weighed) {
    let optimal = curves.ratios(1, 0);
    let butterfly = curves.ratios(3, 2);
    let list = |ratios: &[f64]| {
        let text: Vec<String> =
            ratios.iter().map(|r| format!("{:+.1}", 100.0 * (r - 1.0))).collect();
        text.join(", ")
    };
    item.claim(
        name,
        smaller_error(&optimal, &butterfly),
        format!(
            "with the curvature the mean error changes by {} % (from many faces to few); with the new \
             vertex at the butterfly point for both, by {} %. Over weights of {} to {} and three face \
             counts it changes by {}, and at the butterfly point by {}. By itself the curvature norm as published \
             is {:.0} times worse than the distance at {} faces, guarded {:.0} times",
            list(&optimal),
            list(&butterfly),
            WEIGHTS[0],
            WEIGHTS[WEIGHTS.len() - 1],
            span(&weighed.optimal),
            span(&weighed.butterfly),
            curves.ratios(4, 0)[2],
            plain(curves.faces[2] as f64),
            curves.ratios(5, 0)[2],
        ),
    );
}

/// Whether the geometric mean of the ratios falls by more than noise: at both positions of the new
/// vertex, at one, or at none.
fn smaller_error(optimal: &[f64], butterfly: &[f64]) -> Outcome {
    let gains = |ratios: &[f64]| {
        let logarithms: f64 = ratios.iter().map(|r| r.ln()).sum();
        (logarithms / ratios.len().max(1) as f64).exp() < 1.0 - NOISE
    };
    match (gains(optimal), gains(butterfly)) {
        (true, true) => Outcome::Holds,
        (false, false) => Outcome::Fails,
        _ => Outcome::InPart,
    }
}

/// From the least to the largest change, in words.
fn span(changes: &[f64]) -> String {
    let least = changes.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = changes.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{least:+.1} to {largest:+.1} %")
}

/// By how many percent the mean error changes with the curvature, for all weights and face counts.
struct Weighed {
    optimal: Vec<f64>,
    butterfly: Vec<f64>,
}

/// How the error depends on the weight of the curvature.
fn weights(
    item: &mut Item,
    model: &str,
    mesh: &TriMesh,
    faces: [usize; 3],
) -> Result<Weighed, Failure> {
    let original = Original::new(mesh)?;
    let mut lines = Vec::new();
    let mut changes = |placement: &str, place: fn(Options) -> Options| {
        let weights: Vec<f64> = [0.0].into_iter().chain(WEIGHTS).collect();
        let means_of = |&weight: &f64| -> Result<Vec<f64>, Failure> {
            let levels = levels(mesh, place(with_curvature(weight)), &faces)?;
            levels.iter().map(|level| original.mean_percent(level)).collect()
        };
        let means: Vec<Vec<f64>> = weights.par_iter().map(means_of).collect::<Result<_, _>>()?;
        let mut changes = Vec::new();
        for (i, faces) in faces.iter().enumerate() {
            let without = means[0][i];
            let mut line =
                vec![placement.to_owned(), plain(*faces as f64), format!("{without:.5}")];
            for (weight, means) in weights.iter().zip(&means).skip(1) {
                let quantity =
                    format!("{model}, {placement} placement, weight {weight}, {faces} faces");
                item.number_within(quantity, means[i], CHAINS);
                let change = 100.0 * (means[i] / without - 1.0);
                line.push(format!("{:.5} ({change:+.1} %)", means[i]));
                changes.push(change);
            }
            lines.push(line);
        }
        Ok(changes)
    };
    let optimal = changes("optimal", |options| options)?;
    let butterfly = changes("butterfly", butterfly)?;
    let header = ["placement", "faces", "distance only"].map(str::to_owned);
    item.table(
        format!("{model}: mean distance in %, by the weight of the curvature."),
        header.into_iter().chain(WEIGHTS.map(|weight| format!("weight {weight}"))),
        lines,
    );
    Ok(Weighed { optimal, butterfly })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn larger_errors_turn_the_verdict() {
        let (low, same) = ([0.9, 0.95], [1.0, 0.99]);
        assert_eq!(smaller_error(&low, &low), Outcome::Holds);
        assert_eq!(smaller_error(&low, &same), Outcome::InPart);
        assert_eq!(smaller_error(&same, &same), Outcome::Fails);
    }
}
