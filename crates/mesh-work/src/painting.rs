//! Colours for pictures: of values, of the content itself, of texture coordinates.

use mesh_core::{FaceMap, VertexMap};
use mesh_render::{Paint, RenderError, Scale, ScaleOptions, Texture};

use crate::loaded::Source;

/// Colours that are made before a scene borrows them.
#[derive(Clone, Debug)]
pub enum Painting {
    /// None.
    Plain,
    /// Of the vertices, and the scale that they follow if they show values.
    Vertices(VertexMap<[u8; 3]>, Option<Scale>),
    /// Of the faces, likewise.
    Faces(FaceMap<[u8; 3]>, Option<Scale>),
    /// Materials and textures.
    Texture(Texture),
}

impl Painting {
    /// What the content itself has: colours of vertices, of faces, then materials; `load` finds the
    /// bytes of pictures in files of their own.
    ///
    /// # Errors
    /// A picture cannot be decoded.
    pub fn of_content(
        source: Source<'_>,
        load: impl Fn(&str) -> Option<Vec<u8>>,
    ) -> Result<Self, RenderError> {
        match Self::of_colors(source) {
            Some(colors) => Ok(colors),
            None => Ok(Self::of_materials(source, load)?.unwrap_or(Self::Plain)),
        }
    }

    /// Colours of the vertices, or else of the faces, if the content has any.
    #[must_use]
    pub fn of_colors(Source { model, provenance, .. }: Source<'_>) -> Option<Self> {
        let eight_bits =
            |c: [f32; 4]| [c[0], c[1], c[2]].map(|x| (255.0 * x.clamp(0.0, 1.0)).round() as u8);
        if let Some(colors) = &model.vertex_colors {
            let of = |&v: &u32| eight_bits(colors[v as usize]);
            let colors = provenance.vertex_source.iter().map(of).collect();
            return Some(Self::Vertices(VertexMap::from_vec(colors), None));
        }
        let colors = model.face_colors.as_ref()?;
        let of = |&f: &u32| eight_bits(colors[f as usize]);
        let colors = provenance.face_source.iter().map(of).collect();
        Some(Self::Faces(FaceMap::from_vec(colors), None))
    }

    /// Materials with their textures, if the content has any.
    ///
    /// # Errors
    /// A picture cannot be decoded.
    pub fn of_materials(
        Source { model, provenance, .. }: Source<'_>,
        load: impl Fn(&str) -> Option<Vec<u8>>,
    ) -> Result<Option<Self>, RenderError> {
        let (faces, corners) = (&provenance.face_source, &provenance.corner_source);
        Ok(Texture::of_model(model, faces, corners, load)?.map(Self::Texture))
    }

    /// Values of the vertices of the content; signed if there are some on both sides of zero.
    #[must_use]
    pub fn of_vertex_values(source: Source<'_>, values: &[f64], options: ScaleOptions) -> Self {
        let (colors, scale) = colors(values, &source.provenance.vertex_source, options);
        Self::Vertices(VertexMap::from_vec(colors), Some(scale))
    }

    /// Values of the faces of the content, likewise.
    #[must_use]
    pub fn of_face_values(source: Source<'_>, values: &[f64], options: ScaleOptions) -> Self {
        let (colors, scale) = colors(values, &source.provenance.face_source, options);
        Self::Faces(FaceMap::from_vec(colors), Some(scale))
    }

    /// A chessboard of so many squares over the texture coordinates, if there are any.
    #[must_use]
    pub fn chessboard(Source { model, provenance, .. }: Source<'_>, squares: u32) -> Option<Self> {
        let uvs = model.corner_uvs.as_ref()?;
        let corners = provenance.corner_source.iter().map(|c| c.map(|c| uvs[c as usize]));
        Some(Self::Texture(Texture::chessboard(squares, corners)))
    }

    /// For a scene.
    #[must_use]
    pub fn paint(&self) -> Paint<'_> {
        match self {
            Self::Plain => Paint::Clay,
            Self::Vertices(colors, _) => Paint::Vertices(colors),
            Self::Faces(colors, _) => Paint::Faces(colors),
            Self::Texture(texture) => Paint::Texture(texture),
        }
    }

    /// The scale of values, for a bar of colours.
    #[must_use]
    pub fn scale(&self) -> Option<Scale> {
        match self {
            Self::Vertices(_, scale) | Self::Faces(_, scale) => *scale,
            _ => None,
        }
    }
}

fn colors(values: &[f64], sources: &[u32], options: ScaleOptions) -> (Vec<[u8; 3]>, Scale) {
    let values: Vec<f64> = sources.iter().map(|&source| values[source as usize]).collect();
    let signed = values.iter().any(|&x| x < 0.0) && values.iter().any(|&x| x > 0.0);
    let scale = ScaleOptions { signed, ..options }.fit(values.iter().copied());
    (values.iter().map(|&x| scale.color(x)).collect(), scale)
}
