//! The textures of a mesh file, as the rasteriser samples them.

use std::path::Path;

use image::RgbImage;
use mesh_core::build::Provenance;
use mesh_io::{ImageData, Model};

use crate::failure::Failure;

/// Instead of the number of a picture, where a face has none.
pub(crate) const NO_IMAGE: f32 = -1.0;

/// Colours and pictures of the faces of a mesh.
#[derive(Debug)]
pub(crate) struct Texture {
    images: Vec<RgbImage>,
    /// Per face: the colour, the picture if any, and where in the picture its corners are.
    faces: Vec<Skin>,
}

/// How a face is painted.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Skin {
    pub(crate) color: [f32; 3],
    pub(crate) image: f32,
    /// The origin is at the lower left of the picture.
    pub(crate) uvs: [[f32; 2]; 3],
}

impl Texture {
    /// The materials of a file on the faces of the mesh that was built from it, `None` if it has
    /// neither materials nor texture coordinates. With `squares`, faces with texture coordinates
    /// get a chessboard of so many squares across the picture instead.
    pub(crate) fn of(
        model: &Model,
        provenance: &Provenance,
        folder: &Path,
        squares: Option<u32>,
    ) -> Result<Option<Self>, Failure> {
        if model.corner_uvs.is_none() && model.face_materials.is_none() {
            return Ok(None);
        }
        let mut texture = Self { images: Vec::new(), faces: Vec::new() };
        let pictures: Vec<Option<f32>> = match squares {
            Some(squares) => {
                texture.images.push(chessboard(squares));
                Vec::new()
            }
            None => texture.load(model, folder)?,
        };
        let sources = provenance.face_source.iter().zip(&provenance.corner_source);
        for (&face, corners) in sources {
            let material = model.face_materials.as_ref().map(|all| all[face as usize]);
            let material = material.and_then(|id| model.materials.get(id as usize));
            let uvs = model.corner_uvs.as_ref().map(|all| corners.map(|c| all[c as usize]));
            let uvs = uvs.filter(|uvs| uvs.as_flattened().iter().all(|x| x.is_finite()));
            let of_material =
                || pictures.get(material?.base_color_image? as usize).copied().flatten();
            let image = if squares.is_some() { Some(0.0) } else { of_material() };
            let [r, g, b, _] = material.map_or([0.8; 4], |m| m.base_color);
            let color = if squares.is_some() { [1.0; 3] } else { [r, g, b].map(srgb) };
            texture.faces.push(Skin {
                color,
                image: image.filter(|_| uvs.is_some()).unwrap_or(NO_IMAGE),
                uvs: uvs.unwrap_or_default(),
            });
        }
        Ok(Some(texture))
    }

    /// Decodes the pictures; the place of each, `None` for those that are not there.
    fn load(&mut self, model: &Model, folder: &Path) -> Result<Vec<Option<f32>>, Failure> {
        let mut places = Vec::new();
        for picture in &model.images {
            let bytes = match &picture.data {
                ImageData::Bytes(bytes) => Some(bytes.clone()),
                ImageData::Uri(uri) => std::fs::read(folder.join(uri)).ok(),
            };
            let decoded = bytes.map(|bytes| image::load_from_memory(&bytes)).transpose();
            let decoded = decoded.map_err(|source| Failure::Picture {
                path: folder.join(&picture.name),
                source: Box::new(source),
            })?;
            places.push(decoded.map(|picture| {
                self.images.push(picture.to_rgb8());
                (self.images.len() - 1) as f32
            }));
        }
        Ok(places)
    }

    /// How a face is painted, by its index.
    pub(crate) fn skin(&self, face: usize) -> Skin {
        let bare = Skin { color: [0.8; 3], image: NO_IMAGE, uvs: [[0.0; 2]; 3] };
        self.faces.get(face).copied().unwrap_or(bare)
    }

    /// The colour of a picture at a place, from the four nearest pixels; the picture repeats.
    pub(crate) fn sample(&self, image: f32, [u, v]: [f32; 2]) -> [f32; 3] {
        let Some(picture) = self.images.get(image.round() as usize) else { return [1.0; 3] };
        let (width, height) = picture.dimensions();
        let x = u * width as f32 - 0.5;
        let y = (1.0 - v) * height as f32 - 0.5;
        let mut color = [0.0; 3];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let (px, py) = (x.floor() as i64 + dx, y.floor() as i64 + dy);
            let weight = (1.0 - (x - px as f32).abs()) * (1.0 - (y - py as f32).abs());
            let column = px.rem_euclid(i64::from(width)) as u32;
            let row = py.rem_euclid(i64::from(height)) as u32;
            for (sum, &value) in color.iter_mut().zip(&picture.get_pixel(column, row).0) {
                *sum += weight * f32::from(value) / 255.0;
            }
        }
        color
    }
}

/// Light to what pictures store.
fn srgb(linear: f32) -> f32 {
    linear.clamp(0.0, 1.0).powf(1.0 / 2.2)
}

/// A chessboard whose squares differ in hue from one to the next, so that they can be told apart.
fn chessboard(squares: u32) -> RgbImage {
    let size = 2048;
    let squares = squares.clamp(1, size);
    RgbImage::from_fn(size, size, |x, y| {
        let [i, j] = [x, y].map(|p| p * squares / size);
        let tint = |n: u32| (55.0 * f64::from(n % squares) / f64::from(squares)) as u8;
        let base = if (i + j) % 2 == 0 { 200 } else { 90 };
        image::Rgb([base + tint(i), base, base + tint(j)])
    })
}
