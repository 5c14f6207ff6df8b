//! The vertices of a simplified mesh of a scene, with all attributes and morph targets.
//!
//! Each corner of the result has a point of the input, between three vertices of one primitive. Texture coordinates,
//! colours, numbers with fractions and morph targets are interpolated there, in the type of the file. Whole numbers,
//! which are labels, are those of the nearest vertex. Joints and weights of skins are combined, and the largest weights
//! kept. Normals are those of the carried model. Tangents are made perpendicular to them.
//!
//! Where charts are merged, the point of texture coordinates and tangents is in the chart of the face. The point of all
//! other data is the closest one, which can be in another chart and another primitive.

use std::collections::HashMap;

use glam::DVec3;
use mesh_core::{TriMesh, as_u32};
use mesh_io::{Blend, Model, NewPrimitive, ScalarType, ScenePrimitive, VertexData};

use crate::attributes::Sources;

/// The primitives of a result. `model` is the input, and `carried` the result.
pub(super) fn transfer(
    model: &Model,
    primitives: &[ScenePrimitive],
    result: &TriMesh,
    sources: &Sources,
    carried: &Model,
) -> Vec<NewPrimitive> {
    let skins = primitives.iter().map(skin).collect();
    let given = Given { model, primitives, skins };
    let mut all: Vec<Primitive<'_>> =
        (0..primitives.len()).map(|place| Primitive::new(&given, place, carried)).collect();
    let blends = sources.corners.iter().zip(&sources.points);
    let faces = result.topology().triangles().zip(&sources.faces).zip(blends);
    for (face, ((vertices, &source), (in_chart, at_point))) in faces.enumerate() {
        let place = primitives.partition_point(|p| p.faces.end <= source as usize);
        let Some(primitive) = all.get_mut(place) else { continue };
        let corner = |k: usize| {
            let normal = carried.corner_normals.as_ref().and_then(|all| all.get(3 * face + k));
            let position = result.positions().get(vertices[k] as usize);
            Corner {
                vertex: vertices[k],
                position: position.copied().unwrap_or(DVec3::ZERO),
                normal: normal.map(|normal| DVec3::from(normal.map(f64::from))),
            }
        };
        primitive.triangle([0, 1, 2].map(|k| (corner(k), [in_chart[k], at_point[k]])));
    }
    all.into_iter().map(Primitive::finish).collect()
}

/// A corner of the result.
struct Corner {
    vertex: u32,
    position: DVec3,
    normal: Option<DVec3>,
}

/// How the values of an attribute are found.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Rule {
    Position,
    Normal,
    Tangent,
    /// The joints or the weights of a set of four influences.
    Joints(usize),
    Weights(usize),
    Nearest,
    Blend,
}

/// An attribute of the input, and the rule for the result.
struct Column<'m> {
    old: &'m VertexData,
    /// The place of the attribute in its list.
    place: usize,
    /// The type of the new values.
    new: VertexData,
    rule: Rule,
}

/// The input.
struct Given<'m> {
    model: &'m Model,
    primitives: &'m [ScenePrimitive],
    /// For each primitive, the sets of joints and weights.
    skins: Vec<Vec<[&'m VertexData; 2]>>,
}

/// A primitive of the result while it grows.
struct Primitive<'m> {
    given: &'m Given<'m>,
    /// The place of the primitive in the input.
    place: usize,
    old: &'m ScenePrimitive,
    columns: Vec<Column<'m>>,
    /// The columns of each morph target.
    targets: Vec<Vec<Column<'m>>>,
    /// The distinct vertices: the vertex of the mesh, and all values.
    known: HashMap<(u32, Vec<u8>), u32>,
    distinct: Vec<(u32, Vec<u8>)>,
    triangles: Vec<[u32; 3]>,
}

impl<'m> Primitive<'m> {
    fn new(given: &'m Given<'m>, place: usize, carried: &Model) -> Self {
        let old = &given.primitives[place];
        let skin_sets = given.skins[place].len();
        // A flat-shaded mesh has no normals, which tangents need.
        let is_kept = |(_, data): &(usize, &VertexData)| {
            carried.corner_normals.is_some() || !matches!(data.name.as_str(), "NORMAL" | "TANGENT")
        };
        let column = |(place, old): (usize, &'m VertexData)| {
            let rule = rule(old, skin_sets);
            Column { old, place, new: new_type(old, rule), rule }
        };
        let delta = |(place, old): (usize, &'m VertexData)| Column {
            old,
            place,
            new: old.empty(),
            rule: Rule::Blend,
        };
        let columns = old.attributes.iter().enumerate().filter(is_kept).map(column).collect();
        let targets = old.targets.iter();
        let targets = targets.map(|t| t.iter().enumerate().filter(is_kept).map(delta).collect());
        Self {
            given,
            place,
            old,
            columns,
            targets: targets.collect(),
            known: HashMap::new(),
            distinct: Vec::new(),
            triangles: Vec::new(),
        }
    }

