//! The compiled part of the Python package `curvmesh`: thin functions between arrays and the libraries. The public API
//! and its documentation are in `python/curvmesh`.
//!
//! Every function releases the interpreter lock while it works ([`host`]), and raises exceptions of `curvmesh._errors`
//! ([`failure`]). Results equal the results of the program to the last bit, since both call the same functions of
//! `mesh-work` and the libraries below it.

mod collapse_functions;
mod content;
mod curvature;
mod data;
mod distance;
mod failure;
mod flip;
mod flip_functions;
mod host;
mod info;
mod input;
mod length;
mod lod;
mod materials;
mod mesh;
mod options;
mod page;
mod patch;
mod picture;
mod program;
mod repair;
mod repair_warning;
mod scene;
mod shapes;
mod simplify;
mod views;

/// Compiled functions of `curvmesh`.
#[pyo3::pymodule(gil_used = false)]
mod _core {
    #[pymodule_export]
    use crate::curvature::{curvature, principal_directions};
    #[pymodule_export]
    use crate::data::{data, data_names, with_data};
    #[pymodule_export]
    use crate::distance::{distance, vertex_distances};
    #[pymodule_export]
    use crate::flip::flip;
    #[pymodule_export]
    use crate::host::Call;
    #[pymodule_export]
    use crate::info::info;
    #[pymodule_export]
    use crate::lod::{load_record, lod, record_bytes, representatives, save_record};
    #[pymodule_export]
    use crate::materials::{groups, images, materials, with_groups, with_images, with_materials};
    #[pymodule_export]
    use crate::mesh::{MeshData, read, write};
    #[pymodule_export]
    use crate::page::page;
    #[pymodule_export]
    use crate::patch::{CoverData, patch};
    #[pymodule_export]
    use crate::picture::{figure, render};
    #[pymodule_export]
    use crate::program::run_program;
    #[pymodule_export]
    use crate::repair::{repair, subdivide};
    #[pymodule_export]
    use crate::scene::{
        SceneData, lod_scene, read_scene, scene_bytes, scene_mesh, simplify_scene, write_scene,
    };
    #[pymodule_export]
    use crate::shapes::{polyhedron, sphere, torus};
    #[pymodule_export]
    use crate::simplify::{LogData, simplify};

    /// The version of the package.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
