//! A result as one file for each region. Vertices that two files share have the same coordinates, bit for bit.

use std::path::Path;

use mesh_core::{BoundingBox, PolygonSoup};
use mesh_io::{Model, WriteOptions};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::error::Error;
use crate::refine::used_vertices;
use crate::run::ResultMesh;
use crate::sealed_json::hex;
use crate::work::Work;

/// The file of a region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tile {
    /// The name of the file.
    pub file: String,
    /// The number of vertices. Vertices on the boundary are in other tiles too.
    pub vertices: u64,
    /// The number of faces. Each face is in one tile.
    pub faces: u64,
    /// The bounding box.
    pub bounds: BoundingBox,
    /// The SHA-256 checksum of the file.
    pub sha256: String,
}

/// The content of `tiles.json`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tiles {
    /// The version of the format.
    pub version: u32,
    /// The number of faces of all tiles.
    pub faces: u64,
    /// The tiles. Cells without faces have none.
    pub tiles: Vec<Tile>,
}

/// Writes a result as binary PLY files to a folder, which is created if it is missing: a tile for each region, or for
/// each cell of level 0 if the result is one mesh. `tiles.json` is written last.
///
/// # Errors
/// A region is missing or damaged, or a file cannot be written.
pub fn write_tiles(work: &Work, result: &ResultMesh, folder: &Path) -> Result<Tiles, Error> {
    std::fs::create_dir_all(folder).map_err(Error::io(folder))?;
    let mut tiles = Tiles { version: 1, faces: 0, tiles: Vec::new() };
    let mut add = |cell: u32, soup: PolygonSoup| -> Result<(), Error> {
        let Some(bounds) = BoundingBox::of_points(soup.positions().iter().copied()) else {
            return Ok(());
        };
        let (vertices, faces) = (soup.vertex_count() as u64, soup.face_count() as u64);
        let file = format!("tile-{cell}.ply");
        let path = folder.join(&file);
        mesh_io::write(&path, &Model::from(soup), &WriteOptions::default())?;
        let mut sum = Sha256::new();
        let mut written = std::fs::File::open(&path).map_err(Error::io(&path))?;
        std::io::copy(&mut written, &mut sum).map_err(Error::io(&path))?;
        tiles.faces += faces;
        tiles.tiles.push(Tile { file, vertices, faces, bounds, sha256: hex(&sum.finalize()) });
        Ok(())
    };
    match result {
        ResultMesh::OnDisk { level } => {
            for cell in 0..work.cells(*level)? {
                let region = work.refined_region(*level, cell)?;
                let position = |v: u32| region.positions[v as usize];
                add(
                    cell,
                    used_vertices(region.own_triangles(), region.positions.len(), position)?.0,
                )?;
            }
        }
        ResultMesh::InMemory(mesh) => {
            let cells = &work.manifest().cells;
            let centroid = |triangle: [glam::DVec3; 3]| triangle.iter().sum::<glam::DVec3>() / 3.0;
            let mut faces: Vec<(u32, [u32; 3])> = (mesh.topology().faces())
                .zip(mesh.topology().triangles())
                .map(|(face, triangle)| (cells.cell_of(centroid(mesh.triangle(face))), triangle))
                .collect();
            faces.sort_by_key(|&(cell, _)| cell);
            for group in faces.chunk_by(|a, b| a.0 == b.0) {
                let triangles = group.iter().map(|&(_, triangle)| triangle);
                let position = |v: u32| mesh.positions()[v as usize];
                add(group[0].0, used_vertices(triangles, mesh.positions().len(), position)?.0)?;
            }
        }
    }
    let path = folder.join("tiles.json");
    let text = serde_json::to_string_pretty(&tiles)
        .map_err(|error| Error::damaged(&path, error.to_string()))?;
    mesh_io::replace_file(&path, |writer| writer.write_all(text.as_bytes()))?;
    Ok(tiles)
}
