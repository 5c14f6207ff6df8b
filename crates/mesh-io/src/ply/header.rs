//! The header of a PLY file.

use crate::budget::GROWING;
use crate::error::{Location, ReadErrorKind};
use crate::input::{Input, Line, integer};
use crate::scalars::ScalarType;
use crate::text::quote;

/// The storage of the values.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Storage {
    Text,
    LittleEndian,
    BigEndian,
}

/// The type with this name in a header. 64-bit integers are an extension.
fn parse_type(word: &[u8]) -> Option<ScalarType> {
    Some(match word {
        b"char" | b"int8" => ScalarType::I8,
        b"uchar" | b"uint8" => ScalarType::U8,
        b"short" | b"int16" => ScalarType::I16,
        b"ushort" | b"uint16" => ScalarType::U16,
        b"int" | b"int32" => ScalarType::I32,
        b"uint" | b"uint32" => ScalarType::U32,
        b"long" | b"int64" => ScalarType::I64,
        b"ulong" | b"uint64" => ScalarType::U64,
        b"float" | b"float32" => ScalarType::F32,
        b"double" | b"float64" => ScalarType::F64,
        _ => return None,
    })
}

/// The value of full intensity in a colour of this type. Only bytes have a known range. Other types are assumed to be
/// from 0 to 1 here, and are divided when all colours are known.
pub(super) fn full_intensity(kind: ScalarType) -> f64 {
    match kind {
        ScalarType::U8 => 255.0,
        ScalarType::I8 => 127.0,
        _ => 1.0,
    }
}

/// A property of an element: one value, or a list of values preceded by their number.
#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    pub value: ScalarType,
    /// The type of the number of values, for a list.
    pub count: Option<ScalarType>,
}

/// A kind of record.
#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
    /// The header line that declares it.
    pub line: u64,
}

impl Element {
    /// The bytes of a record with empty lists.
    pub(super) fn least_bytes(&self, storage: Storage) -> u64 {
        match storage {
            // A digit and a separator.
            Storage::Text => 2 * self.properties.len() as u64,
            _ => self.properties.iter().map(|p| p.count.unwrap_or(p.value).bytes() as u64).sum(),
        }
    }

    pub(super) fn has_lists(&self) -> bool {
        self.properties.iter().any(|property| property.count.is_some())
    }
}

pub(super) struct Header {
    pub storage: Storage,
    pub elements: Vec<Element>,
    /// The pictures named in comments, as MeshLab writes them.
    pub textures: Vec<String>,
    /// All other comments, and the lines of `obj_info` with this word.
    pub comments: Vec<String>,
}

/// Reads up to and including `end_header`.
pub(super) fn read(input: &mut Input<'_>) -> Result<Header, ReadErrorKind> {
    let mut storage = None;
    let mut elements: Vec<Element> = Vec::new();
    let (mut textures, mut comments) = (Vec::new(), Vec::new());
    let mut first = true;
    loop {
        let number = input.line_number() + u64::from(!first);
        let Some(line) = input.line()? else {
            return Err(ReadErrorKind::malformed(
                Location::Line(number),
                "end_header",
                "the end of the file",
            ));
        };
        let mut words = line.words();
        let keyword = words.next().unwrap_or_default();
        if std::mem::take(&mut first) {
            if keyword != b"ply" {
                return Err(line.unexpected("the word ply", keyword));
            }
            continue;
        }
        match keyword {
            b"comment" if words.clone().next() == Some(b"TextureFile") => {
                words.next();
                textures.push(String::from_utf8_lossy(words.remainder()).replace('\\', "/"));
            }
            b"comment" => {
                let text = words.remainder();
                comments.extend((!text.is_empty()).then(|| String::from_utf8_lossy(text).into()));
            }
            b"obj_info" => comments.push(String::from_utf8_lossy(line.text.trim_ascii()).into()),
            b"" => continue,
            b"format" => storage = Some(read_format(line)?),
            b"element" => elements.push(read_element(line)?),
            b"property" => {
                let property = read_property(line)?;
                let element = elements.last_mut().ok_or_else(|| {
                    line.unexpected("an element before its properties", line.text)
                })?;
                element.properties.push(property);
            }
            b"end_header" => {
                let storage = storage
                    .ok_or_else(|| line.unexpected("a format line before", b"end_header"))?;
                return Ok(Header { storage, elements, textures, comments });
            }
            other => {
                let expected = "one of format, element, property, comment, obj_info, end_header";
                return Err(line.unexpected(expected, other));
            }
        }
        // The line itself, and the memory of an element or property here and while it is read.
        let length = line.text.len() as u64;
        input.spend_on_line(length + GROWING * size_of::<Element>() as u64 + 128)?;
    }
}

fn read_format(line: Line<'_>) -> Result<Storage, ReadErrorKind> {
    let mut words = line.words().skip(1);
    let storage = match words.next().unwrap_or_default() {
        b"ascii" => Storage::Text,
        b"binary_little_endian" => Storage::LittleEndian,
        b"binary_big_endian" => Storage::BigEndian,
        other => {
            let expected = "ascii, binary_little_endian or binary_big_endian";
            return Err(line.unexpected(expected, other));
        }
    };
    match words.next().unwrap_or(b"1.0") {
        b"1.0" => Ok(storage),
        other => Err(line.unexpected("version 1.0", other)),
    }
}

fn read_element(line: Line<'_>) -> Result<Element, ReadErrorKind> {
    let mut words = line.words().skip(1);
    let name = words.next().ok_or_else(|| line.unexpected("the name of an element", b""))?;
    let count = words.next().unwrap_or_default();
    Ok(Element {
        name: String::from_utf8_lossy(name).into_owned(),
        count: integer(count).ok_or_else(|| line.unexpected("how many of them", count))?,
        properties: Vec::new(),
        line: line.number,
    })
}

fn read_property(line: Line<'_>) -> Result<Property, ReadErrorKind> {
    let mut words = line.words().skip(1);
    let read_type = |word: &[u8]| {
        parse_type(word).ok_or_else(|| {
            line.unexpected("a type (char to uint, int8 to uint64, float, double)", word)
        })
    };
    let first = words.next().unwrap_or_default();
    let (count, value) = if first == b"list" {
        let count = words.next().unwrap_or_default();
        let count_type = read_type(count)?;
        if !count_type.is_integer() {
            return Err(line.unexpected("an integer type for the length of a list", count));
        }
        (Some(count_type), read_type(words.next().unwrap_or_default())?)
    } else {
        (None, read_type(first)?)
    };
    let name = words.next().ok_or_else(|| line.unexpected("the name of a property", b""))?;
    Ok(Property { name: String::from_utf8_lossy(name).into_owned(), value, count })
}

/// The error for a vertex element without positions.
pub(super) fn no_positions(element: &Element) -> ReadErrorKind {
    let names: Vec<&str> = element.properties.iter().map(|p| p.name.as_str()).collect();
    ReadErrorKind::malformed(
        Location::Line(element.line),
        "properties x, y and z of the vertices",
        quote(names.join(" ").as_bytes()),
    )
}
