//! Reads a mesh, flips edges, simplifies it with its own constraint, and saves it.
use mesh_core::{Repair, TriMesh, build, glam::DVec3};
use simplify::{EdgePatch, Constraint, Policies, Policy, Rejection, Scratch};
use std::ops::ControlFlow;

/// Edges above a height do not collapse.
#[derive(Clone)]
struct Above(f64);

impl Policy for Above {}

impl Constraint for Above {
    fn check(&self, patch: &EdgePatch<'_>, _: DVec3, _: &mut Scratch) -> Result<(), Rejection> {
        let ends = patch.ends().map(|end| (patch.origin() + end).z);
        if ends.iter().any(|&z| z > self.0) { Err(Rejection::Other) } else { Ok(()) }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paths: Vec<String> = std::env::args().skip(1).collect();
    let [input, output] = &paths[..] else { return Err("give an input and an output".into()) };
    let model = mesh_io::read(input)?;
    let mut mesh: TriMesh = build(&model.soup, &Repair::strict())?.mesh;
    let flips = dtri_flip::optimise(&mut mesh, &dtri_flip::AbsMean, &Default::default())?;
    let top = mesh.positions().iter().map(|p| p.z).fold(f64::MIN, f64::max);

    let options = simplify::Options::default().to_faces(mesh.topology().face_count() / 2);
    let cost = simplify::Hybrid::default();
    let mut policies = Policies::new(cost, simplify::Optimal::default());
    policies.constraints.push(Above(0.9 * top));
    let go_on = &mut |_: &_| ControlFlow::Continue(());
    let result = simplify::simplify_with(&mesh, policies, &options.custom(), go_on)?;
    mesh_io::write(output, &result.mesh, &Default::default())?;
    println!("{} flips, {} faces", flips.flips, result.mesh.topology().face_count());
    Ok(())
}
