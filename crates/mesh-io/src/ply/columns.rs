//! The meaning of the properties of PLY vertices and faces, by name.

use super::header::{Element, Property, full_intensity, no_positions};
use super::records::{Column, Record};
use crate::Model;
use crate::error::ReadErrorKind;
use crate::notes::Notes;
use crate::scalars::{ScalarType, ScalarValues, Scalars};
use crate::text::quote;
use glam::DVec3;

/// The meaning of a property.
#[derive(Clone, Copy, PartialEq)]
enum Target {
    Position(usize),
    Normal(usize),
    /// A channel, and the value of full intensity.
    Color(usize, f64),
    Uv(usize),
    /// One of the named numbers.
    Scalar(usize),
    Nothing,
}

const POSITION: [&str; 3] = ["x", "y", "z"];
pub(super) const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
pub(super) const COLORS: [[&str; 3]; 3] =
    [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];
const ALPHAS: [&str; 3] = ["alpha", "diffuse_alpha", "a"];
pub(super) const UVS: [[&str; 2]; 4] =
    [["s", "t"], ["u", "v"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];
const INDICES: [&str; 2] = ["vertex_indices", "vertex_index"];

/// The indices of the single-valued properties with these names, if all of them exist.
fn find_all<const N: usize>(element: &Element, names: [&str; N]) -> Option<[usize; N]> {
    let places = names
        .map(|name| element.properties.iter().position(|p| p.count.is_none() && p.name == name));
    places.iter().all(Option::is_some).then(|| places.map(Option::unwrap_or_default))
}

/// The indices of the coordinates.
pub(super) fn positions(element: &Element) -> Result<[usize; 3], ReadErrorKind> {
    find_all(element, POSITION).ok_or_else(|| no_positions(element))
}

/// Assigns colours and all remaining properties; returns the remaining ones as named numbers.
fn assign_colors_and_scalars(element: &Element, targets: &mut [Target]) -> NamedNumbers {
    let full = |place: usize| full_intensity(element.properties[place].value);
    let color = COLORS.iter().zip(ALPHAS);
    if let Some((places, alpha)) =
        color.filter_map(|(names, alpha)| Some((find_all(element, *names)?, alpha))).next()
    {
        for (channel, place) in places.into_iter().enumerate() {
            targets[place] = Target::Color(channel, full(place));
        }
        if let Some([place]) = find_all(element, [alpha]) {
            targets[place] = Target::Color(3, full(place));
        }
    }
    let mut scalars = NamedNumbers::default();
    for (target, property) in targets.iter_mut().zip(&element.properties) {
        if *target == Target::Nothing && property.count.is_none() {
            *target = Target::Scalar(scalars.columns.len());
            scalars.columns.push(NamedColumn::new(property));
        }
    }
    scalars
}

/// The named numbers of an element while it is read, each in the type of its property.
#[derive(Default)]
pub(super) struct NamedNumbers {
    columns: Vec<NamedColumn>,
}

struct NamedColumn {
    name: String,
    declared: ScalarType,
    values: ScalarValues,
    /// The first number in a text file that the declared type cannot hold.
    beyond: Option<f64>,
}

impl NamedColumn {
    fn new(property: &Property) -> Self {
        let values = ScalarValues::zeros(property.value, 0);
        Self { name: property.name.clone(), declared: property.value, values, beyond: None }
    }

    /// Sets a number of a record. The column gets a wider type if the declared type cannot hold the number.
    fn set(&mut self, row: usize, value: f64, whole: Option<i128>) {
        if self.values.set(row, value, whole) {
            return;
        }
        self.beyond.get_or_insert(value);
        for wider in [ScalarType::I64, ScalarType::U64, ScalarType::F64] {
            let negative = (0..row).any(|row| self.values.whole(row).is_some_and(|w| w < 0));
            if wider == ScalarType::U64 && negative {
                continue;
            }
            self.values = self.values.cast(wider);
            if self.values.set(row, value, whole) {
                return;
            }
        }
    }
}

impl NamedNumbers {
    fn reserve_exact(&mut self, room: usize) {
        self.columns.iter_mut().for_each(|column| column.values.reserve_exact(room));
    }

    fn resize(&mut self, count: usize) {
        self.columns.iter_mut().for_each(|column| column.values.resize(count));
    }

    /// The bytes of the numbers of one record, after a possible change of type.
    fn row(&self) -> u64 {
        8 * self.columns.len() as u64
    }

    fn set(&mut self, index: usize, row: usize, record: &Record, property: usize) {
        self.columns[index].set(row, record.values[property], record.wholes[property]);
    }

    fn finish(self, notes: &mut Notes) -> Vec<Scalars> {
        let finish = |NamedColumn { name, declared, values, beyond }| {
            if let Some(value) = beyond {
                let (declared, kind) = (declared.ply_name(), values.scalar_type().ply_name());
                notes.add(format!(
                    "the PLY property {} is declared {declared} but holds {value}: read as {kind}",
                    quote(name.as_bytes())
                ));
            }
            Scalars::new(name, values)
        };
        self.columns.into_iter().map(finish).collect()
    }
}

/// The numbers of double properties that the 32 bits of a model round.
#[derive(Default)]
struct Rounded {
    normals: u64,
    colors: u64,
    uvs: u64,
}

impl Rounded {
    /// The counter of a property.
    fn of(&mut self, target: Target, kind: ScalarType) -> Option<&mut u64> {
        match target {
            _ if kind != ScalarType::F64 => None,
            Target::Normal(_) => Some(&mut self.normals),
            Target::Color(..) => Some(&mut self.colors),
            Target::Uv(_) => Some(&mut self.uvs),
            Target::Position(_) | Target::Scalar(_) | Target::Nothing => None,
        }
    }

    fn finish(&self, of: &str, notes: &mut Notes) {
        for (count, what) in
            [(self.normals, "normals"), (self.colors, "colours"), (self.uvs, "texture coordinates")]
        {
            let why = "a model has 32 bits for them";
            notes.lose_some(format!("digits of the {what} of {of}"), count, why);
        }
    }
}

fn is_rounded(value: f64) -> bool {
    f64::from(value as f32) != value && !value.is_nan()
}

/// The attributes of the vertices while they are read.
pub(super) struct VertexColumns {
    targets: Vec<Target>,
    positions: Vec<DVec3>,
    normals: Option<Vec<[f32; 3]>>,
    colors: Option<Vec<[f32; 4]>>,
    uvs: Option<Vec<[f32; 2]>>,
    scalars: NamedNumbers,
    kinds: Vec<ScalarType>,
    rounded: Rounded,
    /// The number of records before the current block.
    done: usize,
}

impl VertexColumns {
    pub(super) fn new(element: &Element) -> Result<Self, ReadErrorKind> {
        let mut targets = vec![Target::Nothing; element.properties.len()];
        let position = positions(element)?;
        for (axis, place) in position.into_iter().enumerate() {
            targets[place] = Target::Position(axis);
        }
        if let Some(places) = find_all(element, NORMAL) {
            for (axis, place) in places.into_iter().enumerate() {
                targets[place] = Target::Normal(axis);
            }
        }
        if let Some(places) = UVS.iter().find_map(|names| find_all(element, *names)) {
            for (axis, place) in places.into_iter().enumerate() {
                targets[place] = Target::Uv(axis);
            }
        }
        let scalars = assign_colors_and_scalars(element, &mut targets);
        let has = |kind: fn(&Target) -> bool| targets.iter().any(kind);
        Ok(Self {
            positions: Vec::new(),
            normals: has(|t| matches!(t, Target::Normal(_))).then(Vec::new),
            colors: has(|t| matches!(t, Target::Color(..))).then(Vec::new),
            uvs: has(|t| matches!(t, Target::Uv(_))).then(Vec::new),
            targets,
            scalars,
            kinds: element.properties.iter().map(|property| property.value).collect(),
            rounded: Rounded::default(),
            done: 0,
        })
    }

    /// Reserves memory for this many vertices.
    pub(super) fn reserve(&mut self, room: usize) {
        self.positions.reserve_exact(room);
        if let Some(normals) = &mut self.normals {
            normals.reserve_exact(room);
        }
        if let Some(colors) = &mut self.colors {
            colors.reserve_exact(room);
        }
        if let Some(uvs) = &mut self.uvs {
            uvs.reserve_exact(room);
        }
        self.scalars.reserve_exact(room);
    }

    /// The bytes of a vertex.
    pub(super) fn row(&self) -> u64 {
        let of = |there: bool, bytes| if there { bytes } else { 0 };
        24 + of(self.normals.is_some(), 12)
            + of(self.colors.is_some(), 16)
            + of(self.uvs.is_some(), 8)
            + self.scalars.row()
    }

    /// Extends the columns by a block of records, to be filled by `set_block`.
    pub(super) fn grow(&mut self, records: usize) {
        self.done = self.positions.len();
        let count = self.done + records;
        self.positions.resize(count, DVec3::ZERO);
        if let Some(normals) = &mut self.normals {
            normals.resize(count, [0.0; 3]);
        }
        if let Some(colors) = &mut self.colors {
            colors.resize(count, [0.0, 0.0, 0.0, 1.0]);
        }
        if let Some(uvs) = &mut self.uvs {
            uvs.resize(count, [0.0; 2]);
        }
        self.scalars.resize(count);
    }

    /// Sets the values of a property for the current block.
    pub(super) fn set_block(&mut self, property: usize, column: Column<'_>) {
        let done = self.done;
        if let Some(count) = self.rounded.of(self.targets[property], column.kind) {
            column.each(|_, value| *count += u64::from(is_rounded(value)));
        }
        match (self.targets[property], &mut self.normals, &mut self.colors, &mut self.uvs) {
            (Target::Position(axis), ..) => {
                let rows = &mut self.positions[done..];
                column.each(|record, value| rows[record][axis] = value);
            }
            (Target::Normal(axis), Some(normals), ..) => {
                let rows = &mut normals[done..];
                column.each(|record, value| rows[record][axis] = value as f32);
            }
            (Target::Color(channel, full), _, Some(colors), _) => {
                let rows = &mut colors[done..];
                column.each(|record, value| rows[record][channel] = intensity(value, full));
            }
            (Target::Uv(axis), .., Some(uvs)) => {
                let rows = &mut uvs[done..];
                column.each(|record, value| rows[record][axis] = value as f32);
            }
            (Target::Scalar(index), ..) => {
                column.fill(&mut self.scalars.columns[index].values, done);
            }
            _ => {}
        }
    }

    /// Adds one record.
    pub(super) fn push(&mut self, record: &Record) {
        self.grow(1);
        let row = self.done;
        let all = (&mut self.normals, &mut self.colors, &mut self.uvs);
        for (place, (&target, &value)) in self.targets.iter().zip(&record.values).enumerate() {
            if let Some(count) = self.rounded.of(target, self.kinds[place]) {
                *count += u64::from(is_rounded(value));
            }
            match (target, &mut *all.0, &mut *all.1, &mut *all.2) {
                (Target::Position(axis), ..) => self.positions[row][axis] = value,
                (Target::Normal(axis), Some(normals), ..) => normals[row][axis] = value as f32,
                (Target::Color(channel, full), _, Some(colors), _) => {
                    colors[row][channel] = intensity(value, full);
                }
                (Target::Uv(axis), .., Some(uvs)) => uvs[row][axis] = value as f32,
                (Target::Scalar(index), ..) => self.scalars.set(index, row, record, place),
                _ => {}
            }
        }
    }

    /// Moves everything into the model, except the texture coordinates, which are needed for the corners.
    pub(super) fn store(self, model: &mut Model, notes: &mut Notes) -> Option<Vec<[f32; 2]>> {
        *model.soup.positions_mut() = self.positions;
        model.vertex_normals = self.normals;
        model.vertex_colors = self.colors;
        model.vertex_scalars = self.scalars.finish(notes);
        self.rounded.finish("vertices", notes);
        self.uvs
    }
}

/// A colour from 0 to 1. The formula gives the same values for eight-bit colours as the rest of the crate.
fn intensity(value: f64, full: f64) -> f32 {
    value as f32 / full as f32
}

/// The attributes of the faces while they are read.
pub(super) struct FaceColumns {
    indices: usize,
    /// The list of two texture coordinates per corner.
    uv_list: Option<usize>,
    targets: Vec<Target>,
    uvs: Vec<[f32; 2]>,
    colors: Option<Vec<[f32; 4]>>,
    scalars: NamedNumbers,
    kinds: Vec<ScalarType>,
    rounded: Rounded,
    /// The number of faces so far.
    count: usize,
}

impl FaceColumns {
    /// `None` if the element has no list of vertex indices.
    pub(super) fn new(element: &Element) -> Option<Self> {
        let list = |names: &[&str]| {
            let is = |p: &Property| p.count.is_some() && names.contains(&p.name.as_str());
            element.properties.iter().position(is)
        };
        let mut targets = vec![Target::Nothing; element.properties.len()];
        let scalars = assign_colors_and_scalars(element, &mut targets);
        Some(Self {
            indices: list(&INDICES)?,
            uv_list: list(&["texcoord"]),
            colors: targets.iter().any(|t| matches!(t, Target::Color(..))).then(Vec::new),
            targets,
            uvs: Vec::new(),
            scalars,
            kinds: element.properties.iter().map(|property| property.value).collect(),
            rounded: Rounded::default(),
            count: 0,
        })
    }

    /// The bytes of a face with this many corners, with texture coordinates of the corners or of their vertices.
    pub(super) fn row(&self, corners: usize) -> u64 {
        12 * corners as u64 + 4 + 16 + self.scalars.row()
    }

    /// The indices of the lists that are read.
    pub(super) fn lists(&self) -> Vec<usize> {
        std::iter::once(self.indices).chain(self.uv_list).collect()
    }

    /// The index of the list of vertex indices.
    pub(super) fn index_list(&self) -> usize {
        self.indices
    }

    pub(super) fn indices<'r>(&self, record: &'r Record) -> &'r [f64] {
        &record.lists[self.indices]
    }

    /// Adds the attributes of a face.
    pub(super) fn push(&mut self, record: &Record, corners: usize) {
        if let Some(list) = self.uv_list {
            if self.kinds[list] == ScalarType::F64 {
                let rounded = record.lists[list].iter().filter(|&&value| is_rounded(value));
                self.rounded.uvs += rounded.count() as u64;
            }
            let (pairs, rest) = record.lists[list].as_chunks::<2>();
            if pairs.len() == corners && rest.is_empty() {
                self.uvs.extend(pairs.iter().map(|uv| uv.map(|value| value as f32)));
            } else {
                self.uvs.extend(std::iter::repeat_n([f32::NAN; 2], corners));
            }
        }
        let mut color = [0.0, 0.0, 0.0, 1.0];
        self.scalars.resize(self.count + 1);
        for (place, (&target, &value)) in self.targets.iter().zip(&record.values).enumerate() {
            if let Some(count) = self.rounded.of(target, self.kinds[place]) {
                *count += u64::from(is_rounded(value));
            }
            match target {
                Target::Color(channel, full) => color[channel] = intensity(value, full),
                Target::Scalar(index) => self.scalars.set(index, self.count, record, place),
                _ => {}
            }
        }
        if let Some(colors) = &mut self.colors {
            colors.push(color);
        }
        self.count += 1;
    }

    pub(super) fn store(self, model: &mut Model, notes: &mut Notes) {
        model.corner_uvs = self.uv_list.map(|_| self.uvs);
        model.face_colors = self.colors;
        model.face_scalars = self.scalars.finish(notes);
        self.rounded.finish("faces", notes);
    }
}
