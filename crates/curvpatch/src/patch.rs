//! The trigonometric surface patch (SN10, section 2), in one formula for all signs of curvature.

use core::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use crate::arc::{reach, sagitta};
use crate::disc_curvature::DiscCurvature;
use crate::shape::Shape;

/// The reason why data does not describe a patch.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatchError {
    /// An arc is at least a quarter of its circle. The patch would not be a graph over its tangent plane.
    #[error(
        "an arc of length {arc} with curvature {curvature} turns by a quarter circle or more; use a radius below {}", FRAC_PI_2 / curvature.abs()
    )]
    RadiusTooLarge {
        /// The length of the arc.
        arc: f64,
        /// Its curvature.
        curvature: f64,
    },
    /// An arc is not positive and finite.
    #[error("an arc has length {arc}, but it must be positive and finite")]
    BadArc {
        /// Its length.
        arc: f64,
    },
    /// The frame is not orthonormal and right-handed, or a number is not finite.
    #[error("the frame is not orthonormal and right-handed, or a number is not finite")]
    BadFrame,
}

/// The numbers that determine a patch. A patch made from them has the same bits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct PatchData {
    /// The origin P of the frame: a point of the mesh.
    pub origin: [f64; 3],
    /// e₁, e₂ and e₃: the two principal directions and the normal.
    pub frame: [[f64; 3]; 3],
    /// κ₁ and κ₂, in 1 / length, positive where convex.
    pub curvatures: [f64; 2],
    /// The lengths L₁ and L₂ of the arcs from the centre to the boundary.
    pub arcs: [f64; 2],
    /// The translation τ along e₃.
    pub translation: f64,
}

/// A smooth patch spanned by the arcs of two osculating circles.
///
/// With u from 0 (centre) to 1 (boundary) and φ from 0 to 2π,
///
/// ```text
/// q(u, φ) = P + A₁ cos φ e₁ + A₂ sin φ e₂ + (τ - H₁ cos² φ - H₂ sin² φ) e₃,
/// Aᵢ = sin(κᵢ Lᵢ u) / κᵢ,   Hᵢ = (1 - cos(κᵢ Lᵢ u)) / κᵢ.
/// ```
///
/// Both terms have limits for κ → 0, so that one formula holds for straight arms and all signs. The
/// second fundamental form at the centre is exactly diag(κ₁, κ₂). For κ₁ = κ₂ the patch is a spherical
/// cap. The patch is a graph over an ellipse in its tangent plane, the *footprint*, with the semi-axes
/// A₁ and A₂ for u = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(try_from = "PatchData", into = "PatchData"))]
pub struct Patch {
    origin: DVec3,
    frame: [DVec3; 3],
    curvatures: [f64; 2],
    arcs: [f64; 2],
    translation: f64,
    /// A₁ and A₂ at the boundary.
    semi_axes: DVec2,
}

impl TryFrom<PatchData> for Patch {
    type Error = PatchError;

    fn try_from(data: PatchData) -> Result<Self, PatchError> {
        let frame = data.frame.map(DVec3::from_array);
        let origin = DVec3::from_array(data.origin);
        let [e1, e2, e3] = frame;
        let off_frame = (e1.cross(e2) - e3).length() + (e2.cross(e3) - e1).length();
        if !(off_frame < 1e-6 && origin.is_finite() && data.translation.is_finite()) {
            return Err(PatchError::BadFrame);
        }
        let patch = Self::new(origin, frame, data.curvatures, data.arcs)?;
        Ok(patch.translated(data.translation))
    }
}

impl From<Patch> for PatchData {
    fn from(patch: Patch) -> Self {
        Self {
            origin: patch.origin.to_array(),
            frame: patch.frame.map(|e| e.to_array()),
            curvatures: patch.curvatures,
            arcs: patch.arcs,
            translation: patch.translation,
        }
    }
}

/// An oriented elliptical disc that approximates a patch, for point-based rendering.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Splat {
    /// The centre.
    pub center: [f64; 3],
    /// The unit normal.
    pub normal: [f64; 3],
    /// The semi-axes of the ellipse, as vectors.
    pub axes: [[f64; 3]; 2],
}

impl Patch {
    /// The patch of a disc, not translated.
    ///
    /// # Errors
    /// [`PatchError::RadiusTooLarge`] if an arc turns by a quarter circle or more.
    pub fn from_curvature(disc: &DiscCurvature, shape: Shape) -> Result<Self, PatchError> {
        let arcs = shape.arcs(disc.curvatures, disc.radius);
        Self::new(disc.center, disc.frame, disc.curvatures, arcs)
    }

