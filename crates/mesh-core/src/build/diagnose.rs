//! Counts of the parts and defects of a polygon soup, even if no mesh can be built from it.

use glam::DVec3;

use crate::build::edges::{EdgeTable, proper_pair};
use crate::build::soup::PolygonSoup;
use crate::build::{
    BuildError, Draft, Repair, build_and_compare, find_duplicates, has_zero_area, repeated_vertex,
};
use crate::index::as_u32;
use crate::measure::any_size::unit_sized;
use crate::topology::disjoint_sets::DisjointSets;
use crate::topology::edge_connectivity::EdgeConnectivity;

/// Counts of the parts and defects of a polygon soup, without any weld or repair.
///
/// Polygons are cut into triangles as [`crate::build()`] does; all counts but the first five are of
/// triangles and their edges. Connectivity (edges, boundary, components, Euler characteristic and
/// everything derived) is that of the *proper* triangles: three distinct vertices, all of them in
/// the soup. Duplicates are proper and count like any other triangle.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
#[non_exhaustive]
pub struct Diagnosis {
    /// Vertices, in use or not.
    pub vertices: usize,
    /// Faces with three corners.
    pub triangles: usize,
    /// Faces with four corners.
    pub quadrilaterals: usize,
    /// Faces with more than four corners.
    pub larger_polygons: usize,
    /// Faces with fewer than three corners.
    pub too_small_faces: usize,
    /// Faces that refer to vertices that do not exist.
    pub out_of_range_faces: usize,
    /// Vertices with a coordinate that is infinite or not a number.
    pub non_finite_vertices: usize,
    /// Vertices that no proper triangle uses.
    pub unreferenced_vertices: usize,
    /// Triangles after cutting polygons, degenerate ones included.
    pub faces: usize,
    /// Triangles that use a vertex twice.
    pub repeated_vertex_faces: usize,
    /// Proper triangles whose sides have a cross product of exactly zero.
    pub zero_area_faces: usize,
    /// Proper triangles of positive area with a height below 1/1000 of their longest side.
    pub slivers: usize,
    /// Proper triangles with the same vertices as an earlier one, in any order.
    pub duplicate_faces: usize,
    /// Edges: pairs of vertices that are joined by a side of a proper triangle.
    pub edges: usize,
    /// Edges of one triangle.
    pub boundary_edges: usize,
    /// Connected components of the graph of boundary edges. On a 2-manifold these are the boundary loops; loops
    /// that touch at a vertex count as one.
    pub boundary_loops: usize,
    /// Edges of more than two triangles.
    pub non_manifold_edges: usize,
    /// Non-manifold vertices: not all their triangles are connected through edges at the vertex.
    pub non_manifold_vertices: usize,
    /// Edges of two triangles that run along it in the same direction.
    pub inconsistent_edges: usize,
    /// Components with more than half of their area facing the wrong way, by the [rules](crate::measure::facing) of
    /// [`Repair::reorient`], after an exact weld. `None` where a coordinate is not finite.
    pub inside_out: Option<usize>,
    /// Connected components, where triangles are connected through common vertices.
    pub components: usize,
    /// Connected components, where triangles are connected through common edges.
    pub edge_components: usize,
    /// Vertices in use minus edges plus proper triangles.
    pub euler_characteristic: i64,
}

impl Diagnosis {
    /// Whether there are faces and no edge belongs to one alone.
    #[must_use]
    pub fn is_closed(&self) -> bool {
        self.edges > 0 && self.boundary_edges == 0
    }

    /// Whether no edge has more than two triangles and no vertex is pinched.
    #[must_use]
    pub fn is_manifold(&self) -> bool {
        self.non_manifold_edges == 0 && self.non_manifold_vertices == 0
    }

    /// Whether the triangles at every edge of two run along it in opposite directions.
    #[must_use]
    pub fn is_oriented(&self) -> bool {
        self.inconsistent_edges == 0
    }

    /// Triangles that use a vertex twice or have zero area.
    #[must_use]
    pub fn degenerate_faces(&self) -> usize {
        self.repeated_vertex_faces + self.zero_area_faces
    }
}

/// Height below which a triangle is a sliver, in units of its longest side.
pub const SLIVER_HEIGHT: f64 = 1e-3;

