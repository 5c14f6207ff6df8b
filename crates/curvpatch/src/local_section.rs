//! One section whose length is limited by the shape of the surface: its turning, its boundary, and the
//! number of faces.

use glam::DVec3;
use mesh_core::TriMesh;

use crate::scalar_walk::ScalarWalk;
use crate::section::Section;
use crate::section_arc::{SectionArc, WalkEnd};
use crate::section_plane::SectionPlane;
use crate::tangent_plane::TangentPlane;

/// A section with the weight of its curvature and the reasons for its length.
pub(crate) struct LocalSection {
    pub(crate) section: Section,
    /// The intended length of the arcs.
    pub(crate) intended: f64,
    /// Product of the arc lengths over the square of the intended length: 1 for two full arcs. 0 if both
    /// arcs end in the first face, where every section is straight.
    pub(crate) weight: f64,
    /// At least one arc ends at the boundary of the mesh.
    pub(crate) truncated: bool,
    /// The section closes on itself, and no shorter section leaves the first face.
    pub(crate) wrapped: bool,
    /// Points of both arcs. Points inside the first face, where every section is straight, are at the origin.
    pub(crate) points: [SectionPoint; 4],
}

/// A point of a section in the coordinates of its plane, in units of the intended length of the arcs.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct SectionPoint {
    /// Position along the tangent.
    pub(crate) along: f64,
    /// Depth below the tangent plane.
    pub(crate) depth: f64,
}

/// Cosine of the largest turning angle of an arc, 75°.
///
/// A section of a tube that turns further leaves the side of the tube where it started.
const COS_MAX_TURN: f64 = 0.258_819_045_102_520_76;

/// Cosine of the smallest angle between two successive segments at a crease, 60°. Sections pass creases;
/// only smooth turning is limited.
const COS_CREASE: f64 = 0.5;

/// The largest number of faces of an arc. Arcs of four edges cross about eight faces, and many
/// more across long triangles.
const MAX_FACES: usize = 128;

/// Where the points of an arc are, as shares of its length.
const SHARES: [f64; 2] = [1.0, 0.5];

/// An arc of limited turning, and the reason for its end.
struct LimitedArc {
    /// Where the arc leaves its faces, and its length up to there.
    points: [(DVec3, f64); MAX_FACES],
    length: f64,
    end: ArcEnd,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ArcEnd {
    Full,
    Boundary,
    Closed,
    Turned,
    MaxFaces,
}

impl LocalSection {
    /// Measures the section in `plane`, with the intended length to either side.
    pub(crate) fn measure(
        mesh: &TriMesh,
        tangent_plane: &TangentPlane,
        plane: &SectionPlane,
        length: f64,
    ) -> Self {
        let normal = tangent_plane.normal;
        let Some(walks) = ScalarWalk::both_ways(mesh, tangent_plane.face, plane) else {
            let section = Section::new([SectionArc::EMPTY; 2], plane, normal);
            let points = Default::default();
            return Self {
                section,
                intended: length,
                weight: 0.0,
                truncated: true,
                wrapped: false,
                points,
            };
        };
        let limited = [
            limited_arc(walks[0], plane.tangent, length),
            limited_arc(walks[1], -plane.tangent, length),
        ];
        let exits = walks.map(|walk| walk.crossing().length());
        let is_any = |end: ArcEnd| limited.iter().any(|arc| arc.end == end);
        let intended = limited.iter().map(LimitedArc::intended_length).fold(length, f64::min);
        let point = |at: usize| {
            let (arc, exit) = (&limited[at / SHARES.len()], exits[at / SHARES.len()]);
            let length = SHARES[at % SHARES.len()] * arc.length.min(intended);
            if length <= exit {
                return SectionPoint::default();
            }
            let place = arc.at(length) / intended;
            SectionPoint { along: place.dot(plane.tangent), depth: -place.dot(normal) }
        };
        let points = core::array::from_fn(point);
        let shorter = limited.iter().map(|arc| arc.length).fold(intended, f64::min);
        // Equal arcs make the error of the Menger curvature quadratic in their length. Arcs that hardly
        // leave the first face would give no information.
        let longest_exit = exits[0].max(exits[1]);
        let lengths = if shorter > 1.5 * longest_exit {
            [shorter; 2]
        } else {
            [0, 1].map(|side| limited[side].length.min(intended))
        };
        let arcs = [0, 1].map(|side| {
            let length = lengths[side];
            SectionArc { end: limited[side].at(length), length, cut_short: None }
        });
        let leaves = lengths[0] > exits[0] || lengths[1] > exits[1];
        let weight = lengths[0] * lengths[1] / (intended * intended);
        Self {
            section: Section::new(arcs, plane, normal),
            intended,
            weight: if leaves { weight } else { 0.0 },
            truncated: is_any(ArcEnd::Boundary),
            wrapped: is_any(ArcEnd::Closed) && !leaves,
            points,
        }
    }
}

impl LocalSection {
    /// The section with its weight.
    pub(crate) fn weighted(&self) -> (&Section, f64) {
        (&self.section, self.weight)
    }
}

impl LimitedArc {
    /// The place on the arc after a length.
    fn at(&self, length: f64) -> DVec3 {
        let mut from = (DVec3::ZERO, 0.0);
        for &to in &self.points {
            if to.1 >= length {
                let step = to.1 - from.1;
                let share = if step > 0.0 { (length - from.1) / step } else { 0.0 };
                return from.0 + share * (to.0 - from.0);
            }
            if to.1 < from.1 {
                break;
            }
            from = to;
        }
        from.0
    }

    /// The length that counts as full. A quarter of a loop is the longest useful arc on it.
    fn intended_length(&self) -> f64 {
        match self.end {
            ArcEnd::Turned => self.length,
            ArcEnd::Closed => 0.25 * self.length,
            ArcEnd::Full | ArcEnd::Boundary | ArcEnd::MaxFaces => f64::INFINITY,
        }
    }
}

/// Follows a section up to `length`, at most [`MAX_FACES`] faces and 75° of smooth turning.
fn limited_arc(mut walk: ScalarWalk<'_>, tangent: DVec3, length: f64) -> LimitedArc {
    let mut arc =
        LimitedArc { points: [(DVec3::ZERO, 0.0); MAX_FACES], length: 0.0, end: ArcEnd::MaxFaces };
    let mut last = DVec3::ZERO;
    let mut previous = tangent;
    let mut has_crease = false;
    for point in &mut arc.points {
        let ahead = walk.crossing() - last;
        let step = ahead.length();
        if step > 0.0 && !has_crease {
            let direction = ahead / step;
            if direction.dot(previous) < COS_CREASE {
                has_crease = true;
            } else if direction.dot(tangent) < COS_MAX_TURN {
                arc.end = ArcEnd::Turned;
                break;
            }
            previous = direction;
        }
        last += ahead;
        *point = (last, arc.length + step);
        if arc.length + step >= length {
            (arc.length, arc.end) = (length, ArcEnd::Full);
            break;
        }
        arc.length += step;
        if let Err(cause) = walk.step() {
            let is_boundary = cause == WalkEnd::Boundary;
            arc.end = if is_boundary { ArcEnd::Boundary } else { ArcEnd::Closed };
            break;
        }
    }
    arc
}
