//! Curvature quantities by name, and their integrals.

use core::fmt;
use core::str::FromStr;

use dcurv::Totals;

/// A curvature quantity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(rename_all = "kebab-case"))]
#[non_exhaustive]
pub enum Quantity {
    /// K, per area.
    Gaussian,
    /// H, per length, signed.
    #[default]
    Mean,
    /// |H|, per length.
    AbsMean,
    /// 1/4 sum of |e| |beta| per area, per length: the |H| of DHKL01.
    AbsDihedral,
    /// The larger principal curvature, per length.
    K1,
    /// The smaller principal curvature, per length.
    K2,
    /// |k1| + |k2|, per length.
    AbsSum,
    /// Bobenko's Willmore energy of the vertex, without unit.
    Willmore,
    /// K+ of Alboul and van Damme: the angle defect of the convex hull of the star, in radians.
    KPlus,
    /// K- = K+ - K, in radians.
    KMinus,
    /// Koenderink's shape index, from -1 (cup) to 1 (cap).
    ShapeIndex,
    /// sqrt((k1² + k2²) / 2), per length.
    Curvedness,
}

/// An unknown name of a quantity.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "unknown quantity {0:?}; the quantities are gaussian, mean, abs-mean, abs-dihedral, k1, k2, abs-sum, willmore, k-plus, k-minus, shape-index, curvedness"
)]
pub struct UnknownQuantity(pub String);

impl Quantity {
    /// All quantities.
    pub const ALL: &'static [Self] = &[
        Self::Gaussian,
        Self::Mean,
        Self::AbsMean,
        Self::AbsDihedral,
        Self::K1,
        Self::K2,
        Self::AbsSum,
        Self::Willmore,
        Self::KPlus,
        Self::KMinus,
        Self::ShapeIndex,
        Self::Curvedness,
    ];

    /// The name, as accepted by [`FromStr`].
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Gaussian => "gaussian",
            Self::Mean => "mean",
            Self::AbsMean => "abs-mean",
            Self::AbsDihedral => "abs-dihedral",
            Self::K1 => "k1",
            Self::K2 => "k2",
            Self::AbsSum => "abs-sum",
            Self::Willmore => "willmore",
            Self::KPlus => "k-plus",
            Self::KMinus => "k-minus",
            Self::ShapeIndex => "shape-index",
            Self::Curvedness => "curvedness",
        }
    }

    /// A short description.
    #[must_use]
    pub fn meaning(self) -> &'static str {
        match self {
            Self::Gaussian => "K, per area",
            Self::Mean => "H, per length, signed",
            Self::AbsMean => "|H|, per length",
            Self::AbsDihedral => "1/4 sum of |e| |dihedral angle| per area, per length",
            Self::K1 => "The larger principal curvature, per length",
            Self::K2 => "The smaller principal curvature, per length",
            Self::AbsSum => "|k1| + |k2|, per length",
            Self::Willmore => "Bobenko's Willmore energy of the vertex, without unit",
            Self::KPlus => "Positive extrinsic curvature of the vertex, in radians",
            Self::KMinus => "Negative extrinsic curvature of the vertex, in radians",
            Self::ShapeIndex => "Koenderink's shape index, from -1 (cup) to 1 (cap)",
            Self::Curvedness => "sqrt((k1² + k2²) / 2), per length",
        }
    }

    /// The name of the property in a PLY file.
    #[must_use]
    pub fn property(self) -> &'static str {
        match self {
            Self::Gaussian => "gaussian_curvature",
            Self::Mean => "mean_curvature",
            Self::AbsMean => "abs_mean_curvature",
            Self::AbsDihedral => "abs_dihedral_curvature",
            Self::K1 => "k1",
            Self::K2 => "k2",
            Self::AbsSum => "abs_principal_sum",
            Self::Willmore => "willmore_energy",
            Self::KPlus => "k_plus",
            Self::KMinus => "k_minus",
            Self::ShapeIndex => "shape_index",
            Self::Curvedness => "curvedness",
        }
    }

    /// The unit of its values, or empty.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::Gaussian => "1 / model unit\u{b2}",
            Self::Mean
            | Self::AbsMean
            | Self::AbsDihedral
            | Self::K1
            | Self::K2
            | Self::AbsSum
            | Self::Curvedness => "1 / model unit",
            Self::Willmore | Self::KPlus | Self::KMinus | Self::ShapeIndex => "",
        }
    }

    /// The quantity with this [property](Self::property).
    #[must_use]
    pub fn of_property(property: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|quantity| quantity.property() == property)
    }

    /// Whether the quantity is defined by the star of a vertex, not at a point of a surface. Only the estimator
    /// `vertex` provides it.
    #[must_use]
    pub fn is_of_star(self) -> bool {
        matches!(self, Self::AbsDihedral | Self::Willmore | Self::KPlus | Self::KMinus)
    }

    /// Whether it has values on both sides of zero.
    #[must_use]
    pub fn is_signed(self) -> bool {
        matches!(self, Self::Gaussian | Self::Mean | Self::K1 | Self::K2 | Self::ShapeIndex)
    }
}

/// The name of a property above a legend: that of a [`Quantity`] as words and with its unit.
#[must_use]
pub fn legend_title(property: &str) -> String {
    match Quantity::of_property(property) {
        Some(quantity) if quantity.unit().is_empty() => property.replace('_', " "),
        Some(quantity) => format!("{} ({})", property.replace('_', " "), quantity.unit()),
        None => property.to_owned(),
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

impl FromStr for Quantity {
    type Err = UnknownQuantity;

    fn from_str(name: &str) -> Result<Self, UnknownQuantity> {
        let found = Self::ALL.iter().copied().find(|quantity| quantity.name() == name);
        found.ok_or_else(|| UnknownQuantity(name.to_owned()))
    }
}

/// Integrals over the mesh, for every estimator.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Integrals {
    /// Of K, without unit.
    pub integral_gaussian: f64,
    /// Of |K|, without unit.
    pub integral_abs_gaussian: f64,
    /// Of H, in model units.
    pub integral_mean: f64,
    /// Of |H|, in model units.
    pub integral_abs_mean: f64,
    /// F1 of DHKL01: of H², without unit.
    pub f1: f64,
    /// F2 of DHKL01: of the |H| of that paper, in model units. For the estimator `vertex` the sum of the
    /// absolute dihedral angles times half the edge lengths; else the integral of |H|.
    pub f2: f64,
    /// F3 of DHKL01: of |k1| + |k2|, in model units.
    pub f3: f64,
    /// The Willmore energy: of H² - K, without unit.
    pub willmore: f64,
}

impl Integrals {
    /// From the sums over the vertices, and the sum of their Willmore energies.
    #[must_use]
    pub fn new(totals: &Totals, willmore: f64) -> Self {
        Self {
            integral_gaussian: totals.gaussian.value(),
            integral_abs_gaussian: totals.abs_gaussian.value(),
            integral_mean: totals.mean.value(),
            integral_abs_mean: totals.abs_mean.value(),
            f1: totals.f1,
            f2: totals.f2(),
            f3: totals.f3,
            willmore,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn titles_are_words_with_units() {
        assert_eq!(legend_title("gaussian_curvature"), "gaussian curvature (1 / model unit\u{b2})");
        assert_eq!(legend_title("shape_index"), "shape index");
        assert_eq!(legend_title("heat_flow"), "heat_flow");
    }
}
