//! Reading OBJ.

use super::material;
use super::polypaint::Polypaint;
use crate::budget::GROWING;
use crate::color_range::NO_COLOR;
use crate::error::ReadErrorKind;
use crate::external::Files;
use crate::input::{Input, Line, integer, number};
use crate::notes::Notes;
use crate::numbering::Numbering;
use crate::text::quote;
use crate::{Group, Model};
use glam::DVec3;
use mesh_core::{PolygonSoup, as_u32};
use std::collections::{BTreeMap, HashMap};

pub(crate) fn read(input: &mut Input<'_>, files: &Files<'_>) -> Result<Model, ReadErrorKind> {
    let mut reader = Reader::new();
    // A line joined from several.
    let mut joined = Vec::new();
    while let Some(line) = input.line()? {
        let cost = if line.text.ends_with(b"\\") {
            let number = line.number;
            joined.clear();
            joined.extend_from_slice(line.text);
            join_lines(&mut joined, input)?;
            reader.line(Line { number, text: &joined })?
        } else {
            reader.line(line)?
        };
        input.spend_on_line(cost)?;
    }
    reader.finish(input, files)
}

/// Appends lines while the last one ends in a backslash.
pub(super) fn join_lines(joined: &mut Vec<u8>, input: &mut Input<'_>) -> Result<(), ReadErrorKind> {
    while joined.pop_if(|last| *last == b'\\').is_some() {
        joined.push(b' ');
        match input.line()? {
            Some(line) => joined.extend_from_slice(line.text),
            None => break,
        }
    }
    Ok(())
}

/// The content read so far.
struct Reader {
    soup: PolygonSoup,
    /// Empty, or one per vertex; white where a vertex has no colour.
    colors: Vec<[f32; 4]>,
    /// The colours in comments.
    polypaint: Polypaint,
    /// The texture coordinates and normals that the file lists.
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    /// The texture coordinates and normals of the corners, up to the last face that has any.
    corner_uvs: Option<Vec<[f32; 2]>>,
    corner_normals: Option<Vec<[f32; 3]>>,
    face_groups: Vec<u32>,
    face_materials: Vec<u32>,
    objects: Numbering,
    group_names: Numbering,
    /// The object and the name of every group, and the inverse map.
    groups: Vec<[u32; 2]>,
    group_ids: HashMap<[u32; 2], u32, foldhash::fast::RandomState>,
    materials: Numbering,
    libraries: Numbering,
    /// The object and group of the next face.
    object: u32,
    group_name: u32,
    group: u32,
    material: u32,
    /// The current face: its vertices, and the indices of their texture coordinates and normals.
    face: Vec<u32>,
    face_uvs: Vec<u32>,
    face_normals: Vec<u32>,
    small_faces: u64,
    /// The number of texture coordinates with a third number that is not 0.
    third_uvs: u64,
    /// The smoothing group of every face up to the last face in a group, and the group of the next face.
    smoothing: Vec<u32>,
    smoothing_group: u32,
    /// The number of lines that contain no part of a mesh, by keyword.
    others: BTreeMap<String, u64>,
    notes: Notes,
}

impl Reader {
    fn new() -> Self {
        let mut reader = Self {
            soup: PolygonSoup::new(),
            colors: Vec::new(),
            polypaint: Polypaint::default(),
            uvs: Vec::new(),
            normals: Vec::new(),
            corner_uvs: None,
            corner_normals: None,
            face_groups: Vec::new(),
            face_materials: Vec::new(),
            objects: Numbering::default(),
            group_names: Numbering::default(),
            groups: Vec::new(),
            group_ids: HashMap::default(),
            materials: Numbering::default(),
            libraries: Numbering::default(),
            object: 0,
            group_name: 0,
            group: Model::NONE,
            material: Model::NONE,
            face: Vec::new(),
            face_uvs: Vec::new(),
            face_normals: Vec::new(),
            small_faces: 0,
            third_uvs: 0,
            smoothing: Vec::new(),
            smoothing_group: 0,
            others: BTreeMap::new(),
            notes: Notes::default(),
        };
        // Content before the first object is in an object without a name, and likewise for groups.
        reader.objects.number("");
        reader.group_names.number("");
        reader
    }

