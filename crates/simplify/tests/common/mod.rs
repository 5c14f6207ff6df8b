//! Real meshes for the tests.
#![allow(clippy::unwrap_used, clippy::print_stderr)]

use std::path::PathBuf;

use mesh_core::TriMesh;
use mesh_core::build::{Repair, build};

/// A real mesh, if the environment says where they are.
pub(crate) fn model(name: &str) -> Option<TriMesh> {
    let Ok(folder) = std::env::var("CURVMESH_MODELS") else {
        eprintln!("skipped: set CURVMESH_MODELS to a folder with {name}");
        return None;
    };
    let model = mesh_io::read(PathBuf::from(folder).join(name)).unwrap();
    Some(build(&model.soup, &Repair::lenient()).unwrap().mesh)
}