    fn new(
        origin: DVec3,
        frame: [DVec3; 3],
        curvatures: [f64; 2],
        arcs: [f64; 2],
    ) -> Result<Self, PatchError> {
        for (curvature, arc) in curvatures.into_iter().zip(arcs) {
            if !(arc > 0.0 && arc.is_finite()) {
                return Err(PatchError::BadArc { arc });
            }
            if !curvature.is_finite() {
                return Err(PatchError::BadFrame);
            }
            if curvature.abs() * arc >= FRAC_PI_2 {
                return Err(PatchError::RadiusTooLarge { arc, curvature });
            }
        }
        let mut patch =
            Self { origin, frame, curvatures, arcs, translation: 0.0, semi_axes: DVec2::ZERO };
        patch.semi_axes = patch.reaches(1.0).0;
        Ok(patch)
    }

    /// The same patch with the translation τ along its normal.
    #[must_use]
    pub fn translated(self, translation: f64) -> Self {
        Self { translation, ..self }
    }

    /// The origin P of the frame.
    #[must_use]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// The centre P + τ e₃.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        self.origin + self.translation * self.frame[2]
    }

    /// e₁, e₂ and e₃: both principal directions and the normal.
    #[must_use]
    pub fn frame(&self) -> [DVec3; 3] {
        self.frame
    }

    /// κ₁ and κ₂, positive where convex.
    #[must_use]
    pub fn curvatures(&self) -> [f64; 2] {
        self.curvatures
    }

    /// L₁ and L₂, the lengths of the arcs from the centre to the boundary.
    #[must_use]
    pub fn arcs(&self) -> [f64; 2] {
        self.arcs
    }

    /// τ, the translation along the normal.
    #[must_use]
    pub fn translation(&self) -> f64 {
        self.translation
    }

    /// The semi-axes of the footprint.
    #[must_use]
    pub fn semi_axes(&self) -> [f64; 2] {
        self.semi_axes.to_array()
    }

    /// The larger turning angle |κᵢ Lᵢ| of the two arcs, in radians.
    #[must_use]
    pub fn turn(&self) -> f64 {
        (self.curvatures[0] * self.arcs[0]).abs().max((self.curvatures[1] * self.arcs[1]).abs())
    }

    /// A point of space in the coordinates of the frame, with P as origin.
    #[must_use]
    pub fn to_local(&self, point: DVec3) -> DVec3 {
        self.turn_to_local(point - self.origin)
    }

    /// An offset from P in the coordinates of the frame.
    #[inline]
    pub(crate) fn turn_to_local(&self, offset: DVec3) -> DVec3 {
        let [e1, e2, e3] = self.frame;
        DVec3::new(e1.dot(offset), e2.dot(offset), e3.dot(offset))
    }

    /// The point of space with these coordinates in the frame.
    #[must_use]
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.origin + self.turned(local)
    }

    fn turned(&self, local: DVec3) -> DVec3 {
        let [e1, e2, e3] = self.frame;
        local.x * e1 + local.y * e2 + local.z * e3
    }

    /// A₁ and A₂, and their derivatives by arc length.
    fn reaches(&self, u: f64) -> (DVec2, DVec2) {
        let (a1, c1) = reach(self.curvatures[0], self.arcs[0] * u);
        let (a2, c2) = reach(self.curvatures[1], self.arcs[1] * u);
        (DVec2::new(a1, a2), DVec2::new(c1, c2))
    }

    /// H₁ and H₂.
    fn sagittas(&self, u: f64) -> DVec2 {
        let arm = |i: usize| sagitta(self.curvatures[i], self.arcs[i] * u);
        DVec2::new(arm(0), arm(1))
    }

    /// The point q(u, φ) of the patch in its own frame.
    #[must_use]
    pub fn local_point(&self, u: f64, phi: f64) -> DVec3 {
        let (sin, cos) = phi.sin_cos();
        self.point_of_arms(self.arms(u), sin, cos)
    }

    /// (A₁, A₂) and (H₁, H₂) for a parameter u.
    pub(crate) fn arms(&self, u: f64) -> [DVec2; 2] {
        [self.reaches(u).0, self.sagittas(u)]
    }

    /// The point in the frame of the patch from its arms and the sine and cosine of φ.
    #[inline]
    pub(crate) fn point_of_arms(&self, [reach, sagitta]: [DVec2; 2], sin: f64, cos: f64) -> DVec3 {
        let depth = sagitta.dot(DVec2::new(cos * cos, sin * sin));
        DVec3::new(reach.x * cos, reach.y * sin, self.translation - depth)
    }

    /// The point q(u, φ) of the patch.
    #[must_use]
    pub fn point(&self, u: f64, phi: f64) -> DVec3 {
        self.to_world(self.local_point(u, phi))
    }

    /// The partial derivatives of q by u and by φ.
    #[must_use]
    pub fn partials(&self, u: f64, phi: f64) -> [DVec3; 2] {
        let (sin, cos) = phi.sin_cos();
        let (reach, slope) = self.reaches(u);
        let [l1, l2] = self.arcs;
        let [k1, k2] = self.curvatures;
        let h = self.sagittas(u);
        let fall1 = l1 * (k1 * l1 * u).sin() * cos * cos;
        let fall2 = l2 * (k2 * l2 * u).sin() * sin * sin;
        let by_u = DVec3::new(l1 * slope.x * cos, l2 * slope.y * sin, -fall1 - fall2);
        let by_phi = DVec3::new(-reach.x * sin, reach.y * cos, 2.0 * (h.x - h.y) * sin * cos);
        [self.turned(by_u), self.turned(by_phi)]
    }

    /// The unit normal at q(u, φ), on the side of e₃.
    #[must_use]
    pub fn normal(&self, u: f64, phi: f64) -> DVec3 {
        let [by_u, by_phi] = self.partials(u, phi);
        by_u.cross(by_phi).normalize_or(self.frame[2])
    }

    /// Whether the footprint contains the point (x, y) of the tangent plane.
    #[must_use]
    pub fn contains(&self, x: f64, y: f64) -> bool {
        (DVec2::new(x, y) / self.semi_axes).length_squared() <= 1.0
    }

    /// The parameters u and φ of the point over (x, y) of the tangent plane, on the patch (u ≤ 1) or on
    /// its continuation up to a quarter circle of an arm. `None` beyond.
    ///
    /// Solves (x / A₁(u))² + (y / A₂(u))² = 1 by Newton's method.
    #[must_use]
    pub fn parameters(&self, x: f64, y: f64) -> Option<[f64; 2]> {
        let u = self.parameter_u(DVec2::new(x, y))?;
        let reach = self.reaches(u).0;
        let phi = if u == 0.0 { 0.0 } else { (y / reach.y).atan2(x / reach.x) };
        Some([u, phi])
    }

    /// The height of the patch or its continuation over (x, y) of the tangent plane, including the
    /// translation. `None` where [`Patch::parameters`] is `None`.
    #[must_use]
    pub fn height(&self, x: f64, y: f64) -> Option<f64> {
        self.parameter_u(DVec2::new(x, y)).map(|u| self.height_at(u, DVec2::new(x, y)))
    }

    /// z = τ - κ₁ x² / (1 + cos κ₁L₁u) - κ₂ y² / (1 + cos κ₂L₂u): the third coordinate of q, without
    /// cancellation.
    fn height_at(&self, u: f64, at: DVec2) -> f64 {
        let slope = self.reaches(u).1;
        let [k1, k2] = self.curvatures;
        self.translation - k1 * at.x * at.x / (1.0 + slope.x) - k2 * at.y * at.y / (1.0 + slope.y)
    }

    /// The parameter u over a point of the tangent plane; see [`Patch::parameters`].
    fn parameter_u(&self, at: DVec2) -> Option<f64> {
        let start = (at / DVec2::from_array(self.arcs)).length();
        let end = (self.turn().recip() * FRAC_PI_2).min(start * FRAC_PI_2);
        let rho = |u: f64| (at / self.reaches(u).0).length();
        // False for numbers that are not finite.
        let exists = start == 0.0 || (start <= end && rho(end) <= 1.0 + 1e-12);
        exists.then(|| self.solve_u(at, start, end))
    }

    /// Newton's method on 1 / ρ(u) = 1 with ρ = |(x / A₁, y / A₂)|, from the left end of a bracket. 1 / ρ
    /// is nearly linear and concave, so the iterates stay left of the root.
    fn solve_u(&self, at: DVec2, start: f64, end: f64) -> f64 {
        let arcs = DVec2::from_array(self.arcs);
        let mut u = start;
        for _ in 0..40 {
            if u == 0.0 {
                break;
            }
            let (reach, slope) = self.reaches(u);
            let scaled = at / reach;
            let rho = scaled.length();
            let fall = (scaled * scaled * slope * arcs / reach).element_sum();
            let step = rho * rho * (rho - 1.0) / fall;
            let next = (u + step).clamp(start, end);
            // Convergence is quadratic: the next step would be below rounding.
            let settled = (next - u).abs() <= 1e-9 * u;
            u = if next.is_nan() { end } else { next };
            if settled {
                break;
            }
        }
        u
    }

    /// The height over a point of the footprint; `None` outside, where [`Patch::height`] follows the
    /// continuation.
    #[inline]
    pub(crate) fn height_in_footprint(&self, x: f64, y: f64) -> Option<f64> {
        let at = DVec2::new(x, y);
        self.contains(x, y).then(|| {
            let start = (at / DVec2::from_array(self.arcs)).length();
            self.height_at(self.solve_u(at, start, start.max(1.0)), at)
        })
    }

    /// The patch as an oriented elliptical disc.
    #[must_use]
    pub fn splat(&self) -> Splat {
        let [e1, e2, e3] = self.frame;
        Splat {
            center: self.center().to_array(),
            normal: e3.to_array(),
            axes: [(self.semi_axes.x * e1).to_array(), (self.semi_axes.y * e2).to_array()],
        }
    }
}
