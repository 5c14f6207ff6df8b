//! The shapes that the meshes of a scene take: skins at the key frames of animations, and morph targets.

use super::document::Scene;
use super::placement::{SceneDraw, inverse_binds};
use crate::error::{ReadError, ReadErrorKind};
use crate::gltf::accessor::at;
use crate::gltf::scene::{each_node, local, placement};
use crate::gltf::schema::{Node, Root};
use glam::{DMat4, DQuat};
use serde::Deserialize;
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};

/// A shape that a drawn mesh takes.
#[derive(Clone, Debug, PartialEq)]
pub struct ScenePose {
    /// The transforms of the joints of its skin, from the mesh to the scene; empty without a skin.
    pub joints: Vec<DMat4>,
    /// The weights of its morph targets.
    pub weights: Vec<f64>,
}

/// At most this many key frames of all animations.
const MOST_FRAMES: usize = 256;

impl Scene {
    /// The shapes that drawn meshes take: each with the joints and weights of the nodes, then with each morph target
    /// alone, then at the key frames of the animations that move it. Of more than 256 key frames, some at equal
    /// distances are taken. A mesh without skin and targets has none.
    ///
    /// # Errors
    /// A skin refers to data that are not there, or the poses need more memory than a file of this size may use. Channels
    /// of animations whose data do not fit are left out.
    pub fn poses(&self, draws: &[SceneDraw]) -> Result<Vec<Vec<ScenePose>>, ReadError> {
        Ok(self.read_poses(draws)?)
    }

    fn read_poses(&self, draws: &[SceneDraw]) -> Result<Vec<Vec<ScenePose>>, ReadErrorKind> {
        let document = &*self.document;
        let mut all: Vec<Deforming> = Vec::new();
        for (place, draw) in draws.iter().enumerate() {
            all.extend(self.deforming(place, draw)?);
        }
        let mut poses = vec![Vec::new(); draws.len()];
        if all.is_empty() {
            return Ok(poses);
        }
        let (clips, mut bytes) = self.clips()?;
        let numbers = |one: &Deforming| 16 * one.inverse.len() + one.weights.len();
        let at_rest: usize = all.iter().map(|one| (one.weights.len() + 1) * numbers(one)).sum();
        let of_frame: usize = all.iter().map(numbers).sum();
        bytes = bytes.saturating_add(8 * (at_rest + MOST_FRAMES * of_frame) as u64);
        if bytes > self.memory {
            let at = at("animations");
            return Err(ReadErrorKind::Memory { at, needed: bytes, limit: self.memory });
        }
        let root = &document.root;
        let still = worlds(root, &BTreeMap::new())?;
        for one in &all {
            let joints = one.joints(root, &still);
            poses[one.place]
                .push(ScenePose { joints: joints.clone(), weights: one.weights.clone() });
            for target in 0..one.weights.len() {
                let mut weights = vec![0.0; one.weights.len()];
                weights[target] = 1.0;
                poses[one.place].push(ScenePose { joints: joints.clone(), weights });
            }
        }
        let parents = parents(root);
        let frames: usize = clips.iter().map(|clip| clip.times.len()).sum();
        let step = frames.div_ceil(MOST_FRAMES).max(1);
        for clip in &clips {
            let moved: Vec<&Deforming> =
                all.iter().filter(|one| one.is_moved(root, &parents, clip)).collect();
            for &time in clip.times.iter().step_by(step).filter(|_| !moved.is_empty()) {
                let (places, weights) = clip.at(root, time);
                let worlds = worlds(root, &places)?;
                for one in &moved {
                    let own = weights.get(&one.node).filter(|own| own.len() == one.weights.len());
                    poses[one.place].push(ScenePose {
                        joints: one.joints(root, &worlds),
                        weights: own.cloned().unwrap_or_else(|| one.weights.clone()),
                    });
                }
            }
        }
        Ok(poses)
    }

