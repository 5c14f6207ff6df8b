//! Named numbers of vertices and faces, in the type of the file.

use std::borrow::Cow;

/// One number per vertex or per face under a name, such as PLY's `quality` or `label`.
///
/// ```
/// use mesh_io::{ScalarValues, Scalars};
///
/// let label = Scalars::new("label", vec![3_u8, 3, 7]);
/// assert!(label.is_label);
/// assert_eq!(label.values.get(2), Some(7.0));
/// let quality = Scalars::new("quality", vec![0.25, 0.5, 1.0]);
/// assert!(!quality.is_label);
/// assert!(matches!(quality.values, ScalarValues::F64(_)));
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Scalars {
    /// The name.
    pub name: String,
    /// The numbers, in their type.
    pub values: ScalarValues,
    /// Whether the numbers are labels. A label is copied from the nearest vertex or face; other numbers are
    /// interpolated. Integers are labels unless stated otherwise, and so are up to 256 different numbers without fractions
    /// in a file.
    pub is_label: bool,
}

impl Scalars {
    /// Named numbers; integers are labels.
    #[must_use]
    pub fn new(name: impl Into<String>, values: impl Into<ScalarValues>) -> Self {
        let values = values.into();
        Self { name: name.into(), is_label: values.is_integer(), values }
    }

    /// The same name and meaning with other values.
    #[must_use]
    pub(crate) fn with(&self, values: ScalarValues) -> Self {
        Self { name: self.name.clone(), values, is_label: self.is_label }
    }
}

/// The type of the numbers in a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ScalarType {
    /// `i8`, called `char` in PLY.
    I8,
    /// `u8`, called `uchar` in PLY.
    U8,
    /// `i16`, called `short` in PLY.
    I16,
    /// `u16`, called `ushort` in PLY.
    U16,
    /// `i32`, called `int` in PLY.
    I32,
    /// `u32`, called `uint` in PLY.
    U32,
    /// `i64`, called `int64` in PLY.
    I64,
    /// `u64`, called `uint64` in PLY.
    U64,
    /// `f32`, called `float` in PLY.
    F32,
    /// `f64`, called `double` in PLY.
    F64,
}

/// A column of numbers, in the type of the file.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub enum ScalarValues {
    /// Numbers of type `i8`.
    I8(Vec<i8>),
    /// Numbers of type `u8`.
    U8(Vec<u8>),
    /// Numbers of type `i16`.
    I16(Vec<i16>),
    /// Numbers of type `u16`.
    U16(Vec<u16>),
    /// Numbers of type `i32`.
    I32(Vec<i32>),
    /// Numbers of type `u32`.
    U32(Vec<u32>),
    /// Numbers of type `i64`.
    I64(Vec<i64>),
    /// Numbers of type `u64`.
    U64(Vec<u64>),
    /// Numbers of type `f32`.
    F32(Vec<f32>),
    /// Numbers of type `f64`.
    F64(Vec<f64>),
}

/// Expands an expression for a column of any type.
macro_rules! each_type {
    ($column:expr, $values:ident => $then:expr) => {
        match $column {
            ScalarValues::I8($values) => $then,
            ScalarValues::U8($values) => $then,
            ScalarValues::I16($values) => $then,
            ScalarValues::U16($values) => $then,
            ScalarValues::I32($values) => $then,
            ScalarValues::U32($values) => $then,
            ScalarValues::I64($values) => $then,
            ScalarValues::U64($values) => $then,
            ScalarValues::F32($values) => $then,
            ScalarValues::F64($values) => $then,
        }
    };
}
pub(crate) use each_type;

macro_rules! from_numbers {
    ($($variant:ident $number:ty),*) => {
        $(
            impl From<Vec<$number>> for ScalarValues {
                fn from(values: Vec<$number>) -> Self {
                    Self::$variant(values)
                }
            }
        )*
    };
}

from_numbers!(I8 i8, U8 u8, I16 i16, U16 u16, I32 i32, U32 u32, I64 i64, U64 u64, F32 f32, F64 f64);