/// Counts the parts and defects of a polygon soup. Takes as long as [`crate::build()`] with
/// repairs.
///
/// # Errors
/// [`BuildError::TooManyElements`] for soups beyond 32-bit indices; nothing else.
pub fn diagnose(soup: &PolygonSoup) -> Result<Diagnosis, BuildError> {
    if let Some((scaled, _)) = soup.at_unit_size() {
        return diagnose(&scaled);
    }
    let lenient = Repair::lenient();
    let mut draft = Draft::unchecked(soup, &lenient)?;
    draft.triangulate();
    let mut diagnosis = Diagnosis {
        vertices: soup.vertex_count(),
        out_of_range_faces: draft.report.dropped_out_of_range.count(),
        too_small_faces: draft.report.dropped_degenerate.count(),
        non_finite_vertices: soup.positions().iter().filter(|p| !p.is_finite()).count(),
        faces: draft.triangles.len(),
        ..Diagnosis::default()
    };
    diagnosis.count_polygons(soup);
    let mut triangles = draft.triangles.into_owned();
    triangles.retain(|&triangle| repeated_vertex(triangle).is_none());
    diagnosis.repeated_vertex_faces = diagnosis.faces - triangles.len();
    diagnosis.measure(soup.positions(), &triangles);
    diagnosis.connect(soup.vertex_count(), &triangles);
    diagnosis.inside_out = count_inside_out(soup);
    Ok(diagnosis)
}

/// Components for which the repair would reverse more than half of the area.
fn count_inside_out(soup: &PolygonSoup) -> Option<usize> {
    let (built, reversed) = build_and_compare(soup, &Repair::lenient()).ok()?;
    let (mesh, topology) = (&built.mesh, built.mesh.topology());
    let components = topology.components();
    let mut turned_area = vec![0.0; components.count];
    for face in topology.faces() {
        let [vertex, ..] = topology.face_vertices(face);
        if let Some(component) = components.of_vertex[vertex] {
            let is_reversed = reversed.get(face.index()) == Some(&true);
            let area = mesh.face_area(face);
            turned_area[component as usize] += if is_reversed { area } else { -area };
        }
    }
    Some(turned_area.into_iter().filter(|&area| area > 0.0).count())
}

impl Diagnosis {
    fn count_polygons(&mut self, soup: &PolygonSoup) {
        for face in soup.faces() {
            match face.len() {
                0..3 => {}
                3 => self.triangles += 1,
                4 => self.quadrilaterals += 1,
                _ => self.larger_polygons += 1,
            }
        }
    }

    fn measure(&mut self, positions: &[DVec3], triangles: &[[u32; 3]]) {
        for triangle in triangles {
            let corners = triangle.map(|vertex| positions[vertex as usize]);
            if has_zero_area(corners) {
                self.zero_area_faces += 1;
            } else if is_sliver(corners) {
                self.slivers += 1;
            }
        }
    }

    fn connect(&mut self, vertex_count: usize, triangles: &[[u32; 3]]) {
        let table = EdgeTable::new(vertex_count, triangles);
        self.duplicate_faces = find_duplicates(triangles, &table).len();
        let mut edges = EdgeConnectivity::new(vertex_count, triangles);
        let mut boundary = DisjointSets::new(vertex_count);
        let mut boundary_vertices = Vec::new();
        for edge in table.iter() {
            let [from, to] = edges.connect(edge.iter().copied());
            self.edges += 1;
            match edge.len() {
                1 => {
                    self.boundary_edges += 1;
                    boundary.union(from, to);
                    boundary_vertices.push(from);
                }
                2 if proper_pair(triangles, edge).is_none() => self.inconsistent_edges += 1,
                2 => {}
                _ => self.non_manifold_edges += 1,
            }
        }
        self.boundary_loops = boundary.count_sets(boundary_vertices.into_iter());
        let corners = triangles.as_flattened();
        self.components = edges.vertices.count_sets(corners.iter().copied());
        self.edge_components = edges.faces.count_sets(0..as_u32(triangles.len()));

        let fans_at = edges.fans(vertex_count);
        self.unreferenced_vertices = fans_at.iter().filter(|&&fans| fans == 0).count();
        self.non_manifold_vertices = fans_at.iter().filter(|&&fans| fans > 1).count();
        let used = vertex_count - self.unreferenced_vertices;
        self.euler_characteristic = used as i64 - self.edges as i64 + triangles.len() as i64;
    }
}

/// Whether the height of a triangle over its longest side is below a thousandth of that side.
#[must_use]
pub fn is_sliver([a, b, c]: [DVec3; 3]) -> bool {
    let [u, v, w] = unit_sized([b - a, c - b, a - c]);
    let longest = u.length_squared().max(v.length_squared()).max(w.length_squared());
    u.cross(v).length() < SLIVER_HEIGHT * longest
}
