//! The content of a picture, and its style.

use glam::DVec3;
use mesh_core::{FaceMap, TriMesh, VertexMap};

use crate::error::RenderError;
use crate::texture::Texture;

/// A mesh with colours and lines.
#[derive(Clone, Copy, Debug)]
pub struct Scene<'a> {
    /// The mesh.
    pub mesh: &'a TriMesh,
    /// The colours of its surface.
    pub paint: Paint<'a>,
    /// The faces whose edges are drawn; `None` for all faces.
    pub edged: Option<&'a FaceMap<bool>>,
    /// Lines on the surface or beside it; hidden if the surface is clearly in front of them.
    pub strokes: &'a [Stroke],
}

impl<'a> Scene<'a> {
    /// The mesh alone, light grey.
    #[must_use]
    pub fn of(mesh: &'a TriMesh) -> Self {
        Self { mesh, paint: Paint::Clay, edged: None, strokes: &[] }
    }

    /// Checks that the maps are long enough for the mesh.
    pub(crate) fn check(&self) -> Result<(), RenderError> {
        let topology = self.mesh.topology();
        let (vertices, faces) = (topology.vertex_capacity(), topology.face_capacity());
        let check = |what, found: usize, of, expected| match found < expected {
            true => Err(RenderError::Length { what, found, of, expected }),
            false => Ok(()),
        };
        match self.paint {
            Paint::Vertices(colors) | Paint::Labels(colors) => {
                check("the map of colours", colors.len(), "vertices", vertices)?;
            }
            Paint::Faces(colors) => check("the map of colours", colors.len(), "faces", faces)?,
            Paint::Texture(texture) => check("the texture", texture.face_count(), "faces", faces)?,
            Paint::Clay => {}
        }
        self.edged
            .map_or(Ok(()), |edged| check("the map of edged faces", edged.len(), "faces", faces))
    }
}

/// The paint of the surface.
#[derive(Clone, Copy, Debug, Default)]
#[non_exhaustive]
pub enum Paint<'a> {
    /// Light grey.
    #[default]
    Clay,
    /// A colour per vertex, blended between them.
    Vertices(&'a VertexMap<[u8; 3]>),
    /// A colour per vertex for labels: every place has the colour of its nearest vertex, so that there are no colours
    /// in between.
    Labels(&'a VertexMap<[u8; 3]>),
    /// A colour per face.
    Faces(&'a FaceMap<[u8; 3]>),
    /// Materials with their pictures.
    Texture(&'a Texture),
}

/// A line through points, or a dot at a single one.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
pub struct Stroke {
    /// The points of the line, in model units.
    pub points: Vec<DVec3>,
    /// The colour; it is not lit.
    pub color: [u8; 3],
    /// The width in pixels.
    pub width: f64,
}

/// How a mesh is drawn.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default))]
pub struct Style {
    /// Width and height of the picture in pixels, each up to [`crate::LARGEST_SIDE`].
    pub size: [u32; 2],
    /// One normal per vertex instead of one per face.
    pub smooth: bool,
    /// Width of the drawn edges in pixels; 0 draws none.
    pub edge_width: f64,
    /// Width in pixels of the outlines, where the surface turns away from the camera and at its boundary. 0 draws none.
    pub silhouette_width: f64,
    /// If outlines are drawn, edges with a larger dihedral angle than this are drawn too, in radians.
    pub crease: Option<f64>,
    /// The colour of the background; `None` for transparent.
    pub background: Option<[u8; 3]>,
    /// Samples per pixel and direction, from 1 to 8.
    pub supersampling: u32,
    /// Room around the mesh, as a share of its extent.
    pub margin: f64,
    /// How much darker cavities and creases are (ambient occlusion), from 0 to 1. SVG files have none.
    pub occlusion: f64,
}

impl Style {
    /// 900 by 900 pixels, flat, on white, four samples per pixel.
    pub const DEFAULT: Self = Self {
        size: [900, 900],
        smooth: false,
        edge_width: 0.0,
        silhouette_width: 0.0,
        crease: None,
        background: Some([255; 3]),
        supersampling: 2,
        margin: 0.04,
        occlusion: 0.0,
    };

    pub(crate) fn check(&self) -> Result<(), RenderError> {
        crate::picture::check_size(self.size.map(u64::from))?;
        if !(1..=8).contains(&self.supersampling) {
            return Err(RenderError::Supersampling(self.supersampling));
        }
        let measures = [
            ("the width of edges", self.edge_width),
            ("the width of outlines", self.silhouette_width),
            ("the margin", self.margin),
            ("the crease angle", self.crease.unwrap_or(0.0)),
        ];
        if !(0.0..=1.0).contains(&self.occlusion) {
            return Err(RenderError::Occlusion(self.occlusion));
        }
        match measures.into_iter().find(|(_, value)| !(0.0..=1e6).contains(value)) {
            Some((what, value)) => Err(RenderError::Measure { what, value }),
            None => Ok(()),
        }
    }
}

impl Default for Style {
    fn default() -> Self {
        Self::DEFAULT
    }
}