impl ScalarType {
    /// The name of the type in a PLY header.
    #[must_use]
    pub fn ply_name(self) -> &'static str {
        match self {
            Self::I8 => "char",
            Self::U8 => "uchar",
            Self::I16 => "short",
            Self::U16 => "ushort",
            Self::I32 => "int",
            Self::U32 => "uint",
            Self::I64 => "int64",
            Self::U64 => "uint64",
            Self::F32 => "float",
            Self::F64 => "double",
        }
    }

    /// The size of one number in bytes.
    #[must_use]
    pub fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }

    /// Whether the numbers are whole.
    #[must_use]
    pub fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }

    /// The smallest and the largest whole number of the type; `None` for floating point.
    pub(crate) fn range(self) -> Option<[i128; 2]> {
        fn range<T: Into<i128>>(least: T, most: T) -> Option<[i128; 2]> {
            Some([least.into(), most.into()])
        }
        match self {
            Self::I8 => range(i8::MIN, i8::MAX),
            Self::U8 => range(u8::MIN, u8::MAX),
            Self::I16 => range(i16::MIN, i16::MAX),
            Self::U16 => range(u16::MIN, u16::MAX),
            Self::I32 => range(i32::MIN, i32::MAX),
            Self::U32 => range(u32::MIN, u32::MAX),
            Self::I64 => range(i64::MIN, i64::MAX),
            Self::U64 => range(u64::MIN, u64::MAX),
            Self::F32 | Self::F64 => None,
        }
    }
}

impl ScalarValues {
    /// `count` zeros of a type.
    #[must_use]
    pub fn zeros(kind: ScalarType, count: usize) -> Self {
        match kind {
            ScalarType::I8 => Self::I8(vec![0; count]),
            ScalarType::U8 => Self::U8(vec![0; count]),
            ScalarType::I16 => Self::I16(vec![0; count]),
            ScalarType::U16 => Self::U16(vec![0; count]),
            ScalarType::I32 => Self::I32(vec![0; count]),
            ScalarType::U32 => Self::U32(vec![0; count]),
            ScalarType::I64 => Self::I64(vec![0; count]),
            ScalarType::U64 => Self::U64(vec![0; count]),
            ScalarType::F32 => Self::F32(vec![0.0; count]),
            ScalarType::F64 => Self::F64(vec![0.0; count]),
        }
    }

    /// The type of the numbers.
    #[must_use]
    pub fn scalar_type(&self) -> ScalarType {
        match self {
            Self::I8(_) => ScalarType::I8,
            Self::U8(_) => ScalarType::U8,
            Self::I16(_) => ScalarType::I16,
            Self::U16(_) => ScalarType::U16,
            Self::I32(_) => ScalarType::I32,
            Self::U32(_) => ScalarType::U32,
            Self::I64(_) => ScalarType::I64,
            Self::U64(_) => ScalarType::U64,
            Self::F32(_) => ScalarType::F32,
            Self::F64(_) => ScalarType::F64,
        }
    }

    /// The number of entries.
    #[must_use]
    pub fn len(&self) -> usize {
        each_type!(self, values => values.len())
    }

    /// Whether there are no numbers.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Whether the type is an integer type.
    #[must_use]
    pub fn is_integer(&self) -> bool {
        self.scalar_type().is_integer()
    }

