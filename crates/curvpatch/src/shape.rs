//! The outlines of patches.

/// How far a patch reaches along its second principal direction.
///
/// Along the first one, where the curvature is larger, the arc is always `r_g` long.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Shape {
    /// Equal arcs: `r_g` both ways.
    #[default]
    Circle,
    /// The same central angle both ways, β = min(α, 2.5 `r_g` / ρ₂) as SN10 prints it:
    /// an arc of length `r_g` min(|κ₁| / |κ₂|, 2.5).
    ///
    /// (Where the text of SN10 lets β go to π/2 as κ₂ vanishes, the formula lets it go to zero and
    /// the arc to 2.5 `r_g`, which is what is meant.)
    Ellipse,
    /// The same rise over the tangent plane both ways: `r_g` min(√(|κ₁| / |κ₂|), 2.5).
    EqualSagitta,
}

impl Shape {
    /// All shapes.
    pub const ALL: &'static [Self] = &[Self::Circle, Self::Ellipse, Self::EqualSagitta];

    /// The largest ratio of the two arcs.
    pub const MAX_STRETCH: f64 = 2.5;

    /// The lengths of both arcs.
    #[must_use]
    pub fn arcs(self, curvatures: [f64; 2], radius: f64) -> [f64; 2] {
        let [k1, k2] = curvatures.map(f64::abs);
        let stretch = if self == Self::Circle || k1 * radius < 1e-9 {
            1.0
        } else {
            // Infinite for κ₂ = 0, and so capped.
            let ratio = k1 / k2;
            let stretch = if self == Self::Ellipse { ratio } else { ratio.sqrt() };
            stretch.min(Self::MAX_STRETCH)
        };
        [radius, radius * stretch]
    }
}
