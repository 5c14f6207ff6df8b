//! Reading PLY.
//!
//! Vertices of fixed size are decoded one property at a time over a block of records, so that the type of a property is
//! examined once per block. Faces that consist of one index list have their own fast path. All other elements are read
//! record by record.

use super::columns::{FaceColumns, VertexColumns};
use super::header::{self, Element, Storage};
use super::records::{Column, Record, each_record, note_more};
use super::textures::NUMBER;
use crate::budget::GROWING;
use crate::error::{Location, ReadErrorKind};
use crate::input::Input;
use crate::lost::Lost;
use crate::notes::Notes;
use crate::scalars::ScalarType;
use crate::text::quote;
use crate::{Image, ImageData, Material, Model};
use mesh_core::soup::TooManyCorners;
use mesh_core::{PolygonSoup, as_u32};

/// The reason why elements without indices are lost.
const NO_INDICES: &str = "there is no list of vertex indices, vertex_indices or vertex_index";

/// The number of bytes that are decoded together.
const BLOCK: usize = 1 << 15;

pub(crate) fn read(input: &mut Input<'_>) -> Result<Model, ReadErrorKind> {
    let header = header::read(input)?;
    // Faces may come before their vertices.
    let vertex_count = header.elements.iter().find(|e| e.name == "vertex").map_or(0, |e| e.count);
    let mut reader = Reader {
        input,
        storage: header.storage,
        vertex_count,
        uvs: None,
        model: Model::default(),
        notes: Notes::default(),
    };
    for element in &header.elements {
        reader.element(element)?;
    }
    note_more(reader.input, reader.storage, &mut reader.notes)?;
    reader.model.comments = header.comments;
    reader.finish(header.textures)
}

struct Reader<'i, 'a> {
    input: &'i mut Input<'a>,
    storage: Storage,
    vertex_count: u64,
    /// Texture coordinates by vertex.
    uvs: Option<Vec<[f32; 2]>>,
    model: Model,
    notes: Notes,
}

