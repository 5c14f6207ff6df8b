//! From a file to a mesh.

use std::path::Path;
use std::time::Instant;

use mesh_core::TriMesh;
use mesh_core::build::{Built, Provenance, Repair, Weld, build};
use mesh_io::Model;
use serde::Serialize;

use crate::args::RepairOptions;
use crate::console::Console;
use crate::failure::Failure;

/// Wall-clock seconds of the parts of a run.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub(crate) struct Seconds {
    pub(crate) load: f64,
    pub(crate) compute: f64,
    pub(crate) save: f64,
    pub(crate) total: f64,
}

impl Seconds {
    /// Runs a part and takes its time.
    pub(crate) fn time<T>(part: &mut f64, work: impl FnOnce() -> T) -> T {
        let start = Instant::now();
        let result = work();
        *part += start.elapsed().as_secs_f64();
        result
    }

    /// With the total filled in.
    pub(crate) fn summed(mut self) -> Self {
        self.total = self.load + self.compute + self.save;
        self
    }
}

/// A mesh with the file content that it was built from.
pub(crate) struct Loaded {
    pub(crate) model: Model,
    pub(crate) mesh: TriMesh,
    pub(crate) provenance: Provenance,
}

/// Reads a file, and says what the reader passed over.
pub(crate) fn read(path: &Path, console: &Console) -> Result<Model, Failure> {
    let model = mesh_io::read(path).map_err(|error| Failure::Read(Box::new(error)))?;
    for note in &model.notes {
        console.message(format_args!("{}: {note}", path.display()));
    }
    Ok(model)
}

/// Reads a file and builds the mesh, with the repairs that are allowed.
pub(crate) fn load(
    path: &Path,
    repair: &RepairOptions,
    console: &Console,
) -> Result<Loaded, Failure> {
    let model = read(path, console)?;
    assemble(path, model, &repair.repair(), console)
}

/// As [`load`], but where vertices of a file are split so that each has one texture coordinate and
/// one normal, as glTF does it, the parts are one vertex of the mesh unless `--weld` says otherwise.
pub(crate) fn load_whole(
    path: &Path,
    options: &RepairOptions,
    console: &Console,
) -> Result<Loaded, Failure> {
    let model = read(path, console)?;
    let mut repair = options.repair();
    let has_corner_data = model.corner_uvs.is_some() || model.corner_normals.is_some();
    if has_corner_data && options.weld.is_none() {
        repair.weld = Weld::Exact;
    }
    assemble(path, model, &repair, console)
}

fn assemble(
    path: &Path,
    model: Model,
    repair: &Repair,
    console: &Console,
) -> Result<Loaded, Failure> {
    let Built { mesh, report, provenance } = build(&model.soup, repair)
        .map_err(|source| Failure::Build { path: path.to_owned(), source: Box::new(source) })?;
    if !report.is_unchanged() {
        console.message(format_args!("{}: {report}", path.display()));
    }
    Ok(Loaded { model, mesh, provenance })
}

/// The content of a file as it is, or of the mesh that the repairs make of it if there are any.
pub(crate) fn content(
    path: &Path,
    repair: &RepairOptions,
    console: &Console,
) -> Result<Model, Failure> {
    if !repair.any() {
        return read(path, console);
    }
    let loaded = load(path, repair, console)?;
    loaded.to_model(&loaded.provenance.corner_source)
}

impl Loaded {
    /// The content for the mesh as it is now, each corner taking its data from one of the file.
    pub(crate) fn to_model(&self, corner_source: &[[u32; 3]]) -> Result<Model, Failure> {
        let triangles: Vec<[u32; 3]> = self.mesh.topology().triangles().collect();
        let Provenance { vertex_source, face_source, .. } = &self.provenance;
        self.model
            .reindexed(self.mesh.positions(), &triangles, vertex_source, face_source, corner_source)
            .map_err(Failure::model)
    }

    /// The number of vertices and faces.
    pub(crate) fn counts(&self) -> [usize; 2] {
        [self.mesh.topology().vertex_count(), self.mesh.topology().face_count()]
    }
}
