//! The working state of a build: triangles, their provenance, and the report so far.

use std::borrow::Cow;

use glam::DVec3;

use crate::build::edges::NONE;
use crate::build::error::BuildError;
use crate::build::repair::Repair;
use crate::build::report::BuildReport;
use crate::build::screen;
use crate::build::soup::PolygonSoup;
use crate::build::triangulate::{Triangulation, Triangulator};
use crate::index::as_u32;
use crate::measure::any_size::unit_sized;
use crate::measure::facing::Facing;
use crate::mesh::{MeshError, TriMesh};
use crate::topology::Topology;
use crate::topology::handle::{FaceId, HalfEdgeId};

/// A mesh built from a polygon soup.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Built {
    /// The mesh.
    pub mesh: TriMesh,
    /// The repairs that were made.
    pub report: BuildReport,
    /// The origin of its vertices and faces.
    pub provenance: Provenance,
}

/// The origin of the elements of a built mesh, to carry data of the soup over to it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Provenance {
    /// Per vertex of the mesh, the vertex of the soup whose position it has.
    pub vertex_source: Vec<u32>,
    /// Per triangle of the mesh, the face of the soup that it is (part of).
    pub face_source: Vec<u32>,
    /// Per triangle of the mesh and corner, the corner of the soup. A repaired vertex may differ
    /// from the one that the soup has at this corner.
    pub corner_source: Vec<[u32; 3]>,
}

/// The working state of a build.
pub(crate) struct Draft<'a> {
    pub(super) soup: &'a PolygonSoup,
    pub(super) repair: &'a Repair,
    pub(crate) report: BuildReport,
    /// Faces of the soup to leave out, ascending.
    left_out: Vec<u32>,
    /// Per corner of the soup, its vertex in the draft.
    corners: Cow<'a, [u32]>,
    pub(crate) triangles: Cow<'a, [[u32; 3]]>,
    pub(super) provenance: Provenance,
    /// Per triangle, whether it was reversed; empty when none was.
    reversed: Vec<bool>,
}

impl<'a> Draft<'a> {
    pub(super) fn new(soup: &'a PolygonSoup, repair: &'a Repair) -> Result<Self, BuildError> {
        let mut draft = Self::unchecked(soup, repair)?;
        let not_finite = screen::check_coordinates(soup, repair, &draft.left_out)?;
        draft.report.dropped_not_finite = not_finite.iter().copied().collect();
        draft.left_out.extend(not_finite);
        draft.left_out.sort_unstable();
        Ok(draft)
    }

    /// A draft whose coordinates need not be finite.
    pub(crate) fn unchecked(soup: &'a PolygonSoup, repair: &'a Repair) -> Result<Self, BuildError> {
        screen::check_sizes(soup)?;
        let mut report = BuildReport {
            vertices_in: soup.vertex_count(),
            faces_in: soup.face_count(),
            ..BuildReport::default()
        };
        let left_out = screen::check_faces(soup, repair, &mut report)?;
        Ok(Self {
            soup,
            repair,
            report,
            left_out,
            corners: Cow::Borrowed(soup.corners()),
            triangles: Cow::default(),
            provenance: Provenance {
                vertex_source: (0..as_u32(soup.vertex_count())).collect(),
                ..Provenance::default()
            },
            reversed: Vec::new(),
        })
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.provenance.vertex_source.len()
    }

    pub(super) fn weld(&mut self) -> Result<(), BuildError> {
        let Some(target) = self.repair.weld.targets(self.soup)? else {
            return Ok(());
        };
        let is_merged = |&vertex: &u32| target[vertex as usize] != vertex;
        self.report.welded_vertices = (0..as_u32(target.len())).filter(is_merged).collect();
        if self.report.welded_vertices.is_empty() {
            return Ok(());
        }
        let merged: Vec<bool> =
            (0..as_u32(target.len())).map(|vertex| is_merged(&vertex)).collect();
        let renumbered = self.remove_vertices(&merged);
        let left_out_corners =
            self.left_out.iter().map(|&face| self.soup.corner_range(face as usize));
        let mut kept = vec![true; self.corners.len()];
        left_out_corners.for_each(|range| kept[range].fill(false));
        for (corner, _) in self.corners.to_mut().iter_mut().zip(kept).filter(|(_, kept)| *kept) {
            *corner = renumbered[target[*corner as usize] as usize];
        }
        Ok(())
    }

