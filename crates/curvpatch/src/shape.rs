//! Shapes of patches: the ratio of their two arcs.

/// The ratio of the arc lengths of a patch along its two principal directions.
///
/// Let κ be the principal curvature with the larger absolute value, and κ' the other one. The arc along the
/// direction of κ always has the length `r_g`. (SN10 calls these curvatures κ₁ and κ₂.)
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum Shape {
    /// Equal arcs: `r_g` in both directions.
    #[default]
    Circle,
    /// Equal central angles, limited: β = min(α, 2.5 `r_g` / ρ₂) (SN10, section 2). The arc has the
    /// length `r_g` min(|κ / κ'|, 2.5).
    ///
    /// The text of SN10 says that β tends to π/2 as κ' vanishes. By the formula β tends to 0, and the arc
    /// to 2.5 `r_g`. The formula is used.
    Ellipse,
    /// Equal sagittas, limited: the arc has the length `r_g` min(√|κ / κ'|, 2.5).
    EqualSagitta,
}

impl Shape {
    /// All shapes.
    pub const ALL: &'static [Self] = &[Self::Circle, Self::Ellipse, Self::EqualSagitta];

    /// The largest ratio of the two arcs.
    pub const MAX_STRETCH: f64 = 2.5;

    /// The lengths of both arcs, for principal curvatures κ₁, κ₂ in any order and a radius `r_g`.
    #[must_use]
    pub fn arcs(self, curvatures: [f64; 2], radius: f64) -> [f64; 2] {
        let [k1, k2] = curvatures.map(f64::abs);
        let (large, small) = if k1 >= k2 { (k1, k2) } else { (k2, k1) };
        let stretch = if self == Self::Circle || large * radius < 1e-9 {
            1.0
        } else {
            // Infinite for a straight direction; the cap below applies.
            let ratio = large / small;
            let stretch = if self == Self::Ellipse { ratio } else { ratio.sqrt() };
            stretch.min(Self::MAX_STRETCH)
        };
        if k1 >= k2 { [radius, radius * stretch] } else { [radius * stretch, radius] }
    }
}