    /// What deforms a drawn mesh; `None` if nothing does.
    fn deforming(
        &self,
        place: usize,
        draw: &SceneDraw,
    ) -> Result<Option<Deforming>, ReadErrorKind> {
        let (document, root) = (&*self.document, self.root());
        let Some(node) = root.nodes.get(draw.node) else { return Ok(None) };
        let skin = node.skin.map(|skin| skin as usize).filter(|&skin| skin < root.skins.len());
        let targets = root.meshes.get(draw.mesh).map_or(0, |mesh| {
            mesh.primitives.iter().map(|primitive| primitive.targets.len()).max().unwrap_or(0)
        });
        if skin.is_none() && targets == 0 {
            return Ok(None);
        }
        let inverse = match skin.and_then(|skin| root.skins.get(skin)) {
            Some(skin) => inverse_binds(document, skin)?,
            None => Vec::new(),
        };
        let given = |list: &str, index: usize| {
            let weights = self.json.get(list)?.get(index)?.get("weights")?.as_array()?;
            let weights: Vec<f64> = weights.iter().filter_map(Value::as_f64).collect();
            (weights.len() == targets).then_some(weights)
        };
        let weights = given("nodes", draw.node).or_else(|| given("meshes", draw.mesh));
        let weights = weights.unwrap_or_else(|| vec![0.0; targets]);
        Ok(Some(Deforming { place, node: draw.node, skin, inverse, weights }))
    }

    /// The animations with their values, and their size in bytes.
    fn clips(&self) -> Result<(Vec<Clip>, u64), ReadErrorKind> {
        let document = &*self.document;
        let animations = self.json.get("animations").cloned().unwrap_or_default();
        let animations = Vec::<Animation>::deserialize(animations).unwrap_or_default();
        let (mut clips, mut bytes) = (Vec::new(), 0_u64);
        for (index, animation) in animations.iter().enumerate() {
            let mut clip = Clip::default();
            for channel in &animation.channels {
                let Some(sampler) = animation.samplers.get(channel.sampler) else { continue };
                let Some(path) = Path::of(&channel.target.path) else { continue };
                let Some(node) = channel.target.node else { continue };
                let at_input = format!("animations[{index}].samplers[{}]", channel.sampler);
                for accessor in [sampler.input, sampler.output] {
                    let count = document.count(accessor, &at_input).unwrap_or(0);
                    bytes = bytes.saturating_add(count.saturating_mul(16));
                }
                if bytes > self.memory {
                    let at = at(&at_input);
                    return Err(ReadErrorKind::Memory { at, needed: bytes, limit: self.memory });
                }
                let numbers = |accessor: u32, width: usize| -> Result<Vec<f32>, ReadErrorKind> {
                    let values = document.values(accessor, &at_input, width..=width)?;
                    Ok(match width {
                        1 => values.to_vec::<1>(0.0)?.into_flattened(),
                        _ => values.to_vec::<4>(0.0)?.into_flattened(),
                    })
                };
                // A channel whose data do not fit animates nothing.
                let (Ok(times), Ok(values)) =
                    (numbers(sampler.input, 1), numbers(sampler.output, path.width()))
                else {
                    continue;
                };
                let is_sound = !times.is_empty() && times.is_sorted_by(|a, b| a < b);
                if let (true, Some(track)) =
                    (is_sound, Track::new(node, path, times, values, &sampler.interpolation))
                {
                    clip.tracks.push(track);
                }
            }
            let times = clip.tracks.iter().flat_map(|track| &track.times).copied();
            clip.times = times.collect();
            clip.times.sort_by(f32::total_cmp);
            clip.times.dedup();
            clips.push(clip);
        }
        Ok((clips, bytes))
    }
}

/// A drawn mesh that can deform.
struct Deforming {
    /// Its place in the list of draws.
    place: usize,
    node: usize,
    skin: Option<usize>,
    /// The inverse bind matrices of its skin.
    inverse: Vec<DMat4>,
    weights: Vec<f64>,
}

