//! What can be written: models, and whatever becomes one.

use crate::model::{Model, ModelError};
use mesh_core::{PolygonSoup, TriMesh};
use std::borrow::Cow;

/// Something that can be written to a file: a [`Model`], or a mesh or a soup, which have positions
/// and faces and nothing else.
///
/// Implement it for a mesh type of your own, and [`write()`](crate::write()) takes it.
pub trait ToModel {
    /// The model; borrowed where there is one already.
    ///
    /// # Errors
    /// When it would be too large for the 32-bit indices of a model.
    fn to_model(&self) -> Result<Cow<'_, Model>, ModelError>;
}

impl ToModel for Model {
    fn to_model(&self) -> Result<Cow<'_, Model>, ModelError> {
        Ok(Cow::Borrowed(self))
    }
}

impl ToModel for Cow<'_, Model> {
    fn to_model(&self) -> Result<Cow<'_, Model>, ModelError> {
        Ok(Cow::Borrowed(self))
    }
}

impl ToModel for PolygonSoup {
    fn to_model(&self) -> Result<Cow<'_, Model>, ModelError> {
        Ok(Cow::Owned(self.clone().into()))
    }
}

/// Vertices and faces keep their order; the gaps that edits have left are closed.
impl ToModel for TriMesh {
    fn to_model(&self) -> Result<Cow<'_, Model>, ModelError> {
        Ok(Cow::Owned(self.into()))
    }
}
