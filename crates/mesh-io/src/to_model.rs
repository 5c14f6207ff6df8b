//! Types that can be written: models, soups and meshes.

use crate::model::{Model, ModelError};
use mesh_core::{PolygonSoup, TriMesh};
use std::borrow::Cow;

/// A type that can be written to a file: a [`Model`], or a mesh or soup without attributes.
///
/// [`write()`](crate::write()) accepts every type that implements it.
pub trait ToModel {
    /// The model, borrowed if possible.
    ///
    /// # Errors
    /// The mesh is too large for the 32-bit indices of a model.
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

/// Vertices and faces keep their order; gaps are closed.
impl ToModel for TriMesh {
    fn to_model(&self) -> Result<Cow<'_, Model>, ModelError> {
        Ok(Cow::Owned(self.into()))
    }
}
