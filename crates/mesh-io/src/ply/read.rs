//! Reading PLY.
//!
//! Vertices of fixed size are decoded a property at a time over a block of records, so that the
//! type of a property is looked at once per block; faces that are one list of indices have a path
//! of their own. Everything else goes record by record.

use super::columns::{FaceColumns, VertexColumns};
use super::header::{self, Element, Storage, Type};
use super::records::{Column, Record, each_record};
use crate::Model;
use crate::error::{Location, ReadErrorKind};
use crate::input::Input;
use mesh_core::PolygonSoup;

/// Bytes decoded at a time.
const BLOCK: usize = 1 << 15;

pub(crate) fn read(input: &mut Input<'_>) -> Result<Model, ReadErrorKind> {
    let header = header::read(input)?;
    // Faces may come before the vertices that they refer to.
    let vertex_count = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut reader =
        Reader { input, storage: header.storage, vertex_count, uvs: None, model: Model::default() };
    for element in &header.elements {
        reader.element(element)?;
    }
    Ok(reader.finish())
}

struct Reader<'i, 'a> {
    input: &'i mut Input<'a>,
    storage: Storage,
    vertex_count: u64,
    /// Texture coordinates by vertex.
    uvs: Option<Vec<[f32; 2]>>,
    model: Model,
}

impl Reader<'_, '_> {
    fn element(&mut self, element: &Element) -> Result<(), ReadErrorKind> {
        let here = match self.storage {
            Storage::Text => Location::Line(element.line),
            _ => self.input.here(),
        };
        let least = element.least_bytes(self.storage);
        let what = format!("{:?} records", element.name);
        let room = if element.properties.is_empty() {
            0
        } else {
            self.input.plausible(element.count, least, here, &what)?
        };
        let soup = &self.model.soup;
        match element.name.as_str() {
            "vertex" if soup.vertex_count() == 0 => self.vertices(element, room),
            "face" if soup.face_count() == 0 => self.faces(element, room),
            "tristrips" if soup.face_count() == 0 => self.strips(element),
            _ => {
                self.model.notes.push(format!("skipped the PLY element {:?}", element.name));
                each_record(self.input, self.storage, element, |_| Ok(()))
            }
        }
    }

    fn vertices(&mut self, element: &Element, room: usize) -> Result<(), ReadErrorKind> {
        let mut columns = VertexColumns::new(element, room)?;
        if self.storage == Storage::Text || element.has_lists() {
            each_record(self.input, self.storage, element, |record| {
                columns.push(&record.values);
                Ok(())
            })?;
        } else {
            self.fixed_records(element, &mut columns)?;
        }
        self.uvs = columns.store(&mut self.model);
        Ok(())
    }

