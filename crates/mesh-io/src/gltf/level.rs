//! A model as columns of numbers for glTF.

use super::wedges::Wedges;
use crate::color::{are_bytes, color_in_bytes};
use crate::cutter::Cutter;
use crate::distinct_names::distinct_names;
use crate::error::WriteError;
use crate::format::Format;
use crate::lost::Lost;
use crate::model::Model;
use crate::scalars::{ScalarType, ScalarValues};
use crate::single::{are_finite, finite_or, flattened, flattened_faces};
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::io::Write;
use std::ops::Range;

/// The attributes of the vertices, in the order of the buffer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Column {
    Position,
    Normal,
    /// A set of texture coordinates, the first or a further one.
    Uv(usize),
    /// Colours of eight bits.
    ByteColor,
    Color,
    /// A column of named numbers, in the component type that holds them.
    Scalar(usize, Component),
}

/// The component type of an attribute of named numbers. glTF has no 32-bit integers there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Component {
    I8,
    U8,
    I16,
    U16,
    F32,
}

impl Component {
    /// The type of a column in the file: its own type, or the narrowest integer type that holds all of its integers.
    fn of(values: &ScalarValues) -> Self {
        match values {
            ScalarValues::I8(_) => return Self::I8,
            ScalarValues::U8(_) => return Self::U8,
            ScalarValues::I16(_) => return Self::I16,
            ScalarValues::U16(_) => return Self::U16,
            ScalarValues::F32(_) | ScalarValues::F64(_) => return Self::F32,
            _ => {}
        }
        let whole = (0..values.len()).filter_map(|place| values.whole(place));
        let [least, most] = whole.fold([0, 0], |[l, m], w: i128| [l.min(w), m.max(w)]);
        let fits =
            |kind: ScalarType| kind.range().is_some_and(|[low, high]| low <= least && most <= high);
        let kinds = [
            (ScalarType::U8, Self::U8),
            (ScalarType::I8, Self::I8),
            (ScalarType::U16, Self::U16),
            (ScalarType::I16, Self::I16),
        ];
        kinds
            .into_iter()
            .find(|(kind, _)| fits(*kind))
            .map_or(Self::F32, |(_, component)| component)
    }

    /// The `componentType` of its accessor.
    pub(super) fn code(self) -> u32 {
        match self {
            Self::I8 => 5120,
            Self::U8 => 5121,
            Self::I16 => 5122,
            Self::U16 => 5123,
            Self::F32 => 5126,
        }
    }
}

impl Column {
    /// The `type` of its accessor.
    pub(super) fn shape(self) -> &'static str {
        match self {
            Self::Position | Self::Normal => "VEC3",
            Self::Uv(_) => "VEC2",
            Self::ByteColor | Self::Color => "VEC4",
            Self::Scalar(..) => "SCALAR",
        }
    }

    /// Bytes per vertex.
    pub(super) fn size(self) -> usize {
        match self {
            Self::Position | Self::Normal => 12,
            Self::Uv(_) => 8,
            Self::Color => 16,
            Self::ByteColor | Self::Scalar(..) => 4,
        }
    }
}

/// The triangles of one material.
pub(super) struct Primitive {
    pub(super) material: u32,
    /// The range of its indices in [`Level::indices`].
    pub(super) range: Range<usize>,
}

/// A model, split into its columns.
pub(super) struct Level<'m> {
    model: &'m Model,
    wedges: Wedges,
    /// The vector that is subtracted from the positions.
    offset: DVec3,
    /// The columns under their names in glTF.
    pub(super) columns: Vec<(String, Column)>,
    /// Normals for vertices whose own normals have no length, if there are any.
    substitutes: Option<Vec<Vec3>>,
    /// The indices of all primitives, one after another.
    pub(super) indices: Vec<u32>,
    pub(super) primitives: Vec<Primitive>,
    /// The smallest and the largest position.
    pub(super) bounds: [Vec3; 2],
    /// The largest error of a coordinate.
    pub(super) rounding: f64,
    /// The content that is not written.
    pub(super) lost: Vec<Lost>,
}

impl<'m> Level<'m> {
    pub(super) fn new(model: &'m Model, offset: DVec3, format: Format) -> Result<Self, WriteError> {
        let wedges = Wedges::new(model, format)?;
        let (primitives, indices) = primitives(model, &wedges);
        let mut level = Self {
            model,
            wedges,
            offset,
            columns: Vec::new(),
            substitutes: None,
            indices,
            primitives,
            bounds: [Vec3::INFINITY, Vec3::NEG_INFINITY],
            rounding: 0.0,
            lost: Vec::new(),
        };
        level.measure(format)?;
        level.take_normals();
        level.find_columns();
        Ok(level)
    }

