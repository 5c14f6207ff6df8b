//! The choice between fits of several degrees and scales.
//!
//! Fits at small scales follow noise, fits at large scales miss details. The noise of each fit is known if the noise of
//! the positions is. By Lepski's method (1991, On a problem of adaptive estimation in Gaussian white noise), the fit
//! with the least noise is chosen among those that agree with all noisier fits within the error of both: their noise
//! and, for fits through the vertex, the error of the model as the residuals tell.

use crate::jet_fit::{Covariance, JetFit};

/// A fit, as seen by the choice.
#[derive(Clone, Copy)]
pub(crate) struct Candidate {
    pub(crate) fit: JetFit,
    /// The second derivatives over the tangent plane, by `xx`, `xy` and `yy`. They are linear in the heights, which the
    /// curvatures of a fit with an uncertain slope are not.
    form: [f64; 3],
    /// Standard deviation of the form by noise.
    pub(crate) noise: f64,
    /// Covariance of the form by noise.
    noise_covariance: Covariance,
}

/// The chosen fit and the error of its second fundamental form.
pub(crate) struct Choice {
    pub(crate) fit: JetFit,
    pub(crate) error: f64,
}

impl Candidate {
    /// `noise` is the standard deviation of positions. `None` if the form overflows.
    pub(crate) fn new(fit: JetFit, noise: f64) -> Option<Self> {
        let form = [fit.jet.xx, fit.jet.xy, fit.jet.yy];
        let noise_covariance = fit.noise.combined(noise, &Covariance::default(), 0.0);
        let noise = noise * fit.noise.total().sqrt();
        let is_finite = noise.is_finite() && form.iter().all(|entry| entry.is_finite());
        is_finite.then_some(Self { fit, form, noise, noise_covariance })
    }

    /// The error by the model, from the residuals, and by noise.
    ///
    /// Residuals tell only the order of the error of a model, because the error is no independent noise. The factors
    /// are the ratios of errors to standard deviations at 90 % of the vertices of surfaces with known curvature.
    pub(crate) fn error(&self) -> f64 {
        self.model_error() + 2.0 * self.noise
    }

    pub(crate) fn model_error(&self) -> f64 {
        self.model_factor() * self.fit.model.total().sqrt()
    }

    fn model_factor(&self) -> f64 {
        match self.fit.degree {
            2 => 3.0,
            3 => 4.5,
            _ => 1.5,
        }
    }

    pub(crate) fn distance(&self, other: &Self) -> f64 {
        let [a, b, c] = [0, 1, 2].map(|i| self.form[i] - other.form[i]);
        (a * a + 2.0 * b * b + c * c).sqrt()
    }

    /// Whether the form agrees with each noisier one of `others`, within the error of both.
    ///
    /// Entries are compared by their covariance: along long triangles, points may determine the curvature across
    /// a hundred times better than the curvature along. A fit whose curvature along is uncertain must not excuse
    /// another curvature across.
    pub(crate) fn agrees(&self, others: &[Self]) -> bool {
        let mut noisier = others.iter().filter(|other| other.noise >= self.noise);
        noisier.all(|other| self.agrees_with(other))
    }

    fn agrees_with(&self, other: &Self) -> bool {
        /// How many standard deviations fits may differ. Three independent entries differ by more once in 150 times.
        const AGREEMENT: f64 = 3.5;
        let noise = other.noise_covariance.combined(AGREEMENT, &self.noise_covariance, AGREEMENT);
        let tolerance = noise.combined(1.0, &other.fit.model, other.model_factor());
        let difference = [0, 1, 2].map(|i| self.form[i] - other.form[i]);
        tolerance.deviations(difference) <= 1.0
    }

    /// The slope of the fitted surface against the tangent plane.
    pub(crate) fn slope(&self) -> f64 {
        self.fit.jet.px.hypot(self.fit.jet.py)
    }

    /// The largest entry of the form.
    pub(crate) fn size(&self) -> f64 {
        self.form.iter().fold(0.0, |size, entry| size.max(entry.abs()))
    }
}

/// The candidate with the least predicted error.
pub(crate) fn least_error(candidates: &[Candidate]) -> Option<Candidate> {
    candidates.iter().copied().min_by(|a, b| a.error().total_cmp(&b.error()))
}

/// Chooses by Lepski's method. Sorts the candidates by noise.
pub(crate) fn choose(candidates: &mut [Candidate]) -> Option<Choice> {
    candidates.sort_by(|a, b| b.noise.total_cmp(&a.noise));
    let agrees = |&k: &usize| candidates[k].agrees(&candidates[..k]);
    let chosen = candidates[(0..candidates.len()).rev().find(agrees)?];
    // Fits with at most twice the noise show how far the choice itself may be wrong.
    let similar =
        candidates.iter().filter(|c| (chosen.noise..2.0 * chosen.noise).contains(&c.noise));
    let spread = similar.map(|other| chosen.distance(other)).fold(0.0, f64::max);
    let error = chosen.model_error() + 4.0 * chosen.noise + 3.0 * spread;
    Some(Choice { fit: chosen.fit, error })
}