    /// Adds a face. Each corner has the point of its texture coordinates, and the point of its other data.
    fn triangle(&mut self, corners: [(Corner, [Blend; 2]); 3]) {
        let triangle = corners.map(|(corner, blends)| {
            let values = self.values(&corner, blends);
            let next = as_u32(self.distinct.len());
            let key = (corner.vertex, values);
            match self.known.get(&key) {
                Some(&vertex) => vertex,
                None => {
                    self.distinct.push(key.clone());
                    self.known.insert(key, next);
                    next
                }
            }
        });
        self.triangles.push(triangle);
    }

    /// The three vertices of the primitive between which a corner lies, with weights. A corner of another primitive,
    /// which has no part of the surface here, gets the nearest vertex.
    fn sources(&self, blend: &Blend, at: DVec3) -> Blend {
        let corners = 3 * self.old.faces.start..3 * self.old.faces.end;
        let used = blend.sources.iter().zip(blend.weights).filter(|(_, weight)| *weight != 0.0);
        if used.clone().all(|(corner, _)| corners.contains(&(*corner as usize))) {
            return self.local(self.old, blend);
        }
        let distance = |corner: &usize| {
            let vertex = self.given.model.soup.corners().get(*corner).copied().unwrap_or(0);
            let position = self.given.model.soup.positions().get(vertex as usize);
            position.map_or(f64::INFINITY, |position| position.distance_squared(at))
        };
        let nearest = corners.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        Blend::one(self.vertex(self.old, as_u32(nearest.unwrap_or(0))))
    }

    /// Corners of the model as vertices of their primitive.
    fn local(&self, primitive: &ScenePrimitive, blend: &Blend) -> Blend {
        let first = self.vertex(primitive, blend.nearest());
        let local = |(corner, weight): (u32, f64)| {
            if weight == 0.0 { first } else { self.vertex(primitive, corner) }
        };
        let [a, b, c] = blend.sources;
        let [x, y, z] = blend.weights;
        Blend { sources: [(a, x), (b, y), (c, z)].map(local), ..*blend }
    }

    /// The vertex of a primitive at a corner of the model.
    fn vertex(&self, primitive: &ScenePrimitive, corner: u32) -> u32 {
        let vertex = self.given.model.soup.corners().get(corner as usize).copied().unwrap_or(0);
        vertex.saturating_sub(primitive.first_vertex)
    }

    /// The place of the primitive at a point, if it has the same attributes, and the point in its vertices. Otherwise of
    /// this primitive.
    fn at_point(&self, blend: &Blend, at: DVec3) -> (usize, Blend) {
        let face = blend.nearest() as usize / 3;
        let place = self.given.primitives.partition_point(|p| p.faces.end <= face);
        match self.given.primitives.get(place) {
            Some(other) if place != self.place && has_same_columns(self.old, other) => {
                (place, self.local(other, blend))
            }
            _ => (self.place, self.sources(blend, at)),
        }
    }

    /// All values of a corner, in the order of the columns.
    fn values(&self, corner: &Corner, [in_chart, at_point]: [Blend; 2]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let (place, point) = self.at_point(&at_point, corner.position);
        let in_chart = if in_chart == at_point && place == self.place {
            point
        } else {
            self.sources(&in_chart, corner.position)
        };
        let (primitive, skin) = (&self.given.primitives[place], &self.given.skins[place]);
        let is_copy = point.weights.contains(&1.0) && has_unit_sum(skin, point.nearest());
        let influences = if is_copy { Vec::new() } else { influences(skin, &point) };
        // The primitive has the same attributes in the same order.
        let same = |column: &Column<'m>, all: &'m [VertexData]| {
            all.get(column.place).unwrap_or(column.old)
        };
        for column in &self.columns {
            if column.old.name.starts_with("TEXCOORD_") || column.rule == Rule::Tangent {
                column.push(column.old, corner, &in_chart, &[], &mut bytes);
            } else {
                let old = same(column, &primitive.attributes);
                column.push(old, corner, &point, &influences, &mut bytes);
            }
        }
        for (columns, all) in self.targets.iter().zip(&primitive.targets) {
            for column in columns {
                column.push(same(column, all), corner, &point, &[], &mut bytes);
            }
        }
        bytes
    }
    /// The vertices in the order of the mesh; further ones at a vertex, which a seam parts, follow.
    fn finish(self) -> NewPrimitive {
        let mut order: Vec<u32> = (0..as_u32(self.distinct.len())).collect();
        let vertex =
            |place: u32| self.distinct.get(place as usize).map_or(0, |(vertex, _)| *vertex);
        order.sort_by_key(|&place| vertex(place));
        let is_further: Vec<bool> =
            (0..order.len()).map(|i| i > 0 && vertex(order[i]) == vertex(order[i - 1])).collect();
        let part = |further: bool| {
            let both = order.iter().zip(&is_further).filter(move |(_, is)| **is == further);
            both.map(|(&place, _)| place)
        };
        let mut further: Vec<u32> = part(true).collect();
        further.sort_unstable();
        let order: Vec<u32> = part(false).chain(further).collect();
        let mut places = vec![0_u32; order.len()];
        for (new, &old) in (0..).zip(&order) {
            places[old as usize] = new;
        }
        let triangles =
            self.triangles.iter().map(|triangle| triangle.map(|v| places[v as usize])).collect();
        let mut start = 0;
        let distinct = &self.distinct;
        let mut gather = |column: Column<'_>| {
            let mut data = column.new;
            let range = start..start + data.size();
            start = range.end;
            for &place in &order {
                let values = distinct.get(place as usize).and_then(|(_, v)| v.get(range.clone()));
                data.bytes.extend_from_slice(values.unwrap_or_default());
            }
            data
        };
        let attributes = self.columns.into_iter().map(&mut gather).collect();
        let targets: Vec<Vec<VertexData>> = self
            .targets
            .into_iter()
            .map(|target| target.into_iter().map(&mut gather).collect())
            .collect();
        NewPrimitive { index: self.old.index, attributes, targets, triangles }
    }
}

