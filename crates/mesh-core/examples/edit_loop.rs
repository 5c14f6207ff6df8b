//! An edit loop: collapse the shortest edge until no edge can be collapsed without losing the manifold, and write the
//! result as OBJ.
//!
//! `cargo run -p mesh-core --example edit_loop > coarse.obj`

use std::error::Error;
use std::io::{Write, stdout};

use mesh_core::TriMesh;
use mesh_shapes::Torus;

fn main() -> Result<(), Box<dyn Error>> {
    let mut mesh = TriMesh::from_soup(&Torus { major: 2.0, minor: 0.7 }.mesh(48, 24)?)?;
    while mesh.topology().face_count() > 400 {
        // A queue would be quicker; this is short.
        let mut edges: Vec<_> = mesh.topology().edges().collect();
        edges.sort_by(|&a, &b| mesh.edge_length(a).total_cmp(&mesh.edge_length(b)));
        let legal =
            |edge: &mesh_core::EdgeId| mesh.topology().check_collapse(edge.half_edge()).ok();
        let Some(collapse) = edges.iter().find_map(legal) else { break };
        let [a, b] = [collapse.removed(), collapse.kept()].map(|v| mesh.position(v));
        mesh.collapse(collapse, 0.5 * (a + b));
    }
    let soup = mesh.to_soup();
    let mut out = stdout().lock();
    for p in soup.positions() {
        writeln!(out, "v {} {} {}", p.x, p.y, p.z)?;
    }
    for face in soup.faces() {
        writeln!(out, "f {} {} {}", face[0] + 1, face[1] + 1, face[2] + 1)?;
    }
    Ok(())
}
