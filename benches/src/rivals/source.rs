//! The meshes of the jobs: files, and generated ones.

use std::path::Path;

use mesh_core::{PolygonSoup, TriMesh};
use mesh_shapes::{Torus, add_normal_noise};
use sha2::{Digest, Sha256};
use xtask_common::Failure;

use crate::raw_mesh::RawMesh;

/// Where a mesh comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Source<'n> {
    File(&'n str),
    /// The torus of DHKL01 with about this number of faces. Half of its edges are worth flipping.
    Torus(usize),
    /// The same with noise along the normals.
    NoisyTorus(usize),
}

/// Standard deviation of the noise, in mean edge lengths, and its seed.
const NOISE: f64 = 0.1;
const SEED: u64 = 1;

/// A mesh around the origin with a diagonal of one.
#[derive(Clone, Debug)]
pub(super) struct Mesh {
    pub(super) raw: RawMesh,
    /// Of the file, in hexadecimal digits; none if it is generated.
    pub(super) sha256: Option<String>,
}

impl<'n> Source<'n> {
    pub(super) fn of_name(name: &'n str) -> Self {
        let faces = |prefix: &str| name.strip_prefix(prefix)?.parse().ok();
        match (faces("torus-"), faces("noisy-")) {
            (Some(faces), _) => Self::Torus(faces),
            (_, Some(faces)) => Self::NoisyTorus(faces),
            _ => Self::File(name),
        }
    }

    pub(super) fn mesh(self, models: &Path) -> Result<Mesh, Failure> {
        let (raw, sha256) = match self {
            Self::File(name) => {
                let path = models.join(name);
                let bytes = std::fs::read(&path).map_err(Failure::reading(&path))?;
                (RawMesh::from_file(&path)?, Some(format!("{:x}", Sha256::digest(&bytes))))
            }
            Self::Torus(faces) => (raw(&torus(faces)?)?, None),
            Self::NoisyTorus(faces) => {
                let mut soup = torus(faces)?;
                add_normal_noise(&mut soup, NOISE, SEED);
                (raw(&soup)?, None)
            }
        };
        let raw = raw.with_unit_diagonal().ok_or_else(|| {
            Failure::Usage(format!("{self:?} has no extent, so no distances can be given"))
        })?;
        Ok(Mesh { raw, sha256 })
    }
}

fn torus(faces: usize) -> Result<PolygonSoup, Failure> {
    let sides = (((faces / 4) as f64).sqrt().round() as usize).max(3);
    let rings = (faces / (4 * sides)).max(2) * 2;
    Torus { major: 5.0, minor: 2.0 }.shifted_mesh(rings, sides).map_err(Failure::mesh)
}

fn raw(soup: &PolygonSoup) -> Result<RawMesh, Failure> {
    Ok(RawMesh::of(&TriMesh::from_soup(soup).map_err(Failure::mesh)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generated_meshes_have_about_the_faces_asked_for() {
        for name in ["torus-2000", "noisy-2000"] {
            let source = Source::of_name(name);
            assert!(!matches!(source, Source::File(_)));
            let mesh = source.mesh(Path::new("")).unwrap();
            let faces = mesh.raw.triangles.len();
            assert!((1800..2200).contains(&faces), "{name}: {faces}");
            assert_eq!(mesh.sha256, None);
        }
        assert_eq!(Source::of_name("torus-x.obj"), Source::File("torus-x.obj"));
        assert!(Source::File("none.obj").mesh(Path::new("")).is_err());
    }
}
