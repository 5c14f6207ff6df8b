//! The values of PLY records, from text or either kind of binary.

use super::header::{Element, Storage};
use crate::error::{Location, ReadErrorKind};
use crate::input::{Input, integer, number};
use crate::lost::Lost;
use crate::notes::Notes;
use crate::scalars::{ScalarType, ScalarValues};

/// Expands `decode!` for the Rust type of a PLY type.
macro_rules! by_type {
    ($kind:expr, $decode:ident) => {
        match $kind {
            ScalarType::I8 => $decode!(i8),
            ScalarType::U8 => $decode!(u8),
            ScalarType::I16 => $decode!(i16),
            ScalarType::U16 => $decode!(u16),
            ScalarType::I32 => $decode!(i32),
            ScalarType::U32 => $decode!(u32),
            ScalarType::I64 => $decode!(i64),
            ScalarType::U64 => $decode!(u64),
            ScalarType::F32 => $decode!(f32),
            ScalarType::F64 => $decode!(f64),
        }
    };
}

/// A record, decoded.
pub(super) struct Record {
    /// One entry per property; zero for a list.
    pub values: Vec<f64>,
    /// One entry per property: the exact value of an integer that 64-bit floating point may round.
    pub wholes: Vec<Option<i128>>,
    /// One entry per property; empty for a single value.
    pub lists: Vec<Vec<f64>>,
    /// The location of the record.
    pub at: Location,
}

/// Notes content after the last record.
pub(super) fn note_more(
    input: &mut Input<'_>,
    storage: Storage,
    notes: &mut Notes,
) -> Result<(), ReadErrorKind> {
    if input.has_more(storage == Storage::Text)? {
        let what = "content after the last PLY record";
        notes.lose(Lost::new(what, "the header does not announce it"));
    }
    Ok(())
}

/// Decodes every record of an element in order; `visit` returns the memory that it adds to the model.
pub(super) fn each_record(
    input: &mut Input<'_>,
    storage: Storage,
    element: &Element,
    mut visit: impl FnMut(&Record) -> Result<u64, ReadErrorKind>,
) -> Result<(), ReadErrorKind> {
    let properties = element.properties.len();
    if properties == 0 {
        return Ok(());
    }
    let mut record = Record {
        values: vec![0.0; properties],
        wholes: vec![None; properties],
        lists: vec![Vec::new(); properties],
        at: Location::Byte(0),
    };
    for _ in 0..element.count {
        match storage {
            Storage::Text => read_line(input, element, &mut record)?,
            Storage::LittleEndian => read_binary(input, element, &mut record, false)?,
            Storage::BigEndian => read_binary(input, element, &mut record, true)?,
        }
        let cost = visit(&record)?;
        input.spend(cost, || record.at.clone())?;
    }
    Ok(())
}

fn read_binary(
    input: &mut Input<'_>,
    element: &Element,
    record: &mut Record,
    big_endian: bool,
) -> Result<(), ReadErrorKind> {
    record.at = input.here();
    let slots = record.values.iter_mut().zip(&mut record.wholes).zip(&mut record.lists);
    for (property, ((value, whole), list)) in element.properties.iter().zip(slots) {
        let Some(count_type) = property.count else {
            (*value, *whole) = scalar(input, property.value, big_endian, &property.name)?;
            continue;
        };
        let at = input.here();
        let (count, _) = scalar(input, count_type, big_endian, &property.name)?;
        if count < 0.0 {
            let expected = format!("the length of the list {:?}", property.name);
            return Err(ReadErrorKind::malformed(at, expected, count.to_string()));
        }
        let bytes = property.value.bytes() as u64;
        let count = count as u64;
        let room = input.plausible(count, bytes, at, "list entries")?;
        list.clear();
        list.reserve(room);
        for _ in 0..count {
            list.push(scalar(input, property.value, big_endian, &property.name)?.0);
        }
    }
    Ok(())
}

/// A value, and the exact integer if the value is rounded.
fn scalar(
    input: &mut Input<'_>,
    kind: ScalarType,
    big_endian: bool,
    name: &str,
) -> Result<(f64, Option<i128>), ReadErrorKind> {
    macro_rules! decode {
        ($number:ty) => {{
            let bytes = input.array(name)?;
            if big_endian {
                <$number>::from_be_bytes(bytes)
            } else {
                <$number>::from_le_bytes(bytes)
            }
        }};
    }
    macro_rules! exact {
        ($number:ty) => {
            (f64::from(decode!($number)), None)
        };
    }
    Ok(match kind {
        ScalarType::I64 => of_whole(decode!(i64).into()),
        ScalarType::U64 => of_whole(decode!(u64).into()),
        ScalarType::I8 => exact!(i8),
        ScalarType::U8 => exact!(u8),
        ScalarType::I16 => exact!(i16),
        ScalarType::U16 => exact!(u16),
        ScalarType::I32 => exact!(i32),
        ScalarType::U32 => exact!(u32),
        ScalarType::F32 => exact!(f32),
        ScalarType::F64 => exact!(f64),
    })
}

