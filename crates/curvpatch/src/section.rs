//! Walking along a normal section: the polygon in which a plane through a point cuts the mesh.
//!
//! Every vertex lies on one of two sides of the plane; one *in* the plane counts as above it. With
//! that rule a triangle with vertices on both sides has exactly two crossed edges, whatever is hit
//! exactly, so the walk needs no special cases: a vertex in the plane costs a few steps of length
//! zero through its fan of triangles, and nothing else.

use glam::DVec3;
use mesh_core::{FaceId, HalfEdgeId, TriMesh, VertexId};

/// A plane through a point, spanned by a normal and a tangent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SectionPlane {
    /// The point that the section starts from.
    pub(crate) origin: DVec3,
    /// The unit tangent of the half-section that is called forward.
    pub(crate) tangent: DVec3,
    /// The unit vector across the plane.
    pub(crate) across: DVec3,
}

impl SectionPlane {
    pub(crate) fn new(origin: DVec3, normal: DVec3, tangent: DVec3) -> Self {
        Self { origin, tangent, across: normal.cross(tangent) }
    }
}

/// Why a walk went no further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum WalkEnd {
    /// It came to the boundary of the mesh.
    Boundary,
    /// It came back to the face that it started from.
    Returned,
    /// It crossed more faces than there are across the mesh.
    Lost,
}

impl WalkEnd {
    /// Whether the section goes round its component of the mesh, or counts as going round.
    pub(crate) fn is_round(self) -> bool {
        matches!(self, Self::Returned | Self::Lost)
    }
}

/// A vertex as seen from the plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sighting {
    /// Position relative to the origin of the section.
    pub(crate) at: DVec3,
    /// Signed distance from the plane.
    pub(crate) distance: f64,
}

impl Sighting {
    #[inline]
    pub(crate) fn new(position: DVec3, origin: DVec3, across: DVec3) -> Self {
        let at = position - origin;
        Self { at, distance: across.dot(at) }
    }

    #[inline]
    pub(crate) fn is_above(&self) -> bool {
        self.distance >= 0.0
    }

    /// Where the line between two vertices on either side meets the plane.
    #[inline]
    pub(crate) fn crossing(from: &Self, to: &Self) -> DVec3 {
        from.at + from.distance / (from.distance - to.distance) * (to.at - from.at)
    }
}

/// A walker that stands in a face and looks at the edge through which the section leaves it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SectionWalk<'a> {
    mesh: &'a TriMesh,
    plane: SectionPlane,
    start: FaceId,
    face: FaceId,
    /// The half-edge of `face` that the section leaves through.
    exit: HalfEdgeId,
    from: Sighting,
    to: Sighting,
    steps_left: usize,
}

impl<'a> SectionWalk<'a> {
    /// Two walkers in the same face, one for each half of the section, forward first.
    ///
    /// `None` when rounding puts all three vertices on one side of the plane, which takes a
    /// triangle of hardly any height.
    pub(crate) fn both_ways(
        mesh: &'a TriMesh,
        start: FaceId,
        plane: &SectionPlane,
    ) -> Option<[Self; 2]> {
        let topology = mesh.topology();
        let half_edges = topology.face_half_edges(start);
        let seen = half_edges.map(|h| sight(mesh, plane, topology.origin(h)));
        let mut exits = (0..3).filter_map(|i| {
            let (from, to) = (seen[i], seen[(i + 1) % 3]);
            (from.is_above() != to.is_above()).then(|| Self {
                mesh,
                plane: *plane,
                start,
                face: start,
                exit: half_edges[i],
                from,
                to,
                steps_left: most_steps(topology.face_count()),
            })
        });
        let (first, second) = (exits.next()?, exits.next()?);
        let ahead = |walk: &Self| walk.crossing().dot(plane.tangent);
        Some(if ahead(&first) >= ahead(&second) { [first, second] } else { [second, first] })
    }

    /// The face that the walker stands in.
    pub(crate) fn face(&self) -> FaceId {
        self.face
    }

    /// Where the section leaves the face, relative to the origin of the section.
    #[inline]
    pub(crate) fn crossing(&self) -> DVec3 {
        Sighting::crossing(&self.from, &self.to)
    }

    /// Goes on to the next face.
    #[inline]
    pub(crate) fn step(&mut self) -> Result<(), WalkEnd> {
        let topology = self.mesh.topology();
        let entry = self.exit.twin();
        let Some(face) = topology.face(entry) else { return Err(WalkEnd::Boundary) };
        if face == self.start {
            return Err(WalkEnd::Returned);
        }
        if self.steps_left == 0 {
            return Err(WalkEnd::Lost);
        }
        self.steps_left -= 1;
        self.face = face;
        // Seen from the old face the edge runs `from` - `to`; the new face has it the other way
        // round, followed by `from` - `apex` and `apex` - `to`.
        let second = topology.next(entry);
        let apex = sight(self.mesh, &self.plane, topology.target(second));
        if apex.is_above() == self.from.is_above() {
            self.exit = topology.next(second);
            self.from = apex;
        } else {
            self.exit = second;
            self.to = apex;
        }
        Ok(())
    }

    /// Follows the section for a length and says where it ends.
    #[inline]
    pub(crate) fn arc(mut self, length: f64) -> Arc {
        let mut walked = 0.0;
        let mut last = DVec3::ZERO;
        loop {
            let ahead = self.crossing() - last;
            let step = ahead.length();
            if walked + step >= length {
                let end = last + (length - walked) / step * ahead;
                return Arc { end, length, cut_short: None };
            }
            walked += step;
            last += ahead;
            if let Err(cause) = self.step() {
                return Arc { end: last, length: walked, cut_short: Some(cause) };
            }
        }
    }
}

