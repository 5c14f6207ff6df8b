//! A result as one file for each region. Vertices on a common rim have the same coordinates, bit for bit.

use std::path::Path;

use mesh_core::{BoundingBox, PolygonSoup};
use mesh_io::{Model, WriteOptions};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::error::Error;
use crate::region::hex;
use crate::run::Left;
use crate::work::{Work, put_json};

/// One of the files.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tile {
    /// Its name.
    pub file: String,
    /// The vertices, of which those on the rim are in other tiles too.
    pub vertices: u64,
    /// The faces; each is in one tile.
    pub faces: u64,
    /// The box round them.
    pub bounds: BoundingBox,
    /// The SHA-256 checksum of the file.
    pub sha256: String,
}

/// What `tiles.json` says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tiles {
    /// The version of this list.
    pub version: u32,
    /// The faces of all tiles.
    pub faces: u64,
    /// The tiles; cells without faces have none.
    pub tiles: Vec<Tile>,
}

/// Writes a result as binary PLY files into a folder, which is made if it is not there, and `tiles.json` last:
/// a tile for each region, or for each cell of level 0 where the result is one mesh.
///
/// # Errors
/// A region is missing or damaged, or a file cannot be written.
pub fn write_tiles(work: &Work, left: &Left, folder: &Path) -> Result<Tiles, Error> {
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
    match left {
        Left::Regions { level } => {
            for cell in 0..work.cells(*level)? {
                let region = work.finished_region(*level, cell)?;
                let position = |v: u32| region.positions[v as usize];
                add(cell, soup_of(region.own_triangles(), region.positions.len(), position)?)?;
            }
        }
        Left::Mesh(mesh) => {
            let cells = &work.manifest().cells;
            let middle = |triangle: [glam::DVec3; 3]| triangle.iter().sum::<glam::DVec3>() / 3.0;
            let mut faces: Vec<(u32, [u32; 3])> = (mesh.topology().faces())
                .zip(mesh.topology().triangles())
                .map(|(face, triangle)| (cells.cell_of(middle(mesh.triangle(face))), triangle))
                .collect();
            faces.sort_by_key(|&(cell, _)| cell);
            for group in faces.chunk_by(|a, b| a.0 == b.0) {
                let triangles = group.iter().map(|&(_, triangle)| triangle);
                let position = |v: u32| mesh.positions()[v as usize];
                add(group[0].0, soup_of(triangles, mesh.positions().len(), position)?)?;
            }
        }
    }
    put_json(&folder.join("tiles.json"), &tiles)?;
    Ok(tiles)
}

/// Some triangles with the vertices that they use, in the order of their first use.
fn soup_of(
    triangles: impl Iterator<Item = [u32; 3]>,
    vertices: usize,
    position: impl Fn(u32) -> glam::DVec3,
) -> Result<PolygonSoup, Error> {
    let mut number = vec![u32::MAX; vertices];
    let mut soup = PolygonSoup::new();
    for triangle in triangles {
        let corners = triangle.map(|v| {
            if number[v as usize] == u32::MAX {
                number[v as usize] = soup.vertex_count() as u32;
                soup.push_vertex(position(v));
            }
            number[v as usize]
        });
        let faces = soup.face_count() as u64;
        soup.push_face(&corners).map_err(|_| Error::RegionTooLarge { faces })?;
    }
    Ok(soup)
}
