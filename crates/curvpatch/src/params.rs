//! Parameters of the curvature estimation, and two presets.

/// The formula for the curvature of one normal section from its two arcs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SectionRule {
    /// From the chord of an arc, to third order: |κ| = √(24 (S - d) / S³) with arc length S and chord d.
    ///
    /// SN10 (section 1) computes the radius of the osculating circle "by a third order approximation
    /// method" and prints no formula. This one follows from the series d = S - κ² S³ / 24 + O(κ⁴ S⁵) of a
    /// circular arc; for S = 2 `r_g` it is the radius √(`r_g`³ / (3 (2 `r_g` - d))).
    ///
    /// On a circle of curvature k it yields k (1 - a²/40 + ...) with a = `r_g` k. A chord is never longer
    /// than its arc, so noise and facets bias the result away from zero.
    ThirdOrderChord,
    /// From the same chord without truncation: |κ| = 2X/S with sin X / X = d / S. Exact on circles.
    ExactChord,
    /// The signed curvature of the circle through both ends and the centre (Menger curvature). Exact on
    /// circles, and without bias near zero.
    #[default]
    ThreePointCircle,
}

/// The normal vector in the section planes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum NormalRule {
    /// The normal of the face.
    ///
    /// It approximates the surface normal at the circumcentre of the triangle. At the barycentre it is
    /// tilted by about the curvature times the distance between circumcentre and barycentre.
    Face,
    /// The normal of the disc: a plane is fitted to the slopes of all sections, and the sections are
    /// repeated in planes through its normal.
    #[default]
    Disc,
}

/// The rule for the principal curvatures from the section curvatures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PrincipalRule {
    /// The largest and the smallest *signed* section curvature. The direction of the curvature with the
    /// larger absolute value is kept, and the other direction is orthogonal to it.
    ///
    /// SN10 (section 1) takes the largest and the smallest diameter (chord) of the disc. On saddles this
    /// fails: the chords for κ and -κ have the same length, and the longest chord lies along an asymptotic
    /// direction, more than 20° from any principal direction.
    SignedExtremes,
    /// Least-squares fit of Euler's formula κ(φ) = p + q cos 2φ + r sin 2φ. The principal curvatures are
    /// p ± √(q² + r²). A section is weighted by the product of its arc lengths over `r_g`².
    #[default]
    EulerFit,
}

/// The rule for the translation of a patch along its normal, towards the vertices of its base face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum TranslationRule {
    /// If both curvatures have the same sign, as in SN10 (section 2).
    Elliptic,
    /// Always. Near points with a vanishing principal curvature, the centre of the patch is then 10 to 50
    /// times closer to the surface.
    #[default]
    Always,
}

/// Parameters of the curvature estimation and of the placement of patches.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Params {
    /// Number of normal planes, evenly spaced over half a turn; at least 3. Beyond 12, the fit of Euler's
    /// formula hardly changes.
    pub planes: u16,
    /// The formula for the curvature of one section.
    pub section: SectionRule,
    /// The normal vector in the section planes.
    pub normal: NormalRule,
    /// The rule for the principal curvatures.
    pub principal: PrincipalRule,
    /// The rule for the translation of patches.
    pub translation: TranslationRule,
}

impl Params {
    /// As SN10: 36 planes through the face normal, third-order chords, signed extremes, and translation at
    /// elliptic points only.
    #[must_use]
    pub const fn paper() -> Self {
        Self {
            planes: 36,
            section: SectionRule::ThirdOrderChord,
            normal: NormalRule::Face,
            principal: PrincipalRule::SignedExtremes,
            translation: TranslationRule::Elliptic,
        }
    }

    /// The default: 18 planes through the disc normal, three-point circles, fit of Euler's formula, and
    /// translation always. The errors of curvatures and directions are 2 to 10 times smaller than with
    /// [`Params::paper`], at the same cost.
    #[must_use]
    pub const fn robust() -> Self {
        Self {
            planes: 18,
            section: SectionRule::ThreePointCircle,
            normal: NormalRule::Disc,
            principal: PrincipalRule::EulerFit,
            translation: TranslationRule::Always,
        }
    }

    /// Whether sections are measured by circles and curvatures fitted to them: the rules of [`Params::robust`].
    pub(crate) fn fits_circles(&self) -> bool {
        (self.principal, self.section) == (PrincipalRule::EulerFit, SectionRule::ThreePointCircle)
    }
}

impl Default for Params {
    fn default() -> Self {
        Self::robust()
    }
}
