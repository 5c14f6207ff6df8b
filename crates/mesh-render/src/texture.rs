//! Materials and their pictures, as the rasteriser samples them.

use image::RgbaImage;
#[cfg(feature = "textures")]
use mesh_io::{Alpha, ImageData, Material, Model};

#[cfg(feature = "textures")]
use crate::error::RenderError;

/// Colours and pictures of the faces of a mesh.
#[derive(Clone, Debug, Default)]
pub struct Texture {
    images: Vec<Sampled>,
    faces: Vec<Skin>,
}

/// A picture, and the opacity below which the surface is cut out.
#[derive(Clone, Debug)]
struct Sampled {
    pixels: RgbaImage,
    cutoff: f32,
}

/// How a face is painted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skin {
    /// What the picture is multiplied with, from 0 to 1.
    pub color: [f32; 3],
    /// Which picture, if any.
    pub image: Option<u32>,
    /// Where in the picture the corners are; the origin is at its lower left.
    pub uvs: [[f32; 2]; 3],
}

impl Skin {
    /// Light grey.
    const BARE: Self = Self { color: [0.8; 3], image: None, uvs: [[0.0; 2]; 3] };
}

impl Texture {
    /// A chessboard of so many squares across the picture, for looking at texture coordinates.
    /// Squares differ in hue from one to the next, so that they can be told apart.
    #[must_use]
    pub fn chessboard(squares: u32, uvs: impl IntoIterator<Item = [[f32; 2]; 3]>) -> Self {
        let size = 2048;
        let squares = squares.clamp(1, size);
        let pixels = RgbaImage::from_fn(size, size, |x, y| {
            let [i, j] = [x, y].map(|p| p * squares / size);
            let tint = |n: u32| (55.0 * f64::from(n % squares) / f64::from(squares)) as u8;
            let base = if (i + j) % 2 == 0 { 200 } else { 90 };
            image::Rgba([base + tint(i), base, base + tint(j), 255])
        });
        let skin = |uvs: [[f32; 2]; 3]| match uvs.as_flattened().iter().all(|x| x.is_finite()) {
            true => Skin { color: [1.0; 3], image: Some(0), uvs },
            false => Skin::BARE,
        };
        let images = vec![Sampled { pixels, cutoff: 0.0 }];
        Self { images, faces: uvs.into_iter().map(skin).collect() }
    }

    /// The number of faces it is for.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// How a face is painted, by its index; light grey beyond the last one.
    #[must_use]
    pub fn skin(&self, face: usize) -> Skin {
        self.faces.get(face).copied().unwrap_or(Skin::BARE)
    }

    /// The colour of a picture at a place, from the four nearest pixels; the picture repeats.
    /// `None` where it is cut out.
    pub(crate) fn sample(&self, image: u32, [u, v]: [f32; 2]) -> Option<[f32; 3]> {
        let Some(Sampled { pixels, cutoff }) = self.images.get(image as usize) else {
            return Some([1.0; 3]);
        };
        let (width, height) = pixels.dimensions();
        let (x, y) = (u * width as f32 - 0.5, (1.0 - v) * height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let mut sums = [0.0; 4];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let near = |distance: f32, step: i64| if step == 0 { 1.0 - distance } else { distance };
            let weight = near(x - left, dx) * near(y - top, dy);
            let column = (left as i64).saturating_add(dx).rem_euclid(i64::from(width)) as u32;
            let row = (top as i64).saturating_add(dy).rem_euclid(i64::from(height)) as u32;
            for (sum, value) in sums.iter_mut().zip(pixels.get_pixel(column, row).0) {
                *sum += weight * f32::from(value) / 255.0;
            }
        }
        let [r, g, b, opacity] = sums;
        (opacity >= *cutoff).then_some([r, g, b])
    }
}

#[cfg(feature = "textures")]
impl Texture {
    /// The materials of a model on the faces of the mesh that was built from it, `None` if it has
    /// neither materials nor texture coordinates.
    ///
    /// `face_source` and `corner_source` are those of the mesh's provenance. `load` finds the bytes
    /// of pictures that are in files of their own, by the name that the model gives; where it
    /// returns `None`, the material is drawn without its picture. Nothing is read that `load` does
    /// not read.
    ///
    /// # Errors
    /// A picture is no PNG or JPEG.
    pub fn of_model(
        model: &Model,
        face_source: &[u32],
        corner_source: &[[u32; 3]],
        load: impl Fn(&str) -> Option<Vec<u8>>,
    ) -> Result<Option<Self>, RenderError> {
        if model.corner_uvs.is_none() && model.face_materials.is_none() {
            return Ok(None);
        }
        let mut texture = Self::default();
        let mut painted = Vec::with_capacity(model.materials.len());
        for material in &model.materials {
            let image = texture.picture_of(material, model, &load)?;
            let [r, g, b, _] = material.base_color;
            painted.push(([r, g, b].map(srgb), image));
        }
        let plain = ([0.8; 3], None);
        let skin = |(face, corners): (&u32, &[u32; 3])| {
            let material = model.face_materials.as_ref().and_then(|all| all.get(*face as usize));
            let (color, image) =
                material.and_then(|id| painted.get(*id as usize)).copied().unwrap_or(plain);
            let uv = |corner: u32| model.corner_uvs.as_ref()?.get(corner as usize).copied();
            let uvs = match corners.map(uv) {
                [Some(a), Some(b), Some(c)] => Some([a, b, c]),
                _ => None,
            };
            let uvs = uvs.filter(|uvs| uvs.as_flattened().iter().all(|x| x.is_finite()));
            Skin { color, image: image.filter(|_| uvs.is_some()), uvs: uvs.unwrap_or_default() }
        };
        texture.faces = face_source.iter().zip(corner_source).map(skin).collect();
        Ok(Some(texture))
    }

    /// Decodes the picture of a material; its number, `None` if it is not there.
    fn picture_of(
        &mut self,
        material: &Material,
        model: &Model,
        load: &impl Fn(&str) -> Option<Vec<u8>>,
    ) -> Result<Option<u32>, RenderError> {
        let image = material.base_color_image.and_then(|i| model.images.get(i as usize));
        let Some(image) = image else { return Ok(None) };
        let (name, loaded) = match &image.data {
            ImageData::Bytes(_) => (&image.name, None),
            ImageData::Uri(uri) => (uri, load(uri)),
        };
        let bytes = match &image.data {
            ImageData::Bytes(bytes) => bytes,
            ImageData::Uri(_) => match &loaded {
                Some(bytes) => bytes,
                None => return Ok(None),
            },
        };
        let decoded = image::load_from_memory(bytes).map_err(|source| RenderError::Texture {
            name: name.clone(),
            source: Box::new(source),
        })?;
        let cutoff = match material.alpha {
            Alpha::Mask(cutoff) => cutoff,
            _ => 0.0,
        };
        self.images.push(Sampled { pixels: decoded.to_rgba8(), cutoff });
        Ok(Some((self.images.len() - 1) as u32))
    }
}

/// Light to what pictures store.
#[cfg(feature = "textures")]
fn srgb(linear: f32) -> f32 {
    linear.clamp(0.0, 1.0).powf(1.0 / 2.2)
}
