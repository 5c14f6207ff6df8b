//! The content of a page, and its conversion to text.

use std::borrow::Cow;
use std::collections::{HashMap, HashSet};

use glam::DVec3;
use mesh_core::{BoundingBox, as_u32};
use mesh_io::Alpha;
use mesh_render::{ColorMap, LABEL_COLORS};
use serde_json::{Value, json};

use crate::encode::{Blobs, octahedral, remainders};
use crate::error::ViewError;
use crate::exhibit::{Exhibit, Field, Materials, On};
use crate::markup::document;
use crate::reduce::reduce;
use crate::text::{file_name, in_script, visible};
use crate::up::Up;

/// A page with one or several meshes.
#[derive(Clone, Debug, PartialEq)]
pub struct Page {
    /// The title.
    pub title: String,
    /// The meshes, in order.
    pub exhibits: Vec<Exhibit>,
    /// The initial arrangement of several meshes.
    pub layout: Layout,
    /// The other initial settings of the page.
    pub start: Start,
    /// The sections of the side panel: the operation, its options, its errors.
    pub report: Vec<Section>,
    /// The precision of positions.
    pub precision: Precision,
    /// Meshes with more faces are simplified, and the page says so.
    pub most_faces: usize,
}

/// The arrangement of several meshes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Layout {
    /// Side by side, with one camera.
    #[default]
    Side,
    /// One over the other, with a movable border between them.
    Wipe,
    /// Alternating.
    Blink,
    /// One mesh at a time.
    One,
    /// By the size on the screen, for levels of detail; see [`Exhibit::coverage`].
    Distance,
}

impl Layout {
    /// All arrangements.
    pub const ALL: &'static [Self] =
        &[Self::Side, Self::Wipe, Self::Blink, Self::One, Self::Distance];

    /// The name in lower case.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Side => "side",
            Self::Wipe => "wipe",
            Self::Blink => "blink",
            Self::One => "one",
            Self::Distance => "distance",
        }
    }
}

/// The initial settings of a page; all of them can be changed on it.
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct Start {
    /// The colours: [`Field::key`], [`Exhibit::COMPONENTS`], `plain`, `material`, `vertexColors` or `faceColors`.
    /// `None` for materials if there are any, otherwise the first available kind.
    pub color: Option<String>,
    /// The colour map; `None` for the usual one of the quantity.
    pub map: Option<ColorMap>,
    /// The range of the colours; `None` for the range of the field.
    pub range: Option<[f64; 2]>,
    /// Smooth shading; `None` to use it for meshes of more than 20,000 faces.
    pub smooth: Option<bool>,
    /// Drawn edges; `None` to draw them for meshes of up to 20,000 faces without materials.
    pub edges: Option<bool>,
    /// Lines that are visible at first, besides those with their own setting: `Boundary`, `Non-manifold edges`, `Sharp
    /// edges`.
    pub overlays: Vec<String>,
    /// The axis that points up.
    pub up: Up,
    /// The rotation of the model as a quaternion, x, y, z and w, instead of one in which `up` points up.
    pub turn: Option<[f64; 4]>,
}

/// The precision of positions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Precision {
    /// 65,536 steps along each side of the box, finer than a screen.
    #[default]
    Screen,
    /// 32-bit floating-point numbers, relative to the centre of the box.
    Single,
}

/// A section of the side panel.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Section {
    /// Its heading.
    pub title: String,
    /// A paragraph.
    pub text: String,
    /// Names and values.
    pub rows: Vec<(String, String)>,
    /// The column heads of a table.
    pub header: Vec<String>,
    /// The rows of the table.
    pub lines: Vec<Vec<String>>,
    /// The key of a field of labels: the first cell of each row of the table is one of them, and shows it alone.
    pub labels: Option<String>,
    /// Whether it is collapsed at first.
    pub folded: bool,
}

impl Section {
    /// A section with names and values.
    #[must_use]
    pub fn of_rows<N: Into<String>, V: Into<String>>(
        title: &str,
        rows: impl IntoIterator<Item = (N, V)>,
    ) -> Self {
        let rows = rows.into_iter().map(|(name, value)| (name.into(), value.into())).collect();
        Self { title: title.into(), rows, ..Self::default() }
    }

    /// A JSON document as names and values. Nested names follow the outer ones. Of lists of objects, those that tell what
    /// they are about have a row: their count and the reason.
    #[must_use]
    pub fn of_json(title: &str, document: &Value) -> Self {
        let mut rows = Vec::new();
        flatten("", document, &mut rows);
        Self::of_rows(title, rows)
    }
}

