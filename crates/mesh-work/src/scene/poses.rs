//! The poses of a mesh of a scene: which ones count, how its vertices move to them, and the errors there.

use std::collections::HashMap;

use glam::{DAffine3, DMat3, DMat4, DVec3};
use mesh_core::{SplitMix64, VertexId, as_u32};
use mesh_io::{NewMesh, ScenePose, ScenePrimitive, VertexData};
use mesh_metric::{CompareOptions, Surface, SurfaceError, compare};
use simplify::Poses;

use crate::loaded::Source;

/// The errors of a simplified mesh that deforms, over all poses that count.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct DeformedError {
    /// The number of poses, without the one of the file.
    pub poses: usize,
    /// The root mean square distance between the deformed surfaces of the input and the result, over all poses.
    pub rms: f64,
    /// The largest distance.
    pub max: f64,
}

/// A mesh that deforms.
pub(super) struct Deforming {
    /// The poses that count.
    poses: Vec<ScenePose>,
    /// The largest factor by which a length grows where the mesh is drawn. Errors are in units of the mesh.
    scale: f64,
    /// The poses of the vertices, for the cost.
    pub(super) of_vertices: Poses,
}

/// The vertices whose distances tell poses apart.
const SAMPLES: usize = 2000;
/// Poses are equal if the distances differ by less than this part.
const SAME: f64 = 1e-4;

impl Deforming {
    /// At most `most` of the shapes that a mesh takes, chosen one by one: each is farthest from those before it. Motions
    /// of the mesh as a whole do not count. `None` if it does not deform.
    pub(super) fn new(
        source: Source<'_>,
        primitives: &[ScenePrimitive],
        shapes: &[ScenePose],
        most: usize,
        scale: f64,
    ) -> Option<Self> {
        let mesh = source.mesh;
        let movers = Movers::new(primitives);
        let map = |v: usize, pose: &ScenePose| {
            let vertex = source.provenance.vertex_source.get(v).copied().unwrap_or(0);
            movers.map(vertex, pose, scale)
        };
        let topology = mesh.topology();
        let mut random = SplitMix64::new(1);
        let mut sampled: Vec<usize> = topology.vertices().map(VertexId::index).collect();
        for i in (1..sampled.len()).rev() {
            sampled.swap(i, (random.uniform() * (i + 1) as f64) as usize);
        }
        sampled.truncate(SAMPLES);
        let lengths = |pose: Option<&ScenePose>| -> Vec<f64> {
            let at = |&v: &usize| {
                let at = mesh.positions().get(v).copied().unwrap_or_default();
                pose.map_or(at, |pose| map(v, pose).transform_point3(at))
            };
            let points: Vec<DVec3> = sampled.iter().map(at).collect();
            points.iter().zip(points.iter().cycle().skip(1)).map(|(a, b)| a.distance(*b)).collect()
        };
        let difference =
            |a: &[f64], b: &[f64]| -> f64 { a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum() };
        let rest = lengths(None);
        let least = SAME * SAME * rest.iter().map(|length| length * length).sum::<f64>();
        let all: Vec<Vec<f64>> = shapes.iter().map(|shape| lengths(Some(shape))).collect();
        let mut apart: Vec<f64> = all.iter().map(|own| difference(own, &rest)).collect();
        let mut poses = Vec::new();
        while poses.len() < most {
            let farthest = (0..all.len()).filter(|&i| apart[i].is_finite());
            let farthest = farthest.reduce(|a, b| if apart[b] > apart[a] { b } else { a });
            let Some(next) = farthest.filter(|&i| apart[i] > least) else { break };
            poses.push(shapes[next].clone());
            for (own, apart) in all.iter().zip(&mut apart) {
                *apart = apart.min(difference(own, &all[next]));
            }
        }
        let of_vertices = Poses::new(mesh, poses.len(), |v, pose| map(v.index(), &poses[pose]));
        (!poses.is_empty()).then_some(Self { poses, scale, of_vertices })
    }

    /// The errors of a result, in units of the scene.
    pub(super) fn error(
        &self,
        source: Source<'_>,
        primitives: &[ScenePrimitive],
        result: &NewMesh,
        samples: usize,
    ) -> Result<DeformedError, SurfaceError> {
        let soup = &source.model.soup;
        let triangles: Vec<[u32; 3]> = soup.corners().as_chunks().0.to_vec();
        let sampling = CompareOptions { samples, ..CompareOptions::default() };
        let (mut squares, mut max) = (0.0, 0.0_f64);
        let movers = Movers::new(primitives);
        for pose in &self.poses {
            let positions = (0_u32..)
                .zip(soup.positions())
                .map(|(vertex, &at)| movers.map(vertex, pose, self.scale).transform_point3(at));
            let before = Surface::from_triangles(&positions.collect::<Vec<_>>(), &triangles)?;
            let (positions, triangles) = self.moved(result, pose);
            let after = Surface::from_triangles(&positions, &triangles)?;
            let distance = compare(&before, &after, &sampling);
            squares += distance.rms().powi(2);
            max = max.max(distance.hausdorff());
        }
        let poses = self.poses.len();
        let rms = self.scale * (squares / poses as f64).sqrt();
        Ok(DeformedError { poses, rms, max: self.scale * max })
    }

