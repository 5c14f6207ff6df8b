//! Where the meshes of a scene are drawn.

use super::document::Scene;
use crate::error::{ReadError, ReadErrorKind};
use crate::gltf::accessor::{Document, at};
use crate::gltf::plan::{FAN, POINTS, STRIP, has_points, is_surface};
use crate::gltf::scene::{
    INSTANCE, Placed, each_node, each_placed, instance_count, tops, transforms,
};
use crate::gltf::schema::Skin;
use glam::{DMat3, DMat4, DVec3};
use std::collections::HashSet;

/// A mesh drawn by a node.
#[derive(Clone, Debug, PartialEq)]
pub struct SceneDraw {
    /// The mesh.
    pub mesh: usize,
    /// The node.
    pub node: usize,
    /// The transforms to the scene: one, or one for each instance of `EXT_mesh_gpu_instancing`. A mesh with a skin has
    /// the transforms of the joints in the rest pose instead.
    pub transforms: Vec<DMat4>,
    /// The number of times that the mesh is drawn.
    pub times: usize,
}

impl Scene {
    /// The meshes that the default scene draws, in the order in which its nodes are visited.
    ///
    /// # Errors
    /// Instances or a skin refer to data that are not there, or the instances need more memory than a file of this size
    /// may use.
    pub fn draws(&self) -> Result<Vec<SceneDraw>, ReadError> {
        let document = &*self.document;
        let root = &document.root;
        let mut worlds = vec![DMat4::IDENTITY; root.nodes.len()];
        let mut placed = Vec::new();
        each_node(root, |index, node, transform| {
            if let Some(world) = worlds.get_mut(index) {
                *world = transform;
            }
            if let Some(mesh) = node.mesh {
                placed.push(Placed { index, node, mesh, transform });
            }
            Ok(())
        })?;
        let mut draws = Vec::with_capacity(placed.len());
        let mut bytes = 0_u64;
        for placed in placed {
            let (mesh, node) = (placed.mesh as usize, placed.index);
            let skin = placed.node.skin.and_then(|skin| root.skins.get(skin as usize));
            let (transforms, times) = match skin {
                Some(skin) => {
                    self.require(&mut bytes, skin.joints.len() as u64, node)?;
                    (joints(document, skin, &worlds)?, 1)
                }
                None => {
                    self.require(&mut bytes, instance_count(document, &placed)?, node)?;
                    let transforms = transforms(document, &placed)?;
                    let times = transforms.len();
                    (transforms, times)
                }
            };
            draws.push(SceneDraw { mesh, node, transforms, times });
        }
        Ok(draws)
    }

    /// The nodes at the top of the default scene.
    #[must_use]
    pub fn top_nodes(&self) -> Vec<usize> {
        // The nodes were checked when the scene was read.
        tops(self.root()).unwrap_or_default().into_iter().map(|node| node as usize).collect()
    }

    /// The numbers of vertices and triangles of a mesh, without points and lines. Primitives with the same attributes share
    /// their vertices.
    #[must_use]
    pub fn mesh_counts(&self, mesh: usize) -> [u64; 2] {
        self.counts_of(mesh, false)
    }

    fn counts_of(&self, mesh: usize, has_points: bool) -> [u64; 2] {
        let root = self.root();
        let primitives = root.meshes.get(mesh).map_or(&[][..], |mesh| &mesh.primitives[..]);
        let mut seen = HashSet::new();
        let count = |accessor: u32| root.accessors.get(accessor as usize).map_or(0, |a| a.count);
        let (mut vertices, mut faces) = (0_u64, 0_u64);
        let is_read = |mode: u32| is_surface(mode) || (has_points && mode == POINTS);
        for primitive in primitives.iter().filter(|primitive| is_read(primitive.mode)) {
            let own = primitive.attributes.get("POSITION").map_or(0, count);
            if seen.insert(&primitive.attributes) {
                vertices = vertices.saturating_add(own);
            }
            let corners = primitive.indices.map_or(own, count);
            let more = match primitive.mode {
                POINTS => 0,
                STRIP | FAN => corners.saturating_sub(2),
                _ => corners / 3,
            };
            faces = faces.saturating_add(more);
        }
        [vertices, faces]
    }

