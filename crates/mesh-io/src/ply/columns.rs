//! What the properties of PLY vertices and faces mean, by their names.

use super::header::{Element, Property, no_positions};
use super::records::{Column, Record};
use crate::error::ReadErrorKind;
use crate::{Model, Scalars};
use glam::DVec3;

/// What a property says about its vertex or face.
#[derive(Clone, Copy, PartialEq)]
enum Target {
    Position(usize),
    Normal(usize),
    /// A channel, and the value that stands for one.
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

/// The places of the single-valued properties of these names, when all of them are there.
fn find_all<const N: usize>(element: &Element, names: [&str; N]) -> Option<[usize; N]> {
    let places = names
        .map(|name| element.properties.iter().position(|p| p.count.is_none() && p.name == name));
    places.iter().all(Option::is_some).then(|| places.map(Option::unwrap_or_default))
}

/// The places of the coordinates.
pub(super) fn positions(element: &Element) -> Result<[usize; 3], ReadErrorKind> {
    find_all(element, POSITION).ok_or_else(|| no_positions(element))
}

/// Assigns colours and whatever remains; returns the names of the remaining numbers.
fn assign_colors_and_scalars(element: &Element, targets: &mut [Target]) -> Vec<Scalars> {
    let full = |place: usize| element.properties[place].value.full_intensity();
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
    let mut scalars = Vec::new();
    for (target, property) in targets.iter_mut().zip(&element.properties) {
        if *target == Target::Nothing && property.count.is_none() {
            *target = Target::Scalar(scalars.len());
            scalars.push(Scalars { name: property.name.clone(), values: Vec::new() });
        }
    }
    scalars
}

/// The attributes of the vertices as they are read.
pub(super) struct VertexColumns {
    targets: Vec<Target>,
    positions: Vec<DVec3>,
    normals: Option<Vec<[f32; 3]>>,
    colors: Option<Vec<[f32; 4]>>,
    uvs: Option<Vec<[f32; 2]>>,
    scalars: Vec<Scalars>,
    /// The records before the block that is being read.
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
            done: 0,
        })
    }

    /// Makes room for so many vertices.
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
        for Scalars { values, .. } in &mut self.scalars {
            values.reserve_exact(room);
        }
    }

    /// The bytes of a vertex.
    pub(super) fn row(&self) -> u64 {
        let of = |there: bool, bytes| if there { bytes } else { 0 };
        24 + of(self.normals.is_some(), 12)
            + of(self.colors.is_some(), 16)
            + of(self.uvs.is_some(), 8)
            + 8 * self.scalars.len() as u64
    }

    /// Makes room for a block of records, to be filled by `set_block`.
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
        for Scalars { values, .. } in &mut self.scalars {
            values.resize(count, 0.0);
        }
    }

    /// Takes the values of a property for the records last made room for.
    pub(super) fn set_block(&mut self, property: usize, column: Column<'_>) {
        let done = self.done;
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
                let rows = &mut self.scalars[index].values[done..];
                column.each(|record, value| rows[record] = value);
            }
            _ => {}
        }
    }

    /// Takes one record.
    pub(super) fn push(&mut self, values: &[f64]) {
        self.grow(1);
        let row = self.done;
        let all = (&mut self.normals, &mut self.colors, &mut self.uvs);
        for (&target, &value) in self.targets.iter().zip(values) {
            match (target, &mut *all.0, &mut *all.1, &mut *all.2) {
                (Target::Position(axis), ..) => self.positions[row][axis] = value,
                (Target::Normal(axis), Some(normals), ..) => normals[row][axis] = value as f32,
                (Target::Color(channel, full), _, Some(colors), _) => {
                    colors[row][channel] = intensity(value, full);
                }
                (Target::Uv(axis), .., Some(uvs)) => uvs[row][axis] = value as f32,
                (Target::Scalar(index), ..) => self.scalars[index].values[row] = value,
                _ => {}
            }
        }
    }

    /// Moves everything into the model, save the texture coordinates, which wait for the corners.
    pub(super) fn store(self, model: &mut Model) -> Option<Vec<[f32; 2]>> {
        *model.soup.positions_mut() = self.positions;
        model.vertex_normals = self.normals;
        model.vertex_colors = self.colors;
        model.vertex_scalars = self.scalars;
        self.uvs
    }
}

/// A colour from 0 to 1; written so that eight-bit values come out as everywhere in the crate.
fn intensity(value: f64, full: f64) -> f32 {
    value as f32 / full as f32
}

/// The attributes of the faces as they are read.
pub(super) struct FaceColumns {
    indices: usize,
    /// The list of two texture coordinates per corner.
    uv_list: Option<usize>,
    targets: Vec<Target>,
    uvs: Vec<[f32; 2]>,
    colors: Option<Vec<[f32; 4]>>,
    scalars: Vec<Scalars>,
}

impl FaceColumns {
    /// Nothing when the element has no list of vertex indices.
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
        })
    }

    /// The bytes of a face of so many corners, with texture coordinates of the corners or of their
    /// vertices.
    pub(super) fn row(&self, corners: usize) -> u64 {
        12 * corners as u64 + 4 + 16 + 8 * self.scalars.len() as u64
    }

    /// The place of the list of vertex indices.
    pub(super) fn index_list(&self) -> usize {
        self.indices
    }

    pub(super) fn indices<'r>(&self, record: &'r Record) -> &'r [f64] {
        &record.lists[self.indices]
    }

    /// Takes the attributes of a face.
    pub(super) fn push(&mut self, record: &Record, corners: usize) {
        if let Some(list) = self.uv_list {
            let (pairs, rest) = record.lists[list].as_chunks::<2>();
            if pairs.len() == corners && rest.is_empty() {
                self.uvs.extend(pairs.iter().map(|uv| uv.map(|value| value as f32)));
            } else {
                self.uvs.extend(std::iter::repeat_n([f32::NAN; 2], corners));
            }
        }
        let mut color = [0.0, 0.0, 0.0, 1.0];
        for (&target, &value) in self.targets.iter().zip(&record.values) {
            match target {
                Target::Color(channel, full) => color[channel] = intensity(value, full),
                Target::Scalar(index) => self.scalars[index].values.push(value),
                _ => {}
            }
        }
        if let Some(colors) = &mut self.colors {
            colors.push(color);
        }
    }

    pub(super) fn store(self, model: &mut Model) {
        model.corner_uvs = self.uv_list.map(|_| self.uvs);
        model.face_colors = self.colors;
        model.face_scalars = self.scalars;
    }
}