fn of_whole(whole: i128) -> (f64, Option<i128>) {
    (whole as f64, Some(whole))
}

fn read_line(
    input: &mut Input<'_>,
    element: &Element,
    record: &mut Record,
) -> Result<(), ReadErrorKind> {
    let line = input.data_line(&element.name)?;
    record.at = line.location();
    let mut words = line.words();
    let mut next = |name: &str, kind: ScalarType| -> Result<(f64, Option<i128>), ReadErrorKind> {
        let word = words.next().unwrap_or_default();
        if let (8, true, Some(whole)) = (kind.bytes(), kind.is_integer(), integer::<i128>(word)) {
            return Ok(of_whole(whole));
        }
        let value = number(word);
        let value = value.ok_or_else(|| line.unexpected(format!("a number for {name:?}"), word));
        Ok((value?, None))
    };
    let slots = record.values.iter_mut().zip(&mut record.wholes).zip(&mut record.lists);
    for (property, ((value, whole), list)) in element.properties.iter().zip(slots) {
        let Some(count_type) = property.count else {
            (*value, *whole) = next(&property.name, property.value)?;
            continue;
        };
        let (first, _) = next(&property.name, count_type)?;
        if !(first >= 0.0 && first.fract() == 0.0) {
            let expected = format!("the length of the list {:?}", property.name);
            return Err(line.unexpected(expected, first.to_string().as_bytes()));
        }
        list.clear();
        for _ in 0..first as u64 {
            list.push(next(&property.name, property.value)?.0);
        }
    }
    match words.next() {
        None => Ok(()),
        Some(word) => Err(line.unexpected("the end of the line", word)),
    }
}

/// One property of a block of equally sized records.
#[derive(Clone, Copy)]
pub(super) struct Column<'b> {
    pub block: &'b [u8],
    /// The size of a record.
    pub stride: usize,
    /// The offset of the property in a record.
    pub offset: usize,
    pub kind: ScalarType,
    pub big_endian: bool,
}

impl Column<'_> {
    /// Calls `put` with every value in turn; one loop for each type.
    #[allow(clippy::unnecessary_cast, clippy::cast_lossless, reason = "one loop for all types")]
    pub(super) fn each(self, mut put: impl FnMut(usize, f64)) {
        macro_rules! decode {
            ($number:ty) => {
                if self.big_endian {
                    self.each_chunk(|record, bytes| {
                        put(record, <$number>::from_be_bytes(bytes) as f64);
                    });
                } else {
                    self.each_chunk(|record, bytes| {
                        put(record, <$number>::from_le_bytes(bytes) as f64);
                    });
                }
            };
        }
        by_type!(self.kind, decode);
    }

    /// Stores every value in a column of the same type, from row `first` on.
    pub(super) fn fill(self, values: &mut ScalarValues, first: usize) {
        macro_rules! fill {
            ($rows:expr, $number:ty) => {{
                let rows = $rows.get_mut(first..).unwrap_or_default();
                let decode = if self.big_endian {
                    <$number>::from_be_bytes
                } else {
                    <$number>::from_le_bytes
                };
                self.each_chunk(|record, bytes| {
                    if let Some(row) = rows.get_mut(record) {
                        *row = decode(bytes);
                    }
                });
            }};
        }
        match values {
            ScalarValues::I8(rows) => fill!(rows, i8),
            ScalarValues::U8(rows) => fill!(rows, u8),
            ScalarValues::I16(rows) => fill!(rows, i16),
            ScalarValues::U16(rows) => fill!(rows, u16),
            ScalarValues::I32(rows) => fill!(rows, i32),
            ScalarValues::U32(rows) => fill!(rows, u32),
            ScalarValues::I64(rows) => fill!(rows, i64),
            ScalarValues::U64(rows) => fill!(rows, u64),
            ScalarValues::F32(rows) => fill!(rows, f32),
            ScalarValues::F64(rows) => fill!(rows, f64),
        }
    }

    fn each_chunk<const N: usize>(self, mut put: impl FnMut(usize, [u8; N])) {
        for (index, record) in self.block.chunks_exact(self.stride).enumerate() {
            if let Some(&bytes) = record.get(self.offset..).and_then(<[u8]>::first_chunk) {
                put(index, bytes);
            }
        }
    }
}
