//! A model and the mesh built from it.

use mesh_core::build::{BuildError, BuildReport, Built, Provenance, Repair, Weld, build};
use mesh_core::{PolygonSoup, TriMesh};
use mesh_io::{Format, Lost, Model, ModelError};

/// A model, the mesh built from it, and the map between their elements.
#[derive(Clone, Debug)]
pub struct Loaded {
    /// The model.
    pub model: Model,
    /// The mesh.
    pub mesh: TriMesh,
    /// For each element of the mesh, its source in the model.
    pub provenance: Provenance,
    /// The repairs that were made.
    pub report: BuildReport,
}

/// A borrowed [`Loaded`], the argument of most functions of this crate.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a> {
    /// The model.
    pub model: &'a Model,
    /// The mesh as it was built from the model.
    pub mesh: &'a TriMesh,
    /// For each element of the mesh, its source in the model.
    pub provenance: &'a Provenance,
}

/// Whether a file may split a vertex where its faces differ in texture coordinates or normals. glTF files do.
/// The copies must be welded, because an edge between unconnected faces has no curvature and cannot flip.
#[must_use]
pub fn splits_vertices(model: &Model, format: Option<Format>) -> bool {
    matches!(format, Some(Format::Gltf | Format::Glb))
        || model.corner_uvs.is_some()
        || model.corner_normals.is_some()
}

/// The vertices that commands join where they are not told otherwise: all copies of a vertex in a file that may
/// [split](splits_vertices) vertices, and open edges that lie on each other in other files.
#[must_use]
pub fn usual_weld(model: &Model, format: Option<Format>) -> Weld {
    if splits_vertices(model, format) { Weld::Exact } else { Weld::Seams }
}

/// Builds a mesh with the repairs that are asked for. If the content still is no oriented 2-manifold, the build is
/// repeated with the repairs that leave no choice: vertices at infinite or undefined positions are dropped with their
/// faces, degenerate and duplicate triangles are dropped, and the surface is cut where it is not a manifold. Faces are
/// reversed only if neighbours still disagree.
///
/// Content that builds without these repairs is never changed by them.
///
/// # Errors
/// As [`mesh_core::build()`] for faces with vertices that are not there, for meshes that are too large, and if every face
/// is at a position that is infinite or undefined.
pub fn build_with_needed_repairs(soup: &PolygonSoup, asked: &Repair) -> Result<Built, BuildError> {
    let error = match build(soup, asked) {
        Err(error) if is_repairable(&error) => error,
        built => return built,
    };
    let mut cut = *asked;
    cut.drop_not_finite = true;
    cut.drop_degenerate = true;
    cut.drop_duplicates = true;
    cut.cut_non_manifold = true;
    let mut turned = cut;
    turned.reorient = true;
    let built = match build(soup, &cut) {
        Err(error) if is_repairable(&error) => build(soup, &turned),
        built => built,
    }?;
    let is_lost = built.report.faces_out == 0 && !built.report.dropped_not_finite.is_empty();
    if is_lost { Err(error) } else { Ok(built) }
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

    /// Builds the mesh with the repairs that it needs; see [`build_with_needed_repairs`].
    ///
    /// # Errors
    /// As [`build_with_needed_repairs`].
    pub fn build_with_needed_repairs(model: Model, asked: &Repair) -> Result<Self, BuildError> {
        let Built { mesh, report, provenance } = build_with_needed_repairs(&model.soup, asked)?;
        Ok(Self { model, mesh, provenance, report })
    }

    /// Borrows the model, the mesh and the map.
    #[must_use]
    pub fn source(&self) -> Source<'_> {
        Source { model: &self.model, mesh: &self.mesh, provenance: &self.provenance }
    }

    /// The model of the mesh in its present state. `corner_source` holds for each corner the corner of the file
    /// whose attributes it takes.
    ///
    /// # Errors
    /// The sources do not match the mesh or the model.
    pub fn to_model(&self, corner_source: &[[u32; 3]]) -> Result<Model, ModelError> {
        self.source().to_model(&self.mesh, corner_source)
    }

    /// The model of the mesh as it was built. There is no copy if the build changed nothing.
    ///
    /// # Errors
    /// The model is inconsistent.
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

/// Whether an unambiguous repair may let the build succeed.
fn is_repairable(error: &BuildError) -> bool {
    !matches!(error, BuildError::TooManyElements { .. } | BuildError::IndexOutOfRange { .. })
}

impl Source<'_> {
    /// The vertices whose normals, colours or numbers are lost, since they were joined with vertices that have others.
    #[must_use]
    pub fn lost_by_joining(&self) -> Option<Lost> {
        let Model { soup, vertex_normals, vertex_colors, vertex_scalars, .. } = self.model;
        let Provenance { vertex_source, corner_source, .. } = self.provenance;
        let (normals, colors) = (vertex_normals.as_deref(), vertex_colors.as_deref());
        if normals.is_none() && colors.is_none() && vertex_scalars.is_empty() {
            return None;
        }
        let differ = |a: u32, b: u32| {
            let [a, b] = [a, b].map(|vertex| vertex as usize);
            normals.is_some_and(|all| all.get(a) != all.get(b))
                || colors.is_some_and(|all| all.get(a) != all.get(b))
                || vertex_scalars.iter().any(|s| s.values.get(a) != s.values.get(b))
        };
        let mut lost: Vec<u32> = Vec::new();
        for (corners, sources) in self.mesh.topology().triangles().zip(corner_source) {
            for (vertex, source) in corners.into_iter().zip(sources) {
                let joined = vertex_source.get(vertex as usize);
                let own = soup.corners().get(*source as usize);
                lost.extend(
                    own.zip(joined).filter(|(a, b)| a != b && differ(**a, **b)).map(|p| p.0),
                );
            }
        }
        lost.sort_unstable();
        lost.dedup();
        let why = "they were joined with vertices at the same place that have others; --weld none, or join=False in \
                   Python, keeps them apart";
        let what = "normals, colours or numbers of vertices";
        (!lost.is_empty()).then(|| Lost::some(what, lost.len() as u64, why))
    }

    /// Whether model and mesh have the same elements in the same order.
    #[must_use]
    pub fn is_whole(&self) -> bool {
        let Provenance { vertex_source, face_source, corner_source } = self.provenance;
        let soup = &self.model.soup;
        is_identity(vertex_source, soup.vertex_count())
            && is_identity(face_source, soup.face_count())
            && is_identity(corner_source.as_flattened(), soup.corners().len())
    }

    /// The model of another mesh with the same vertices and faces, such as one with flipped edges.
    ///
    /// # Errors
    /// The sources do not match the mesh or the model.
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

/// Whether the map is the identity on `count` elements.
fn is_identity(source: &[u32], count: usize) -> bool {
    source.len() == count && source.iter().zip(0..).all(|(&found, i): (_, u32)| found == i)
}
