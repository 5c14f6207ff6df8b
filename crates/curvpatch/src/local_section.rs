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
    /// Product of the arc lengths over the square of the intended length: 1 for two full arcs. 0 if both
    /// arcs end in the first face, where every section is straight.
    pub(crate) weight: f64,
    /// At least one arc ends at the boundary of the mesh.
    pub(crate) truncated: bool,
    /// The section closes on itself, and no shorter section leaves the first face.
    pub(crate) wrapped: bool,
}

/// Cosine of the largest turning angle of an arc, 75°.
///
/// A section of a tube that turns further leaves the side of the tube where it started.
const COS_MAX_TURN: f64 = 0.258_819_045_102_520_76;

/// Cosine of the smallest angle between two successive segments at a crease, 60°. Sections pass creases;
/// only smooth turning is limited.
const COS_CREASE: f64 = 0.5;

/// The largest number of faces of an arc. Arcs of four edges cross about eight faces.
const MAX_FACES: usize = 64;

/// An arc of limited turning, and the reason for its end.
#[derive(Clone, Copy)]
struct LimitedArc {
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
            return Self { section, weight: 0.0, truncated: true, wrapped: false };
        };
        let limited = [
            limited_arc(walks[0], plane.tangent, length),
            limited_arc(walks[1], -plane.tangent, length),
        ];
        let exits = walks.map(|walk| walk.crossing().length());
        let is_any = |end: ArcEnd| limited.iter().any(|arc| arc.end == end);
        let intended = limited.iter().map(LimitedArc::intended_length).fold(length, f64::min);
        let shorter = limited.iter().map(|arc| arc.length).fold(intended, f64::min);
        // Equal arcs make the error of the Menger curvature quadratic in their length. Arcs that hardly
        // leave the first face would give no information.
        let longest_exit = exits[0].max(exits[1]);
        let lengths = if shorter > 1.5 * longest_exit {
            [shorter; 2]
        } else {
            limited.map(|arc| arc.length.min(intended))
        };
        let arcs = [walks[0].arc(lengths[0]), walks[1].arc(lengths[1])];
        let leaves = lengths[0] > exits[0] || lengths[1] > exits[1];
        let weight = lengths[0] * lengths[1] / (intended * intended);
        Self {
            section: Section::new(arcs, plane, normal),
            weight: if leaves { weight } else { 0.0 },
            truncated: is_any(ArcEnd::Boundary),
            wrapped: is_any(ArcEnd::Closed) && !leaves,
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
    let (mut walked, mut last) = (0.0, DVec3::ZERO);
    let mut previous = tangent;
    let mut has_crease = false;
    for _ in 0..MAX_FACES {
        let ahead = walk.crossing() - last;
        let step = ahead.length();
        if step > 0.0 && !has_crease {
            let direction = ahead / step;
            if direction.dot(previous) < COS_CREASE {
                has_crease = true;
            } else if direction.dot(tangent) < COS_MAX_TURN {
                return LimitedArc { length: walked, end: ArcEnd::Turned };
            }
            previous = direction;
        }
        if walked + step >= length {
            return LimitedArc { length, end: ArcEnd::Full };
        }
        walked += step;
        last += ahead;
        match walk.step() {
            Ok(()) => {}
            Err(WalkEnd::Boundary) => return LimitedArc { length: walked, end: ArcEnd::Boundary },
            Err(WalkEnd::Returned | WalkEnd::StepLimit) => {
                return LimitedArc { length: walked, end: ArcEnd::Closed };
            }
        }
    }
    LimitedArc { length: walked, end: ArcEnd::MaxFaces }
}