    /// Removes marked vertices and returns the new index of each of the others.
    fn remove_vertices(&mut self, is_removed: &[bool]) -> Vec<u32> {
        let mut renumbered = vec![NONE; is_removed.len()];
        let mut kept = 0;
        for (vertex, _) in is_removed.iter().enumerate().filter(|(_, removed)| !**removed) {
            renumbered[vertex] = as_u32(kept);
            self.provenance.vertex_source[kept] = self.provenance.vertex_source[vertex];
            kept += 1;
        }
        self.provenance.vertex_source.truncate(kept);
        renumbered
    }

    /// Cuts all polygons into triangles.
    pub(crate) fn triangulate(&mut self) {
        let soup = self.soup;
        if self.left_out.is_empty() && (0..soup.face_count()).all(|face| soup.face(face).len() == 3)
        {
            self.triangles = match &self.corners {
                Cow::Borrowed(corners) => Cow::Borrowed(corners.as_chunks().0),
                Cow::Owned(corners) => Cow::Owned(corners.as_chunks().0.to_vec()),
            };
            let faces = 0..as_u32(soup.face_count());
            self.provenance.corner_source =
                faces.clone().map(|face| [3 * face, 3 * face + 1, 3 * face + 2]).collect();
            self.provenance.face_source = faces.collect();
            return;
        }
        let mut triangulator = Triangulator::default();
        let mut positions: Vec<DVec3> = Vec::new();
        let mut local = Vec::new();
        let mut left_out = self.left_out.iter().peekable();
        for face in 0..soup.face_count() {
            if left_out.next_if_eq(&&as_u32(face)).is_some() {
                continue;
            }
            let range = soup.corner_range(face);
            let vertices = &self.corners[range.clone()];
            positions.clear();
            positions.extend(vertices.iter().map(|&vertex| self.position(vertex)));
            local.clear();
            let quality = triangulator.triangulate(&positions, vertices, &mut local);
            if range.len() > 3 {
                self.report.triangulated += 1;
            }
            if quality == Triangulation::Fallback {
                self.report.triangulated_badly.push(as_u32(face));
            }
            for triangle in &local {
                self.provenance.face_source.push(as_u32(face));
                let corners = triangle.map(|corner| as_u32(range.start) + corner);
                self.provenance.corner_source.push(corners);
            }
        }
        let vertex_of = |corner: u32| self.corners[corner as usize];
        let corner_source = &self.provenance.corner_source;
        let triangle = |&[a, b, c]: &[u32; 3]| [vertex_of(a), vertex_of(b), vertex_of(c)];
        self.triangles = corner_source.iter().map(triangle).collect();
    }

    fn position(&self, vertex: u32) -> DVec3 {
        self.soup.positions()[self.provenance.vertex_source[vertex as usize] as usize]
    }

    /// Drops triangles that use a vertex twice.
    pub(super) fn drop_degenerate(&mut self) -> Result<(), BuildError> {
        let faces: Vec<u32> = (0..as_u32(self.triangles.len()))
            .filter(|&face| repeated_vertex(self.triangles[face as usize]).is_some())
            .collect();
        let Some(&first) = faces.first() else {
            return Ok(());
        };
        let sources = faces.iter().map(|&face| self.provenance.face_source[face as usize]);
        if !self.repair.drop_degenerate {
            let vertex = repeated_vertex(self.triangles[first as usize]).unwrap_or_default();
            return Err(BuildError::RepeatedVertex {
                face: self.provenance.face_source[first as usize],
                vertex: self.provenance.vertex_source[vertex as usize],
                faces: sources.collect(),
            });
        }
        self.report.dropped_degenerate.extend(sources);
        self.remove_triangles(&faces);
        Ok(())
    }

    /// Removes triangles, given in ascending order.
    pub(super) fn remove_triangles(&mut self, faces: &[u32]) {
        let mut is_removed = vec![false; self.triangles.len()];
        faces.iter().for_each(|&face| is_removed[face as usize] = true);
        let mut retain = is_removed.iter();
        self.triangles.to_mut().retain(|_| retain.next() == Some(&false));
        let mut retain = is_removed.iter();
        self.provenance.face_source.retain(|_| retain.next() == Some(&false));
        let mut retain = is_removed.iter();
        self.provenance.corner_source.retain(|_| retain.next() == Some(&false));
    }

