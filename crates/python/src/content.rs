//! The mesh of the Python API: the content of a file or of arrays, and the half-edge mesh, which is built on first use.

use std::borrow::Cow;
use std::sync::{Arc, OnceLock};

use mesh_core::build::{BuildError, BuildReport, Built, Provenance, Repair, Weld, build};
use mesh_core::measure::cracks::cracks;
use mesh_core::{PolygonSoup, Topology, TriMesh, as_u32};
use mesh_io::Model;
use mesh_work::{Source, build_with_needed_repairs};

use crate::failure::Failure;
use crate::repair_warning;

/// The content of a mesh, shared by its users and never changed.
pub(crate) struct Content {
    pub(crate) model: Model,
    /// Which vertices are one vertex of the mesh: nowhere a distance.
    pub(crate) weld: Weld,
    built: Arc<OnceLock<Result<Whole, BuildError>>>,
}

/// The half-edge mesh and its origin.
pub(crate) struct Whole {
    pub(crate) mesh: TriMesh,
    provenance: Provenance,
    /// For each vertex of the content its first vertex of the mesh, if these differ.
    vertex_of: Option<Vec<u32>>,
    /// The vertices of the content that are several vertices of the mesh, since the surface is cut there.
    cut: Vec<u32>,
    /// The repairs without which the content is no oriented manifold, and how many there are of each.
    repairs: Vec<(&'static str, usize)>,
}

impl Content {
    pub(crate) fn new(model: Model, weld: Weld) -> Self {
        Self { model, weld, built: Arc::default() }
    }

    /// The polygons, with vertices at equal positions merged if they are one vertex of the surface.
    pub(crate) fn joined(&self) -> Cow<'_, PolygonSoup> {
        let soup = &self.model.soup;
        match self.targets() {
            Some(targets) => Cow::Owned(soup.merged(&targets)),
            None => Cow::Borrowed(soup),
        }
    }

    /// The vertex that every vertex merges into, if any merge.
    fn targets(&self) -> Option<Vec<u32>> {
        let targets = self.weld.targets(&self.model.soup).ok().flatten()?;
        (!targets.iter().copied().eq(0..as_u32(targets.len()))).then_some(targets)
    }

    /// The same faces and vertices with other data.
    pub(crate) fn with_model(&self, model: Model) -> Self {
        Self { model, weld: self.weld, built: Arc::clone(&self.built) }
    }

    /// The mesh, built once. Arrays of ids in Python are `int32`, so it has fewer than 2^31 vertices; a mesh with half-edges
    /// of 32 bits has fewer faces than that anyway.
    pub(crate) fn whole(&self) -> Result<&Whole, Failure> {
        let count = self.model.soup.vertex_count();
        if i32::try_from(count).is_err() {
            let message = format!(
                "{count} vertices are too many: ids have 31 bits; `curvmesh.regions` takes larger meshes"
            );
            return Err(Failure::new("TooLargeError", message));
        }
        let built = self.built.get_or_init(|| self.build());
        built.as_ref().map_err(|error| error.clone().into())
    }

    /// The content as an argument of functions of `mesh-work`.
    pub(crate) fn source(&self) -> Result<Source<'_>, Failure> {
        let whole = self.whole()?;
        Ok(Source { model: &self.model, mesh: &whole.mesh, provenance: &whole.provenance })
    }

    /// The repairs that were made if the mesh has been built.
    pub(crate) fn repairs(&self) -> &[(&'static str, usize)] {
        match self.built.get() {
            Some(Ok(whole)) => &whole.repairs,
            _ => &[],
        }
    }

    /// Whether the content is an oriented manifold, with as little memory as that takes.
    pub(crate) fn validate(&self) -> Result<(), Failure> {
        let soup = &self.model.soup;
        if self.built.get().is_none() && self.weld != Weld::Exact && self.is_triangular() {
            let (triangles, _) = soup.corners().as_chunks::<3>();
            let finite = soup.positions().iter().all(|p| p.is_finite());
            if finite && Topology::from_triangles(soup.vertex_count(), triangles).is_ok() {
                return Ok(());
            }
        }
        match self.built.get() {
            Some(Ok(whole)) if whole.repairs.is_empty() => Ok(()),
            _ => Ok(build(soup, &self.joining()).map(drop)?),
        }
    }

    pub(crate) fn is_triangular(&self) -> bool {
        let ends = self.model.soup.face_ends();
        ends.iter().zip(1_u64..).all(|(&end, face)| u64::from(end) == 3 * face)
    }

    /// No repair but joining vertices.
    fn joining(&self) -> Repair {
        let mut repair = Repair::strict();
        repair.weld = self.weld;
        repair
    }

    /// Builds the mesh with the repairs that it needs. A warning names them.
    fn build(&self) -> Result<Whole, BuildError> {
        let soup = &self.model.soup;
        let Built { mesh, provenance, report } = build_with_needed_repairs(soup, &self.joining())?;
        let repairs: Vec<_> =
            report.repairs().filter(|repair| repair.0 != BuildReport::MERGED).collect();
        repair_warning::put(&repairs);
        let source = Source { model: &self.model, mesh: &mesh, provenance: &provenance };
        if report.welded_vertices.count() > 0
            && let Some(lost) = source.lost_by_joining()
        {
            repair_warning::put_lost(&lost);
        }
        if self.weld == Weld::Seams
            && let Some(cracks) = cracks(&mesh)
        {
            repair_warning::put_cracks(&cracks);
        }
        let count = as_u32(soup.vertex_count());
        let is_same = provenance.vertex_source.iter().copied().eq(0..count);
        let mut cut = Vec::new();
        let vertex_of = (!is_same).then(|| {
            let mut vertices = vec![(u32::MAX, false); soup.vertex_count()];
            for (&source, vertex) in provenance.vertex_source.iter().zip(0_u32..) {
                let first = &mut vertices[source as usize];
                *first = if first.0 == u32::MAX { (vertex, false) } else { (first.0, true) };
            }
            let joins = report.welded_vertices.count() > 0;
            let targets = if joins { self.targets() } else { None };
            for (v, &target) in targets.iter().flatten().enumerate() {
                vertices[v] = vertices[target as usize];
            }
            cut.extend((0..count).zip(&vertices).filter(|v| v.1.1).map(|v| v.0));
            vertices.into_iter().map(|vertex| vertex.0).collect()
        });
        Ok(Whole { mesh, provenance, vertex_of, cut, repairs })
    }
}

impl Whole {
    /// Values of surface points at the vertices of the content; `none` at vertices without a face, and where the
    /// surface is cut, so that there are several values.
    pub(crate) fn of_surface<T: Copy>(&self, mut values: Vec<T>, none: T) -> Vec<T> {
        let topology = self.mesh.topology();
        for (vertex, value) in topology.vertices().zip(&mut values) {
            if topology.outgoing(vertex).next().is_none() {
                *value = none;
            }
        }
        let mut values = self.of_vertices(values, none);
        for &v in &self.cut {
            if let Some(value) = values.get_mut(v as usize) {
                *value = none;
            }
        }
        values
    }

    /// Values of the vertices of the mesh at the vertices of the content; of the first one where the surface is cut.
    pub(crate) fn of_vertices<T: Copy>(&self, values: Vec<T>, none: T) -> Vec<T> {
        match &self.vertex_of {
            None => values,
            Some(of) => {
                of.iter().map(|&v| values.get(v as usize).copied().unwrap_or(none)).collect()
            }
        }
    }
}
