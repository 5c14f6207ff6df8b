//! What is left once it fits into memory: the last collapses, in one piece.

use core::ops::ControlFlow;

use mesh_core::{PolygonSoup, Repair, TriMesh, build};
use simplify::regions::Fragment;
use simplify::{Options, Progress, Run, finish_collapses};

use crate::error::Error;
use crate::region::Region;
use crate::star::stuck_vertices;

/// Collapses the region of the whole mesh to the number of faces that the options name.
pub(crate) fn collapse_rest(
    region: Region,
    options: &Options,
    size: f64,
    faces_before: usize,
    observe: &mut dyn FnMut(&Progress) -> ControlFlow<()>,
) -> Result<(TriMesh, Run), Error> {
    let is_manifold = stuck_vertices(region.positions.len(), &region.triangles).is_empty();
    let fragment = if is_manifold { region.into_fragment().0 } else { cut(region)? };
    Ok(finish_collapses(fragment, options, size, faces_before, observe)?)
}

/// The region as a manifold.
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
