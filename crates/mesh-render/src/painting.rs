//! Colours for pictures: from values, from the content of a file, or from texture coordinates.

use mesh_core::build::Provenance;
use mesh_core::{FaceMap, TriMesh, VertexMap};
use mesh_io::{Model, Pictures, color_in_bytes};

use crate::error::RenderError;
use crate::labels::Labels;
use crate::legend::Legend;
use crate::scale::ScaleOptions;
use crate::scene::Paint;
use crate::texture::Texture;

/// Colours that are computed before a [`Scene`](crate::Scene) borrows them.
///
/// The mesh in the picture is built from `model`; `provenance` holds the vertex, face or corner of
/// the model that each element of the mesh comes from.
#[derive(Clone, Debug)]
pub enum Painting {
    /// No colours.
    Plain,
    /// Colours of the vertices, and the legend of the values that they show.
    Vertices(VertexMap<[u8; 3]>, Option<Legend>),
    /// Colours of the faces, and the legend of the values that they show.
    Faces(FaceMap<[u8; 3]>, Option<Legend>),
    /// Materials and textures.
    Texture(Texture),
}

impl Painting {
    /// The colours in the content: of the vertices, else of the faces, else the materials. `pictures` loads the
    /// pictures of the materials, if they are needed.
    ///
    /// # Errors
    /// An image cannot be decoded.
    pub fn of_content(
        model: &Model,
        provenance: &Provenance,
        pictures: impl FnOnce() -> Pictures,
    ) -> Result<Self, RenderError> {
        match Self::of_colors(model, provenance) {
            Some(colors) => Ok(colors),
            None => Ok(Self::of_materials(model, provenance, &pictures())?.unwrap_or(Self::Plain)),
        }
    }

    /// The colours of the vertices, else of the faces; `None` if the content has neither.
    #[must_use]
    pub fn of_colors(model: &Model, provenance: &Provenance) -> Option<Self> {
        let eight_bits = |c: &[f32; 4]| {
            let [r, g, b, _] = color_in_bytes(c);
            [r, g, b]
        };
        if let Some(colors) = &model.vertex_colors {
            let of = |&v: &u32| eight_bits(&colors[v as usize]);
            let colors = provenance.vertex_source.iter().map(of).collect();
            return Some(Self::Vertices(VertexMap::from_vec(colors), None));
        }
        let colors = model.face_colors.as_ref()?;
        let of = |&f: &u32| eight_bits(&colors[f as usize]);
        let colors = provenance.face_source.iter().map(of).collect();
        Some(Self::Faces(FaceMap::from_vec(colors), None))
    }

    /// The materials with their textures; `None` if the content has none.
    ///
    /// # Errors
    /// An image cannot be decoded.
    pub fn of_materials(
        model: &Model,
        provenance: &Provenance,
        pictures: &Pictures,
    ) -> Result<Option<Self>, RenderError> {
        let (faces, corners) = (&provenance.face_source, &provenance.corner_source);
        Ok(Texture::of_model(model, faces, corners, pictures)?.map(Self::Texture))
    }

    /// Colours of values, one for each vertex of the model. The scale is signed if there are values on
    /// both sides of zero.
    #[must_use]
    pub fn of_vertex_values(
        provenance: &Provenance,
        values: &[f64],
        options: ScaleOptions,
    ) -> Self {
        let (colors, legend) = colors(values, &provenance.vertex_source, options);
        Self::Vertices(VertexMap::from_vec(colors), Some(legend))
    }

    /// Colours of values, one for each face of the model. The scale is signed if there are values on
    /// both sides of zero.
    #[must_use]
    pub fn of_face_values(provenance: &Provenance, values: &[f64], options: ScaleOptions) -> Self {
        let (colors, legend) = colors(values, &provenance.face_source, options);
        Self::Faces(FaceMap::from_vec(colors), Some(legend))
    }

    /// Colours of labels, one for each vertex of the model.
    #[must_use]
    pub fn of_vertex_labels(provenance: &Provenance, labels: &[f64]) -> Self {
        let (colors, legend) = label_colors(labels, &provenance.vertex_source);
        Self::Vertices(VertexMap::from_vec(colors), Some(legend))
    }

    /// Colours of labels, one for each face of the model.
    #[must_use]
    pub fn of_face_labels(provenance: &Provenance, labels: &[f64]) -> Self {
        let (colors, legend) = label_colors(labels, &provenance.face_source);
        Self::Faces(FaceMap::from_vec(colors), Some(legend))
    }

    /// A colour for each component of the mesh, numbered from 0.
    #[must_use]
    pub fn of_components(mesh: &TriMesh) -> Self {
        let components = mesh.topology().components();
        let number = |&component: &Option<u32>| component.map_or(f64::NAN, f64::from);
        let numbers: Vec<f64> = components.of_vertex.as_slice().iter().map(number).collect();
        let labels = Labels::of(numbers.iter().copied());
        let colors = numbers.iter().map(|&x| labels.color(x)).collect();
        Self::Vertices(VertexMap::from_vec(colors), Some(Legend::Labels(labels)))
    }

    /// A chessboard with `squares` squares along each side of the texture; `None` without texture
    /// coordinates.
    #[must_use]
    pub fn chessboard(model: &Model, provenance: &Provenance, squares: u32) -> Option<Self> {
        let uvs = model.corner_uvs.as_ref()?;
        let corners = provenance.corner_source.iter().map(|c| c.map(|c| uvs[c as usize]));
        Some(Self::Texture(Texture::chessboard(squares, corners)))
    }

    /// The paint of a scene.
    #[must_use]
    pub fn paint(&self) -> Paint<'_> {
        match self {
            Self::Plain => Paint::Clay,
            Self::Vertices(colors, Some(Legend::Labels(_))) => Paint::Labels(colors),
            Self::Vertices(colors, _) => Paint::Vertices(colors),
            Self::Faces(colors, _) => Paint::Faces(colors),
            Self::Texture(texture) => Paint::Texture(texture),
        }
    }

    /// The legend of the values.
    #[must_use]
    pub fn legend(&self) -> Option<&Legend> {
        match self {
            Self::Vertices(_, legend) | Self::Faces(_, legend) => legend.as_ref(),
            _ => None,
        }
    }
}

fn colors(values: &[f64], sources: &[u32], options: ScaleOptions) -> (Vec<[u8; 3]>, Legend) {
    let values: Vec<f64> = sources.iter().map(|&source| values[source as usize]).collect();
    let signed = values.iter().any(|&x| x < 0.0) && values.iter().any(|&x| x > 0.0);
    let scale = ScaleOptions { signed, ..options }.fit(values.iter().copied());
    (values.iter().map(|&x| scale.color(x)).collect(), Legend::Scale(scale))
}

fn label_colors(values: &[f64], sources: &[u32]) -> (Vec<[u8; 3]>, Legend) {
    let values: Vec<f64> = sources.iter().map(|&source| values[source as usize]).collect();
    let labels = Labels::of(values.iter().copied());
    (values.iter().map(|&x| labels.color(x)).collect(), Legend::Labels(labels))
}
