//! Fig. 6: butterfly subdivision of the initial and of the optimised torus.

use std::path::Path;

use mesh_core::butterfly::{ButterflyOptions, subdivide};

use super::super::item::{Item, Row};
use super::super::published::Paper;
use super::{SETTINGS, distance_to_torus, norms, optimised, picture, torus_view};
use crate::failure::Failure;
use crate::render::Style;

pub(super) const NAME: &str = "Fig. 6";

/// The subdivision steps of the figure.
const STEPS: u32 = 3;
/// Lattice steps on a side of a triangle of the subdivided mesh. The coarse mesh gets as many per
/// length, 2^[`STEPS`] times this.
const SUBDIVISIONS: u32 = 4;

/// The distance to the torus before and after subdivision, without and with optimisation.
pub(super) fn item(paper: &Paper, out: &Path) -> Result<Item, Failure> {
    let mut rows = Vec::new();
    let mut figures = Vec::new();
    for setting in SETTINGS.iter().filter(|setting| ["initial", "F1"].contains(&setting.row)) {
        let coarse = optimised(setting)?;
        let options = ButterflyOptions::default();
        let fine = subdivide(&coarse, STEPS, &options).map_err(Failure::mesh)?.mesh;
        let before = distance_to_torus(&coarse, SUBDIVISIONS << STEPS);
        let after = distance_to_torus(&fine, SUBDIVISIONS);
        for (when, error) in [("before", before), ("after", after)] {
            for (norm, value) in norms(&error) {
                let quantity = format!("{}, {when} subdivision, {norm}", setting.row);
                rows.push(Row::new(paper, NAME, &quantity, value));
            }
        }
        let style = Style { size: [900, 760], smooth: true, edge_width: 0.0 };
        let name = format!("dhkl01-subdivided-{}", setting.row.to_lowercase());
        let caption = format!("{}, after three butterfly steps", setting.how);
        figures.push(picture(&fine, &torus_view(&coarse)?, &style, &name, &caption, out)?);
    }
    Ok(Item {
        paper: paper.short.clone(),
        name: NAME.into(),
        about: "Three butterfly steps from the torus as given and as optimised by F1, and the \
                distance to the torus before and after, at lattice points that are equally dense \
                on all four meshes. The paper shows pictures only."
            .into(),
        needs: None,
        rows,
        figures,
        functions: vec!["dtri_flip::optimise", "mesh_core::butterfly::subdivide"],
        command: "curvmesh flip IN -o OUT --cost f1",
    })
}