    /// Processes a line of the file and returns its memory.
    fn line(&mut self, line: Line<'_>) -> Result<u64, ReadErrorKind> {
        let mut words = line.words();
        let Some(keyword) = words.next() else { return Ok(self.polypaint.line(&line)) };
        let name = || String::from_utf8_lossy(words.remainder());
        match keyword {
            b"v" => self.position(line),
            b"vt" => {
                let [u, v, w] = floats(line, 1)?;
                self.uvs.push([u, v]);
                self.third_uvs += u64::from(w != 0.0);
                Ok(GROWING * 8)
            }
            b"vn" => {
                self.normals.push(floats(line, 3)?);
                Ok(GROWING * 12)
            }
            b"f" | b"fo" => self.face(line),
            b"o" => {
                let (object, is_new) = self.objects.number(&name());
                (self.object, self.group_name) = (object, 0);
                Ok(self.group() + cost_of_name(is_new, words.remainder()))
            }
            b"g" => {
                let (group_name, is_new) = self.group_names.number(&name());
                self.group_name = group_name;
                Ok(self.group() + cost_of_name(is_new, words.remainder()))
            }
            b"usemtl" => {
                let (material, is_new) = self.materials.number(&name());
                self.material = material;
                let material = if is_new { material::COST } else { 0 };
                Ok(material + cost_of_name(is_new, words.remainder()))
            }
            b"mtllib" => {
                let (_, is_new) = self.libraries.number(&name());
                Ok(cost_of_name(is_new, words.remainder()))
            }
            b"s" => {
                self.smoothing_group = smoothing_group(words.remainder());
                Ok(0)
            }
            other => {
                let known = String::from_utf8_lossy(other);
                if self.others.len() < MOST_KEYWORDS || self.others.contains_key(known.as_ref()) {
                    *self.others.entry(known.into_owned()).or_insert(0) += 1;
                } else {
                    *self.others.entry(String::new()).or_insert(0) += 1;
                }
                Ok(0)
            }
        }
    }

    /// Switches to the group of the current object and name, and returns its memory.
    fn group(&mut self) -> u64 {
        let key = [self.object, self.group_name];
        let next = as_u32(self.groups.len());
        self.group = *self.group_ids.entry(key).or_insert(next);
        if self.group != next {
            return 0;
        }
        self.groups.push(key);
        // An entry in the list and in the table, and later the full names.
        let [object, name] = self.names(key).map(|name| name.len() as u64 + 16);
        GROWING * 32 + size_of::<Group>() as u64 + object + name
    }

    fn names(&self, [object, name]: [u32; 2]) -> [&str; 2] {
        [&self.objects.names()[object as usize], &self.group_names.names()[name as usize]]
    }

    fn position(&mut self, line: Line<'_>) -> Result<u64, ReadErrorKind> {
        let (position, color) = position(line)?;
        let vertices = self.soup.vertex_count();
        if color.is_some() || !self.colors.is_empty() {
            self.colors.resize(vertices, NO_COLOR);
            self.colors.push(color.unwrap_or(NO_COLOR));
        }
        self.soup.push_vertex(position);
        // Includes memory for a colour, whether or not there is one yet.
        Ok(GROWING * (24 + 16))
    }

    fn face(&mut self, line: Line<'_>) -> Result<u64, ReadErrorKind> {
        self.face.clear();
        self.face_uvs.clear();
        self.face_normals.clear();
        let counts = [self.soup.vertex_count(), self.uvs.len(), self.normals.len()];
        for word in line.words().skip(1) {
            let [vertex, uv, normal] = corner(line, word, counts)?;
            self.face.extend(vertex);
            self.face_uvs.extend(uv);
            self.face_normals.extend(normal);
        }
        if self.face.len() < 3 {
            self.small_faces += 1;
            return Ok(0);
        }
        let first = self.soup.corners().len();
        self.soup.push_face(&self.face)?;
        // A face has texture coordinates only if all corners do.
        if self.face_uvs.len() == self.face.len() {
            let uvs = self.face_uvs.iter().map(|&uv| self.uvs[uv as usize]);
            append(self.corner_uvs.get_or_insert_default(), first, [f32::NAN; 2], uvs);
        }
        if self.face_normals.len() == self.face.len() {
            let normals = self.face_normals.iter().map(|&normal| self.normals[normal as usize]);
            append(self.corner_normals.get_or_insert_default(), first, [f32::NAN; 3], normals);
        }
        if self.smoothing_group != 0 {
            append(
                &mut self.smoothing,
                self.face_groups.len(),
                0,
                [self.smoothing_group].into_iter(),
            );
        }
        self.face_groups.push(self.group);
        self.face_materials.push(self.material);
        Ok(GROWING * (16 + self.face.len() as u64 * (4 + 8 + 12)))
    }