    /// Drops vertices that no triangle uses, if the repair asks for it: all of them, or those that are not finite.
    pub(super) fn drop_unreferenced(&mut self) {
        let Repair { drop_unreferenced, drop_not_finite, .. } = *self.repair;
        if !drop_unreferenced && !drop_not_finite {
            return;
        }
        let mut is_dropped = vec![true; self.vertex_count()];
        for &vertex in self.triangles.as_flattened() {
            is_dropped[vertex as usize] = false;
        }
        for (is_dropped, &source) in is_dropped.iter_mut().zip(&self.provenance.vertex_source) {
            let is_finite = !drop_not_finite || self.soup.positions()[source as usize].is_finite();
            *is_dropped &= drop_unreferenced || !is_finite;
            if *is_dropped && is_finite {
                self.report.dropped_vertices.push(source);
            } else if *is_dropped {
                self.report.not_finite_vertices.push(source);
            }
        }
        if self.report.dropped_vertices.is_empty() && self.report.not_finite_vertices.is_empty() {
            return;
        }
        let renumbered = self.remove_vertices(&is_dropped);
        for vertex in self.triangles.to_mut().as_flattened_mut() {
            *vertex = renumbered[*vertex as usize];
        }
    }

    /// The half-edge structure, if the triangles form an oriented 2-manifold without duplicates.
    pub(super) fn pair(&self) -> Option<Topology> {
        let topology = Topology::from_triangles(self.vertex_count(), &self.triangles).ok()?;
        // The only duplicates that a manifold can hold are the two faces of a pillow: they share
        // all edges, so the neighbours across two of them are the same face.
        let neighbour = |h: HalfEdgeId| topology.face(h.twin());
        let is_pillow = |face: FaceId| {
            let h = topology.half_edge_of_face(face);
            let across = neighbour(h);
            across.is_some() && across == neighbour(topology.next(h))
        };
        let has_pillow = topology.faces().any(is_pillow);
        (!has_pillow).then_some(topology)
    }

    /// Reverses marked triangles; their first corner stays the first.
    pub(super) fn reverse_faces(&mut self, faces: impl Iterator<Item = usize>) {
        self.reversed.resize(self.triangles.len(), false);
        let triangles = self.triangles.to_mut();
        for face in faces {
            triangles[face].swap(1, 2);
            self.provenance.corner_source[face].swap(1, 2);
            self.reversed[face] ^= true;
        }
    }

    /// Reverses the components of a mesh that are inside out. Its faces are the triangles.
    fn turn_outward(&mut self, mesh: TriMesh) -> Result<TriMesh, BuildError> {
        let facings = mesh.facings();
        self.report.undecided_components = facings.count(Facing::Undecided);
        let source = |face: &FaceId| self.provenance.face_source[face.index()];
        let firsts = facings.inside_out().filter_map(|faces| faces.first());
        self.report.turned_components = firsts.map(source).collect();
        if self.report.turned_components.is_empty() {
            return Ok(mesh);
        }
        self.reverse_faces(facings.inside_out().flatten().map(|face| face.index()));
        let topology = Topology::from_triangles(self.vertex_count(), &self.triangles);
        Ok(TriMesh::new(topology.map_err(MeshError::from)?, mesh.positions().to_vec())?)
    }

    pub(super) fn finish(mut self, topology: Topology) -> Result<(Built, Vec<bool>), BuildError> {
        let positions: Vec<DVec3> = self
            .provenance
            .vertex_source
            .iter()
            .map(|&v| self.soup.positions()[v as usize])
            .collect();
        let mut mesh = TriMesh::new(topology, positions)?;
        if self.repair.reorient {
            mesh = self.turn_outward(mesh)?;
        }
        let positions = mesh.positions();
        let reversed = self.reversed.iter().zip(&self.provenance.face_source);
        self.report.flipped_faces =
            reversed.filter_map(|(&is_reversed, &source)| is_reversed.then_some(source)).collect();
        self.report.vertices_out = positions.len();
        self.report.faces_out = self.triangles.len();
        let sources = self.triangles.iter().zip(&self.provenance.face_source);
        self.report.zero_area_faces = sources
            .filter(|(triangle, _)| has_zero_area(triangle.map(|v| positions[v as usize])))
            .map(|(_, &source)| source)
            .collect();
        let built = Built { mesh, report: self.report, provenance: self.provenance };
        Ok((built, self.reversed))
    }
}

/// The vertex that a triangle uses twice, if it does.
pub(crate) fn repeated_vertex([a, b, c]: [u32; 3]) -> Option<u32> {
    if a == b || a == c { Some(a) } else { (b == c).then_some(b) }
}

/// Whether the cross product of two sides is exactly zero, at any size.
#[must_use]
pub fn has_zero_area([a, b, c]: [DVec3; 3]) -> bool {
    let is_zero = |[u, v]: [DVec3; 2]| u.cross(v) == DVec3::ZERO;
    is_zero([b - a, c - a]) && is_zero(unit_sized([b - a, c - a]))
}
