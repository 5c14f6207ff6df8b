//! Faces that no edit may produce: faces that turn too far, and slivers.

use glam::DVec3;

/// The smallest cosine between the normals of a face before and after an edit.
const MIN_COSINE: f64 = 0.5;

/// The smallest height of a new face relative to its longest side. Reports call a face a sliver below half of this,
/// which leaves room for the rounding of coordinates in files.
const MIN_HEIGHT: f64 = 2e-3;

/// Whether a face with the vector area `new` is turned by less than sixty degrees from `old`.
pub(crate) fn keeps_side(new: DVec3, old: DVec3) -> bool {
    new.dot(old) > MIN_COSINE * new.length() * old.length()
}

/// Whether none of the new faces is a sliver, or the slivers among them are neither more nor flatter than those among
/// the old ones: a mesh that has slivers must stay editable.
pub(crate) fn keeps_height<const N: usize>(new: [[DVec3; 3]; N], old: [[DVec3; 3]; N]) -> bool {
    let (lowest, slivers) = lowest_and_slivers(&new);
    if slivers == 0 {
        return true;
    }
    let (before, slivers_before) = lowest_and_slivers(&old);
    lowest > 0.0 && lowest >= before && slivers <= slivers_before
}

/// Whether a face is a sliver, or has no area.
pub(crate) fn is_sliver(face: [DVec3; 3]) -> bool {
    lowest_and_slivers(&[face]).1 > 0
}

/// The square of the lowest relative height, and the number of slivers.
fn lowest_and_slivers(faces: &[[DVec3; 3]]) -> (f64, usize) {
    let heights = faces.iter().map(squared_height);
    heights.fold((f64::INFINITY, 0), |(lowest, slivers), height| {
        let is_sliver = height < MIN_HEIGHT * MIN_HEIGHT;
        (lowest.min(height), slivers + usize::from(is_sliver))
    })
}

/// The height over the longest side, relative to that side, squared; 0 for a face without area.
fn squared_height(&[a, b, c]: &[DVec3; 3]) -> f64 {
    let longest =
        (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    // Twice the area is the longest side times the height over it.
    let squared = (b - a).cross(c - a).length_squared();
    if squared > 0.0 { squared / (longest * longest) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A face with the longest side 1 and this height.
    fn with_height(height: f64) -> [DVec3; 3] {
        [DVec3::ZERO, DVec3::X, DVec3::new(0.4, height, 0.0)]
    }

    #[test]
    fn slivers_are_told_by_their_height_at_any_size() {
        for size in [1e-60, 1.0, 1e60] {
            let face = |height: f64| with_height(height).map(|p| size * p);
            let fine = face(0.5);
            assert!(keeps_height([face(0.00201), fine], [fine, fine]));
            assert!(!keeps_height([face(0.00199), fine], [fine, fine]));
            // Slivers that were there may stay and get higher, but neither lower nor more.
            assert!(keeps_height([face(1e-4), fine], [face(1e-5), fine]));
            assert!(!keeps_height([face(1e-5), fine], [face(1e-4), fine]));
            assert!(!keeps_height([face(1e-4), face(1e-4)], [face(1e-5), fine]));
        }
    }

    #[test]
    fn faces_without_area_are_refused_whatever_was_there() {
        let flat = with_height(0.0);
        assert!(!keeps_height([flat], [with_height(0.1)]));
        assert!(!keeps_height([flat], [flat]));
        assert!(!keeps_height([[DVec3::NAN; 3]], [with_height(0.1)]));
    }

    #[test]
    fn a_face_keeps_its_side_up_to_sixty_degrees() {
        let turned =
            |degrees: f64| DVec3::new(degrees.to_radians().sin(), 0.0, degrees.to_radians().cos());
        assert!(keeps_side(turned(59.0), DVec3::Z) && !keeps_side(turned(61.0), DVec3::Z));
    }
}