impl Deforming {
    fn joint_nodes<'r>(&self, root: &'r Root) -> &'r [u32] {
        self.skin.and_then(|skin| root.skins.get(skin)).map_or(&[], |skin| &skin.joints)
    }

    fn joints(&self, root: &Root, worlds: &[DMat4]) -> Vec<DMat4> {
        let world = |joint: u32| worlds.get(joint as usize).copied().unwrap_or(DMat4::IDENTITY);
        let joints = self.joint_nodes(root).iter().zip(&self.inverse);
        joints.map(|(&joint, inverse)| world(joint) * *inverse).collect()
    }

    /// Whether an animation moves its joints or its targets.
    fn is_moved(&self, root: &Root, parents: &[Option<usize>], clip: &Clip) -> bool {
        let mut above = BTreeSet::new();
        for &joint in self.joint_nodes(root) {
            let mut next = Some(joint as usize);
            while let Some(node) = next.filter(|&node| above.insert(node)) {
                next = parents.get(node).copied().flatten();
            }
        }
        clip.tracks.iter().any(|track| match track.path {
            Path::Weights => track.node == self.node && !self.weights.is_empty(),
            _ => above.contains(&track.node),
        })
    }
}

#[derive(Deserialize)]
struct Animation {
    #[serde(default)]
    channels: Vec<Channel>,
    #[serde(default)]
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct Channel {
    sampler: usize,
    target: ChannelTarget,
}

#[derive(Deserialize)]
struct ChannelTarget {
    node: Option<usize>,
    path: String,
}

#[derive(Deserialize)]
struct Sampler {
    input: u32,
    output: u32,
    #[serde(default)]
    interpolation: String,
}

/// What a track changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Path {
    Translation,
    Rotation,
    Scale,
    Weights,
}

impl Path {
    fn of(name: &str) -> Option<Self> {
        Some(match name {
            "translation" => Self::Translation,
            "rotation" => Self::Rotation,
            "scale" => Self::Scale,
            "weights" => Self::Weights,
            _ => return None,
        })
    }

    /// The number of components of a value in the file.
    fn width(self) -> usize {
        match self {
            Self::Translation | Self::Scale => 3,
            Self::Rotation => 4,
            Self::Weights => 1,
        }
    }
}

/// An animation: its tracks and all of their key frames.
#[derive(Default)]
struct Clip {
    tracks: Vec<Track>,
    times: Vec<f32>,
}

/// The translation, rotation and scale that nodes have at a time, and the weights of their targets.
type Places = BTreeMap<usize, BTreeMap<Path, [f32; 4]>>;

impl Clip {
    fn at(&self, root: &Root, time: f32) -> (Places, BTreeMap<usize, Vec<f64>>) {
        let (mut places, mut weights) = (Places::new(), BTreeMap::new());
        for track in self.tracks.iter().filter(|track| track.node < root.nodes.len()) {
            let value = track.at(time);
            match (track.path, <[f32; 4]>::try_from(&value[..])) {
                (Path::Weights, _) => {
                    weights.insert(track.node, value.into_iter().map(f64::from).collect());
                }
                (path, Ok(value)) => {
                    places.entry(track.node).or_default().insert(path, value);
                }
                _ => {}
            }
        }
        (places, weights)
    }
}

/// The values of one member of a node over time.
struct Track {
    node: usize,
    path: Path,
    times: Vec<f32>,
    /// For each key frame, `width` values; of a spline, also the tangents before and after them.
    values: Vec<f32>,
    width: usize,
    interpolation: Interpolation,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Interpolation {
    Linear,
    Step,
    Spline,
}

impl Track {
    /// `None` if the numbers of times and values do not fit each other.
    fn new(
        node: usize,
        path: Path,
        times: Vec<f32>,
        values: Vec<f32>,
        interpolation: &str,
    ) -> Option<Self> {
        let interpolation = match interpolation {
            "STEP" => Interpolation::Step,
            "CUBICSPLINE" => Interpolation::Spline,
            _ => Interpolation::Linear,
        };
        let parts = if interpolation == Interpolation::Spline { 3 } else { 1 };
        let width = values.len() / (parts * times.len().max(1));
        let fits = width > 0 && width * parts * times.len() == values.len();
        fits.then_some(Self { node, path, times, values, width, interpolation })
    }

