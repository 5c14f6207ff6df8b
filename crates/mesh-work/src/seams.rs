//! Seams of a mesh, and transfer of corner attributes through edge flips.
//!
//! A flip may not cross a *seam*: an edge whose two faces differ in group, material, label or colour, or disagree about
//! the texture coordinates at one of its ends. Seams divide the faces around each vertex into sectors. All corners in a
//! sector have the same texture coordinate. Flips of other edges change the faces of a sector but not the sector. So
//! afterwards each corner takes the attributes of any corner of its sector.

use glam::DVec3;
use mesh_core::build::Provenance;
use mesh_core::{EdgeMap, HalfEdgeId, HalfEdgeMap, Topology, VertexMap, angle_between};
use mesh_io::{Model, Scalars};

/// The seams of a mesh, and the attributes of its corners before the flips.
#[derive(Clone, Debug)]
pub struct Seams {
    /// Edges that must not be flipped.
    pub edges: EdgeMap<bool>,
    /// Per half-edge with a face, the corner of the file at its origin.
    corner: HalfEdgeMap<u32>,
    /// Per vertex, one of its corners in the file.
    any_corner: VertexMap<u32>,
}

impl Seams {
    /// Finds the seams of a freshly built mesh.
    #[must_use]
    pub fn find(topology: &Topology, provenance: &Provenance, model: &Model) -> Self {
        let mut corner = topology.half_edge_map(0);
        let mut any_corner = topology.vertex_map(0);
        for (face, corners) in topology.faces().zip(&provenance.corner_source) {
            for (h, &source) in topology.face_half_edges(face).into_iter().zip(corners) {
                corner[h] = source;
                any_corner[topology.origin(h)] = source;
            }
        }
        let mut seams = Self { edges: topology.edge_map(false), corner, any_corner };
        let labels = segmentations(topology, provenance, model);
        for edge in topology.edges() {
            if let [Some(left), Some(right)] = topology.edge_faces(edge) {
                let faces = [left, right].map(|f| provenance.face_source[f.index()] as usize);
                seams.edges[edge] = faces_differ(model, &labels, faces)
                    || seams.corners_differ(topology, edge.half_edge(), model);
            }
        }
        seams
    }

    /// Number of seams.
    #[must_use]
    pub fn count(&self) -> usize {
        self.edges.as_slice().iter().filter(|&&is_seam| is_seam).count()
    }

    /// Whether the two faces at a half-edge disagree at one of its ends.
    fn corners_differ(&self, topology: &Topology, h: HalfEdgeId, model: &Model) -> bool {
        let twin = h.twin();
        model.corner_uvs.iter().chain(&model.more_corner_uvs).any(|uvs| {
            let at = |h: HalfEdgeId| uvs[self.corner[h] as usize].map(f32::to_bits);
            at(h) != at(topology.next(twin)) || at(twin) != at(topology.next(h))
        })
    }

    /// Adds the creases to the seams: edges whose two faces have normals more than `angle` apart at
    /// one of the ends.
    pub fn add_creases(&mut self, topology: &Topology, normals: &[[f32; 3]], angle: f64) {
        let normal = |h: HalfEdgeId| DVec3::from(normals[self.corner[h] as usize].map(f64::from));
        let is_crease = |h: HalfEdgeId| {
            let pairs = [(h, topology.next(h.twin())), (h.twin(), topology.next(h))];
            pairs.into_iter().any(|(a, b)| angle_between(normal(a), normal(b)) > angle)
        };
        for edge in topology.edges().filter(|&e| !topology.is_boundary_edge(e)) {
            self.edges[edge] |= is_crease(edge.half_edge());
        }
    }

    /// The corner of the file at the origin of a half-edge, in its face.
    #[must_use]
    pub fn corner(&self, h: HalfEdgeId) -> usize {
        self.corner[h] as usize
    }

    /// The corner of the file whose data each corner of the flipped mesh takes.
    #[must_use]
    pub fn corner_source(&self, topology: &Topology) -> Vec<[u32; 3]> {
        let mut sources: HalfEdgeMap<Option<u32>> = topology.half_edge_map(None);
        let faces = topology.faces().map(|face| topology.face_half_edges(face));
        faces
            .map(|sides| {
                sides.map(|h| {
                    let (end, source) = self.end_of_sector(topology, &sources, h);
                    // All corners on the way are in the same sector, so none is visited twice.
                    let mut current = h;
                    while current != end {
                        sources[current] = Some(source);
                        current = topology.next(current.twin());
                    }
                    sources[end] = Some(source);
                    source
                })
            })
            .collect()
    }

    /// Going clockwise from a corner, finds the first corner whose source is known, or else the last one before a seam
    /// or the boundary, which existed before the flips. Returns it with the source of the sector. If the whole vertex
    /// is one sector, any of its corners is the source.
    fn end_of_sector(
        &self,
        topology: &Topology,
        sources: &HalfEdgeMap<Option<u32>>,
        h: HalfEdgeId,
    ) -> (HalfEdgeId, u32) {
        let mut current = h;
        loop {
            if let Some(source) = sources[current] {
                return (current, source);
            }
            if self.edges[current.edge()] || topology.is_exterior(current.twin()) {
                return (current, self.corner[current]);
            }
            let next = topology.next(current.twin());
            if next == h {
                return (current, self.any_corner[topology.origin(h)]);
            }
            current = next;
        }
    }
}

/// The labels of faces that divide the mesh into regions. Labels that differ across most edges are numbers of faces and
/// have no borders to keep.
fn segmentations<'m>(
    topology: &Topology,
    provenance: &Provenance,
    model: &'m Model,
) -> Vec<&'m Scalars> {
    let inner = || {
        topology.edges().filter_map(|edge| match topology.edge_faces(edge) {
            [Some(f), Some(g)] => Some([f, g].map(|f| provenance.face_source[f.index()] as usize)),
            _ => None,
        })
    };
    let is_segmentation = |label: &&Scalars| {
        let borders = inner().filter(|&faces| labels_differ(label, faces)).count();
        2 * borders <= inner().count()
    };
    model.face_scalars.iter().filter(|scalars| scalars.is_label).filter(is_segmentation).collect()
}

fn labels_differ(label: &Scalars, [f, g]: [usize; 2]) -> bool {
    label.values.bits(f) != label.values.bits(g)
}

fn faces_differ(model: &Model, labels: &[&Scalars], [f, g]: [usize; 2]) -> bool {
    let differs = |ids: &Option<Vec<u32>>| ids.as_ref().is_some_and(|ids| ids[f] != ids[g]);
    let recolored =
        |colors: &Vec<[f32; 4]>| colors[f].map(f32::to_bits) != colors[g].map(f32::to_bits);
    differs(&model.face_groups)
        || differs(&model.face_materials)
        || model.face_colors.as_ref().is_some_and(recolored)
        || labels.iter().any(|label| labels_differ(label, [f, g]))
}
