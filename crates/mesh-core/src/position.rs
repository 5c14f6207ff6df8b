//! Types that are accepted as positions and as vertex indices.

use std::borrow::Cow;

use glam::{DVec3, Vec3, Vec3A};

/// A point in space, of any type that holds three coordinates: arrays, tuples and `glam` vectors of
/// `f32` or `f64`, and with the `mint` feature `mint` points and vectors.
pub trait Position: Copy {
    /// The point in double precision.
    fn to_dvec3(self) -> DVec3;
}

/// An index of a vertex, of any integer type. Negative numbers and numbers beyond 32 bits become [`u32::MAX`],
/// which is out of range in every mesh.
pub trait VertexIndex: Copy {
    /// The index as stored in meshes and soups.
    fn to_u32(self) -> u32;

    /// Triangles as meshes store them.
    #[doc(hidden)]
    fn triangles(given: &[[Self; 3]]) -> Cow<'_, [[u32; 3]]> {
        given.iter().map(|corners| corners.map(Self::to_u32)).collect()
    }
}

impl VertexIndex for u32 {
    #[inline]
    fn to_u32(self) -> u32 {
        self
    }

    fn triangles(given: &[[Self; 3]]) -> Cow<'_, [[u32; 3]]> {
        Cow::Borrowed(given)
    }
}

macro_rules! vertex_index {
    ($($integer:ty),*) => {$(
        impl VertexIndex for $integer {
            #[inline]
            fn to_u32(self) -> u32 {
                u32::try_from(self).unwrap_or(u32::MAX)
            }
        }
    )*};
}

vertex_index!(u8, u16, u64, usize, i32, i64, isize);

impl Position for DVec3 {
    #[inline]
    fn to_dvec3(self) -> DVec3 {
        self
    }
}

impl Position for Vec3 {
    #[inline]
    fn to_dvec3(self) -> DVec3 {
        self.as_dvec3()
    }
}

impl Position for Vec3A {
    #[inline]
    fn to_dvec3(self) -> DVec3 {
        self.as_dvec3()
    }
}

impl<C: Copy + Into<f64>> Position for [C; 3] {
    #[inline]
    fn to_dvec3(self) -> DVec3 {
        DVec3::from_array(self.map(Into::into))
    }
}

impl<C: Copy + Into<f64>> Position for (C, C, C) {
    #[inline]
    fn to_dvec3(self) -> DVec3 {
        [self.0, self.1, self.2].to_dvec3()
    }
}

impl<P: Position> Position for &P {
    #[inline]
    fn to_dvec3(self) -> DVec3 {
        (*self).to_dvec3()
    }
}

#[cfg(feature = "mint")]
impl<C: Copy + Into<f64>> Position for mint::Point3<C> {
    #[inline]
    fn to_dvec3(self) -> DVec3 {
        [self.x, self.y, self.z].to_dvec3()
    }
}

#[cfg(feature = "mint")]
impl<C: Copy + Into<f64>> Position for mint::Vector3<C> {
    #[inline]
    fn to_dvec3(self) -> DVec3 {
        [self.x, self.y, self.z].to_dvec3()
    }
}
