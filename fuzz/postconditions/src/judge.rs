//! Compares the output of a command with its input.

use std::collections::BTreeSet;

use glam::DVec3;
use mesh_core::topology::handle::FaceId;
use mesh_core::{
    BoundingBox, Built, Diagnosis, FaceTree, PolygonSoup, Repair, TriMesh, TriangleBounds, Weld,
    build, diagnose, triangles_cross,
};
use mesh_io::{Format, Model, ScalarValues, Scalars};
use mesh_metric::{CompareOptions, Comparison, Surface, compare};
use mesh_work::{build_with_needed_repairs, splits_vertices, usual_weld};
use serde_json::Value;

use crate::turned::Turning;

/// What a command promises about a mesh that it writes. Numbers are finite and labels are labels of the input in any
/// case.
#[derive(Clone, Copy, Debug)]
pub struct Promise {
    /// No new faces without area, no new duplicates.
    pub faces: bool,
    /// No new slivers.
    pub slivers: bool,
    /// No face turns over against the surface.
    pub unfolded: bool,
    /// What becomes of boundary, components and Euler characteristic.
    pub topology: Topology,
    /// No new crossings of faces.
    pub no_crossings: bool,
    /// Vertices stay where they are.
    pub moves_no_vertex: bool,
    /// Every face of the input may become so many.
    pub pieces: usize,
    /// Labels, numbers and colours of the input are in the output.
    pub has_attributes: bool,
    /// Whether the command makes all repairs, not only those that it needs.
    pub is_lenient: bool,
    /// Where the report has a proved bound of the distance.
    pub bound: Option<&'static str>,
}

/// What becomes of the connectivity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Topology {
    /// It stays as the command builds it from the input.
    Same,
    /// As `Same`, but small parts may vanish.
    Fewer,
    /// It stays as it is in the input.
    Copied,
    /// It may change.
    Any,
}

impl Default for Promise {
    fn default() -> Self {
        Self {
            faces: true,
            slivers: true,
            unfolded: true,
            topology: Topology::Fewer,
            no_crossings: false,
            moves_no_vertex: false,
            pieces: 1,
            has_attributes: true,
            is_lenient: false,
            bound: None,
        }
    }
}

impl Promise {
    /// Numbers are finite, and nothing else is promised.
    #[must_use]
    pub fn finite() -> Self {
        Self {
            faces: false,
            slivers: false,
            unfolded: false,
            topology: Topology::Any,
            has_attributes: false,
            ..Self::default()
        }
    }
}

/// A mesh and its defects.
struct Side {
    /// Whether its surface was cut apart where it is not a manifold.
    is_cut: bool,
    /// Whether its vertices were welded, or faces reversed then. A weld joins again what a command has cut apart, and
    /// maybe in another way.
    is_joined: bool,
    mesh: TriMesh,
    defects: Diagnosis,
}

impl Side {
    fn new(Built { mesh, report, .. }: Built) -> Result<Self, String> {
        let defects = diagnose(&mesh.to_soup()).map_err(|error| error.to_string())?;
        let is_cut = report.cut_edges.count() + report.split_vertices.count() > 0;
        let is_joined = report.welded_vertices.count() + report.flipped_faces.count() > 0;
        Ok(Self { is_cut, is_joined, mesh, defects })
    }

    /// The input, as a command builds it.
    fn of_input(model: &Model, format: Option<Format>, promise: &Promise) -> Result<Self, String> {
        let mut repair = if promise.is_lenient { Repair::lenient() } else { Repair::strict() };
        let is_stl = format == Some(Format::Stl);
        repair.weld = if is_stl { Weld::Exact } else { usual_weld(model, format) };
        let built = build_with_needed_repairs(&model.soup, &repair);
        Self::new(built.map_err(|error| format!("input: {error}"))?)
    }

    /// The output: nothing may need a repair, except that formats split vertices.
    fn of_output(model: &Model, format: Option<Format>, input: &Self) -> Result<Self, String> {
        let mut repair = Repair::strict();
        if splits_vertices(model, format) || format == Some(Format::Stl) {
            repair.weld = Weld::Exact;
            repair.cut_non_manifold = input.is_cut;
            repair.reorient = input.is_cut;
            repair.drop_duplicates = input.is_cut;
        }
        Self::new(build(&model.soup, &repair).map_err(|error| error.to_string())?)
    }
}

/// All violations of a promise by an output. The models are as the files have them.
#[must_use]
pub fn violations(
    input: (&Model, Option<Format>),
    output: (&Model, Option<Format>),
    report: &Value,
    promise: &Promise,
) -> Vec<String> {
    let mut found = Vec::new();
    not_finite(output.0, input.0, promise.topology == Topology::Copied, &mut found);
    if promise.has_attributes {
        labels(input.0, output.0, &mut found);
    }
    if promise.topology == Topology::Copied {
        copied(input.0, output.0, &mut found);
        return found;
    }
    if !promise.faces && promise.topology == Topology::Any {
        return found;
    }
    let sides = Side::of_input(input.0, input.1, promise)
        .and_then(|before| Ok((Side::of_output(output.0, output.1, &before)?, before)));
    match sides {
        Ok((after, before)) => compare_sides(&before, &after, report, promise, &mut found),
        Err(error) => found.push(error),
    }
    found
}

