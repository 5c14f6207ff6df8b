//! Numbers derived from the curvature of a vertex.

use dcurv::{VertexCurvature, VertexIntegrals};

/// The number for each vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::cost) enum Measure {
    /// |k1| + |k2| at the vertex.
    AbsSum,
    /// k1² + k2² at the vertex.
    SquaredSum,
    /// |k1| + |k2| integrated over the area of the vertex.
    AbsIntegral,
    /// As [`Measure::AbsSum`], with unsigned dihedral angles.
    UnsignedAbsSum,
    /// As [`Measure::SquaredSum`], with unsigned dihedral angles.
    UnsignedSquaredSum,
}

impl Measure {
    /// Whether dihedral angles count without their sign.
    pub(in crate::cost) fn is_unsigned(self) -> bool {
        matches!(self, Self::UnsignedAbsSum | Self::UnsignedSquaredSum)
    }

    #[inline(always)]
    pub(in crate::cost) fn of(self, integrals: VertexIntegrals, boundary: bool) -> f64 {
        let area = integrals.area;
        let curvature = VertexCurvature::from_integrals(integrals, boundary);
        match self {
            Self::AbsSum | Self::UnsignedAbsSum => curvature.abs_principal_sum().value(),
            Self::SquaredSum | Self::UnsignedSquaredSum => {
                curvature.squared_principal_sum().value()
            }
            Self::AbsIntegral => (curvature.abs_principal_sum() * area).value(),
        }
    }
}

/// The current data of a vertex.
#[derive(Clone, Copy, Debug, Default)]
pub(in crate::cost) struct Term {
    pub(in crate::cost) integrals: VertexIntegrals,
    pub(in crate::cost) measured: f64,
    pub(in crate::cost) boundary: bool,
}

impl Term {
    #[inline]
    pub(in crate::cost) fn new(
        integrals: VertexIntegrals,
        boundary: bool,
        measure: Measure,
    ) -> Self {
        Self { integrals, measured: measure.of(integrals, boundary), boundary }
    }
}
