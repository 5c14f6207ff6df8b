//! The repairs of a build.

use core::fmt;

use crate::build::sample::{Sample, VertexPair};

/// The repairs that [`crate::build()`] made. Indices are of faces and vertices of the soup, from zero.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
#[non_exhaustive]
pub struct BuildReport {
    /// Vertices of the soup.
    pub vertices_in: usize,
    /// Faces of the soup, of any number of corners.
    pub faces_in: usize,
    /// Vertices of the mesh.
    pub vertices_out: usize,
    /// Triangles of the mesh.
    pub faces_out: usize,
    /// Faces of more than three corners that were cut into triangles.
    pub triangulated: usize,
    /// Of these, the polygons that are not simple: their triangles may overlap.
    pub triangulated_badly: Sample<u32>,
    /// Vertices merged into an earlier one.
    pub welded_vertices: Sample<u32>,
    /// Faces dropped because they refer to vertices that do not exist.
    pub dropped_out_of_range: Sample<u32>,
    /// Vertices dropped because their position is infinite or not a number.
    pub not_finite_vertices: Sample<u32>,
    /// Faces dropped because such a vertex is a corner of them.
    pub dropped_not_finite: Sample<u32>,
    /// Faces that lost a triangle that uses a vertex twice (or that had fewer than three corners),
    /// once for each triangle.
    pub dropped_degenerate: Sample<u32>,
    /// Faces that lost a triangle because an earlier one has the same vertices, once for each
    /// triangle.
    pub dropped_duplicates: Sample<u32>,
    /// Faces that were reversed, to agree with their neighbours or to face outward, once for each triangle.
    pub flipped_faces: Sample<u32>,
    /// Connected components that were inside out and were turned as a whole, each by its first face. See
    /// [`Repair::reorient`](crate::build::Repair::reorient).
    pub turned_components: Sample<u32>,
    /// Connected components whose outside cannot be told, such as flat sheets; counted when faces may be reversed.
    pub undecided_components: usize,
    /// Edges along which the surface was cut.
    pub cut_edges: Sample<VertexPair>,
    /// Vertices that were duplicated, once for each copy.
    pub split_vertices: Sample<u32>,
    /// Vertices dropped because no face of the mesh uses them.
    pub dropped_vertices: Sample<u32>,
    /// Faces whose triangles have exactly zero area although their vertices are distinct, once for
    /// each triangle. They are kept.
    pub zero_area_faces: Sample<u32>,
}

impl BuildReport {
    /// Whether no repair was made. Cutting polygons into triangles is not a repair.
    #[must_use]
    pub fn is_unchanged(&self) -> bool {
        self.repairs().next().is_none()
    }

    /// Description of the merging of vertices in [`BuildReport::repairs`].
    pub const MERGED: &str = "merged vertices";

    /// Description and count of each repair that was made.
    pub fn repairs(&self) -> impl Iterator<Item = (&'static str, usize)> {
        self.lines().filter_map(|line| Some((line.repair?, line.count)))
    }

    /// Repairs and remarks with a count above zero.
    fn lines(&self) -> impl Iterator<Item = Line<'_>> {
        let repaired = |repair, what, count, elements| {
            let repair = Some(repair);
            Line { repair, what, count, elements }
        };
        let met = |what, count, elements| Line { repair: None, what, count, elements };
        let lines = [
            repaired(
                Self::MERGED,
                Self::MERGED,
                self.welded_vertices.count(),
                &self.welded_vertices,
            ),
            repaired(
                "dropped faces with indices out of range",
                "dropped faces with indices out of range",
                self.dropped_out_of_range.count(),
                &self.dropped_out_of_range,
            ),
            repaired(
                "dropped vertices at infinite or undefined positions",
                "dropped vertices at infinite or undefined positions",
                self.not_finite_vertices.count(),
                &self.not_finite_vertices,
            ),
            repaired(
                "dropped faces with infinite or undefined positions",
                "dropped faces with infinite or undefined positions",
                self.dropped_not_finite.count(),
                &self.dropped_not_finite,
            ),
            met("polygons cut into triangles", self.triangulated, &self.triangulated),
            met(
                "polygons that are not simple, cut as well as possible",
                self.triangulated_badly.count(),
                &self.triangulated_badly,
            ),
            repaired(
                "dropped degenerate triangles",
                "dropped degenerate triangles of faces",
                self.dropped_degenerate.count(),
                &self.dropped_degenerate,
            ),
            repaired(
                "dropped duplicate triangles",
                "dropped duplicate triangles of faces",
                self.dropped_duplicates.count(),
                &self.dropped_duplicates,
            ),
            repaired(
                "reversed triangles",
                "reversed triangles of faces",
                self.flipped_faces.count(),
                &self.flipped_faces,
            ),
            repaired(
                "inside-out components turned outward",
                "inside-out components turned outward, by their first face",
                self.turned_components.count(),
                &self.turned_components,
            ),
            repaired("cut edges", "cut along edges", self.cut_edges.count(), &self.cut_edges),
            repaired(
                "duplicated vertices",
                "duplicated vertices",
                self.split_vertices.count(),
                &self.split_vertices,
            ),
            repaired(
                "dropped unused vertices",
                "dropped unused vertices",
                self.dropped_vertices.count(),
                &self.dropped_vertices,
            ),
            met(
                "kept triangles of zero area of faces",
                self.zero_area_faces.count(),
                &self.zero_area_faces,
            ),
        ];
        lines.into_iter().filter(|line| line.count > 0)
    }
}

/// A line of the report.
struct Line<'a> {
    /// Description of the repair, for a count. `None` if the line is no repair.
    repair: Option<&'static str>,
    /// Description in front of the elements.
    what: &'static str,
    count: usize,
    elements: &'a dyn fmt::Display,
}

/// One line with the sizes, and one line per kind of repair.
impl fmt::Display for BuildReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} vertices and {} faces became {} vertices and {} triangles",
            self.vertices_in, self.faces_in, self.vertices_out, self.faces_out
        )?;
        for Line { what, elements, .. } in self.lines() {
            write!(f, "\n{what}: {elements}")?;
        }
        Ok(())
    }
}
