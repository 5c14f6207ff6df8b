//! The volume inside a mesh and inside its offsets, by counting points with a signed distance.
#![allow(missing_docs, clippy::print_stdout)]

use glam::DVec3;
use mesh_core::SplitMix64;
use mesh_core::TriMesh;
use mesh_metric::SignedDistance;
use mesh_shapes::Torus;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mesh = TriMesh::from_soup(&Torus { major: 2.0, minor: 0.75 }.mesh(64, 32)?)?;
    let signed = SignedDistance::new(&mesh)?;
    let (half, count) = (DVec3::new(3.25, 3.25, 1.25), 50_000);
    let mut random = SplitMix64::new(1);
    let mut draw = || DVec3::new(random.symmetric(), random.symmetric(), random.symmetric());
    let distances: Vec<f64> = (0..count).map(|_| signed.distance(half * draw())).collect();
    let box_volume = 8.0 * half.x * half.y * half.z;
    println!("the mesh itself has volume {:.3}", mesh.volume());
    for offset in [-0.5, -0.25, 0.0, 0.25, 0.5] {
        let inside = distances.iter().filter(|&&distance| distance <= offset).count();
        let counted = box_volume * inside as f64 / f64::from(count);
        // The exact volume of a torus whose tube is thicker or thinner by the offset.
        let exact = 2.0 * std::f64::consts::PI.powi(2) * 2.0 * (0.75_f64 + offset).powi(2);
        println!("offset {offset:5.2}: {counted:7.3} by counting, {exact:7.3} of the smooth torus");
    }
    Ok(())
}