    /// The number at a place in 64-bit floating point. Whole numbers beyond 2^53 are rounded.
    #[must_use]
    #[allow(
        clippy::unnecessary_cast,
        clippy::cast_lossless,
        reason = "one expression for all types"
    )]
    pub fn get(&self, place: usize) -> Option<f64> {
        each_type!(self, values => values.get(place).map(|&value| value as f64))
    }

    /// The bits of the number at a place. Numbers of a column are equal if their bits are.
    #[must_use]
    pub fn bits(&self, place: usize) -> Option<u64> {
        each_type!(self, values => values.get(place).map(|value| {
            let mut bits = [0; 8];
            bits.iter_mut().zip(value.to_le_bytes()).for_each(|(bit, byte)| *bit = byte);
            u64::from_le_bytes(bits)
        }))
    }

    /// The numbers in 64-bit floating point, without a copy if they have this type already.
    #[must_use]
    pub fn to_f64(&self) -> Cow<'_, [f64]> {
        match self {
            Self::F64(values) => Cow::Borrowed(values),
            other => Cow::Owned(other.iter().collect()),
        }
    }

    /// Iterates over the numbers in 64-bit floating point.
    pub fn iter(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.len()).map(|place| self.get(place).unwrap_or(f64::NAN))
    }

    /// The numbers at these indices. Invalid indices are skipped.
    #[must_use]
    pub fn gather(&self, places: &[u32]) -> Self {
        fn gather<T: Copy>(values: &[T], places: &[u32]) -> Vec<T> {
            places.iter().filter_map(|&place| values.get(place as usize).copied()).collect()
        }
        each_type!(self, values => gather(values, places).into())
    }

    /// The numbers in another type. Fractions are rounded, and numbers out of range are clamped.
    #[must_use]
    pub fn cast(&self, kind: ScalarType) -> Self {
        if self.scalar_type() == kind {
            return self.clone();
        }
        let mut cast = Self::zeros(kind, self.len());
        for place in 0..self.len() {
            let value = self.get(place).unwrap_or_default();
            let whole = self.whole(place).or_else(|| kind.range().map(|_| value.round() as i128));
            let whole = whole.zip(kind.range()).map(|(w, [least, most])| w.clamp(least, most));
            cast.set(place, value, whole);
        }
        cast
    }

    /// The number at an index of an integer column.
    #[must_use]
    pub fn whole(&self, place: usize) -> Option<i128> {
        fn at<T: Copy + Into<i128>>(values: &[T], place: usize) -> Option<i128> {
            values.get(place).map(|&value| value.into())
        }
        match self {
            Self::I8(values) => at(values, place),
            Self::U8(values) => at(values, place),
            Self::I16(values) => at(values, place),
            Self::U16(values) => at(values, place),
            Self::I32(values) => at(values, place),
            Self::U32(values) => at(values, place),
            Self::I64(values) => at(values, place),
            Self::U64(values) => at(values, place),
            Self::F32(_) | Self::F64(_) => None,
        }
    }

    /// Sets the number at an index: `whole` if it is known exactly, else `value`. Returns false if the type cannot hold
    /// the number.
    pub(crate) fn set(&mut self, place: usize, value: f64, whole: Option<i128>) -> bool {
        fn put<T: TryFrom<i128>>(values: &mut [T], place: usize, whole: Option<i128>) -> bool {
            let number = whole.and_then(|whole| T::try_from(whole).ok());
            number.zip(values.get_mut(place)).map(|(number, slot)| *slot = number).is_some()
        }
        let whole = whole.or_else(|| (value.fract() == 0.0).then_some(value as i128));
        match self {
            Self::I8(values) => put(values, place, whole),
            Self::U8(values) => put(values, place, whole),
            Self::I16(values) => put(values, place, whole),
            Self::U16(values) => put(values, place, whole),
            Self::I32(values) => put(values, place, whole),
            Self::U32(values) => put(values, place, whole),
            Self::I64(values) => put(values, place, whole),
            Self::U64(values) => put(values, place, whole),
            Self::F32(values) => values.get_mut(place).map(|slot| *slot = value as f32).is_some(),
            Self::F64(values) => values.get_mut(place).map(|slot| *slot = value).is_some(),
        }
    }

    /// Reserves memory for `more` further numbers.
    pub(crate) fn reserve_exact(&mut self, more: usize) {
        each_type!(self, values => values.reserve_exact(more));
    }

    /// Extends the column with zeros, or shortens it.
    pub(crate) fn resize(&mut self, count: usize) {
        each_type!(self, values => values.resize(count, Default::default()));
    }
}

impl Default for ScalarValues {
    fn default() -> Self {
        Self::F64(Vec::new())
    }
}

impl FromIterator<f64> for ScalarValues {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        Self::F64(values.into_iter().collect())
    }
}

impl PartialEq<[f64]> for ScalarValues {
    fn eq(&self, other: &[f64]) -> bool {
        self.to_f64().as_ref() == other
    }
}

impl<const N: usize> PartialEq<[f64; N]> for ScalarValues {
    fn eq(&self, other: &[f64; N]) -> bool {
        *self == other[..]
    }
}
