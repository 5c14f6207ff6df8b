//! A custom constraint: a painted block keeps all of its vertices, through the collapses and all later steps.

#![allow(clippy::print_stdout)]

use std::ops::ControlFlow;

use glam::DVec3;
use mesh_core::{Remap, TriMesh, VertexMap};
use mesh_shapes::Sphere;
use simplify::{
    Constraint, CurvatureFactor, EdgePatch, Hybrid, Optimal, Options, Policies, Policy, Rejection,
    Scratch, simplify_with,
};

/// Painted vertices are not collapsed, and no other vertex is collapsed into them.
#[derive(Clone)]
struct Painted(VertexMap<bool>);

impl Policy for Painted {
    fn compacted(&mut self, _: &TriMesh, remap: &Remap) {
        self.0 = self.0.compact(remap);
    }
}

impl Constraint for Painted {
    fn check(&self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        let is_painted = |v| self.0.get(v).is_some_and(|&painted| painted);
        let any = is_painted(patch.removed()) || is_painted(patch.kept());
        if any { Err(Rejection::Other) } else { Ok(()) }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = TriMesh::from_soup(&Sphere { radius: 1.0 }.icosphere(4)?)?;
    let is_cap = |p: DVec3| p.z > 0.8;
    let mut painted = mesh.topology().vertex_map(false);
    mesh.topology().vertices().for_each(|v| painted[v] = is_cap(mesh.position(v)));
    let before = painted.iter().filter(|(_, painted)| **painted).count();

    let mut policies = Policies::new(Hybrid::default(), Optimal::default());
    policies.modifiers.push(Box::new(CurvatureFactor::new(0.1)));
    policies.constraints.push(Painted(painted));
    let options = Options::default().to_faces(1500).custom();
    let result = simplify_with(&mesh, policies, &options, &mut |_| ControlFlow::Continue(()))?;

    let vertices = result.mesh.topology().vertices();
    let after = vertices.filter(|&v| is_cap(result.mesh.position(v))).count();
    println!("{} faces; {before} vertices of the cap before, {after} now", 1500);
    Ok(())
}