fn compare_sides(
    before: &Side,
    after: &Side,
    report: &Value,
    promise: &Promise,
    found: &mut Vec<String>,
) {
    let mut count = |is_promised: bool, what: &str, count: fn(&Diagnosis) -> usize| {
        let [old, new] = [&before.defects, &after.defects].map(count);
        if is_promised && new > old * promise.pieces {
            found.push(format!("{new} {what} instead of {old}"));
        }
    };
    count(promise.faces, "faces without area", |d| d.zero_area_faces);
    count(promise.faces, "duplicate faces", |d| d.duplicate_faces);
    count(promise.slivers, "slivers", |d| d.slivers);
    let is_joined_anew = before.is_cut && after.is_joined;
    if !is_joined_anew {
        connectivity(&before.defects, &after.defects, promise, found);
    }
    if promise.moves_no_vertex {
        let key = |p: &DVec3| (*p + DVec3::ZERO).to_array().map(f64::to_bits);
        let keys = |side: &Side| side.mesh.positions().iter().map(key).collect::<BTreeSet<_>>();
        let moved = keys(after).difference(&keys(before)).count();
        if moved > 0 {
            found.push(format!("{moved} vertices moved"));
        }
    }
    if promise.no_crossings {
        let [old, new] = [before, after].map(|side| crossings(&side.mesh));
        if new > old {
            found.push(format!("{new} crossing faces instead of {old}"));
        }
    }
    if after.mesh.topology().face_count() == 0 || before.mesh.topology().face_count() == 0 {
        return;
    }
    let [old, new] = [before, after].map(|side| Surface::new(&side.mesh));
    let (Ok(old), Ok(new)) = (old, new) else {
        found.push("the mesh has no surface".to_owned());
        return;
    };
    let samples = CompareOptions { samples: 4000, ..CompareOptions::default() };
    let distances = compare(&new, &old, &samples);
    if promise.unfolded && promise.pieces == 1 && !is_joined_anew {
        let turning = Turning::new(&before.mesh, &old);
        // Within an error limit, a wall that is thinner may become two sheets on one of its sides.
        let error = match promise.bound {
            Some(_) => distances.forward.max.max(distances.backward.max),
            None => distances.forward.max,
        };
        let is_turned = |&face: &FaceId| turning.is_turned(after.mesh.triangle(face), error);
        let turned: Vec<FaceId> = after.mesh.topology().faces().filter(is_turned).collect();
        if let [first, ..] = turned[..] {
            let corners = after.mesh.triangle(first);
            let count = turned.len();
            found.push(format!("{count} faces are turned over: {first:?} at {corners:?}"));
        }
    }
    size(before, after, &distances, report, promise, found);
}

/// Boundary, components, Euler characteristic.
fn connectivity(before: &Diagnosis, after: &Diagnosis, promise: &Promise, found: &mut Vec<String>) {
    let is_smaller = promise.topology == Topology::Fewer && after.components < before.components;
    if promise.topology == Topology::Any {
        return;
    }
    if before.is_closed() && after.faces > 0 && !after.is_closed() {
        found.push(format!("{} open edges in a closed mesh", after.boundary_edges));
    }
    if is_smaller {
        return;
    }
    let same = [
        ("components", before.components as i64, after.components as i64),
        ("Euler characteristic", before.euler_characteristic, after.euler_characteristic),
        ("boundary loops", before.boundary_loops as i64, after.boundary_loops as i64),
    ];
    for (what, old, new) in same {
        if old != new {
            found.push(format!("{what} {new} instead of {old}"));
        }
    }
}

/// Counts and positions of a copy.
fn copied(input: &Model, output: &Model, found: &mut Vec<String>) {
    let triangles =
        |model: &Model| -> usize { model.soup.faces().map(|face| face.len() - 2).sum() };
    let [old, new] = [triangles(input), triangles(output)];
    if old != new {
        found.push(format!("{new} faces instead of {old}"));
    }
    let corners = |soup: &PolygonSoup| -> Option<BoundingBox> {
        BoundingBox::of_points(soup.corners().iter().map(|&v| soup.positions()[v as usize]))
    };
    if let (Some(old), Some(new)) = (corners(&input.soup), corners(&output.soup)) {
        let size = old.min.abs().max(old.max.abs()).max_element();
        let off = (old.min - new.min).abs().max((old.max - new.max).abs()).max_element();
        if off > 1e-7 * size {
            found.push(format!("the bounding box moved by {off:e}"));
        }
    }
}