fn flatten(name: &str, value: &Value, rows: &mut Vec<(String, String)>) {
    let plain = name.replace('_', " ");
    match value {
        Value::Object(parts) => {
            for (key, part) in parts {
                let inner = if name.is_empty() { key.clone() } else { format!("{name}, {key}") };
                flatten(&inner, part, rows);
            }
        }
        Value::Array(parts) if parts.iter().all(|p| p.is_object() || p.is_array()) => {
            rows.extend(parts.iter().filter_map(|part| about(&plain, part)));
        }
        Value::Array(parts) => {
            let shown = parts.iter().take(12).map(short).collect::<Vec<_>>().join(", ");
            let dots = if parts.len() > 12 { ", ..." } else { "" };
            rows.push((plain, format!("{shown}{dots}")));
        }
        Value::Null => {}
        other => rows.push((plain, short(other))),
    }
}

/// A repair or a loss, by its name.
fn about(list: &str, entry: &Value) -> Option<(String, String)> {
    let what = entry["what"].as_str()?;
    let told = [&entry["count"], &entry["why"]].into_iter().filter(|value| !value.is_null());
    Some((format!("{list}, {what}"), told.map(short).collect::<Vec<_>>().join(": ")))
}

fn short(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Number(number) => match number.as_f64() {
            Some(x) if !number.is_i64() && !number.is_u64() => {
                let rounded: f64 = format!("{x:.6e}").parse().unwrap_or(x);
                if rounded != 0.0 && !(1e-4..1e9).contains(&rounded.abs()) {
                    format!("{rounded:e}")
                } else {
                    rounded.to_string()
                }
            }
            _ => number.to_string(),
        },
        other => other.to_string(),
    }
}

/// The number of colours per map on the page.
const COLORS: usize = 256;

impl Page {
    /// The largest number of faces of a mesh that is shown unchanged.
    pub const MOST_FACES: usize = 1_500_000;

    /// A page of these meshes, side by side.
    #[must_use]
    pub fn new(title: impl Into<String>, exhibits: Vec<Exhibit>) -> Self {
        Self {
            title: title.into(),
            exhibits,
            layout: Layout::default(),
            start: Start::default(),
            report: Vec::new(),
            precision: Precision::default(),
            most_faces: Self::MOST_FACES,
        }
    }

    /// The page as a self-contained HTML file.
    ///
    /// # Errors
    /// There is no mesh, or a mesh has no faces; the length of a list does not match its elements; or an index is out
    /// of range.
    pub fn to_html(&self) -> Result<String, ViewError> {
        self.to_html_until(&|| false).map(Option::unwrap_or_default)
    }

    /// As [`to_html`](Self::to_html), until `stops` returns true; then `None`. It is called before each mesh and at the
    /// end.
    ///
    /// # Errors
    /// As [`to_html`](Self::to_html).
    pub fn to_html_until(&self, stops: &dyn Fn() -> bool) -> Result<Option<String>, ViewError> {
        if self.exhibits.is_empty() {
            return Err(ViewError::NoMeshes);
        }
        let mut blobs = Blobs::default();
        let mut maps: Vec<Value> = ColorMap::ALL
            .iter()
            .map(|map| {
                let blob = blobs.bytes(map.table(COLORS).as_flattened());
                json!({ "name": map.name(), "diverging": map.is_diverging(), "blob": blob })
            })
            .collect();
        let blob = blobs.bytes(LABEL_COLORS.as_flattened());
        maps.push(json!({ "name": "labels", "diverging": false, "blob": blob }));
        let mut meshes: Vec<String> = Vec::new();
        for exhibit in &self.exhibits {
            if stops() {
                return Ok(None);
            }
            meshes.push(self.encode(exhibit, &mut blobs)?);
        }
        let part = |part: &Section| {
            let all = |texts: &[String]| texts.iter().map(|t| visible(t)).collect::<Vec<_>>();
            json!({
                "title": visible(&part.title),
                "text": visible(&part.text),
                "rows": part.rows.iter().map(|(n, v)| [visible(n), visible(v)]).collect::<Vec<_>>(),
                "header": all(&part.header),
                "lines": part.lines.iter().map(|line| all(line)).collect::<Vec<_>>(),
                "labels": part.labels.as_deref().map(visible),
                "open": !part.folded,
            })
        };
        let description = json!({
            "file": file_name(&self.title),
            "maps": maps,
            "layout": self.layout.name(),
            "start": self.start_values(),
            "report": self.report.iter().map(part).collect::<Vec<_>>(),
        });
        let description = with_list(&description, "meshes", meshes);
        if stops() {
            return Ok(None);
        }
        Ok(Some(document(&self.title, &in_script(&description), &blobs.elements)))
    }