    pub(super) fn vertex_count(&self) -> usize {
        self.wedges.count()
    }

    fn measure(&mut self, format: Format) -> Result<(), WriteError> {
        for (vertex, &exact) in self.model.soup.positions().iter().enumerate() {
            let stored = self.stored(vertex);
            if !stored.is_finite() {
                let value = exact.to_array()[exact.abs().max_position()];
                return Err(WriteError::OutOfSingleRange { format, vertex, value });
            }
            let error = (stored.as_dvec3() + self.offset - exact).abs().max_element();
            self.rounding = self.rounding.max(error);
            let [low, high] = self.bounds;
            self.bounds = [low.min(stored), high.max(stored)];
        }
        if self.rounding > 0.0 {
            let count = flattened_faces(&self.model.soup, self.offset);
            self.lost.extend(flattened(count, format));
        }
        Ok(())
    }

    /// The position of a vertex of the model in the file.
    fn stored(&self, vertex: usize) -> Vec3 {
        (self.model.soup.positions()[vertex] - self.offset).as_vec3()
    }

    /// Finds the vertices with a valid normal, and computes normals for the others.
    fn take_normals(&mut self) {
        let model = self.model;
        if model.corner_normals.is_none() && model.vertex_normals.is_none() {
            return;
        }
        let used = |corner: Option<usize>| corner.is_some() || model.corner_normals.is_none();
        let (mut own, mut missing) = (false, false);
        for (vertex, corner) in self.wedges.sources() {
            match self.own_normal(vertex, corner) {
                Some(_) => own = true,
                None => missing |= used(corner),
            }
        }
        if !own {
            self.lost.push(Lost::new("normals", "none of them has a length"));
            return;
        }
        if missing {
            let why = "the normals of the faces stand in for them";
            self.lost.push(Lost::new("normals without length", why));
            self.substitutes = Some(face_normals(model));
        }
        self.columns.push(("NORMAL".to_owned(), Column::Normal));
    }

    /// The unit normal of the model, if it has a direction.
    fn own_normal(&self, vertex: usize, corner: Option<usize>) -> Option<Vec3> {
        let given = match (&self.model.corner_normals, &self.model.vertex_normals) {
            (Some(all), _) => all[corner?],
            (None, Some(all)) => all[vertex],
            (None, None) => return None,
        };
        unit(given)
    }

    fn find_columns(&mut self) {
        let model = self.model;
        self.columns.insert(0, ("POSITION".to_owned(), Column::Position));
        // Zeros replace a missing first set, because names start at TEXCOORD_0.
        let has_uvs = model.corner_uvs.is_some() || !model.more_corner_uvs.is_empty();
        let sets = if has_uvs { 1 + model.more_corner_uvs.len() } else { 0 };
        self.columns.extend((0..sets).map(|set| (format!("TEXCOORD_{set}"), Column::Uv(set))));
        if let Some(colors) = &model.vertex_colors {
            let column = if are_bytes(colors) { Column::ByteColor } else { Column::Color };
            self.columns.push(("COLOR_0".to_owned(), column));
            let beyond = |color: &&[f32; 4]| color.iter().any(|&value| value > 1.0);
            let beyond = colors.iter().filter(beyond).count() as u64;
            if beyond > 0 {
                let what = "light beyond white of vertex colours";
                self.lost.push(Lost::some(
                    what,
                    beyond,
                    "colours of glTF end at 1; PLY keeps them",
                ));
            }
        }
        let name = |name: &str| format!("_{}", name.to_uppercase());
        let names = distinct_names(model.vertex_scalars.iter().map(|s| name(&s.name)), &[]);
        let scalars = names.into_iter().enumerate();
        let component = |index: usize| Component::of(&model.vertex_scalars[index].values);
        self.columns
            .extend(scalars.map(|(index, name)| (name, Column::Scalar(index, component(index)))));
        let mut values = model.vertex_scalars.iter().flat_map(|scalars| scalars.values.iter());
        if values.any(|value| !(value as f32).is_finite()) {
            let what = "numbers that are not finite in 32 bits";
            self.lost.push(Lost::new(what, "zero is written instead"));
        }
    }

