//! The last collapses of a run: all regions of a level as one mesh in memory.

use core::ops::ControlFlow;

use mesh_core::{PolygonSoup, Repair, TriMesh, build};
use simplify::blocks::Fragment;
use simplify::{Options, Progress, Run, StopReason, finish_collapses};

use crate::error::Error;
use crate::ingest::Summary;
use crate::non_manifold::non_manifold_vertices;
use crate::region::Region;
use crate::step::Step;

/// Collapses all regions of a level to the number of faces in the options. The summary belongs to the input.
pub(crate) fn collapse_in_memory(
    fragment: Fragment,
    options: &Options,
    summary: &Summary,
    level: u32,
    observer: &mut dyn FnMut(Step) -> bool,
) -> Result<(TriMesh, Run), Error> {
    let faces_before = usize::try_from(summary.triangles).unwrap_or(usize::MAX);
    let mut observe = |now: &Progress| {
        let of = (faces_before - now.face_target.min(faces_before)) as u64;
        let done = (faces_before - now.faces.min(faces_before)) as u64;
        let step = Step { what: "collapsing", done, of, level };
        if observer(step) { ControlFlow::Continue(()) } else { ControlFlow::Break(()) }
    };
    let done = finish_collapses(fragment, options, summary.size(), faces_before, &mut observe)?;
    if done.1.stop == StopReason::Cancelled {
        return Err(Error::Stopped);
    }
    Ok(done)
}

/// The fragment for the collapses, from the region of the whole mesh. Non-manifold vertices are cut.
pub(crate) fn final_fragment(region: Region) -> Result<Fragment, Error> {
    let is_manifold = non_manifold_vertices(region.positions.len(), &region.triangles).is_empty();
    if is_manifold { Ok(region.into_fragment().0) } else { cut(region) }
}

/// Cuts the region at its non-manifold vertices.
fn cut(region: Region) -> Result<Fragment, Error> {
    let Region { positions, quadrics, triangles, .. } = region;
    let corners = triangles.len() * 3;
    let mut soup = PolygonSoup::with_capacity(positions.len(), triangles.len(), corners);
    positions.iter().for_each(|&position| {
        soup.push_vertex(position);
    });
    for triangle in &triangles {
        let too_large = |_| Error::RegionTooLarge { faces: triangles.len() as u64 };
        soup.push_face(triangle).map_err(too_large)?;
    }
    let built = build(&soup, &Repair::lenient()).map_err(|error| Error::Build(Box::new(error)))?;
    let topology = built.mesh.topology();
    let quadric = |&v: &u32| quadrics.get(v as usize).copied().unwrap_or_default();
    Ok(Fragment {
        own: built.mesh.positions().len(),
        positions: built.mesh.positions().to_vec(),
        quadrics: if quadrics.is_empty() {
            Vec::new()
        } else {
            built.provenance.vertex_source.iter().map(quadric).collect()
        },
        triangles: topology.triangles().collect(),
        vertex_ids: Vec::new(),
    })
}