    fn finish(mut self, input: &mut Input<'_>, files: &Files<'_>) -> Result<Model, ReadErrorKind> {
        let corners = self.soup.corners().len();
        if let Some(uvs) = &mut self.corner_uvs {
            uvs.resize(corners, [f32::NAN; 2]);
        }
        if let Some(normals) = &mut self.corner_normals {
            normals.resize(corners, [f32::NAN; 3]);
        }
        if !self.colors.is_empty() {
            self.colors.resize(self.soup.vertex_count(), NO_COLOR);
        }
        let why = "a face needs three";
        self.notes.lose_some("faces of fewer than three corners", self.small_faces, why);
        let why = "textures of surfaces have two; only the first two are kept";
        self.notes.lose_some("third texture coordinates", self.third_uvs, why);
        for (keyword, count) in &self.others {
            let (what, why) = lost_line(keyword);
            self.notes.lose_some(what, *count, why);
        }
        if !self.smoothing.is_empty() {
            self.smoothing.resize(self.face_groups.len(), 0);
        }
        let named = |&key: &[u32; 2]| {
            let [object, name] = self.names(key).map(str::to_owned);
            Group { object, name }
        };
        let groups: Vec<Group> = self.groups.iter().map(named).collect();
        let (materials, images) = material::read_libraries(
            &self.materials,
            self.libraries.names(),
            input,
            files,
            &mut self.notes,
        )?;
        let mut model = Model {
            soup: self.soup,
            vertex_colors: (!self.colors.is_empty()).then_some(self.colors),
            corner_normals: self.corner_normals,
            corner_uvs: self.corner_uvs,
            face_groups: (!groups.is_empty()).then_some(self.face_groups),
            groups,
            face_materials: (!materials.is_empty()).then_some(self.face_materials),
            materials,
            images,
            material_libraries: self.libraries.into_names(),
            face_smoothing: (!self.smoothing.is_empty()).then_some(self.smoothing),
            ..Model::default()
        };
        self.polypaint.store(&mut model, &mut self.notes);
        self.notes.store(&mut model);
        Ok(model)
    }
}

/// The largest number of keywords that are counted separately.
const MOST_KEYWORDS: usize = 50;

/// The number of a smoothing group; 0 for `off`, and 1 for a name.
fn smoothing_group(word: &[u8]) -> u32 {
    match word {
        b"" | b"off" | b"OFF" | b"Off" => 0,
        b"on" | b"ON" | b"On" => 1,
        word => {
            integer::<i64>(word).map_or(1, |group| u32::try_from(group.max(0)).unwrap_or(u32::MAX))
        }
    }
}

/// The content of the lines with a keyword, and the reason for its loss.
pub(super) fn lost_line(keyword: &str) -> (String, &'static str) {
    let name = match keyword {
        "l" => "lines",
        "p" => "points",
        "vp" => "points of curves",
        "curv" | "curv2" | "surf" => "free-form curves and surfaces",
        "" => return ("OBJ lines of other keywords".to_owned(), "they are no part of OBJ"),
        "cstype" | "deg" | "bmat" | "step" | "parm" | "trim" | "hole" | "scrv" | "sp" | "end"
        | "con" | "mg" | "bevel" | "c_interp" | "d_interp" | "lod" | "shadow_obj" | "trace_obj"
        | "ctech" | "stech" | "maplib" | "usemap" | "call" | "csh" => {
            let what = format!("OBJ lines of {}", quote(keyword.as_bytes()));
            return (what, "a model holds polygons only");
        }
        _ => {
            let what = format!("OBJ lines of {}", quote(keyword.as_bytes()));
            return (what, "the keyword is not known");
        }
    };
    (name.to_owned(), "a model holds polygons only")
}