    fn start_values(&self) -> Value {
        let Start { color, map, range, smooth, edges, overlays, up, turn } = &self.start;
        let mut overlays: Vec<String> = overlays.iter().map(|name| visible(name)).collect();
        for exhibit in &self.exhibits {
            overlays.extend(exhibit.lines.iter().filter(|l| l.shown).map(|l| visible(&l.name)));
            overlays
                .extend(exhibit.directions.iter().filter(|d| d.shown).map(|d| visible(&d.name)));
        }
        json!({
            "color": color, "map": map.map(ColorMap::name), "range": range, "smooth": smooth,
            "edges": edges, "overlays": overlays, "up": up.name(), "turn": turn,
        })
    }

    /// The JSON text of a mesh.
    fn encode<'p>(&self, exhibit: &'p Exhibit, blobs: &mut Blobs<'p>) -> Result<String, ViewError> {
        check(exhibit)?;
        let shown = Shown::of(exhibit, self.most_faces)?;
        let bounds = shown.bounds()?;
        let center = bounds.center();
        let local = |v: u32| {
            let p = exhibit.positions[v as usize];
            // Only vertices without faces can have any position.
            if p.is_finite() { p.clamp(bounds.min, bounds.max) - center } else { DVec3::ZERO }
        };
        let positions: Vec<DVec3> = shown.vertices().map(local).collect();
        let lines = exhibit.lines.iter().map(|line| {
            let ends = line.segments.as_flattened().iter().filter(|p| p.is_finite());
            let numbers = ends.flat_map(|&p| (p - center).to_array()).map(|x| x as f32);
            let blob = blobs.floats(numbers);
            let width = if line.width.is_finite() { line.width.clamp(0.5, 40.0) } else { 2.0 };
            json!({ "name": visible(&line.name), "color": line.color, "width": width, "blob": blob })
        });
        let lines: Vec<Value> = lines.collect();
        let directions = exhibit.directions.iter().map(|set| {
            let bytes = shown.vertices().map(|v| octahedral(set.vectors[v as usize]));
            let blob = blobs.bytes(bytes.collect::<Vec<_>>().as_flattened());
            json!({ "name": visible(&set.name), "color": set.color, "blob": blob })
        });
        let directions: Vec<Value> = directions.collect();
        let mesh = json!({
            "name": visible(&exhibit.name),
            "center": center.to_array(),
            "extent": bounds.extent().to_array(),
            "positions": self.positions(&positions, blobs),
            "index": {
                "count": shown.triangles.len(),
                "blob": blobs.integers(shown.triangles.as_flattened().iter().copied()),
            },
            "same": same(&positions).map(|twins| blobs.integers(twins)),
            "simplified": shown.faces.is_some().then_some(exhibit.triangles.len()),
            "vertexNumbers": shown.vertices.as_ref().map(|v| blobs.integers(v.iter().copied())),
            "faceNumbers": shown.face_numbers().map(|numbers| blobs.integers(numbers)),
            "vertexColors": exhibit.vertex_colors.as_ref().map(|colors| {
                let bytes: Vec<[u8; 4]> = shown.vertices().map(|v| colors[v as usize]).collect();
                blobs.bytes(bytes.as_flattened())
            }),
            "faceColors": exhibit.face_colors.as_ref().map(|colors| {
                let bytes: Vec<[u8; 4]> = shown.faces().map(|f| colors[f as usize]).collect();
                blobs.bytes(bytes.as_flattened())
            }),
            "materials": exhibit.materials.as_ref().map(|m| shown.materials(m, blobs)),
            "lines": lines,
            "directions": directions,
            "facts": exhibit.facts.iter().map(|(n, v)| [visible(n), visible(v)]).collect::<Vec<_>>(),
            "coverage": exhibit.coverage,
            "part": exhibit.is_part,
        });
        let fields = unique(&exhibit.fields).into_iter();
        let fields = fields.map(|(name, field)| shown.field(&name, field, blobs).to_string());
        Ok(with_list(&mesh, "fields", fields))
    }

    fn positions(&self, local: &[DVec3], blobs: &mut Blobs<'_>) -> Value {
        let count = local.len();
        if self.precision == Precision::Single {
            let numbers = local.iter().flat_map(DVec3::to_array).map(|x| x as f32);
            return json!({ "count": count, "blob": blobs.floats(numbers) });
        }
        let low = local.iter().copied().fold(DVec3::INFINITY, DVec3::min);
        let high = local.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max);
        let steps = f64::from(u16::MAX);
        // In a direction in which the mesh is flat, the step would be zero.
        let step = ((high - low) / steps).max(DVec3::splat(f64::MIN_POSITIVE));
        let numbers = local.iter().flat_map(|&p| ((p - low) / step).round().to_array());
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 65,535")]
        let bytes: Vec<u8> = numbers.flat_map(|x| (x as u16).to_le_bytes()).collect();
        json!({
            "count": count, "low": low.to_array(), "step": step.to_array(),
            "blob": blobs.bytes(&bytes),
        })
    }
}

