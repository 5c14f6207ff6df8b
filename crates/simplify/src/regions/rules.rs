//! What a run in regions goes by.

/// The part of the options that a tile needs.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rules {
    /// Whether errors that have already been made are subtracted; see
    /// [`GarlandHeckbert`](crate::GarlandHeckbert).
    pub(crate) marginal: bool,
    /// Whether vertices go only where they keep the volume; see [`Optimal`](crate::Optimal).
    pub(crate) keep_volume: bool,
    /// Whether boundary edges have quadrics; see [`Boundary`](crate::Boundary).
    pub(crate) border: bool,
    /// See [`NormalGuard`](crate::NormalGuard).
    pub(crate) min_cosine: Option<f64>,
    /// See [`ShapeGuard`](crate::ShapeGuard).
    pub(crate) min_shape: Option<f64>,
    /// Whether collapses are recorded.
    pub(crate) record: bool,
    /// One over the fourth power of the size of the mesh, which is the unit of costs.
    pub(crate) scale: f64,
}
