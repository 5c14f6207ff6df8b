//! What a file holds, as far as it is checked.

/// Why a file is not what it should be.
pub(super) type Complaint = Box<dyn std::error::Error + Send + Sync>;

/// Positions and polygons of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Content {
    pub(super) positions: Vec<[f64; 3]>,
    /// The vertices of all faces, one face after the other.
    corners: Vec<u32>,
    /// Where in `corners` each face ends.
    ends: Vec<usize>,
    /// The first number that is not finite and no coordinate, by the name of what it is.
    pub(super) not_finite: Option<String>,
    /// Whether a vertex of the file is a vertex of the mesh: not so where a format splits vertices,
    /// or stores every triangle by itself.
    pub(super) is_indexed: bool,
}

impl Content {
    /// Nothing yet, of a file whose faces name its vertices.
    pub(super) fn indexed() -> Self {
        Self { is_indexed: true, ..Self::default() }
    }

    /// Adds a face.
    pub(super) fn push_face(&mut self, vertices: impl IntoIterator<Item = u32>) {
        self.corners.extend(vertices);
        self.ends.push(self.corners.len());
    }

    /// Notes a number other than a coordinate.
    pub(super) fn see(&mut self, what: &str, number: f64) {
        if !number.is_finite() && self.not_finite.is_none() {
            self.not_finite = Some(format!("{what} {number}"));
        }
    }

    pub(super) fn face_count(&self) -> usize {
        self.ends.len()
    }

    pub(super) fn faces(&self) -> impl Iterator<Item = &[u32]> {
        let starts = [0].into_iter().chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| self.corners.get(start..end).unwrap_or_default())
    }

    /// The triangles, if there is nothing else.
    pub(super) fn triangles(&self) -> Option<Vec<[u32; 3]>> {
        self.faces().map(|face| face.try_into().ok()).collect()
    }

    /// The first index that names no vertex, with its face.
    pub(super) fn out_of_range(&self) -> Option<(usize, u32)> {
        let is_missing = |&vertex: &u32| vertex as usize >= self.positions.len();
        let missing = |face: &[u32]| face.iter().copied().find(is_missing);
        self.faces().enumerate().find_map(|(number, face)| Some((number, missing(face)?)))
    }

    /// The first vertex whose position is not finite.
    pub(super) fn not_finite_vertex(&self) -> Option<usize> {
        self.positions.iter().position(|position| !position.iter().all(|x| x.is_finite()))
    }
}