/// Bounding box, volume and distance against the error that is reported, or else the error that is measured.
fn size(
    before: &Side,
    after: &Side,
    distances: &Comparison,
    report: &Value,
    promise: &Promise,
    found: &mut Vec<String>,
) {
    let [Some(old), Some(new)] = [before, after].map(|side| side.mesh.bounding_box()) else {
        return;
    };
    let rounding = 1e-12 * old.min.abs().max(old.max.abs()).max_element();
    let measured = distances.forward.max.max(distances.backward.max);
    let mut error = measured;
    if let Some(place) = promise.bound {
        match report.pointer(place).and_then(Value::as_f64) {
            Some(bound) if measured > bound + rounding => {
                found.push(format!("a point is {measured:e} away, but the bound is {bound:e}"));
            }
            Some(bound) => error = bound,
            None => found.push(format!("the report has no {place}")),
        }
        let grown = (old.min - new.min).max(new.max - old.max).max_element();
        if grown > error + rounding {
            found.push(format!("the bounding box grew by {grown:e}, but the bound is {error:e}"));
        }
    }
    if promise.pieces == 1 && promise.topology != Topology::Any && before.defects.is_closed() {
        let [old, new] = [before, after].map(|side| side.mesh.volume());
        let area = before.mesh.area().max(after.mesh.area());
        if (old - new).abs() > 1.5 * error * area + rounding * area {
            found.push(format!("the volume is {new:e} instead of {old:e}"));
        }
    }
}

/// Numbers that are not finite.
fn not_finite(output: &Model, input: &Model, is_copy: bool, found: &mut Vec<String>) {
    let mut check = |what: &str, values: Vec<f64>| {
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            found.push(format!("a {what} is {value}"));
        }
    };
    let wide = |numbers: &[f32]| numbers.iter().map(|&x| f64::from(x)).collect();
    // A conversion keeps the coordinates of the input, whatever they are.
    if !is_copy || input.soup.positions().iter().all(|p| p.is_finite()) {
        check("coordinate", output.soup.positions().iter().flat_map(DVec3::to_array).collect());
        // Those of parts without a texture are unknown.
        if let (Some(old), Some(new)) = (&input.corner_uvs, &output.corner_uvs)
            && old.as_flattened().iter().all(|number| number.is_finite())
        {
            check("texture coordinate", wide(new.as_flattened()));
        }
    }
    if let Some(normals) = &output.vertex_normals {
        check("normal", wide(normals.as_flattened()));
    }
    // Numbers that are not in the input, such as curvature, are unknown at some vertices.
    let old: Vec<&str> =
        input.vertex_scalars.iter().chain(&input.face_scalars).map(|s| &*s.name).collect();
    for Scalars { name, values, .. } in output.vertex_scalars.iter().chain(&output.face_scalars) {
        if old.contains(&&**name) {
            check(name, (0..values.len()).filter_map(|i| values.get(i)).collect());
        }
    }
}

/// Labels are labels of the input, and other numbers stay in their range.
fn labels(input: &Model, output: &Model, found: &mut Vec<String>) {
    for (old, new) in [
        (&input.vertex_scalars, &output.vertex_scalars),
        (&input.face_scalars, &output.face_scalars),
    ] {
        for before in old {
            let Some(after) = new.iter().find(|after| after.name == before.name) else {
                continue;
            };
            let list = |values: &ScalarValues| -> Vec<f64> {
                (0..values.len()).filter_map(|index| values.get(index)).collect()
            };
            let (before_values, after_values) = (list(&before.values), list(&after.values));
            if before.is_label {
                let known: BTreeSet<u64> = before_values.iter().map(|x| x.to_bits()).collect();
                if let Some(new) = after_values.iter().find(|x| !known.contains(&x.to_bits())) {
                    found.push(format!("{} has the new label {new}", before.name));
                }
                continue;
            }
            let range = |values: &[f64]| {
                values.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| {
                    [low.min(x), high.max(x)]
                })
            };
            let ([low, high], [new_low, new_high]) = (range(&before_values), range(&after_values));
            let slack = 1e-6 * (high - low).max(high.abs()).max(low.abs());
            if new_low < low - slack || new_high > high + slack {
                found.push(format!(
                    "{} ranges to {new_low:e} and {new_high:e} instead of {low:e} and {high:e}",
                    before.name
                ));
            }
        }
    }
}

/// The number of faces that cross another one.
fn crossings(mesh: &TriMesh) -> usize {
    let tree = FaceTree::new(mesh);
    let triangle = |face: FaceId| (mesh.topology().face_vertices(face), mesh.triangle(face));
    let crosses = |&face: &FaceId| {
        let this = TriangleBounds::new(triangle(face));
        tree.find_crossing(mesh, &this, |other| {
            other != face && triangles_cross(this.triangle, triangle(other))
        })
        .is_some()
    };
    mesh.topology().faces().filter(crosses).count()
}