    /// The numbers of vertices and triangles that the default scene draws, as [`read`](crate::read()) counts them.
    #[must_use]
    pub fn counts(&self) -> [u64; 2] {
        let document = &*self.document;
        let root = &document.root;
        let mut known: Vec<Option<[u64; 2]>> = vec![None; root.meshes.len()];
        let (mut all, has_points) = ([0_u64; 2], has_points(root));
        // The nodes were checked when the scene was read.
        let _ = each_placed(root, |placed| {
            let times = instance_count(document, placed)?;
            let place = placed.mesh as usize;
            if let Some(slot) = known.get_mut(place) {
                let own = *slot.get_or_insert_with(|| self.counts_of(place, has_points));
                all = [0, 1].map(|i| all[i].saturating_add(own[i].saturating_mul(times)));
            }
            Ok(())
        });
        all
    }

    fn require(&self, bytes: &mut u64, count: u64, node: usize) -> Result<(), ReadErrorKind> {
        *bytes = bytes.saturating_add(count.saturating_mul(INSTANCE));
        if *bytes <= self.memory {
            return Ok(());
        }
        let at = at(&format!("nodes[{node}]"));
        Err(ReadErrorKind::Memory { at, needed: *bytes, limit: self.memory })
    }
}

impl SceneDraw {
    /// The largest factor by which a length of the mesh grows where it is drawn.
    #[must_use]
    pub fn scale(&self) -> f64 {
        let scales = self.transforms.iter().map(|transform| stretch(DMat3::from_mat4(*transform)));
        scales.fold(0.0, f64::max)
    }
}

/// The transforms of the joints of a skin, from the mesh to the scene.
fn joints(document: &Document, skin: &Skin, worlds: &[DMat4]) -> Result<Vec<DMat4>, ReadErrorKind> {
    let inverse = inverse_binds(document, skin)?;
    let world = |joint: u32| worlds.get(joint as usize).copied().unwrap_or(DMat4::IDENTITY);
    Ok(skin.joints.iter().zip(inverse).map(|(&joint, inverse)| world(joint) * inverse).collect())
}

/// The inverse bind matrix of each joint of a skin.
pub(super) fn inverse_binds(document: &Document, skin: &Skin) -> Result<Vec<DMat4>, ReadErrorKind> {
    let path = "skins.inverseBindMatrices";
    let inverse = match skin.inverse_bind_matrices {
        Some(accessor) => document.values(accessor, path, 16..=16)?.to_vec::<16>(0.0)?,
        None => Vec::new(),
    };
    let matrix = |place: usize| {
        let matrix = inverse.get(place).map(|matrix| matrix.map(f64::from));
        matrix.map_or(DMat4::IDENTITY, |matrix| DMat4::from_cols_array(&matrix))
    };
    Ok((0..skin.joints.len()).map(matrix).collect())
}

/// The largest singular value of a matrix, the root of the largest eigenvalue of its square.
fn stretch(m: DMat3) -> f64 {
    let square = m.transpose() * m;
    let [xx, yy, zz] = [square.x_axis.x, square.y_axis.y, square.z_axis.z];
    let [xy, xz, yz] = [square.y_axis.x, square.z_axis.x, square.z_axis.y];
    let off = xy * xy + xz * xz + yz * yz;
    if off == 0.0 {
        return DVec3::new(xx, yy, zz).max_element().sqrt();
    }
    // The trigonometric solution for symmetric matrices.
    let mean = (xx + yy + zz) / 3.0;
    let spread = (xx - mean).powi(2) + (yy - mean).powi(2) + (zz - mean).powi(2) + 2.0 * off;
    let p = (spread / 6.0).sqrt();
    let shifted = (square - DMat3::from_diagonal(DVec3::splat(mean))) * (1.0 / p);
    let angle = (0.5 * shifted.determinant()).clamp(-1.0, 1.0).acos() / 3.0;
    (mean + 2.0 * p * angle.cos()).max(0.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::stretch;
    use glam::{DMat3, DQuat, DVec3};

    #[test]
    fn the_stretch_is_the_largest_factor_over_all_directions() {
        let turn = |axis: DVec3, angle| DMat3::from_quat(DQuat::from_axis_angle(axis, angle));
        let (a, b) = (turn(DVec3::Z, 0.7), turn(DVec3::X, -1.9));
        for scale in [DVec3::new(1.0, 2.0, 3.0), DVec3::splat(0.25), DVec3::new(-5.0, 0.0, 1e-9)] {
            for m in [DMat3::from_diagonal(scale), a * DMat3::from_diagonal(scale) * b] {
                let expected = scale.abs().max_element();
                assert!((stretch(m) - expected).abs() <= 1e-9 * expected, "{m}");
            }
        }
    }
}