/// The part of a mesh that is on the page.
struct Shown<'a> {
    exhibit: &'a Exhibit,
    /// The remaining vertices and triangles of the exhibit; `None` for all.
    vertices: Option<Vec<u32>>,
    faces: Option<Vec<u32>>,
    /// The corners, as indices into the shown vertices.
    triangles: Cow<'a, [[u32; 3]]>,
}

impl<'a> Shown<'a> {
    fn of(exhibit: &'a Exhibit, most_faces: usize) -> Result<Self, ViewError> {
        let nothing = || ViewError::NoFaces { name: exhibit.name.clone() };
        if exhibit.triangles.is_empty() {
            return Err(nothing());
        }
        if exhibit.triangles.len() <= most_faces {
            let triangles = Cow::Borrowed(&exhibit.triangles[..]);
            return Ok(Self { exhibit, vertices: None, faces: None, triangles });
        }
        let reduced = reduce(&exhibit.positions, &exhibit.triangles, most_faces);
        if reduced.faces.is_empty() {
            return Err(nothing());
        }
        Ok(Self {
            exhibit,
            vertices: Some(reduced.vertices),
            faces: Some(reduced.faces),
            triangles: Cow::Owned(reduced.triangles),
        })
    }

    fn vertices(&self) -> Box<dyn Iterator<Item = u32> + '_> {
        match &self.vertices {
            Some(vertices) => Box::new(vertices.iter().copied()),
            None => Box::new(0..as_u32(self.exhibit.positions.len())),
        }
    }

    fn faces(&self) -> Box<dyn Iterator<Item = u32> + '_> {
        match &self.faces {
            Some(faces) => Box::new(faces.iter().copied()),
            None => Box::new(0..as_u32(self.exhibit.triangles.len())),
        }
    }

    /// The numbers of the faces, unless they are just the indices.
    fn face_numbers(&self) -> Option<Vec<u32>> {
        let of_exhibit = |f: u32| self.exhibit.face_numbers.as_ref().map_or(f, |n| n[f as usize]);
        let is_counted = self.faces.is_none() && self.exhibit.face_numbers.is_none();
        (!is_counted).then(|| self.faces().map(of_exhibit).collect())
    }

    /// The box of the used vertices.
    fn bounds(&self) -> Result<BoundingBox, ViewError> {
        let nothing = || ViewError::NoFaces { name: self.exhibit.name.clone() };
        let corners = self.exhibit.triangles.as_flattened().iter();
        BoundingBox::of_points(corners.map(|&v| self.exhibit.positions[v as usize]))
            .ok_or_else(nothing)
    }

    fn field(&self, name: &str, field: &Field, blobs: &mut Blobs<'_>) -> Value {
        let at = |i: u32| field.values[i as usize];
        let values: Vec<f64> = match field.on {
            On::Vertices => self.vertices().map(at).collect(),
            On::Faces => self.faces().map(at).collect(),
        };
        let on = match field.on {
            On::Vertices => "vertex",
            On::Faces => "face",
        };
        json!({
            "name": name, "unit": visible(&field.unit), "on": on, "signed": field.signed, "range": field.range,
            "label": field.is_label,
            "blob": blobs.floats(values.iter().map(|&x| x as f32)),
            "fine": remainders(&values).map(|rest| blobs.bytes(&rest)),
        })
    }

    fn materials<'p>(&self, materials: &'p Materials, blobs: &mut Blobs<'p>) -> Value {
        let numbers = materials.surfaces.iter().flat_map(|surface| {
            // Negative for blended surfaces; positive for the smallest opacity that is drawn.
            let alpha = match surface.alpha {
                Alpha::Blend => -1.0,
                Alpha::Mask(cutoff) => cutoff.clamp(0.004, 1.0),
                Alpha::Opaque => 0.0,
            };
            let image = surface.picture.map_or(-1.0, |picture| picture as f32);
            let [r, g, b, opacity] = surface.color;
            [r, g, b, opacity, image, surface.roughness, surface.metallic, alpha]
        });
        let list = blobs.floats(numbers.map(|x| if x.is_finite() { x } else { 0.0 }));
        // A visible name has no line breaks.
        let names: Vec<String> =
            materials.surfaces.iter().map(|surface| visible(&surface.name)).collect();
        let names = names.join("\n");
        let images = materials.pictures.iter().map(|picture| {
            json!({ "type": picture.format.media_type(), "blob": blobs.picture(&picture.bytes) })
        });
        let images: Vec<Value> = images.collect();
        let of_face = blobs.integers(self.faces().map(|f| materials.of_face[f as usize]));
        let (uvs, uv_index) = match &materials.uvs {
            Some(uvs) => {
                let corners = self.faces().flat_map(|f| uvs[f as usize]);
                let keys: Vec<[u32; 2]> = corners.map(|uv| uv.map(f32::to_bits)).collect();
                let mut all = keys.clone();
                all.sort_unstable();
                all.dedup();
                // In the order of first use, so that neighbours are close to each other.
                let mut place = vec![u32::MAX; all.len()];
                let (mut used, mut index) = (Vec::new(), Vec::with_capacity(keys.len()));
                for key in &keys {
                    let at = all.partition_point(|other| other < key);
                    if place[at] == u32::MAX {
                        place[at] = as_u32(used.len());
                        used.push(*key);
                    }
                    index.push(place[at]);
                }
                let floats = used.as_flattened().iter().map(|&bits| f32::from_bits(bits));
                (Some(blobs.floats(floats)), Some(blobs.integers(index)))
            }
            None => (None, None),
        };
        json!({
            "list": list, "names": names, "images": images, "faces": of_face, "uvs": uvs,
            "uvIndex": uv_index,
        })
    }
}