    /// The triangles of a result in a pose.
    fn moved(&self, result: &NewMesh, pose: &ScenePose) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let (mut positions, mut triangles) = (Vec::new(), Vec::new());
        for primitive in &result.primitives {
            let mover = Mover::new(&primitive.attributes, &primitive.targets);
            let Some(data) = primitive.attributes.iter().find(|d| d.name == "POSITION") else {
                continue;
            };
            let first = as_u32(positions.len());
            positions.extend((0..data.count()).map(|vertex| {
                mover.map(vertex, pose, self.scale).transform_point3(vector(data, vertex))
            }));
            triangles.extend(primitive.triangles.iter().map(|t| t.map(|v| first + v)));
        }
        (positions, triangles)
    }
}

/// What moves the vertices of a mesh.
struct Movers<'a> {
    movers: Vec<Mover<'a>>,
    /// The first vertices of the primitives in ascending order, with their counts and primitives. Primitives that share
    /// vertices move them alike.
    owners: Vec<(u32, usize, usize)>,
}

impl<'a> Movers<'a> {
    fn new(primitives: &'a [ScenePrimitive]) -> Self {
        let movers = primitives.iter().map(|p| Mover::new(&p.attributes, &p.targets)).collect();
        let owned = primitives.iter().enumerate().filter(|(_, p)| p.vertex_count > 0);
        let mut owners: Vec<_> =
            owned.map(|(place, p)| (p.first_vertex, p.vertex_count, place)).collect();
        owners.sort_by_key(|&(first, _, _)| first);
        owners.dedup_by_key(|&mut (first, _, _)| first);
        Self { movers, owners }
    }

    /// The map that moves a vertex of the model to a pose.
    fn map(&self, vertex: u32, pose: &ScenePose, scale: f64) -> DAffine3 {
        let next = self.owners.partition_point(|&(first, _, _)| first <= vertex);
        let owner = next.checked_sub(1).and_then(|place| {
            let &(first, count, primitive) = self.owners.get(place)?;
            let local = (vertex - first) as usize;
            Some((self.movers.get(primitive).filter(|_| local < count)?, local))
        });
        owner.map_or(DAffine3::IDENTITY, |(mover, local)| mover.map(local, pose, scale))
    }
}

/// What moves the vertices of a primitive.
struct Mover<'a> {
    /// The joints and weights of each set.
    sets: Vec<[&'a VertexData; 2]>,
    targets: &'a [Vec<VertexData>],
}

impl<'a> Mover<'a> {
    fn new(attributes: &'a [VertexData], targets: &'a [Vec<VertexData>]) -> Self {
        let named: HashMap<&str, &VertexData> =
            attributes.iter().map(|data| (&*data.name, data)).collect();
        let find = |name: String| named.get(&*name).copied();
        let sets = (0..).map_while(|set: usize| {
            Some([find(format!("JOINTS_{set}"))?, find(format!("WEIGHTS_{set}"))?])
        });
        Self { sets: sets.collect(), targets }
    }
}

impl Mover<'_> {
    /// The map that moves a vertex, and its surroundings, to a pose, in units of the mesh.
    fn map(&self, vertex: usize, pose: &ScenePose, scale: f64) -> DAffine3 {
        let mut moved = DVec3::ZERO;
        for (target, weight) in self.targets.iter().zip(&pose.weights) {
            let data = target.iter().find(|data| data.name == "POSITION");
            if let Some(data) = data.filter(|_| *weight != 0.0) {
                moved += *weight * vector(data, vertex);
            }
        }
        let skin = self.skin(vertex, pose, scale);
        skin * DAffine3::from_translation(moved)
    }

    /// The mean of the transforms of the joints of a vertex.
    fn skin(&self, vertex: usize, pose: &ScenePose, scale: f64) -> DAffine3 {
        let mut sum = DMat4::ZERO;
        let mut weights = 0.0;
        for [joints, shares] in &self.sets {
            for component in 0..4 {
                let share = shares.get(vertex, component) / shares.one();
                let joint = pose.joints.get(joints.get(vertex, component) as usize);
                if let Some(joint) = joint.filter(|_| share > 0.0) {
                    sum += *joint * share;
                    weights += share;
                }
            }
        }
        if weights == 0.0 {
            return DAffine3::IDENTITY;
        }
        let mean = sum * (1.0 / (weights * scale));
        DAffine3 { matrix3: DMat3::from_mat4(mean), translation: mean.w_axis.truncate() }
    }
}

/// A value with three components.
fn vector(data: &VertexData, vertex: usize) -> DVec3 {
    DVec3::from([0, 1, 2].map(|component| data.get(vertex, component) / data.one()))
}