/// The sets of joints and weights of a primitive.
fn skin(primitive: &ScenePrimitive) -> Vec<[&VertexData; 2]> {
    let named: HashMap<&str, &VertexData> =
        primitive.attributes.iter().map(|data| (&*data.name, data)).collect();
    let find = |name: &str| named.get(name).copied();
    let sets = (0..).map_while(|set: usize| {
        let pair = [find(&format!("JOINTS_{set}"))?, find(&format!("WEIGHTS_{set}"))?];
        pair.iter().all(|data| data.width == 4).then_some(pair)
    });
    sets.collect()
}

/// Whether two primitives have the same attributes and morph targets, in the same types.
fn has_same_columns(a: &ScenePrimitive, b: &ScenePrimitive) -> bool {
    let are_same = |a: &[VertexData], b: &[VertexData]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| is_same_type(a, b))
    };
    are_same(&a.attributes, &b.attributes)
        && a.targets.len() == b.targets.len()
        && a.targets.iter().zip(&b.targets).all(|(a, b)| are_same(a, b))
}

fn is_same_type(a: &VertexData, b: &VertexData) -> bool {
    (&a.name, a.width, a.component, a.normalized) == (&b.name, b.width, b.component, b.normalized)
}

/// Whether the weights of a vertex have the sum 1, up to rounding.
fn has_unit_sum(skin: &[[&VertexData; 2]], vertex: u32) -> bool {
    let weights = skin
        .iter()
        .flat_map(|[_, weights]| (0..4).map(|k| weights.get(vertex as usize, k) / weights.one()));
    let sum: f64 = weights.sum();
    // All weights may be 0, which leaves the vertex to the reader.
    sum == 0.0 || (sum - 1.0).abs() <= UNIT_SUM
}

/// The joints at a point with their weights, as many as there is room for, from the largest weight.
fn influences(skin: &[[&VertexData; 2]], blend: &Blend) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = Vec::new();
    for (&vertex, share) in blend.sources.iter().zip(blend.weights) {
        for [joints, weights] in skin.iter().filter(|_| share != 0.0) {
            for component in 0..4 {
                let joint = joints.get(vertex as usize, component);
                let weight = share * weights.get(vertex as usize, component) / weights.one();
                match all.iter_mut().find(|(other, _)| *other == joint) {
                    Some((_, sum)) => *sum += weight,
                    None => all.push((joint, weight)),
                }
            }
        }
    }
    all.retain(|(_, weight)| *weight > 0.0);
    all.sort_by(|(i, v), (j, w)| w.total_cmp(v).then(i.total_cmp(j)));
    all.truncate(4 * skin.len());
    let sum: f64 = all.iter().map(|(_, weight)| weight).sum();
    all.iter_mut().for_each(|(_, weight)| *weight /= sum);
    round_weights(skin, &mut all);
    all
}

/// Rounds the weights of integer types so that their sum stays 1: what is missing goes to the largest.
fn round_weights(skin: &[[&VertexData; 2]], all: &mut [(f64, f64)]) {
    let one = skin.first().map_or(1.0, |[_, weights]| weights.one());
    let is_whole = skin.iter().all(|[_, weights]| weights.one() == one) && one > 1.0;
    if !is_whole {
        return;
    }
    all.iter_mut().for_each(|(_, weight)| *weight = (*weight * one).round() / one);
    let missing = 1.0 - all.iter().map(|(_, weight)| weight).sum::<f64>();
    if let Some((_, largest)) = all.first_mut() {
        *largest += missing;
    }
}

