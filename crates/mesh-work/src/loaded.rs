//! The content of a file and the mesh that was built from it.

use mesh_core::TriMesh;
use mesh_core::build::{BuildError, BuildReport, Built, Provenance, Repair, build};
use mesh_io::{Format, Model, ModelError};

/// The content of a file, the mesh that was built from it, and what of the one is what of the
/// other.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The content.
    pub model: Model,
    /// The mesh.
    pub mesh: TriMesh,
    /// Where the elements of the mesh come from.
    pub provenance: Provenance,
    /// What was done to the content to make it a mesh.
    pub report: BuildReport,
}

/// What [`Loaded`] holds, borrowed: what the functions of this crate take.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// The content.
    pub model: &'a Model,
    /// The mesh that was built from it, as it was then.
    pub mesh: &'a TriMesh,
    /// Where the elements of the mesh come from.
    pub provenance: &'a Provenance,
}

/// Whether a file of this format and content may split a vertex where its faces differ in texture
/// coordinates or normals, as glTF does. Such parts are to be welded: an edge whose faces do not
/// know each other has no curvature, and cannot flip.
#[must_use]
pub fn splits_vertices(model: &Model, format: Option<Format>) -> bool {
    matches!(format, Some(Format::Gltf | Format::Glb))
        || model.corner_uvs.is_some()
        || model.corner_normals.is_some()
}

impl Loaded {
    /// Builds the mesh with the repairs that are allowed.
    ///
    /// # Errors
    /// As [`mesh_core::build()`].
    pub fn build(model: Model, repair: &Repair) -> Result<Self, BuildError> {
        let Built { mesh, report, provenance } = build(&model.soup, repair)?;
        Ok(Self { model, mesh, provenance, report })
    }

    /// The same, borrowed.
    #[must_use]
    pub fn source(&self) -> Source<'_> {
        Source { model: &self.model, mesh: &self.mesh, provenance: &self.provenance }
    }

    /// The content for the mesh as it is now, each corner taking its data from one of the file.
    ///
    /// # Errors
    /// The sources do not fit the mesh or the content.
    pub fn to_model(&self, corner_source: &[[u32; 3]]) -> Result<Model, ModelError> {
        self.source().to_model(&self.mesh, corner_source)
    }

    /// The content for the mesh as it was built, without a copy where the file already is that.
    ///
    /// # Errors
    /// The content contradicts itself.
    pub fn into_model(self) -> Result<Model, ModelError> {
        if self.source().is_whole() {
            return Ok(self.model);
        }
        self.to_model(&self.provenance.corner_source)
    }

    /// The number of vertices and faces.
    #[must_use]
    pub fn counts(&self) -> [usize; 2] {
        [self.mesh.topology().vertex_count(), self.mesh.topology().face_count()]
    }
}

impl Source<'_> {
    /// Whether the content already is that of the mesh, element by element.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        let Provenance { vertex_source, face_source, corner_source } = self.provenance;
        let soup = &self.model.soup;
        is_identity(vertex_source, soup.vertex_count())
            && is_identity(face_source, soup.face_count())
            && is_identity(corner_source.as_flattened(), soup.corners().len())
    }

    /// The content for another mesh with the same vertices and faces, such as one whose edges were
    /// flipped; each corner takes its data from one of the file.
    ///
    /// # Errors
    /// The sources do not fit the mesh or the content.
    pub fn to_model(
        &self,
        mesh: &TriMesh,
        corner_source: &[[u32; 3]],
    ) -> Result<Model, ModelError> {
        let triangles: Vec<[u32; 3]> = mesh.topology().triangles().collect();
        let Provenance { vertex_source, face_source, .. } = self.provenance;
        self.model.reindexed(
            mesh.positions(),
            &triangles,
            vertex_source,
            face_source,
            corner_source,
        )
    }
}

/// Whether everything comes from its own place among so many.
fn is_identity(source: &[u32], count: usize) -> bool {
    source.len() == count && source.iter().zip(0..).all(|(&found, i): (_, u32)| found == i)
}