/// How many faces a walk may cross in a mesh of so many. No section visits a face more than twice, and
/// across a surface with faces of some breadth there are about as many as the root of their number
/// tells. Round the apex of a fan with very many faces there are more, and the section counts as
/// going round.
pub(crate) fn most_steps(faces: usize) -> usize {
    const BREADTHS: f64 = 16.0;
    let across = 1024 + (BREADTHS * (faces as f64).sqrt()) as usize;
    across.min(2 * faces + 16)
}

#[inline]
fn sight(mesh: &TriMesh, plane: &SectionPlane, vertex: VertexId) -> Sighting {
    Sighting::new(mesh.position(vertex), plane.origin, plane.across)
}

/// One half of a section, from its origin on.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Arc {
    /// The end, relative to the origin of the section.
    pub(crate) end: DVec3,
    /// The length along the section.
    pub(crate) length: f64,
    /// Why the arc is shorter than asked for, if it is.
    pub(crate) cut_short: Option<WalkEnd>,
}

impl Arc {
    /// An arc that never left its origin.
    pub(crate) const EMPTY: Self =
        Self { end: DVec3::ZERO, length: 0.0, cut_short: Some(WalkEnd::Boundary) };

    /// The other half of a section that has come back to its face, where that comes back too: it is the same
    /// loop, the other way round. `starts` are where the two halves leave the face, this one first.
    pub(crate) fn reversed(&self, [this, other]: [DVec3; 2], most: f64) -> Option<Self> {
        let length = self.length - this.length() + other.length();
        let returns = self.cut_short == Some(WalkEnd::Returned) && length < most;
        returns.then_some(Self { end: this, length, ..*self })
    }
}

/// Both halves of a normal section, in the coordinates of its plane: x along the tangent, y along
/// the normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    pub(crate) forward: PlaneArc,
    pub(crate) backward: PlaneArc,
    /// The distance of the two ends.
    pub(crate) chord: f64,
}

/// The end of an arc in the coordinates of the section plane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlaneArc {
    pub(crate) x: f64,
    pub(crate) y: f64,
    pub(crate) length: f64,
    pub(crate) cut_short: Option<WalkEnd>,
}

impl Section {
    /// Walks both ways for the length `radius`.
    pub(crate) fn measure(
        mesh: &TriMesh,
        face: FaceId,
        plane: &SectionPlane,
        normal: DVec3,
        radius: f64,
    ) -> Self {
        let arcs = SectionWalk::both_ways(mesh, face, plane).map_or([Arc::EMPTY; 2], |walks| {
            let [forward, backward] = walks;
            let starts = walks.map(|walk| walk.crossing());
            let ahead = forward.arc(radius);
            [ahead, ahead.reversed(starts, radius).unwrap_or_else(|| backward.arc(radius))]
        });
        Self::new(arcs, plane, normal)
    }

    /// The section with these arcs, forward first.
    pub(crate) fn new(arcs: [Arc; 2], plane: &SectionPlane, normal: DVec3) -> Self {
        let [forward, backward] = arcs.map(|arc| PlaneArc {
            x: arc.end.dot(plane.tangent),
            y: arc.end.dot(normal),
            length: arc.length,
            cut_short: arc.cut_short,
        });
        Self { forward, backward, chord: arcs[0].end.distance(arcs[1].end) }
    }

    /// The length of both arcs together.
    pub(crate) fn length(&self) -> f64 {
        self.forward.length + self.backward.length
    }

    /// Whether an arc ended for such a reason.
    pub(crate) fn ended_by(&self, is_cause: impl Fn(WalkEnd) -> bool) -> bool {
        let arcs = [&self.forward, &self.backward];
        arcs.into_iter().any(|arc| arc.cut_short.is_some_and(&is_cause))
    }

    /// How much of the disc the section has: 1 for two full arcs, 0 when one of them is empty.
    pub(crate) fn weight(&self, radius: f64) -> f64 {
        self.forward.length * self.backward.length / (radius * radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_core::shapes::Torus;

    /// A section that comes back is walked once: its other half is what walking it would give.
    #[test]
    fn the_other_half_of_a_loop_is_the_loop_the_other_way_round() {
        let mesh = TriMesh::from_soup(&Torus { major: 3.0, minor: 1.0 }.mesh(40, 24).unwrap());
        let mesh = mesh.unwrap();
        let (mut reversed, mut walked) = (0, 0);
        for face in mesh.topology().faces().step_by(7) {
            let [a, b, c] = mesh.triangle(face);
            let normal = (b - a).cross(c - a).normalize();
            let tangent = (b - a).normalize();
            let plane = SectionPlane::new((a + 2.0 * b + 3.0 * c) / 6.0, normal, tangent);
            let Some(walks) = SectionWalk::both_ways(&mesh, face, &plane) else { continue };
            let round = walks[0].arc(1e3).length;
            for radius in [0.5 * round, 0.9999 * round, 1.0001 * round, 1e3] {
                let section = Section::measure(&mesh, face, &plane, normal, radius);
                let expected = Section::new(walks.map(|walk| walk.arc(radius)), &plane, normal);
                let backward = [&section.backward, &expected.backward];
                assert_eq!(backward[0].cut_short, backward[1].cut_short);
                let [found, expected] = backward.map(|arc| DVec3::new(arc.x, arc.y, arc.length));
                assert!(found.distance(expected) < 1e-9, "{found} {expected}");
                let returned = section.forward.cut_short == Some(WalkEnd::Returned);
                *(if returned { &mut reversed } else { &mut walked }) += 1;
            }
        }
        assert!(reversed > 100 && walked > 100, "{reversed} {walked}");
    }
}