/// `x y z`, then nothing, a weight, or a colour with or without opacity.
pub(super) fn position(line: Line<'_>) -> Result<(DVec3, Option<[f32; 4]>), ReadErrorKind> {
    let mut values = [0.0; 7];
    let mut count = 0;
    for word in line.words().skip(1) {
        let value = number(word);
        match (values.get_mut(count), value) {
            (Some(slot), Some(value)) => *slot = value,
            _ => return Err(line.unexpected("3 to 7 numbers", word)),
        }
        count += 1;
    }
    let [x, y, z, fourth, g, b, opacity] = values;
    let position = DVec3::new(x, y, z);
    let color = |opacity| Some([fourth as f32, g as f32, b as f32, opacity]);
    match count {
        3 => Ok((position, None)),
        4 if fourth != 0.0 => Ok((position / fourth, None)),
        4 => Err(line.unexpected("a weight other than zero", b"0")),
        6 => Ok((position, color(1.0))),
        7 => Ok((position, color(opacity as f32))),
        _ => Err(line.unexpected("3, 4, 6 or 7 numbers", line.text)),
    }
}

/// Appends values for the corners from `first` on; earlier corners without values get `fill`.
fn append<T: Copy>(all: &mut Vec<T>, first: usize, fill: T, values: impl Iterator<Item = T>) {
    all.resize(first, fill);
    all.extend(values);
}

fn cost_of_name(is_new: bool, name: &[u8]) -> u64 {
    if is_new { Numbering::COST + name.len() as u64 } else { 0 }
}

/// The numbers after the keyword. At least `least` are required; surplus ones are ignored, but another word is an
/// error: two lines became one.
fn floats<const N: usize>(line: Line<'_>, least: usize) -> Result<[f32; N], ReadErrorKind> {
    let mut values = [0.0; N];
    let mut words = line.words().skip(1);
    for (index, value) in values.iter_mut().enumerate() {
        match words.next() {
            None if index >= least => {}
            word => {
                let word = word.unwrap_or_default();
                let read = number(word);
                *value = read.ok_or_else(|| line.unexpected("a number", word))? as f32;
            }
        }
    }
    match words.find(|word| number(word).is_none()) {
        None => Ok(values),
        Some(word) => Err(line.unexpected("a number or the end of the line", word)),
    }
}

/// The indices of the vertex, the texture coordinate and the normal in `v/vt/vn`. The elements must have been defined
/// before.
pub(super) fn corner(
    line: Line<'_>,
    corner: &[u8],
    counts: [usize; 3],
) -> Result<[Option<u32>; 3], ReadErrorKind> {
    const NAMES: [[&str; 2]; 3] = [
        ["vertex", "vertices"],
        ["texture coordinate", "texture coordinates"],
        ["normal", "normals"],
    ];
    let mut places = [None; 3];
    for (part, word) in corner.split(|&byte| byte == b'/').enumerate() {
        let (Some(&count), Some([name, names])) = (counts.get(part), NAMES.get(part)) else {
            return Err(line.unexpected("no more than vertex/texture/normal", corner));
        };
        if word.is_empty() {
            continue;
        }
        let index: i64 = integer(word)
            .ok_or_else(|| line.unexpected(format!("the index of a {name}"), corner))?;
        if index == 0 || index.unsigned_abs() > count as u64 {
            let expected = format!(
                "the index of one of the {count} {names} before this line (from 1, or from -1 back)"
            );
            return Err(line.unexpected(expected, word));
        }
        let place = if index > 0 { index - 1 } else { count as i64 + index };
        places[part] = Some(u32::try_from(place).map_err(|_| mesh_core::soup::TooManyCorners)?);
    }
    match places {
        [Some(_), ..] => Ok(places),
        _ => Err(line.unexpected("the index of a vertex", corner)),
    }
}
