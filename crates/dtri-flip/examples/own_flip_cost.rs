//! A custom cost: edges that run along a direction, as on a brushed surface.
#![allow(missing_docs, clippy::print_stdout)]

use dtri_flip::{Change, FlipCost, FlipOptions, Quad, Stencil, optimise};
use glam::DVec3;
use mesh_core::{TriMesh, VertexId};
use mesh_shapes::Torus;

/// The sum over the edges of the length across a direction.
struct Across(DVec3);

impl Across {
    fn of(&self, mesh: &TriMesh, [a, b]: [VertexId; 2]) -> f64 {
        (mesh.position(b) - mesh.position(a)).cross(self.0).length()
    }
}

impl FlipCost for Across {
    type Cache = ();

    fn prepare(&self, _: &TriMesh) {}

    fn total(&self, mesh: &TriMesh) -> f64 {
        let topology = mesh.topology();
        topology.edges().map(|edge| self.of(mesh, topology.edge_vertices(edge))).sum()
    }

    fn change(&self, mesh: &TriMesh, (): &(), quad: &Quad) -> Change {
        let [a, b, c, d] = quad.corners;
        Change { before: self.of(mesh, [a, b]), after: self.of(mesh, [c, d]) }
    }

    fn stencil(&self) -> Stencil {
        Stencil::Triangles
    }

    fn length_exponent(&self) -> i32 {
        1
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut mesh = TriMesh::from_soup(&Torus { major: 3.0, minor: 1.0 }.mesh(48, 24)?)?;
    // No face may be turned by more than 60 degrees on the way.
    let options = FlipOptions { max_fold: Some(60_f64.to_radians()), ..FlipOptions::default() };
    let report = optimise(&mut mesh, &Across(DVec3::Z), &options)?;
    println!("{} flips: {:.3} -> {:.3}", report.flips, report.cost_before, report.cost_after);
    println!("{} refused since they fold; stopped: {}", report.rejected.fold, report.stop);
    Ok(())
}
