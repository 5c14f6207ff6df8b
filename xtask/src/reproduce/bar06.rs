//! Brink, Alboul, Rodrigues 2006: edge flips by a virtual Willmore energy.

mod cube;
mod energy;
mod face;
pub(super) mod face_shape;
mod torus;

use core::f64::consts::{FRAC_PI_2, TAU};
use std::ops::ControlFlow;

use dcurv::{VertexArea, intersection_angle, total_willmore_energy};
use dtri_flip::{CostName, FlipCost, FlipOptions, FlipReport, Quad, VirtualWillmore};
use mesh_core::TriMesh;

use super::Step;
use super::item::Item;
use crate::failure::Failure;

pub(super) const STEPS: [Step; 4] = [
    Step { name: "Sec. 2 and 3", compute: energy::compute },
    Step { name: "Fig. 4", compute: cube::compute },
    Step { name: "Fig. 5", compute: torus::compute },
    Step { name: "Fig. 6", compute: face::compute },
];

/// What decides on flips.
struct Rule {
    name: &'static str,
    cost: CostName,
    /// How far a face may turn, in radians.
    max_fold: Option<f64>,
}

/// The rule as printed first, then others that stand on firmer ground.
const RULES: [Rule; 4] = [
    Rule { name: "as printed", cost: CostName::Willmore, max_fold: None },
    Rule { name: "as printed, no folds", cost: CostName::Willmore, max_fold: Some(FRAC_PI_2) },
    Rule { name: "W itself", cost: CostName::WillmorePotential, max_fold: None },
    Rule { name: "F2", cost: CostName::F2, max_fold: None },
];

impl Rule {
    fn optimise(&self, mesh: &mut TriMesh) -> Result<FlipReport, Failure> {
        let options = FlipOptions { max_fold: self.max_fold, ..FlipOptions::default() };
        optimise(mesh, self.cost, &options)
    }
}

/// What is measured before and after.
struct Measures {
    /// Willmore energy.
    w: f64,
    /// Virtual Willmore energy; see [`virtual_energy`].
    virtual_w: f64,
    area: f64,
    f2: f64,
}

impl Measures {
    const NAMES: [&str; 4] = ["W", "virtual W", "area", "F2"];

    fn of(mesh: &TriMesh) -> Self {
        Self {
            w: total_willmore_energy(mesh),
            virtual_w: virtual_energy(mesh),
            area: mesh.area(),
            f2: CostName::F2.total(mesh, VertexArea::Voronoi),
        }
    }

    fn values(&self) -> [f64; 4] {
        [self.w, self.virtual_w, self.area, self.f2]
    }

    /// Adds the numbers to an item.
    fn add(&self, item: &mut Item, of: &str) {
        for (name, value) in Self::NAMES.iter().zip(self.values()) {
            item.number(format!("{of}, {name}"), value);
        }
    }

    /// The numbers as cells of a table.
    fn cells(&self) -> [String; 4] {
        self.values().map(|value| format!("{value:.4}"))
    }

    /// The header of a table with these columns in the middle.
    fn header<'a>(before: &'a [&'a str], after: &'a [&'a str]) -> impl Iterator<Item = &'a str> {
        before.iter().chain(&Self::NAMES).chain(after).copied()
    }
}

/// The virtual Willmore energy of a whole mesh. The paper has it for one edge only: the energy with
/// that edge split at its midpoint. Here it is W and all that the virtual points of the edges
/// between two faces add to it, each taken alone.
fn virtual_energy(mesh: &TriMesh) -> f64 {
    let topology = mesh.topology();
    let quads = topology.edges().filter_map(|edge| Quad::around(topology, edge));
    let added = quads.map(|quad| {
        let split = VirtualWillmore.change(mesh, &(), &quad).before;
        split - energy_around(mesh, &quad) - TAU
    });
    total_willmore_energy(mesh) + added.sum::<f64>()
}

/// The part of W at the edge of a quadrilateral and at its four sides.
fn energy_around(mesh: &TriMesh, quad: &Quad) -> f64 {
    let topology = mesh.topology();
    let [a, b, c, d] = quad.corners.map(|v| mesh.position(v));
    let sides = quad.sides.iter().filter_map(|&side| {
        let beyond = topology.apex(side.twin())?;
        let ends = [topology.origin(side), topology.target(side)].map(|v| mesh.position(v));
        let inside = mesh.position(topology.apex(side)?);
        Some(intersection_angle(ends[0], ends[1], inside, mesh.position(beyond)))
    });
    2.0 * (intersection_angle(a, b, c, d) + sides.sum::<f64>())
}

fn optimise(
    mesh: &mut TriMesh,
    cost: CostName,
    options: &FlipOptions,
) -> Result<FlipReport, Failure> {
    let go_on = &mut |_| ControlFlow::Continue(());
    cost.optimise(mesh, VertexArea::Voronoi, options, go_on).map_err(Failure::mesh)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reproduce::run::mesh_of;
    use mesh_core::shapes::{Torus, inset_cube};

    #[test]
    fn virtual_energy_is_that_of_meshes_with_one_edge_split() {
        let cube = mesh_of(&inset_cube(0.3).unwrap()).unwrap();
        let torus = Torus { major: 5.0, minor: 2.0 }.shifted_mesh(12, 6).unwrap();
        for mesh in [cube, mesh_of(&torus).unwrap()] {
            let w = total_willmore_energy(&mesh);
            let mut expected = w;
            for edge in mesh.topology().edges() {
                let mut split = mesh.clone();
                let [a, b] = mesh.topology().edge_vertices(edge).map(|v| mesh.position(v));
                let legal = split.topology().check_split_edge(edge).unwrap();
                split.split_edge(legal, 0.5 * (a + b));
                expected += total_willmore_energy(&split) - w;
            }
            assert!((virtual_energy(&mesh) - expected).abs() < 1e-9 * expected);
        }
    }
}
