//! Fig. 6: butterfly subdivision of the initial and of the optimised torus.

use mesh_core::butterfly::{ButterflyOptions, subdivide};

use super::super::item::Item;
use super::super::outcome::Outcome;
use super::super::run::Run;
use super::torus::{SETTINGS, TORUS, distance_to_torus, norms, optimised, torus_view};
use mesh_render::Style;
use xtask_common::Failure;

/// The subdivision steps of the figure.
const STEPS: u32 = 3;
/// Lattice steps on a side of a triangle of the subdivided mesh. The coarse mesh gets as many per
/// length, 2^[`STEPS`] times this.
const SUBDIVISIONS: u32 = 4;

/// Significantly better: the mean distance falls by at least a tenth.
fn better(initial: f64, optimised: f64) -> Outcome {
    Outcome::of(optimised < 0.9 * initial)
}

/// The distance to the torus before and after subdivision, without and with optimisation.
pub(super) fn compute(run: &Run<'_>, item: &mut Item) -> Result<(), Failure> {
    item.about(
        "Three butterfly steps from the torus as given and as optimised by F1, and the distance to \
         the torus before and after, at lattice points that are equally dense on all four meshes. \
         The paper shows pictures only.",
    );
    item.how(
        &["dtri_flip::optimise", "mesh_core::butterfly::subdivide"],
        &["curvmesh flip IN -o OUT --cost f1 --shape-constraint unrestricted"],
    );
    item.number("subdivision steps", f64::from(STEPS));
    let mut figures = Vec::new();
    let mut lines = Vec::new();
    let mut means = Vec::new();
    for setting in SETTINGS.iter().filter(|setting| ["initial", "F1"].contains(&setting.row)) {
        let coarse = optimised(&TORUS, setting)?;
        let options = ButterflyOptions::default();
        let fine = subdivide(&coarse, STEPS, &options).map_err(Failure::mesh)?.mesh;
        let before = distance_to_torus(&coarse, SUBDIVISIONS << STEPS);
        let after = distance_to_torus(&fine, SUBDIVISIONS);
        means.push(after.mean);
        for (when, error) in [("before", before), ("after", after)] {
            let mut line = vec![setting.row.to_owned(), format!("{when} subdivision")];
            for (norm, value) in norms(&error) {
                item.number(format!("{}, {when} subdivision, {norm}", setting.row), value);
                line.push(format!("{value:.6}"));
            }
            lines.push(line);
        }
        let style = Style { size: [720, 600], smooth: true, ..Style::DEFAULT };
        let name = format!("dhkl01-subdivided-{}", setting.row.to_lowercase());
        let caption = format!("{}, after three butterfly steps", setting.how);
        figures.push(run.picture(&fine, &torus_view(&coarse)?, &style, &name, &caption)?);
    }
    if let [initial, optimised] = means[..] {
        item.claim(
            "better limit surface",
            better(initial, optimised),
            format!(
                "the mean distance of the subdivided surface falls from {initial:.4} to \
                 {optimised:.4}, by {:.0} %",
                100.0 * (1.0 - optimised / initial)
            ),
        );
    }
    let header = ["mesh", "", "L1", "L2", "Linf"];
    item.table("Distance to the torus, in units of the model.", header, lines);
    item.side_by_side(figures);
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_that_is_no_nearer_turns_the_verdict() {
        assert_eq!(better(0.2, 0.1), Outcome::Holds);
        assert_eq!(better(0.1, 0.2), Outcome::Fails);
        assert_eq!(better(0.2, 0.19), Outcome::Fails);
    }
}
