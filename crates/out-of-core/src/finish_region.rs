//! Finishing a region of a result that does not fit into memory, against its own part of the original.
//!
//! What is on the rim of its faces stays as it is, so that regions are finished one by one, on any machine, and
//! fit together again.

use std::path::Path;

use mesh_core::{FaceId, PolygonSoup, Repair, TriMesh, VertexId, build};
use simplify::Steps;

use crate::error::Error;
use crate::finish::{Finished, Finishing, NONE, only_moves};
use crate::region::Region;
use crate::star::stuck_vertices;
use crate::work::{Step, Work};

/// Finishes the faces that belong to a region; copies of others are left out.
pub(crate) fn finish_region(
    work: &Work,
    region: Region,
    options: &Steps,
    folder: &Path,
    see: &mut dyn FnMut(Step) -> bool,
) -> Result<Region, Error> {
    let (mesh, source) = own_mesh(&region)?;
    let bits = work.cells(0)?.trailing_zeros() - work.cells(region.level)?.trailing_zeros();
    let cells = (region.cell << bits)..((region.cell + 1) << bits);
    let finish = |options: &Steps, see: &mut dyn FnMut(Step) -> bool| {
        let finishing =
            Finishing { work, cells: cells.clone(), folder: folder.to_owned(), options };
        finishing.finish(mesh.clone(), see)
    };
    let mut finished = finish(options, see)?;
    // The neighbour may have come to the same edge.
    if has_new_edges(&mesh, &finished) {
        finished = finish(&only_moves(options), see)?;
    }
    Ok(put_back(region, &mesh, &source, &finished))
}

/// The faces that belong to a region as a mesh, and the place in the region of each vertex.
fn own_mesh(region: &Region) -> Result<(TriMesh, Vec<u32>), Error> {
    let triangles: Vec<[u32; 3]> = region.own_triangles().collect();
    let mut number = vec![NONE; region.positions.len()];
    let mut source = Vec::new();
    let mut soup =
        PolygonSoup::with_capacity(triangles.len(), triangles.len(), 3 * triangles.len());
    let too_large = |_| Error::RegionTooLarge { faces: triangles.len() as u64 };
    for triangle in &triangles {
        let corners = triangle.map(|v| {
            if number[v as usize] == NONE {
                number[v as usize] = source.len() as u32;
                source.push(v);
                soup.push_vertex(region.positions[v as usize]);
            }
            number[v as usize]
        });
        soup.push_face(&corners).map_err(too_large)?;
    }
    // What hangs together at a vertex alone comes apart; it is on the rim, and stays.
    let mut cut = Repair::strict();
    cut.cut_non_manifold = true;
    let built = build(&soup, &cut).map_err(|error| Error::Build(Box::new(error)))?;
    let source = built.provenance.vertex_source.iter().map(|&v| source[v as usize]).collect();
    Ok((built.mesh, source))
}

/// Whether there is an edge between vertices of the boundary that was not there.
fn has_new_edges(before: &TriMesh, finished: &Finished) -> bool {
    let topology = before.topology();
    let mut old = vec![NONE; finished.mesh.positions().len()];
    for v in topology.vertices().filter(|&v| topology.is_boundary_vertex(v)) {
        let new = finished.kept[v.index()];
        if new != NONE {
            old[new as usize] = v.get();
        }
    }
    let after = finished.mesh.topology();
    after.edges().any(|edge| {
        let [a, b] = after.edge_vertices(edge).map(|v| old[v.index()]);
        let found = |a, b| topology.find_half_edge(VertexId::new(a), VertexId::new(b)).is_some();
        a != NONE && b != NONE && !found(a, b) && !found(b, a)
    })
}

/// The region with other faces of its own: what is on their rim is known by its number, and what is within
/// gets one that is free.
fn put_back(region: Region, before: &TriMesh, source: &[u32], finished: &Finished) -> Region {
    let Region { level, cell, own, vertex_ids, homes, positions, .. } = region;
    let mesh = &finished.mesh;
    let topology = before.topology();
    // By vertex of the result the place in the region.
    let mut place = vec![NONE; mesh.positions().len()];
    let mut is_used = vec![false; positions.len()];
    let mut is_within = vec![false; positions.len()];
    for v in topology.vertices() {
        let (old, new) = (source[v.index()], finished.kept[v.index()]);
        if topology.is_boundary_vertex(v) && new != NONE {
            place[new as usize] = old;
            is_used[old as usize] = true;
        } else {
            is_within[old as usize] = true;
        }
    }
    let mut free = (0..own).filter(|&v| is_within[v] && !is_used[v]).map(|v| vertex_ids[v]);
    let mut beyond = (0..u64::MAX).rev();
    // Own vertices: those of the rim and those that only faces of others use, then those within.
    let mut owned: Vec<(u64, u32, bool)> = (0..own as u32)
        .filter(|&v| is_used[v as usize] || !is_within[v as usize])
        .map(|v| (vertex_ids[v as usize], v, true))
        .collect();
    for (new, _) in place.iter().enumerate().filter(|(_, place)| **place == NONE) {
        let id = free.next().or_else(|| beyond.next()).unwrap_or_default();
        owned.push((id, new as u32, false));
    }
    owned.sort_unstable();
    let others: Vec<u32> =
        (own as u32..positions.len() as u32).filter(|&v| is_used[v as usize]).collect();
    let mut number_of_old = vec![NONE; positions.len()];
    let mut number = vec![NONE; mesh.positions().len()];
    let mut result = Region { level, cell, own: owned.len(), ..Region::default() };
    for (i, &(id, v, is_old)) in (0..).zip(&owned) {
        result.vertex_ids.push(id);
        if is_old {
            number_of_old[v as usize] = i;
            result.positions.push(positions[v as usize]);
        } else {
            number[v as usize] = i;
            result.positions.push(mesh.positions()[v as usize]);
        }
    }
    for (i, &v) in (owned.len() as u32..).zip(&others) {
        number_of_old[v as usize] = i;
        result.vertex_ids.push(vertex_ids[v as usize]);
        result.homes.push(homes[v as usize - own]);
        result.positions.push(positions[v as usize]);
    }
    for (new, &old) in place.iter().enumerate().filter(|(_, old)| **old != NONE) {
        number[new] = number_of_old[old as usize];
    }
    let faces = mesh.topology().faces();
    let triangle = |face: FaceId| mesh.topology().face_vertices(face).map(|v| number[v.index()]);
    result.triangles = faces.map(triangle).collect();
    result.stuck = stuck_vertices(result.own, &result.triangles);
    result
}