    /// The value of a key frame, or with `part` 0 and 2 the tangents of a spline before and after it.
    fn value(&self, key: usize, part: usize) -> &[f32] {
        let place = if self.interpolation == Interpolation::Spline { 3 * key + part } else { key };
        self.values.get(place * self.width..(place + 1) * self.width).unwrap_or_default()
    }

    fn at(&self, time: f32) -> Vec<f32> {
        const VALUE: usize = 1;
        let after = self.times.partition_point(|&key| key <= time);
        let (Some(before), true) = (after.checked_sub(1), after < self.times.len()) else {
            return self.value(after.min(self.times.len() - 1), VALUE).to_vec();
        };
        let [from, to] = [before, after].map(|key| self.value(key, VALUE));
        let span = self.times[after] - self.times[before];
        let t = (time - self.times[before]) / span;
        match (self.interpolation, self.path) {
            (Interpolation::Step, _) => from.to_vec(),
            (Interpolation::Linear, Path::Rotation) => {
                let [from, to] = [from, to].map(|q| <[f32; 4]>::try_from(q).unwrap_or_default());
                let [from, to] = [from, to].map(|q| DQuat::from_array(q.map(f64::from)));
                from.slerp(to, f64::from(t)).as_quat().to_array().to_vec()
            }
            (Interpolation::Linear, _) => {
                from.iter().zip(to).map(|(a, b)| a + t * (b - a)).collect()
            }
            (Interpolation::Spline, _) => {
                let tangents = self.value(before, 2).iter().zip(self.value(after, 0));
                let ends = from.iter().zip(to).zip(tangents);
                let (t2, t3) = (t * t, t * t * t);
                let hermite = |((a, b), (out, into)): ((&f32, &f32), (&f32, &f32))| {
                    (2.0 * t3 - 3.0 * t2 + 1.0) * a
                        + span * (t3 - 2.0 * t2 + t) * out
                        + (3.0 * t2 - 2.0 * t3) * b
                        + span * (t3 - t2) * into
                };
                ends.map(hermite).collect()
            }
        }
    }
}

/// The parent of each node.
pub(super) fn parents(root: &Root) -> Vec<Option<usize>> {
    let mut parents = vec![None; root.nodes.len()];
    for (index, node) in root.nodes.iter().enumerate() {
        for &child in &node.children {
            if let Some(slot) = parents.get_mut(child as usize) {
                *slot = Some(index);
            }
        }
    }
    parents
}

/// The transforms of all nodes of the default scene to the scene, some of which have other places.
fn worlds(root: &Root, places: &Places) -> Result<Vec<DMat4>, ReadErrorKind> {
    let mut worlds = vec![DMat4::IDENTITY; root.nodes.len()];
    let parents = parents(root);
    each_node(root, |index, node, _| {
        let parent = parents.get(index).copied().flatten().and_then(|parent| worlds.get(parent));
        let own = places.get(&index).map_or_else(|| local(node), |place| placed(node, place));
        let world = parent.copied().unwrap_or(DMat4::IDENTITY) * own;
        if let Some(slot) = worlds.get_mut(index) {
            *slot = world;
        }
        Ok(())
    })?;
    Ok(worlds)
}

/// The transform of a node some of whose members are replaced.
fn placed(node: &Node, place: &BTreeMap<Path, [f32; 4]>) -> DMat4 {
    if node.matrix.is_some() {
        // Such a node must not be animated.
        return local(node);
    }
    let vector = |path: Path| place.get(&path).map(|&[x, y, z, _]| [x, y, z]);
    placement(
        vector(Path::Translation).or(node.translation),
        place.get(&Path::Rotation).copied().or(node.rotation),
        vector(Path::Scale).or(node.scale),
    )
}
