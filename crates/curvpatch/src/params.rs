//! How curvature is estimated: the parameters, and two presets.

/// How the curvature of one normal section is read off its two arcs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum SectionRule {
    /// From the chord of an arc, to third order: with arc length S and chord d,
    /// |κ| = √(24 (S - d) / S³). SN10 prints its inverse for S = 2r: √(r³ / (3 (2r - d))).
    ///
    /// On a circle of curvature k it yields k (1 - a²/40 + ...) with a = `r_g` k. A chord is never
    /// longer than its arc, so noise and facets bias it away from zero.
    ThirdOrderChord,
    /// From the same chord without the truncation: |κ| = 2X/S with sin X / X = d / S.
    ExactChord,
    /// The circle through both ends and the centre (Menger curvature), signed; exact on circles,
    /// and free of bias near zero.
    #[default]
    ThreePointCircle,
}

/// The normal that the normal planes contain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum NormalRule {
    /// The normal of the face.
    ///
    /// It is the surface normal over the circumcentre of the triangle. At the barycentre it is
    /// tilted by about the distance of the two times the curvature.
    Face,
    /// The normal of the disc: the slopes of all sections are fitted by one plane, and the
    /// sections are taken again about its normal.
    #[default]
    Disc,
}

/// How principal curvatures follow from those of the sections.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum PrincipalRule {
    /// The largest and the smallest *signed* section curvature, with the direction of the one
    /// that is larger in absolute value; the other direction is made orthogonal to it.
    ///
    /// SN10 speaks of the largest and the smallest diameter (chord) of the disc. Taken literally
    /// that fails on saddles: a chord is as short for κ as for -κ, so the longest one lies along
    /// an asymptotic direction, more than 20° away from any principal one.
    SignedExtremes,
    /// A least-squares fit of Euler's formula κ(φ) = p + q cos 2φ + r sin 2φ, sections weighted
    /// by how much of their arcs lies on the mesh. Principal values p ± √(q² + r²).
    #[default]
    EulerFit,
}

/// When a patch is moved along its normal towards the vertices of its base face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[non_exhaustive]
pub enum TranslationRule {
    /// Where both curvatures have the same sign, as in SN10.
    Elliptic,
    /// Everywhere. Without the switch, patches near κ₂ = 0 have centres 10 to 50 times closer to
    /// the surface.
    #[default]
    Always,
}

/// How curvature is estimated from the normal sections through a point, and how a patch is placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Params {
    /// Number of normal planes, evenly spaced over half a turn; at least 3. From 12 on a fit of
    /// Euler's formula does not change any more.
    pub planes: u16,
    /// How the curvature of one section is read off.
    pub section: SectionRule,
    /// The normal that the planes contain.
    pub normal: NormalRule,
    /// How principal curvatures follow from the sections.
    pub principal: PrincipalRule,
    /// When patches are moved along the normal.
    pub translation: TranslationRule,
}

impl Params {
    /// Faithful to SN10: 36 planes through the face normal, third-order chords, signed extremes,
    /// patches translated at elliptic points only.
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

    /// The default: 18 planes through the disc normal, three-point circles, Euler's formula
    /// fitted, patches always translated. Two to ten times the accuracy of [`Params::paper`] at
    /// the same cost, principal directions included.
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
}

impl Default for Params {
    fn default() -> Self {
        Self::robust()
    }
}
