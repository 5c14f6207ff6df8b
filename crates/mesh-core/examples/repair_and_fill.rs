//! Repairs a scan with the usual defects: duplicated vertices, a duplicate face, a reversed face, stray points, and
//! holes.
//!
//! `cargo run -p mesh-core --example repair_and_fill`
#![allow(clippy::print_stdout)]

use std::error::Error;

use mesh_core::fill::FillOptions;
use mesh_core::{PolygonSoup, Repair, build, diagnose};
use mesh_shapes::Sphere;

fn main() -> Result<(), Box<dyn Error>> {
    // Every triangle has vertices of its own, as in STL files; a band and a few faces are missing.
    let sphere = Sphere::UNIT.icosphere(3)?;
    let mut scan = PolygonSoup::new();
    for (i, face) in sphere.faces().enumerate() {
        let corners = [0, 1, 2].map(|k| sphere.positions()[face[k] as usize]);
        if (corners[0].z > 0.2 && corners[0].z < 0.5 && corners[0].x > 0.0) || i % 97 == 0 {
            continue;
        }
        let first = scan.vertex_count();
        corners.iter().for_each(|corner| scan.push_vertex(corner));
        let turned = i % 50 == 0;
        scan.push_face(&[first, first + 1 + usize::from(turned), first + 2 - usize::from(turned)])?;
    }
    scan.push_face(&[0, 1, 2])?;
    scan.push_vertex([5.0, 5.0, 5.0]);

    let found = diagnose(&scan)?;
    println!("as scanned: {} pieces, {} boundary edges", found.components, found.boundary_edges);
    let built = build(&scan, &Repair::lenient())?;
    println!("{}", built.report);

    let mut mesh = built.mesh;
    let report = mesh.fill_holes(&FillOptions::default());
    for hole in &report.filled {
        println!("filled a hole of {} edges with {} faces", hole.edges, hole.faces.len());
    }
    mesh.topology().validate()?;
    println!(
        "closed: {}, volume {:.3} of {:.3}",
        mesh.topology().is_closed(),
        mesh.volume(),
        4.189
    );
    Ok(())
}
