//! Models from data loaded by the crate `gltf`.

use super::accessor::Bytes;
use super::read::{parse, read_root};
use crate::budget::Budget;
use crate::error::{ReadError, ReadErrorKind};
use crate::input::Input;
use crate::model::Model;
use crate::notes::Notes;
use std::ops::Deref;
use std::sync::Arc;

impl Model {
    /// The model of a document that the crate `gltf` has loaded, with the bytes of its buffers in the order
    /// of the document: `Vec<Vec<u8>>`, or the `Vec<gltf::buffer::Data>` that `gltf::import` returns.
    ///
    /// Images are stored as in the document: embedded ones as encoded bytes, others by name.
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// # let triangle = mesh_core::PolygonSoup::from_triangles(
    /// #     &[glam::DVec3::ZERO, glam::DVec3::X, glam::DVec3::Y], &[[0, 1, 2]])?;
    /// # let mut glb = Vec::new();
    /// # mesh_io::write_to(&mut glb, &triangle, mesh_io::Format::Glb, &Default::default())?;
    /// let gltf::Gltf { document, blob } = gltf::Gltf::from_slice(&glb)?;
    /// let buffers: Vec<Vec<u8>> = blob.into_iter().collect();
    /// let model = mesh_io::Model::from_gltf(&document, &buffers)?;
    /// assert_eq!(model.soup.face_count(), 1);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`read_from`](crate::read_from): an index is out of range, or a required extension is not supported.
    pub fn from_gltf<B: Deref<Target: AsRef<[u8]>>>(
        document: &gltf::Document,
        buffers: &[B],
    ) -> Result<Self, ReadError> {
        let json = document.as_json().to_vec().map_err(|error| {
            ReadErrorKind::malformed(super::accessor::at("the document"), "JSON", error.to_string())
        })?;
        let root = parse(&json)?;
        let bytes = |buffer: &B| {
            let all: &[u8] = (**buffer).as_ref();
            let all = all.to_vec();
            Bytes { length: all.len(), all: Arc::new(all) }
        };
        let buffers = buffers.iter().map(bytes).collect();
        let mut nothing: &[u8] = &[];
        // The caller that loaded the document has already accepted its size.
        let mut input = Input::new(&mut nothing, Some(0), Budget::new(Some(u64::MAX)));
        let mut model = read_root(root, buffers, Notes::default(), &mut input)?;
        crate::color_range::to_unit_range(&mut model);
        Ok(model)
    }
}
