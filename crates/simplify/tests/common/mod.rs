//! Meshes for the tests: real ones, and several in one.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::path::PathBuf;

use glam::DVec3;
use mesh_core::TriMesh;
use mesh_core::build::{Repair, build};

/// A real mesh, if the environment variable for their folder is set.
pub(crate) fn model(name: &str) -> Option<TriMesh> {
    let Ok(folder) = std::env::var("CURVMESH_MODELS") else {
        eprintln!("skipped: set CURVMESH_MODELS to a folder with {name}");
        return None;
    };
    let model = mesh_io::read(PathBuf::from(folder).join(name)).unwrap();
    Some(build(&model.soup, &Repair::lenient()).unwrap().mesh)
}

/// Parts, each with points and triangles, in one mesh, not connected.
pub(crate) fn joined(parts: &[(Vec<DVec3>, Vec<[u32; 3]>)]) -> TriMesh {
    let (mut points, mut triangles): (Vec<DVec3>, Vec<[u32; 3]>) = Default::default();
    for (more, faces) in parts {
        let shift = points.len() as u32;
        points.extend(more);
        triangles.extend(faces.iter().map(|t| t.map(|v| v + shift)));
    }
    TriMesh::from_triangles(&points, &triangles).unwrap()
}
