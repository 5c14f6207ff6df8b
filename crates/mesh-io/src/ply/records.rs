//! The values of PLY records, from text or either kind of binary.

use super::header::{Element, Storage, Type};
use crate::error::{Location, ReadErrorKind};
use crate::input::{Input, number};

/// Expands `decode!` for the Rust type of a PLY type.
macro_rules! by_type {
    ($kind:expr, $decode:ident) => {
        match $kind {
            Type::I8 => $decode!(i8),
            Type::U8 => $decode!(u8),
            Type::I16 => $decode!(i16),
            Type::U16 => $decode!(u16),
            Type::I32 => $decode!(i32),
            Type::U32 => $decode!(u32),
            Type::F32 => $decode!(f32),
            Type::F64 => $decode!(f64),
        }
    };
}

/// A record, decoded.
pub(super) struct Record {
    /// One entry per property; zero for a list.
    pub values: Vec<f64>,
    /// One entry per property; empty for a single value.
    pub lists: Vec<Vec<f64>>,
    /// Where the record begins.
    pub at: Location,
}

/// Decodes every record of an element in turn; `visit` says how much memory it takes of the model.
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
    let slots = record.values.iter_mut().zip(&mut record.lists);
    for (property, (value, list)) in element.properties.iter().zip(slots) {
        let Some(count_type) = property.count else {
            *value = scalar(input, property.value, big_endian, &property.name)?;
            continue;
        };
        let at = input.here();
        let count = scalar(input, count_type, big_endian, &property.name)?;
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
            list.push(scalar(input, property.value, big_endian, &property.name)?);
        }
    }
    Ok(())
}

fn scalar(
    input: &mut Input<'_>,
    kind: Type,
    big_endian: bool,
    name: &str,
) -> Result<f64, ReadErrorKind> {
    macro_rules! decode {
        ($number:ty) => {{
            let bytes = input.array(name)?;
            f64::from(if big_endian {
                <$number>::from_be_bytes(bytes)
            } else {
                <$number>::from_le_bytes(bytes)
            })
        }};
    }
    Ok(by_type!(kind, decode))
}

fn read_line(
    input: &mut Input<'_>,
    element: &Element,
    record: &mut Record,
) -> Result<(), ReadErrorKind> {
    let line = input.data_line(&element.name)?;
    record.at = line.location();
    let mut words = line.words();
    let mut next = |name: &str| {
        let word = words.next().unwrap_or_default();
        number(word).ok_or_else(|| line.unexpected(format!("a number for {name:?}"), word))
    };
    let slots = record.values.iter_mut().zip(&mut record.lists);
    for (property, (value, list)) in element.properties.iter().zip(slots) {
        let first = next(&property.name)?;
        if property.count.is_none() {
            *value = first;
            continue;
        }
        if !(first >= 0.0 && first.fract() == 0.0) {
            let expected = format!("the length of the list {:?}", property.name);
            return Err(line.unexpected(expected, first.to_string().as_bytes()));
        }
        list.clear();
        for _ in 0..first as u64 {
            list.push(next(&property.name)?);
        }
    }
    Ok(())
}

/// One property of a block of records of the same size.
#[derive(Clone, Copy)]
pub(super) struct Column<'b> {
    pub block: &'b [u8],
    /// The size of a record.
    pub stride: usize,
    /// Where in a record the property begins.
    pub offset: usize,
    pub kind: Type,
    pub big_endian: bool,
}

impl Column<'_> {
    /// Calls `put` with every value in turn; one loop for each type.
    pub(super) fn each(self, mut put: impl FnMut(usize, f64)) {
        macro_rules! decode {
            ($number:ty) => {
                if self.big_endian {
                    self.each_chunk(|record, bytes| {
                        put(record, f64::from(<$number>::from_be_bytes(bytes)));
                    });
                } else {
                    self.each_chunk(|record, bytes| {
                        put(record, f64::from(<$number>::from_le_bytes(bytes)));
                    });
                }
            };
        }
        by_type!(self.kind, decode);
    }

    fn each_chunk<const N: usize>(self, mut put: impl FnMut(usize, [u8; N])) {
        for (index, record) in self.block.chunks_exact(self.stride).enumerate() {
            if let Some(&bytes) = record.get(self.offset..).and_then(<[u8]>::first_chunk) {
                put(index, bytes);
            }
        }
    }
}
