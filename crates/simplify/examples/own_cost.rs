//! A custom cost: edges along one direction cost more than others, so that triangles become long across it.

#![allow(clippy::print_stdout)]

use std::ops::ControlFlow;

use glam::DVec3;
use mesh_core::TriMesh;
use mesh_shapes::Wave;
use simplify::{
    CostModifier, EdgePatch, Hybrid, Optimal, Options, Policies, Policy, Scratch, simplify_with,
};

/// The cost times 1 + w c², where c is the component of the edge along a unit direction divided by the length of the
/// edge, and w is a weight.
struct Along {
    direction: DVec3,
    weight: f64,
}

impl Policy for Along {}

impl CostModifier for Along {
    fn raise(&self, cost: f64, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> f64 {
        let [a, b] = patch.ends();
        let along = (b - a).normalize_or_zero().dot(self.direction);
        cost * (1.0 + self.weight * along * along)
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let wave = Wave { amplitude: 0.1, wavelength: 1.0, half_width: 2.0 };
    let mesh = TriMesh::from_soup(&wave.mesh(80, Default::default())?)?;
    let options = Options::default().to_faces(1000).custom();
    for weight in [0.0, 100.0] {
        let mut policies = Policies::new(Hybrid::default(), Optimal::default());
        policies.modifiers.push(Box::new(Along { direction: DVec3::X, weight }));
        let result = simplify_with(&mesh, policies, &options, &mut |_| ControlFlow::Continue(()))?;
        let mesh = &result.mesh;
        let edges = mesh.topology().edges().map(|e| mesh.topology().edge_vertices(e));
        let edges: Vec<DVec3> = edges.map(|[a, b]| mesh.position(b) - mesh.position(a)).collect();
        let mean =
            |part: fn(&DVec3) -> f64| edges.iter().map(part).sum::<f64>() / edges.len() as f64;
        println!(
            "weight {weight}: edges are {:.3} by {:.3}",
            mean(|e| e.x.abs()),
            mean(|e| e.y.abs())
        );
    }
    Ok(())
}
