//! What is measured before and after the flips, the virtual Willmore energy of a mesh among it.

use core::f64::consts::TAU;

use dcurv::{VertexArea, intersection_angle, total_willmore_energy};
use dtri_flip::{CostName, FlipCost, Quad, VirtualWillmore};
use mesh_core::TriMesh;

use super::super::item::Item;

/// What is measured before and after.
pub(super) struct Measures {
    /// Willmore energy.
    pub(super) w: f64,
    /// Virtual Willmore energy; see [`virtual_energy`].
    pub(super) virtual_w: f64,
    pub(super) area: f64,
    pub(super) f2: f64,
}

impl Measures {
    pub(super) const NAMES: [&str; 4] = ["W", "virtual W", "area", "F2"];

    pub(super) fn of(mesh: &TriMesh) -> Self {
        Self {
            w: total_willmore_energy(mesh),
            virtual_w: virtual_energy(mesh),
            area: mesh.area(),
            f2: CostName::F2.total(mesh, VertexArea::Voronoi),
        }
    }

    pub(super) fn values(&self) -> [f64; 4] {
        [self.w, self.virtual_w, self.area, self.f2]
    }

    /// Adds the numbers to an item.
    pub(super) fn add(&self, item: &mut Item, of: &str) {
        for (name, value) in Self::NAMES.iter().zip(self.values()) {
            item.number(format!("{of}, {name}"), value);
        }
    }

    /// The numbers as cells of a table.
    pub(super) fn cells(&self) -> [String; 4] {
        self.values().map(|value| format!("{value:.4}"))
    }

    /// The header of a table with these columns in the middle.
    pub(super) fn header<'a>(
        before: &'a [&'a str],
        after: &'a [&'a str],
    ) -> impl Iterator<Item = &'a str> {
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

/// The part of W at the edge of a quadrilateral and at its four sides. Every edge counts once for each
/// interior end.
fn energy_around(mesh: &TriMesh, quad: &Quad) -> f64 {
    let topology = mesh.topology();
    let edge = quad.edge.half_edges()[0];
    let parts = [edge].into_iter().chain(quad.sides).filter_map(|half_edge| {
        let ends = [topology.origin(half_edge), topology.target(half_edge)];
        let interior = ends.iter().filter(|&&end| !topology.is_boundary_vertex(end)).count();
        let apexes = [topology.apex(half_edge)?, topology.apex(half_edge.twin())?];
        let ([a, b], [c, d]) = (ends.map(|v| mesh.position(v)), apexes.map(|v| mesh.position(v)));
        Some(interior as f64 * intersection_angle(a, b, c, d))
    });
    parts.sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::run::mesh_of;
    use mesh_shapes::{Diagonals, Saddle, Torus, inset_cube};

    #[test]
    fn virtual_energy_is_that_of_meshes_with_one_edge_split() {
        let cube = mesh_of(&inset_cube(0.3).unwrap()).unwrap();
        let torus = Torus { major: 5.0, minor: 2.0 }.shifted_mesh(12, 6).unwrap();
        let open =
            Saddle { coefficient: 0.4, half_width: 1.0 }.mesh(5, Diagonals::Uniform).unwrap();
        for mesh in [cube, mesh_of(&torus).unwrap(), mesh_of(&open).unwrap()] {
            let w = total_willmore_energy(&mesh);
            let mut expected = w;
            let is_inside = |edge: &_| !mesh.topology().is_boundary_edge(*edge);
            for edge in mesh.topology().edges().filter(is_inside) {
                let mut split = mesh.clone();
                let [a, b] = mesh.topology().edge_vertices(edge).map(|v| mesh.position(v));
                let legal = split.topology().check_split_edge(edge).unwrap();
                split.split_edge(legal, 0.5 * (a + b));
                expected += total_willmore_energy(&split) - w;
            }
            let found = virtual_energy(&mesh);
            assert!((found - expected).abs() < 1e-9 * expected.abs(), "{found} {expected}");
        }
    }
}
