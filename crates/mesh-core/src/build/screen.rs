//! Checks before the build: sizes, indices and coordinates.

use crate::build::error::BuildError;
use crate::build::repair::Repair;
use crate::build::report::BuildReport;
use crate::build::sample::Sample;
use crate::build::soup::PolygonSoup;
use crate::index::as_u32;
use crate::topology::handle::{HalfEdgeId, Handle, VertexId};

/// Leaves room for two half-edges per side of a triangle and for a copy of a vertex per corner: a
/// polygon has fewer triangles than corners.
pub(crate) fn check_sizes(soup: &PolygonSoup) -> Result<(), BuildError> {
    let (count, limit) = (soup.corners().len(), HalfEdgeId::LIMIT / 6);
    if count > limit {
        return Err(BuildError::TooManyElements { what: "corners", count, limit });
    }
    let (count, limit) = (soup.vertex_count(), VertexId::LIMIT / 2);
    if count > limit {
        return Err(BuildError::TooManyElements { what: "vertices", count, limit });
    }
    Ok(())
}

/// Refuses faces with indices out of range or fewer than three corners, or returns those to leave
/// out, ascending.
pub(crate) fn check_faces(
    soup: &PolygonSoup,
    repair: &Repair,
    report: &mut BuildReport,
) -> Result<Vec<u32>, BuildError> {
    let vertex_count = soup.vertex_count();
    let is_outside = |&index: &u32| index as usize >= vertex_count;
    let all_inside = !soup.corners().iter().any(is_outside);
    if all_inside && soup.faces().all(|face| face.len() >= 3) {
        return Ok(Vec::new());
    }
    let mut first_outside = None;
    let mut first_small = None;
    let mut outside = Sample::default();
    let mut small = Sample::default();
    let mut left_out = Vec::new();
    for (id, face) in soup.faces().enumerate() {
        let id = as_u32(id);
        if let Some(&index) = face.iter().find(|index| is_outside(index)) {
            first_outside.get_or_insert((id, index));
            outside.push(id);
        } else if face.len() < 3 {
            first_small.get_or_insert((id, face.len()));
            small.push(id);
        } else {
            continue;
        }
        left_out.push(id);
    }
    match first_outside {
        Some((face, index)) if !repair.drop_out_of_range => {
            return Err(BuildError::IndexOutOfRange { face, index, vertex_count, faces: outside });
        }
        _ => report.dropped_out_of_range = outside,
    }
    match first_small {
        Some((face, corners)) if !repair.drop_degenerate => {
            return Err(BuildError::TooFewCorners { face, corners, faces: small });
        }
        _ => report.dropped_degenerate = small,
    }
    Ok(left_out)
}

/// Refuses coordinates that are not finite, except of vertices that will be dropped. Returns the faces that go with
/// them, ascending.
pub(crate) fn check_coordinates(
    soup: &PolygonSoup,
    repair: &Repair,
    left_out: &[u32],
) -> Result<Vec<u32>, BuildError> {
    if soup.positions().iter().all(|position| position.is_finite()) {
        return Ok(Vec::new());
    }
    let is_kept = |id: &u32| left_out.binary_search(id).is_err();
    if repair.drop_not_finite {
        let is_bad = |&vertex: &u32| !soup.positions()[vertex as usize].is_finite();
        let faces = (0..as_u32(soup.face_count())).filter(is_kept);
        return Ok(faces.filter(|&id| soup.face(id as usize).iter().any(is_bad)).collect());
    }
    let mut matters = vec![!repair.drop_unreferenced; soup.vertex_count()];
    for id in (0..as_u32(soup.face_count())).filter(is_kept) {
        soup.face(id as usize).iter().for_each(|&vertex| matters[vertex as usize] = true);
    }
    let positions = soup.positions().iter().zip(matters).enumerate();
    let vertices: Sample<u32> = positions
        .filter(|(_, (position, matters))| *matters && !position.is_finite())
        .map(|(vertex, _)| as_u32(vertex))
        .collect();
    match vertices.first().first() {
        Some(&vertex) => {
            let position = soup.positions()[vertex as usize].to_array();
            Err(BuildError::NonFiniteCoordinate { vertex, position, vertices })
        }
        None => Ok(Vec::new()),
    }
}