/// Validators accept weights whose sum differs from 1 by a little less than this.
const UNIT_SUM: f64 = 5e-7;

/// The numbers of the features that a vertex belongs to, also where the file has them as floating point.
const FEATURE_IDS: [&str; 2] = ["_FEATURE_ID_", "_BATCHID"];

fn rule(data: &VertexData, skin_sets: usize) -> Rule {
    let name = data.name.as_str();
    let set = |prefix: &str| {
        let set = name.strip_prefix(prefix)?.parse::<usize>().ok()?;
        (set < skin_sets).then_some(set)
    };
    match (name, set("JOINTS_"), set("WEIGHTS_")) {
        ("POSITION", ..) if data.width == 3 => Rule::Position,
        ("NORMAL", ..) if data.width == 3 => Rule::Normal,
        ("TANGENT", ..) if data.width == 4 => Rule::Tangent,
        (_, Some(set), _) => Rule::Joints(set),
        (_, _, Some(set)) => Rule::Weights(set),
        _ if name.starts_with("JOINTS_") => Rule::Nearest,
        _ if FEATURE_IDS.iter().any(|prefix| name.starts_with(prefix)) => Rule::Nearest,
        _ if name.starts_with('_') && data.component.is_integer() && !data.normalized => {
            Rule::Nearest
        }
        _ => Rule::Blend,
    }
}

/// Positions lie between the steps of an integer type, so they become floating point.
fn new_type(old: &VertexData, rule: Rule) -> VertexData {
    match rule {
        Rule::Position => {
            VertexData { component: ScalarType::F32, normalized: false, ..old.empty() }
        }
        _ => old.empty(),
    }
}

impl Column<'_> {
    /// Appends the value at a point, which is between vertices with the data `old`.
    fn push(
        &self,
        old: &VertexData,
        corner: &Corner,
        blend: &Blend,
        influences: &[(f64, f64)],
        bytes: &mut Vec<u8>,
    ) {
        let Self { new, rule, .. } = self;
        let influence =
            |set: usize, k: usize| influences.get(4 * set + k).copied().unwrap_or((0.0, 0.0));
        match rule {
            Rule::Position => self.push_all(corner.position.to_array(), bytes),
            Rule::Normal => match corner.normal {
                Some(normal) => self.push_all(normal.to_array().map(|n| n * new.one()), bytes),
                None => copy(old, blend.nearest(), bytes),
            },
            Rule::Tangent => self.push_tangent(old, corner.normal, blend, bytes),
            Rule::Joints(set) if !influences.is_empty() => {
                (0..4).for_each(|k| new.encode(influence(*set, k).0, bytes));
            }
            Rule::Weights(set) if !influences.is_empty() => {
                (0..4).for_each(|k| new.encode(influence(*set, k).1 * new.one(), bytes));
            }
            _ if blend.weights.contains(&1.0) => copy(old, blend.nearest(), bytes),
            Rule::Joints(_) | Rule::Weights(_) | Rule::Nearest => copy(old, blend.nearest(), bytes),
            Rule::Blend => {
                (0..old.width).for_each(|k| new.encode(blended(old, blend, k), bytes));
            }
        }
    }

    fn push_all<const N: usize>(&self, values: [f64; N], bytes: &mut Vec<u8>) {
        values.iter().for_each(|&value| self.new.encode(value, bytes));
    }

    /// A tangent of unit length, perpendicular to the normal, on the side of the nearest vertex.
    fn push_tangent(
        &self,
        old: &VertexData,
        normal: Option<DVec3>,
        blend: &Blend,
        bytes: &mut Vec<u8>,
    ) {
        let one = self.new.one();
        let tangent = DVec3::from([0, 1, 2].map(|k| blended(old, blend, k) / one));
        let normal = normal.filter(|normal| normal.is_finite()).unwrap_or(DVec3::ZERO);
        let flat = tangent - normal * tangent.dot(normal);
        let any = || normal.try_normalize().map_or(DVec3::X, DVec3::any_orthonormal_vector);
        let tangent = flat.try_normalize().unwrap_or_else(any);
        self.push_all(tangent.to_array().map(|t| t * one), bytes);
        let side = old.get(blend.nearest() as usize, 3);
        self.new.encode(if side < 0.0 { -one } else { one }, bytes);
    }
}

fn copy(old: &VertexData, vertex: u32, bytes: &mut Vec<u8>) {
    bytes.extend_from_slice(old.value(vertex as usize));
}

fn blended(old: &VertexData, blend: &Blend, component: usize) -> f64 {
    let weighted = blend.sources.iter().zip(blend.weights).filter(|(_, weight)| *weight != 0.0);
    weighted.map(|(&vertex, weight)| weight * old.get(vertex as usize, component)).sum()
}