    /// Writes a column: the value of every vertex.
    pub(super) fn write(&self, column: Column, writer: &mut dyn Write) -> std::io::Result<()> {
        let model = self.model;
        self.wedges.sources().try_for_each(|(vertex, corner)| match column {
            Column::Position => floats(writer, self.stored(vertex).to_array()),
            Column::Normal => {
                let substitute = || self.substitutes.as_ref().map(|normals| normals[vertex]);
                let normal = self.own_normal(vertex, corner).or_else(substitute);
                floats(writer, normal.unwrap_or(Vec3::Z).to_array())
            }
            Column::Uv(set) => {
                let uvs = match set.checked_sub(1) {
                    None => model.corner_uvs.as_ref(),
                    Some(further) => model.more_corner_uvs.get(further),
                };
                let uv = uvs.zip(corner).map(|(uvs, corner)| uvs[corner]);
                let uv = uv.filter(are_finite);
                floats(writer, uv.map_or([0.0; 2], |[u, v]| [u, 1.0 - v]))
            }
            Column::ByteColor => writer.write_all(&color_in_bytes(&self.color(vertex))),
            Column::Color => floats(writer, self.color(vertex).map(|value| value.clamp(0.0, 1.0))),
            Column::Scalar(index, component) => {
                let values = &model.vertex_scalars[index].values;
                match (component, values.whole(vertex)) {
                    (Component::F32, _) | (_, None) => {
                        let value = values.get(vertex).unwrap_or_default() as f32;
                        floats(writer, finite_or([value], 0.0))
                    }
                    (_, Some(whole)) => {
                        // The low bytes of a number that fits; the others are padding.
                        let [a, b, c, d, ..] = whole.to_le_bytes();
                        writer.write_all(&[a, b, c, d])
                    }
                }
            }
        })
    }

    /// The colour of a vertex; white if it has none.
    fn color(&self, vertex: usize) -> [f32; 4] {
        let color = self.model.vertex_colors.as_ref().map_or([1.0; 4], |colors| colors[vertex]);
        finite_or(color, 1.0)
    }

    pub(super) fn write_indices(&self, writer: &mut dyn Write) -> std::io::Result<()> {
        self.indices.iter().try_for_each(|index| writer.write_all(&index.to_le_bytes()))
    }
}

fn floats<const N: usize>(writer: &mut dyn Write, values: [f32; N]) -> std::io::Result<()> {
    values.iter().try_for_each(|value| writer.write_all(&value.to_le_bytes()))
}

/// A normal of unit length. Normals that have unit length already keep their bits.
fn unit(normal: [f32; 3]) -> Option<Vec3> {
    /// The largest deviation of a squared length from 1 that rounding can cause.
    const ROUNDING: f64 = 1e-6;
    let normal = Vec3::from(normal);
    let exact = normal.as_dvec3();
    if (exact.length_squared() - 1.0).abs() <= ROUNDING {
        return Some(normal);
    }
    exact.try_normalize().map(DVec3::as_vec3).filter(|normal| normal.is_finite())
}

/// The unit normal of every vertex: the mean over its faces weighted by area; upwards if the mean has no direction.
fn face_normals(model: &Model) -> Vec<Vec3> {
    let positions = model.soup.positions();
    let mut sums = vec![DVec3::ZERO; positions.len()];
    for face in model.soup.faces() {
        let origin = face.first().map_or(DVec3::ZERO, |&v| positions[v as usize]);
        let from_origin = |v: u32| positions[v as usize] - origin;
        let area: DVec3 =
            face.windows(2).map(|edge| from_origin(edge[0]).cross(from_origin(edge[1]))).sum();
        face.iter().for_each(|&v| sums[v as usize] += area);
    }
    sums.into_iter().map(|sum| sum.normalize_or(DVec3::Z).as_vec3()).collect()
}

/// A primitive for every material, in the order of their first faces, and the indices of all primitives.
fn primitives(model: &Model, wedges: &Wedges) -> (Vec<Primitive>, Vec<u32>) {
    let material = |face: usize| model.face_materials.as_ref().map_or(Model::NONE, |all| all[face]);
    let mut primitives: Vec<Primitive> = Vec::new();
    let mut places = HashMap::<u32, usize, foldhash::fast::RandomState>::default();
    for (face, corners) in model.soup.faces().enumerate() {
        let material = material(face);
        let place = *places.entry(material).or_insert_with(|| {
            primitives.push(Primitive { material, range: 0..0 });
            primitives.len() - 1
        });
        primitives[place].range.end += 3 * (corners.len() - 2);
    }
    let mut total = 0;
    for primitive in &mut primitives {
        let start = total;
        total += primitive.range.end;
        // The range is empty at first, and grows with every triangle.
        primitive.range = start..start;
    }
    let mut indices = vec![0; total];
    let mut cutter = Cutter::default();
    for face in 0..model.soup.face_count() {
        let corners = &wedges.of_corners()[model.soup.corner_range(face)];
        let end = &mut primitives[places[&material(face)]].range.end;
        for &corner in cutter.cut(&model.soup, face).as_flattened() {
            indices[*end] = corners[corner as usize];
            *end += 1;
        }
    }
    (primitives, indices)
}
