//! Distinct types for integrated and pointwise curvature.
//!
//! A mesh has curvature *integrated* over the area of a vertex. Divided by that area it is a *pointwise*
//! estimate for the sampled surface. The two have different units, so they have different types. An
//! [`Area`] converts between them:
//!
//! ```
//! use dcurv::{Area, Integral, Pointwise};
//! let integral = Integral::new(0.5);
//! let pointwise: Pointwise = integral / Area::new(0.25);
//! assert_eq!(pointwise, Pointwise::new(2.0));
//! assert_eq!(pointwise * Area::new(0.25), integral);
//! ```
//!
//! ```compile_fail
//! use dcurv::{Integral, Pointwise};
//! let mixed = Integral::new(1.0) + Pointwise::new(1.0);
//! ```

use core::iter::Sum;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
        #[repr(transparent)]
        pub struct $name(f64);

        impl $name {
            /// A quantity from its value.
            #[inline]
            #[must_use]
            pub const fn new(value: f64) -> Self {
                Self(value)
            }

            /// The number.
            #[inline]
            #[must_use]
            pub const fn value(self) -> f64 {
                self.0
            }

            /// The absolute value.
            #[inline]
            #[must_use]
            pub const fn abs(self) -> Self {
                Self(self.0.abs())
            }
        }

        impl Add for $name {
            type Output = Self;

            #[inline]
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl AddAssign for $name {
            #[inline]
            fn add_assign(&mut self, other: Self) {
                self.0 += other.0;
            }
        }

        impl Sub for $name {
            type Output = Self;

            #[inline]
            fn sub(self, other: Self) -> Self {
                Self(self.0 - other.0)
            }
        }

        impl Neg for $name {
            type Output = Self;

            #[inline]
            fn neg(self) -> Self {
                Self(-self.0)
            }
        }

        impl Sum for $name {
            fn sum<I: Iterator<Item = Self>>(values: I) -> Self {
                values.fold(Self(0.0), |total, value| total + value)
            }
        }
    };
}

quantity! {
    /// Curvature integrated over an area.
    ///
    /// Gaussian curvature comes in radians, mean curvature in model units.
    Integral
}

quantity! {
    /// Curvature at a point: an [`Integral`] divided by its [`Area`].
    ///
    /// Gaussian curvature comes per square of the model unit, mean and principal curvature per
    /// model unit.
    Pointwise
}

quantity! {
    /// An area, in squares of the model unit.
    Area
}

/// The mean over the area; 0 for an area of 0.
impl Div<Area> for Integral {
    type Output = Pointwise;

    #[inline]
    fn div(self, area: Area) -> Pointwise {
        Pointwise(if area.0 > 0.0 { self.0 / area.0 } else { 0.0 })
    }
}

/// The integral over the area.
impl Mul<Area> for Pointwise {
    type Output = Integral;

    #[inline]
    fn mul(self, area: Area) -> Integral {
        Integral(self.0 * area.0)
    }
}