    /// Records of fixed size, a block of them at a time.
    fn fixed_records(
        &mut self,
        element: &Element,
        columns: &mut VertexColumns,
    ) -> Result<(), ReadErrorKind> {
        let stride = element.least_bytes(self.storage) as usize;
        let big_endian = self.storage == Storage::BigEndian;
        let mut missing = element.count;
        while missing > 0 {
            let wanted = missing.min((BLOCK / stride).max(1) as u64) as usize;
            let window = self.input.peek(wanted * stride)?;
            let records = wanted.min(window.len() / stride);
            if records == 0 {
                return Err(self.input.too_short("a vertex", stride as u64));
            }
            let block = &window[..records * stride];
            columns.grow(records);
            let mut offset = 0;
            for (index, property) in element.properties.iter().enumerate() {
                let kind = property.value;
                columns.set_block(index, Column { block, stride, offset, kind, big_endian });
                offset += kind.bytes();
            }
            self.input.consume(records * stride);
            missing -= records as u64;
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, room: usize) -> Result<(), ReadErrorKind> {
        self.reserve_faces(room);
        let Some(mut columns) = FaceColumns::new(element) else {
            self.model.notes.push("the PLY faces have no list of vertex indices".to_owned());
            return each_record(self.input, self.storage, element, |_| Ok(()));
        };
        if self.storage != Storage::Text && is_plain_index_list(element) {
            return self.index_lists(element.count);
        }
        let (soup, limit) = (&mut self.model.soup, self.vertex_count);
        let mut face = Vec::new();
        let mut too_small = 0;
        each_record(self.input, self.storage, element, |record| {
            face.clear();
            for &value in columns.indices(record) {
                face.push(vertex_index(value, limit, record)?);
            }
            if face.len() < 3 {
                too_small += 1;
                return Ok(());
            }
            soup.push_face(&face)?;
            columns.push(record, face.len());
            Ok(())
        })?;
        self.note_small_faces(too_small);
        columns.store(&mut self.model);
        Ok(())
    }

    fn reserve_faces(&mut self, faces: usize) {
        let positions = std::mem::take(self.model.soup.positions_mut());
        // Triangles, unless the file has another mix.
        self.model.soup = PolygonSoup::with_capacity(0, faces, faces.saturating_mul(3));
        *self.model.soup.positions_mut() = positions;
    }

    fn note_small_faces(&mut self, count: u64) {
        if count > 0 {
            self.model.notes.push(format!("skipped {count} faces of fewer than three corners"));
        }
    }

    /// Faces that are nothing but a `list uchar int`.
    fn index_lists(&mut self, count: u64) -> Result<(), ReadErrorKind> {
        const LONGEST: usize = 1 + 4 * u8::MAX as usize;
        let decode = match self.storage {
            Storage::BigEndian => u32::from_be_bytes,
            _ => u32::from_le_bytes,
        };
        let limit = self.vertex_count;
        let mut face = [0; u8::MAX as usize];
        let (mut missing, mut too_small) = (count, 0);
        while missing > 0 {
            let offset = self.input.offset();
            let mut rest = self.input.peek(LONGEST)?;
            let before = rest.len();
            while missing > 0
                && let Some((&corners, list)) = rest.split_first()
                && let Some((list, after)) = list.split_at_checked(4 * usize::from(corners))
            {
                let face = &mut face[..usize::from(corners)];
                let mut highest = 0;
                for (vertex, bytes) in face.iter_mut().zip(list.as_chunks().0) {
                    *vertex = decode(*bytes);
                    highest = highest.max(*vertex);
                }
                if corners < 3 {
                    too_small += 1;
                } else if u64::from(highest) < limit {
                    self.model.soup.push_face(face)?;
                } else {
                    let at = Location::Byte(offset + (before - rest.len()) as u64);
                    return Err(out_of_range(f64::from(highest), limit, at));
                }
                rest = after;
                missing -= 1;
            }
            let used = before - rest.len();
            if used == 0 {
                return Err(self.input.too_short("a face", 13));
            }
            self.input.consume(used);
        }
        self.note_small_faces(too_small);
        Ok(())
    }

    /// Triangle strips: every vertex from the third on makes a triangle with the two before, every
    /// other one turned over; -1 begins a new strip.
    fn strips(&mut self, element: &Element) -> Result<(), ReadErrorKind> {
        let Some(columns) = FaceColumns::new(element) else {
            self.model.notes.push("the PLY strips have no list of vertex indices".to_owned());
            return each_record(self.input, self.storage, element, |_| Ok(()));
        };
        let (soup, limit) = (&mut self.model.soup, self.vertex_count);
        each_record(self.input, self.storage, element, |record| {
            let indices = columns.indices(record);
            for strip in indices.split(|&value| value == -1.0) {
                for (place, corners) in strip.windows(3).enumerate() {
                    let mut triangle = [0; 3];
                    for (vertex, &value) in triangle.iter_mut().zip(corners) {
                        *vertex = vertex_index(value, limit, record)?;
                    }
                    if place % 2 == 1 {
                        triangle.swap(0, 1);
                    }
                    soup.push_face(&triangle)?;
                }
            }
            Ok(())
        })?;
        self.model.face_colors = None;
        self.model.face_scalars.clear();
        Ok(())
    }

    fn finish(mut self) -> Model {
        if let Some(uvs) = self.uvs
            && self.model.corner_uvs.is_none()
        {
            let corners = self.model.soup.corners();
            let uv = |&vertex: &u32| uvs.get(vertex as usize).copied().unwrap_or([f32::NAN; 2]);
            self.model.corner_uvs = Some(corners.iter().map(uv).collect());
        }
        self.model
    }
}

fn is_plain_index_list(element: &Element) -> bool {
    matches!(element.properties.as_slice(), [list] if list.count == Some(Type::U8)
        && matches!(list.value, Type::I32 | Type::U32))
}

/// A value of a list as the index of one of `limit` vertices.
fn vertex_index(value: f64, limit: u64, record: &Record) -> Result<u32, ReadErrorKind> {
    if value >= 0.0 && value < limit as f64 && value.fract() == 0.0 {
        Ok(value as u32)
    } else {
        Err(out_of_range(value, limit, record.at.clone()))
    }
}

fn out_of_range(value: f64, limit: u64, at: Location) -> ReadErrorKind {
    ReadErrorKind::malformed(
        at,
        format!("vertex indices from 0 to below {limit}"),
        value.to_string(),
    )
}
