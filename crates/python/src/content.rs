//! The mesh of the Python API: the content of a file or of arrays, and the half-edge mesh, which is built on first use.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use mesh_core::build::{BuildError, Built, Provenance, Repair, Weld, build, weld_exact};
use mesh_core::{PolygonSoup, Topology, TriMesh};
use mesh_io::Model;
use mesh_work::Source;

use crate::failure::Failure;

/// The content of a mesh, shared by its users and never changed.
pub(crate) struct Content {
    pub(crate) model: Model,
    /// Whether vertices that the format splits are one vertex of the mesh.
    pub(crate) joins: bool,
    built: Arc<OnceLock<Result<Whole, BuildError>>>,
}

/// The half-edge mesh and its origin.
pub(crate) struct Whole {
    pub(crate) mesh: TriMesh,
    provenance: Provenance,
    /// For each vertex of the content the vertex of the mesh, if they differ.
    vertex_of: Option<Vec<u32>>,
}

impl Content {
    pub(crate) fn new(model: Model, joins: bool) -> Self {
        Self { model, joins, built: Arc::default() }
    }

    /// The polygons, with vertices at equal positions merged if they are one vertex of the surface.
    pub(crate) fn joined(&self) -> Cow<'_, PolygonSoup> {
        let soup = &self.model.soup;
        if self.joins {
            Cow::Owned(soup.merged(&weld_exact(soup.positions())))
        } else {
            Cow::Borrowed(soup)
        }
    }

    /// The same faces and vertices with other data.
    pub(crate) fn with_model(&self, model: Model) -> Self {
        Self { model, joins: self.joins, built: Arc::clone(&self.built) }
    }

    /// The mesh, built once.
    pub(crate) fn whole(&self) -> Result<&Whole, Failure> {
        let built = self.built.get_or_init(|| self.build());
        built.as_ref().map_err(|error| error.clone().into())
    }

    /// The content as an argument of functions of `mesh-work`.
    pub(crate) fn source(&self) -> Result<Source<'_>, Failure> {
        let whole = self.whole()?;
        Ok(Source { model: &self.model, mesh: &whole.mesh, provenance: &whole.provenance })
    }

    /// Whether the content is an oriented manifold, computed with little memory.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        let soup = &self.model.soup;
        if self.built.get().is_none() && !self.joins && self.is_triangular() {
            let (triangles, _) = soup.corners().as_chunks::<3>();
            let finite = soup.positions().iter().all(|p| p.is_finite());
            if finite && Topology::from_triangles(soup.vertex_count(), triangles).is_ok() {
                return Ok(());
            }
        }
        self.whole().map(|_| ())
    }

    pub(crate) fn is_triangular(&self) -> bool {
        let ends = self.model.soup.face_ends();
        ends.iter().zip(1_u64..).all(|(&end, face)| u64::from(end) == 3 * face)
    }

    fn build(&self) -> Result<Whole, BuildError> {
        let mut repair = Repair::strict();
        if self.joins {
            repair.weld = Weld::Exact;
        }
        let soup = &self.model.soup;
        let Built { mesh, provenance, .. } = build(soup, &repair)?;
        let is_same = provenance.vertex_source.len() == soup.vertex_count();
        let vertex_of = (!is_same).then(|| {
            let mut vertex_of = vec![u32::MAX; soup.vertex_count()];
            for (&source, vertex) in provenance.vertex_source.iter().zip(0_u32..) {
                vertex_of[source as usize] = vertex;
            }
            for (v, &target) in weld_exact(soup.positions()).iter().enumerate() {
                vertex_of[v] = vertex_of[target as usize];
            }
            vertex_of
        });
        Ok(Whole { mesh, provenance, vertex_of })
    }
}

impl Whole {
    /// Values of surface points at the vertices of the content; `none` at vertices without a face.
    pub(crate) fn of_surface<T: Copy>(&self, mut values: Vec<T>, none: T) -> Vec<T> {
        let topology = self.mesh.topology();
        for (vertex, value) in topology.vertices().zip(&mut values) {
            if topology.outgoing(vertex).next().is_none() {
                *value = none;
            }
        }
        self.of_vertices(values, none)
    }

    /// Values of the vertices of the mesh at the vertices of the content.
    pub(crate) fn of_vertices<T: Copy>(&self, values: Vec<T>, none: T) -> Vec<T> {
        match &self.vertex_of {
            None => values,
            Some(of) => {
                of.iter().map(|&v| values.get(v as usize).copied().unwrap_or(none)).collect()
            }
        }
    }
}