/// The text of an object with a list of texts as one more member. The values of many small parts would take ten times
/// the memory of their texts.
fn with_list(object: &Value, name: &str, parts: impl IntoIterator<Item = String>) -> String {
    let mut text = object.to_string();
    // The closing brace.
    text.pop();
    text.push_str(&format!(",\"{name}\":["));
    for (place, part) in parts.into_iter().enumerate() {
        text.push_str(if place == 0 { "" } else { "," });
        text.push_str(&part);
    }
    text.push_str("]}");
    text
}

/// For every vertex, the first vertex at the same position; `None` if all positions differ.
fn same(positions: &[DVec3]) -> Option<Vec<u32>> {
    // Adding zero turns -0 into 0.
    let key = |v: u32| positions[v as usize].to_array().map(|x| (x + 0.0).to_bits());
    let mut order: Vec<u32> = (0..as_u32(positions.len())).collect();
    order.sort_unstable_by_key(|&v| (key(v), v));
    let mut first: Vec<u32> = (0..as_u32(positions.len())).collect();
    let mut is_any = false;
    for group in order.chunk_by(|&a, &b| key(a) == key(b)) {
        for &v in &group[1..] {
            first[v as usize] = group[0];
            is_any = true;
        }
    }
    is_any.then_some(first)
}

/// The fields with names that are unique for their kind of element.
fn unique(fields: &[Field]) -> Vec<(String, &Field)> {
    let mut taken = HashSet::new();
    // The last number given to each name. The search continues from there.
    let mut last: HashMap<_, u64> = HashMap::new();
    let mut named = Vec::with_capacity(fields.len());
    for field in fields {
        let plain = visible(&field.name);
        let last = last.entry((field.on == On::Faces, plain.clone())).or_insert(0);
        let name = loop {
            *last += 1;
            let name = if *last == 1 { plain.clone() } else { format!("{plain} ({last})") };
            if taken.insert((field.on == On::Faces, name.clone())) {
                break name;
            }
        };
        named.push((name, field));
    }
    named
}

