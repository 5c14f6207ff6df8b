//! Sec. 4: many tori, with other radii and numbers of points than in Table 1.

use dcurv::VertexArea;
use dtri_flip::{CostName, FlipOptions, lattice_error};
use mesh_core::TriMesh;
use mesh_shapes::{SignedDistance, Torus};
use rayon::prelude::*;

use super::super::flips::optimise;
use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::{Run, mesh_of};
use super::torus::{errors_fall, norms};
use xtask_common::Failure;

/// Points along and around, and the two radii; the first torus is that of Table 1.
const TORI: [(usize, usize, f64, f64); 10] = [
    (12, 6, 5.0, 2.0),
    (16, 6, 5.0, 2.0),
    (12, 8, 5.0, 2.0),
    (20, 10, 5.0, 2.0),
    (24, 12, 5.0, 2.0),
    (12, 6, 5.0, 1.0),
    (16, 8, 5.0, 3.0),
    (18, 6, 8.0, 2.0),
    (24, 8, 8.0, 2.0),
    (30, 12, 10.0, 3.0),
];
const COSTS: [CostName; 3] = [CostName::F1, CostName::F2, CostName::F3];
/// Lattice steps on a side of a triangle.
const SUBDIVISIONS: u32 = 20;

/// The errors of one torus: initial, and after minimising each cost.
type Errors = [[f64; 3]; 4];

pub(super) fn compute(_: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Ten tori, triangulated as in the paper, and their distance from the surface before and after minimising \
         each cost. Areas are Voronoi areas, ties are broken by edge number. A torus counts if all nine \
         errors fall by at least a tenth and no result is best in all three norms.",
    );
    item.how(
        &["dtri_flip::optimise", "dtri_flip::lattice_error"],
        &["curvmesh flip IN -o OUT --cost f1 --shape-constraint unrestricted"],
    );
    let errors: Vec<Errors> = TORI.par_iter().map(errors_of).collect::<Result<_, _>>()?;
    let mut lines = Vec::new();
    let mut outcomes = Vec::new();
    for ((m, n, major, minor), [initial, results @ ..]) in TORI.iter().zip(&errors) {
        let name = format!("{m} x {n}, R = {major}, r = {minor}");
        let mut line = vec![name];
        line.extend(initial.map(|error| format!("{error:.4}")));
        for row in results {
            line.push(
                row.iter()
                    .zip(initial)
                    .map(|(a, b)| format!("{:.2}", a / b))
                    .collect::<Vec<_>>()
                    .join(" "),
            );
        }
        let outcome = errors_fall(*initial, *results);
        line.push(outcome.to_string());
        lines.push(line);
        outcomes.push(outcome);
    }
    let count = |wanted| outcomes.iter().filter(|outcome| **outcome == wanted).count();
    item.claim(
        "many tori",
        together(&outcomes),
        format!(
            "of ten tori the claim holds on {}; on {} all errors fall and one result is best in every norm; on {} \
             an error falls by less than a tenth or rises",
            count(Outcome::Holds),
            count(Outcome::InPart),
            count(Outcome::Fails)
        ),
    );
    item.table(
        "Distances to the torus in units of the model; for each cost, L1, L2 and Linf over the initial ones.",
        ["torus", "L1", "L2", "Linf", "F1", "F2", "F3", "claim"],
        lines,
    );
    Ok(())
}

fn errors_of(&(m, n, major, minor): &(usize, usize, f64, f64)) -> Result<Errors, Failure> {
    let torus = Torus { major, minor };
    let initial = mesh_of(&torus.shifted_mesh(m, n).map_err(Failure::mesh)?)?;
    let error = |mesh: &TriMesh| {
        norms(&lattice_error(mesh, SUBDIVISIONS, |p| torus.signed_distance(p)))
            .map(|(_, value)| value)
    };
    let mut errors = [error(&initial); 4];
    for (cost, errors) in COSTS.iter().zip(&mut errors[1..]) {
        let mut mesh = initial.clone();
        optimise(&mut mesh, *cost, VertexArea::Voronoi, &FlipOptions::default())?;
        *errors = error(&mesh);
    }
    Ok(errors)
}

/// The outcome over all tori: it holds if it holds on each, and fails if it fails on each.
fn together(outcomes: &[Outcome]) -> Outcome {
    let all = |wanted| outcomes.iter().all(|outcome| *outcome == wanted);
    match (all(Outcome::Holds), all(Outcome::Fails)) {
        (true, _) => Outcome::Holds,
        (_, true) => Outcome::Fails,
        _ => Outcome::InPart,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_torus_on_which_it_fails_turns_the_verdict() {
        assert_eq!(together(&[Outcome::Holds; 10]), Outcome::Holds);
        assert_eq!(together(&[Outcome::Holds, Outcome::Fails]), Outcome::InPart);
        assert_eq!(together(&[Outcome::Fails; 10]), Outcome::Fails);
    }
}
