//! Joining the regions of neighbouring cells, so that vertices along their seams can move.

use glam::DVec3;
use mesh_core::as_u32;
use simplify::Quadric;

use crate::error::Error;
use crate::region::Region;

/// Joins the regions of cells whose numbers are equal without their last `bits` binary digits. That number is the cell
/// of the joined region on the next level. The regions may be in any order.
///
/// # Errors
/// Together the regions are too large for indices of 32 bits, one is missing, or they belong to different runs.
///
/// # Panics
/// There is no region, or the cells do not make up one cell.
pub fn join(mut regions: Vec<Region>, bits: u32) -> Result<Region, Error> {
    regions.sort_unstable_by_key(|region| region.cell);
    assert!(!regions.is_empty(), "regions to be joined");
    let (level, cell) = (regions[0].level + 1, regions[0].cell >> bits);
    assert!(regions.iter().all(|region| region.cell >> bits == cell), "cells of one cell");
    let faces: usize = regions.iter().map(|region| region.triangles.len()).sum();
    let vertices: usize = regions.iter().map(|region| region.positions.len()).sum();
    if faces > u32::MAX as usize / 3 || vertices > u32::MAX as usize {
        return Err(Error::RegionTooLarge { faces: faces as u64 });
    }
    // The own vertices of all regions, in the order of the input. Their numbers fit into 32 bits.
    let mut order: Vec<(u64, u32, u32)> = Vec::new();
    for (which, region) in regions.iter().enumerate() {
        let own = region.vertex_ids[..region.own].iter().zip(0..);
        order.extend(own.map(|(&id, v)| (id, as_u32(which), v)));
    }
    order.sort_unstable();
    let own = order.len();
    let mut number: Vec<Vec<u32>> =
        regions.iter().map(|region| vec![u32::MAX; region.positions.len()]).collect();
    for (new, &(_, which, v)) in order.iter().enumerate() {
        number[which as usize][v as usize] = as_u32(new);
    }
    let has_quadrics = regions.iter().all(|region| region.quadrics.len() == region.own);
    let quadric = |&(_, which, v): &(u64, u32, u32)| regions[which as usize].quadrics[v as usize];
    let quadrics: Vec<Quadric> =
        if has_quadrics { order.iter().map(quadric).collect() } else { Vec::new() };
    let position = |&(_, which, v): &(u64, u32, u32)| regions[which as usize].positions[v as usize];
    let mut positions: Vec<DVec3> = order.iter().map(position).collect();
    let mut vertex_ids: Vec<u64> = order.iter().map(|&(id, ..)| id).collect();
    drop(order);
    let mut non_manifold: Vec<u32> = Vec::new();
    for (region, number) in regions.iter().zip(&number) {
        non_manifold.extend(region.non_manifold.iter().map(|&v| number[v as usize]));
    }
    non_manifold.sort_unstable();
    // Vertices of other cells: some are own vertices of a neighbour that is joined, the others stay foreign.
    let mut elsewhere: Vec<(u64, u32, u32)> = Vec::new();
    for (which, region) in regions.iter().enumerate() {
        for v in region.own..region.positions.len() {
            let id = region.vertex_ids[v];
            let home = region.other_cells[v - region.own];
            let neighbour = regions.binary_search_by_key(&home, |other| other.cell);
            match neighbour {
                Ok(other) => {
                    let ids = &regions[other].vertex_ids[..regions[other].own];
                    let place = ids
                        .binary_search(&id)
                        .map_err(|_| Error::DoNotFit { cell: region.cell, other: home })?;
                    number[which][v] = number[other][place];
                }
                Err(_) if home >> bits == cell => {
                    return Err(Error::DoNotFit { cell: region.cell, other: home });
                }
                Err(_) => elsewhere.push((id, as_u32(which), as_u32(v))),
            }
        }
    }
    elsewhere.sort_unstable();
    let mut other_cells = Vec::new();
    for (id, which, v) in elsewhere {
        let region = &regions[which as usize];
        if other_cells.is_empty() || vertex_ids.last() != Some(&id) {
            vertex_ids.push(id);
            other_cells.push(region.other_cells[v as usize - region.own] >> bits);
            positions.push(region.positions[v as usize]);
        }
        number[which as usize][v as usize] = as_u32(vertex_ids.len() - 1);
    }
    // A face is taken from the first of the regions that hold it.
    let is_here = |home: u32| regions.binary_search_by_key(&home, |other| other.cell).is_ok();
    let mut triangles = Vec::with_capacity(faces);
    for (region, number) in regions.iter().zip(&number) {
        for triangle in &region.triangles {
            let other_cells = triangle.map(|v| region.home(v));
            let first = other_cells.into_iter().filter(|&home| is_here(home)).min();
            if first == Some(region.cell) {
                triangles.push(triangle.map(|v| number[v as usize]));
            }
        }
    }
    Ok(Region {
        level,
        cell,
        own,
        vertex_ids,
        other_cells,
        non_manifold,
        positions,
        quadrics,
        triangles,
    })
}