/// Checks that every list has the length of its elements and every index is in range.
fn check(exhibit: &Exhibit) -> Result<(), ViewError> {
    let (vertices, faces) = (exhibit.positions.len(), exhibit.triangles.len());
    let length = |what: &str, found: usize, of: &'static str, expected: usize| {
        let (name, what) = (exhibit.name.clone(), what.to_owned());
        if found == expected {
            Ok(())
        } else {
            Err(ViewError::Length { name, what, found, of, expected })
        }
    };
    let index = |what: &'static str, index: usize, value: u32, count: usize| {
        let name = exhibit.name.clone();
        Err(ViewError::Index { name, what, index, value, count })
    };
    let is_there = |v: u32| exhibit.positions.get(v as usize).is_some_and(|p| p.is_finite());
    for (face, corners) in exhibit.triangles.iter().enumerate() {
        if let Some(&vertex) = corners.iter().find(|&&v| !is_there(v)) {
            return index("triangle", face, vertex, vertices);
        }
    }
    for field in &exhibit.fields {
        let (of, expected) = match field.on {
            On::Vertices => ("vertices", vertices),
            On::Faces => ("triangles", faces),
        };
        length(&field.name, field.values.len(), of, expected)?;
    }
    let count = |list: &Option<Vec<[u8; 4]>>, expected| list.as_ref().map_or(expected, Vec::len);
    length("the list of colours", count(&exhibit.vertex_colors, vertices), "vertices", vertices)?;
    length("the list of colours", count(&exhibit.face_colors, faces), "triangles", faces)?;
    let numbers = exhibit.face_numbers.as_ref().map_or(faces, Vec::len);
    length("the list of face numbers", numbers, "triangles", faces)?;
    for set in &exhibit.directions {
        length(&set.name, set.vectors.len(), "vertices", vertices)?;
    }
    let Some(Materials { surfaces, of_face, uvs, pictures, .. }) = &exhibit.materials else {
        return Ok(());
    };
    length("the list of materials", of_face.len(), "triangles", faces)?;
    length(
        "the list of texture coordinates",
        uvs.as_ref().map_or(faces, Vec::len),
        "triangles",
        faces,
    )?;
    if let Some((face, &id)) =
        of_face.iter().enumerate().find(|(_, id)| **id as usize >= surfaces.len())
    {
        return index("the material of triangle", face, id, surfaces.len());
    }
    for (number, surface) in surfaces.iter().enumerate() {
        match surface.picture {
            Some(picture) if picture as usize >= pictures.len() => {
                return index("material", number, picture, pictures.len());
            }
            _ => {}
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_is_given_up_at_every_call() {
        let triangle = || Exhibit {
            positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y],
            triangles: vec![[0, 1, 2]],
            ..Exhibit::default()
        };
        let page = Page::new("two", vec![triangle(), triangle()]);
        for calls in 0..4_usize {
            let left = std::cell::Cell::new(calls);
            let stops = || left.replace(left.get().saturating_sub(1)) == 0;
            let html = page.to_html_until(&stops).unwrap();
            assert_eq!(html, (calls == 3).then(|| page.to_html().unwrap()), "{calls}");
        }
    }

    #[test]
    fn lists_are_told_by_name() {
        let document = json!({
            "lost": [{ "file": "a.ply", "what": "materials", "count": 4, "why": "no place" }],
            "repairs": [{ "what": "merged vertices", "count": 2 }],
            "levels": [{ "faces": 7 }],
            "none": [],
            "range": [1, 2.5],
        });
        let row = |name: &str, value: &str| (name.to_owned(), value.to_owned());
        let rows = [
            row("lost, materials", "4: no place"),
            row("range", "1, 2.5"),
            row("repairs, merged vertices", "2"),
        ];
        assert_eq!(Section::of_json("Report", &document).rows, rows);
    }

    /// A search for a free number from the start each time would take a hundred thousand times as long.
    #[test]
    fn fields_of_one_name_are_numbered() {
        let mut fields = vec![Field::new("m (3)", On::Vertices, Vec::new())];
        fields.resize(100_000, Field::new("m", On::Vertices, Vec::new()));
        fields.push(Field::new("m", On::Faces, Vec::new()));
        let named = unique(&fields);
        let names: Vec<&str> = named.iter().map(|(name, _)| &**name).collect();
        assert_eq!(names[..5], ["m (3)", "m", "m (2)", "m (4)", "m (5)"]);
        assert_eq!((names[99_999], names[100_000]), ("m (100000)", "m"));
        let distinct: HashSet<&str> = names[..100_000].iter().copied().collect();
        assert_eq!(distinct.len(), 100_000);
    }
}
