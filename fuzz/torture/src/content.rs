//! The content of a file that is checked.

/// The reason why a file is invalid.
pub(super) type Complaint = Box<dyn std::error::Error + Send + Sync>;

/// Positions and polygons of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Content {
    pub(super) positions: Vec<[f64; 3]>,
    /// The vertices of all faces, face after face.
    corners: Vec<u32>,
    /// The end of each face in `corners`.
    ends: Vec<usize>,
    /// The first number that is not finite and not a coordinate, with its name.
    pub(super) not_finite: Option<String>,
    /// Whether vertices of the file are vertices of the mesh. This is not so in formats that split vertices or store
    /// every triangle separately.
    pub(super) is_indexed: bool,
}

impl Content {
    /// Empty content of a file with indexed faces.
    pub(super) fn indexed() -> Self {
        Self { is_indexed: true, ..Self::default() }
    }

    /// Adds a face.
    pub(super) fn push_face(&mut self, vertices: impl IntoIterator<Item = u32>) {
        self.corners.extend(vertices);
        self.ends.push(self.corners.len());
    }

    /// Records a number other than a coordinate.
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

    /// The triangles, if there are no other faces.
    pub(super) fn triangles(&self) -> Option<Vec<[u32; 3]>> {
        self.faces().map(|face| face.try_into().ok()).collect()
    }

    /// The first index out of range, with its face.
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
