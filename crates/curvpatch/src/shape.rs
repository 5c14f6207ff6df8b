//! Shapes of patches: the ratio of their two arcs.

/// The arc length of a patch along its second principal direction.
///
/// The arc along the first principal direction always has the length `r_g`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Shape {
    /// Equal arcs: `r_g` in both directions.
    #[default]
    Circle,
    /// Equal central angles, limited: β = min(α, 2.5 `r_g` / ρ₂) (SN10, section 2). The arc has the
    /// length `r_g` min(|κ₁| / |κ₂|, 2.5).
    ///
    /// The text of SN10 says that β tends to π/2 as κ₂ vanishes. By the formula β tends to 0, and the arc
    /// to 2.5 `r_g`. The formula is used.
    Ellipse,
    /// Equal sagittas, limited: the arc has the length `r_g` min(√(|κ₁| / |κ₂|), 2.5).
    EqualSagitta,
}

impl Shape {
    /// All shapes.
    pub const ALL: &'static [Self] = &[Self::Circle, Self::Ellipse, Self::EqualSagitta];

    /// The largest ratio of the two arcs.
    pub const MAX_STRETCH: f64 = 2.5;

    /// The lengths of both arcs, for principal curvatures and a radius `r_g`.
    #[must_use]
    pub fn arcs(self, curvatures: [f64; 2], radius: f64) -> [f64; 2] {
        let [k1, k2] = curvatures.map(f64::abs);
        let stretch = if self == Self::Circle || k1 * radius < 1e-9 {
            1.0
        } else {
            // Infinite for κ₂ = 0; the cap below applies.
            let ratio = k1 / k2;
            let stretch = if self == Self::Ellipse { ratio } else { ratio.sqrt() };
            stretch.min(Self::MAX_STRETCH)
        };
        [radius, radius * stretch]
    }
}