impl Reader<'_, '_> {
    fn element(&mut self, element: &Element) -> Result<(), ReadErrorKind> {
        let here = match self.storage {
            Storage::Text => Location::Line(element.line),
            _ => self.input.here(),
        };
        let least = element.least_bytes(self.storage);
        let what = format!("{} records", quote(element.name.as_bytes()));
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
                let name = quote(element.name.as_bytes());
                let why = "a model holds vertices and faces only";
                self.notes.lose_some(format!("PLY element {name}"), element.count, why);
                each_record(self.input, self.storage, element, |_| Ok(0))
            }
        }
    }

    fn vertices(&mut self, element: &Element, room: usize) -> Result<(), ReadErrorKind> {
        let mut columns = VertexColumns::new(element)?;
        self.note_lists(element, &[]);
        let at = || Location::Line(element.line);
        self.input.require(columns.row().saturating_mul(room as u64), at)?;
        columns.reserve(room);
        // If memory for all records is reserved, the lists do not grow.
        let cost = columns.row() * if room as u64 == element.count { 1 } else { GROWING };
        if self.storage == Storage::Text || element.has_lists() {
            each_record(self.input, self.storage, element, |record| {
                columns.push(record);
                Ok(cost)
            })?;
        } else {
            self.fixed_records(element, &mut columns, cost)?;
        }
        self.uvs = columns.store(&mut self.model, &mut self.notes);
        Ok(())
    }

    /// Records of fixed size, in blocks.
    fn fixed_records(
        &mut self,
        element: &Element,
        columns: &mut VertexColumns,
        cost: u64,
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
            let at = self.input.here();
            self.input.spend(records as u64 * cost, || at)?;
            missing -= records as u64;
        }
        Ok(())
    }

    fn faces(&mut self, element: &Element, room: usize) -> Result<(), ReadErrorKind> {
        self.input.require((room as u64).saturating_mul(16), || Location::Line(element.line))?;
        self.reserve_faces(room);
        let Some(mut columns) = FaceColumns::new(element) else {
            self.notes.lose_some("faces", element.count, NO_INDICES);
            return each_record(self.input, self.storage, element, |_| Ok(0));
        };
        self.note_lists(element, &columns.lists());
        if self.storage != Storage::Text && is_plain_index_list(element) {
            return self.index_lists(element.count);
        }
        let (soup, limit) = (&mut self.model.soup, self.vertex_count);
        let mut face = Vec::new();
        let mut too_small = 0;
        each_record(self.input, self.storage, element, |record| {
            face.clear();
            for &value in columns.indices(record) {
                face.push(vertex_index::<u32>(value, limit, record)?);
            }
            if face.len() < 3 {
                too_small += 1;
                return Ok(0);
            }
            soup.push_face(&face)?;
            columns.push(record, face.len());
            Ok(GROWING * columns.row(face.len()))
        })?;
        self.note_small_faces(too_small);
        columns.store(&mut self.model, &mut self.notes);
        Ok(())
    }

    fn reserve_faces(&mut self, faces: usize) {
        let positions = std::mem::take(self.model.soup.positions_mut());
        // The capacity assumes triangles.
        self.model.soup = PolygonSoup::with_capacity(0, faces, faces.saturating_mul(3));
        *self.model.soup.positions_mut() = positions;
    }

    /// Names the lists that are not read. `used` are the indices of the lists that are read.
    fn note_lists(&mut self, element: &Element, used: &[usize]) {
        for (place, property) in element.properties.iter().enumerate() {
            if property.count.is_some() && !used.contains(&place) && element.count > 0 {
                let (list, of) = (quote(property.name.as_bytes()), quote(element.name.as_bytes()));
                let why = "a model holds single numbers for each vertex or face";
                self.notes.lose_some(
                    format!("list {list} of the PLY element {of}"),
                    element.count,
                    why,
                );
            }
        }
    }

    fn note_small_faces(&mut self, count: u64) {
        self.notes.lose_some("faces of fewer than three corners", count, "a face needs three");
    }

    /// Faces that consist of one `list uchar int`.
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
            let (faces, corners) = (self.model.soup.face_count(), self.model.soup.corners().len());
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
            let faces = (self.model.soup.face_count() - faces) as u64;
            let corners = (self.model.soup.corners().len() - corners) as u64;
            self.input.spend(GROWING * (4 * faces + 12 * corners), || Location::Byte(offset))?;
        }
        self.note_small_faces(too_small);
        Ok(())
    }

    /// Triangle strips: every vertex from the third on forms a triangle with the two before, with alternating
    /// orientation; -1 starts a new strip.
    fn strips(&mut self, element: &Element) -> Result<(), ReadErrorKind> {
        let Some(columns) = FaceColumns::new(element) else {
            self.notes.lose_some("triangle strips", element.count, NO_INDICES);
            return each_record(self.input, self.storage, element, |_| Ok(0));
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
            Ok(GROWING * 40 * indices.len() as u64)
        })?;
        let others = element.properties.len() as u64 - 1;
        let why = "a strip is cut into triangles, which have no properties of their own";
        self.notes.lose_some("properties of triangle strips", others, why);
        Ok(())
    }

    fn finish(mut self, textures: Vec<String>) -> Result<Model, ReadErrorKind> {
        if let Some(uvs) = self.uvs.take()
            && self.model.corner_uvs.is_none()
        {
            let corners = self.model.soup.corners();
            let uv = |&vertex: &u32| uvs.get(vertex as usize).copied().unwrap_or([f32::NAN; 2]);
            self.model.corner_uvs = Some(corners.iter().map(uv).collect());
        }
        self.textures(textures)?;
        self.notes.store(&mut self.model);
        Ok(self.model)
    }

    /// Makes a material of every picture named in the header. The property `texnumber` gives the material of a face;
    /// without it, all faces have the first.
    fn textures(&mut self, textures: Vec<String>) -> Result<(), ReadErrorKind> {
        let Some(first) = textures.first() else { return Ok(()) };
        if self.model.corner_uvs.is_none() {
            let name = quote(first.as_bytes());
            let what = format!("texture {name}");
            self.notes.lose(Lost::new(what, "there are no texture coordinates for it"));
            return Ok(());
        }
        let (count, faces) = (textures.len(), self.model.soup.face_count());
        let each = (size_of::<Material>() + size_of::<Image>()) as u64;
        let at = self.input.here();
        self.input.spend(each * count as u64 + 4 * faces as u64, || at)?;
        let number = self.model.face_scalars.iter().find(|scalars| scalars.name == NUMBER);
        if number.is_none() && count > 1 {
            self.notes
                .add(format!("took the first of {count} textures: no face says which it has"));
        }
        #[expect(
            clippy::cast_possible_truncation,
            clippy::cast_sign_loss,
            reason = "below the number of textures"
        )]
        let place = |value: f64| {
            let is_place = value >= 0.0 && value < count as f64;
            if is_place { value as u32 } else { Model::NONE }
        };
        self.model.face_materials = Some(match number {
            Some(scalars) => scalars.values.iter().map(place).collect(),
            None => vec![0; faces],
        });
        self.model.face_scalars.retain(|scalars| scalars.name != NUMBER);
        self.model.materials = (0..as_u32(count))
            .map(|image| Material { base_color_image: Some(image), ..Material::default() })
            .collect();
        let image = |name| Image {
            name: String::new(),
            media_type: String::new(),
            data: ImageData::Uri(name),
        };
        self.model.images = textures.into_iter().map(image).collect();
        Ok(())
    }
}

fn is_plain_index_list(element: &Element) -> bool {
    matches!(element.properties.as_slice(), [list] if list.count == Some(ScalarType::U8)
        && matches!(list.value, ScalarType::I32 | ScalarType::U32))
}

/// A value of a list as the index of one of `limit` vertices, in 32 or 64 bits.
#[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "below 2^64")]
pub(super) fn vertex_index<I: TryFrom<u64>>(
    value: f64,
    limit: u64,
    record: &Record,
) -> Result<I, ReadErrorKind> {
    if value >= 0.0 && value < limit as f64 && value.fract() == 0.0 {
        Ok(I::try_from(value as u64).map_err(|_| TooManyCorners)?)
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
