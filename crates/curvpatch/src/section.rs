//! Both halves of a normal section, in the coordinates of its plane.

use glam::DVec3;
use mesh_core::{FaceId, TriMesh};

use crate::scalar_walk::ScalarWalk;
use crate::section_arc::{SectionArc, WalkEnd};
use crate::section_plane::SectionPlane;

/// Both halves of a normal section. In the plane, x runs along the tangent and y along the normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Section {
    pub(crate) forward: PlaneArc,
    pub(crate) backward: PlaneArc,
    /// The distance between the two ends.
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
    /// Walks both halves for the length `radius`.
    pub(crate) fn measure(
        mesh: &TriMesh,
        face: FaceId,
        plane: &SectionPlane,
        normal: DVec3,
        radius: f64,
    ) -> Self {
        let walks = ScalarWalk::both_ways(mesh, face, plane);
        let arcs = walks.map_or([SectionArc::EMPTY; 2], |walks| {
            let [forward, backward] = walks;
            let exits = walks.map(|walk| walk.crossing());
            let ahead = forward.arc(radius);
            [ahead, ahead.reversed(exits, radius).unwrap_or_else(|| backward.arc(radius))]
        });
        Self::new(arcs, plane, normal)
    }

    /// The section with these arcs, forward first.
    pub(crate) fn new(arcs: [SectionArc; 2], plane: &SectionPlane, normal: DVec3) -> Self {
        let [forward, backward] = arcs.map(|arc| PlaneArc {
            x: arc.end.dot(plane.tangent),
            y: arc.end.dot(normal),
            length: arc.length,
            cut_short: arc.cut_short,
        });
        Self { forward, backward, chord: arcs[0].end.distance(arcs[1].end) }
    }

    /// The total length of both arcs.
    pub(crate) fn length(&self) -> f64 {
        self.forward.length + self.backward.length
    }

    /// Whether an arc is cut short by a cause that satisfies `is_cause`.
    pub(crate) fn is_cut_short_by(&self, is_cause: impl Fn(WalkEnd) -> bool) -> bool {
        let arcs = [&self.forward, &self.backward];
        arcs.into_iter().any(|arc| arc.cut_short.is_some_and(&is_cause))
    }

    /// Product of the two arc lengths.
    pub(crate) fn length_product(&self) -> f64 {
        self.forward.length * self.backward.length
    }

    /// The section with its [`Section::weight`].
    pub(crate) fn weighted(&self, radius: f64) -> (&Self, f64) {
        (self, self.weight(radius))
    }

    /// Product of the two arc lengths over `radius`²: 1 for two full arcs, 0 if one arc is empty.
    pub(crate) fn weight(&self, radius: f64) -> f64 {
        self.length_product() / (radius * radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh_shapes::Torus;

    /// A closed section is walked once. Its other half equals the result of walking it.
    #[test]
    fn the_other_half_of_a_closed_section_is_the_reversed_loop() {
        let mesh = TriMesh::from_soup(&Torus { major: 3.0, minor: 1.0 }.mesh(40, 24).unwrap());
        let mesh = mesh.unwrap();
        let (mut reversed, mut walked) = (0, 0);
        for face in mesh.topology().faces().step_by(7) {
            let [a, b, c] = mesh.triangle(face);
            let normal = (b - a).cross(c - a).normalize();
            let tangent = (b - a).normalize();
            let plane = SectionPlane::new((a + 2.0 * b + 3.0 * c) / 6.0, normal, tangent);
            let Some(walks) = ScalarWalk::both_ways(&mesh, face, &plane) else { continue };
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
