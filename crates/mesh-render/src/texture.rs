//! Materials and their pictures, in the form that the rasteriser samples.

#[cfg(feature = "textures")]
use std::io::Cursor;

use image::{DynamicImage, GenericImageView, RgbaImage};
#[cfg(feature = "textures")]
use image::{
    ImageDecoder, Limits,
    codecs::{jpeg::JpegDecoder, png::PngDecoder},
};
#[cfg(feature = "textures")]
use mesh_core::as_u32;
#[cfg(feature = "textures")]
use mesh_io::{Alpha, Model, Picture, PictureFormat, Pictures};

#[cfg(feature = "textures")]
use crate::error::RenderError;

/// Colours and pictures of the faces of a mesh.
#[derive(Clone, Debug, Default)]
pub struct Texture {
    /// In the form in which the files have them: a copy with four channels would need the memory a second time.
    pictures: Vec<DynamicImage>,
    images: Vec<Sampled>,
    faces: Vec<Skin>,
}

/// The index of a picture, and the opacity below which the surface is cut out.
#[derive(Clone, Copy, Debug)]
struct Sampled {
    picture: u32,
    cutoff: f32,
}

/// The paint of a face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Skin {
    /// The factor of the picture, from 0 to 1.
    pub color: [f32; 3],
    /// The index of the image of the texture, if any.
    pub image: Option<u32>,
    /// The corners in the picture; the origin is at its lower left.
    pub uvs: [[f32; 2]; 3],
}

impl Skin {
    /// Light grey.
    const BARE: Self = Self { color: [0.8; 3], image: None, uvs: [[0.0; 2]; 3] };
}

impl Texture {
    /// A chessboard of `squares` squares along each side of the picture, to inspect texture coordinates. Squares differ
    /// in hue, so that they can be distinguished.
    #[must_use]
    pub fn chessboard(squares: u32, uvs: impl IntoIterator<Item = [[f32; 2]; 3]>) -> Self {
        let size = 2048;
        let squares = squares.clamp(1, size);
        let pixels = RgbaImage::from_fn(size, size, |x, y| {
            let [i, j] = [x, y].map(|p| p * squares / size);
            #[expect(
                clippy::cast_possible_truncation,
                clippy::cast_sign_loss,
                reason = "55 at most"
            )]
            let tint = |n: u32| (55.0 * f64::from(n % squares) / f64::from(squares)) as u8;
            let base = if (i + j) % 2 == 0 { 200 } else { 90 };
            image::Rgba([base + tint(i), base, base + tint(j), 255])
        });
        let skin = |uvs: [[f32; 2]; 3]| match uvs.as_flattened().iter().all(|x| x.is_finite()) {
            true => Skin { color: [1.0; 3], image: Some(0), uvs },
            false => Skin::BARE,
        };
        let images = vec![Sampled { picture: 0, cutoff: 0.0 }];
        Self { pictures: vec![pixels.into()], images, faces: uvs.into_iter().map(skin).collect() }
    }

    /// The number of faces.
    #[must_use]
    pub fn face_count(&self) -> usize {
        self.faces.len()
    }

    /// The paint of a face, by its index; light grey beyond the last one.
    #[must_use]
    pub fn skin(&self, face: usize) -> Skin {
        self.faces.get(face).copied().unwrap_or(Skin::BARE)
    }

    /// The colour of a picture at a place, interpolated between the four nearest pixels; the picture repeats. `None` if
    /// it is cut out there.
    pub(crate) fn sample(&self, image: u32, [u, v]: [f32; 2]) -> Option<[f32; 3]> {
        let image = self.images.get(image as usize);
        let pixels = image.and_then(|image| self.pictures.get(image.picture as usize));
        let (Some(Sampled { cutoff, .. }), Some(pixels)) = (image, pixels) else {
            return Some([1.0; 3]);
        };
        let (width, height) = pixels.dimensions();
        let (x, y) = (u * width as f32 - 0.5, (1.0 - v) * height as f32 - 0.5);
        let (left, top) = (x.floor(), y.floor());
        let mut sums = [0.0; 4];
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let near = |distance: f32, step: i64| if step == 0 { 1.0 - distance } else { distance };
            let weight = near(x - left, dx) * near(y - top, dy);
            #[expect(clippy::cast_possible_truncation, reason = "below the width")]
            let column = (left as i64).saturating_add(dx).rem_euclid(i64::from(width)) as u32;
            #[expect(clippy::cast_possible_truncation, reason = "below the height")]
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
    /// The formats that can be decoded.
    pub const FORMATS: &'static [PictureFormat] = &[PictureFormat::Png, PictureFormat::Jpeg];

    /// The materials of a model on the faces of the mesh that was built from it; `None` if it has neither materials nor
    /// texture coordinates.
    ///
    /// `face_source` and `corner_source` are the faces and corners of the mesh's provenance. A material whose picture
    /// was omitted is drawn without it.
    ///
    /// # Errors
    /// A picture cannot be decoded, or is larger than its header states.
    pub fn of_model(
        model: &Model,
        face_source: &[u32],
        corner_source: &[[u32; 3]],
        pictures: &Pictures,
    ) -> Result<Option<Self>, RenderError> {
        if model.corner_uvs.is_none() && model.face_materials.is_none() {
            return Ok(None);
        }
        let decoded = pictures.pictures.iter().map(decode).collect::<Result<_, _>>()?;
        let mut texture = Self { pictures: decoded, ..Self::default() };
        let mut painted = Vec::with_capacity(model.materials.len());
        for material in &model.materials {
            let cutoff = match material.alpha {
                Alpha::Mask(cutoff) => cutoff,
                _ => 0.0,
            };
            let picture = material.base_color_image.and_then(|image| pictures.of_image(image));
            let image = picture.map(|picture| {
                texture.images.push(Sampled { picture, cutoff });
                as_u32(texture.images.len() - 1)
            });
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
}

/// Decodes a picture within the memory that its header justifies.
#[cfg(feature = "textures")]
fn decode(picture: &Picture) -> Result<DynamicImage, RenderError> {
    let [width, height] = picture.size;
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(width), Some(height));
    // Texts and a profile may take 16 MiB, however many pixels there are. Some rows are in memory twice.
    limits.max_alloc = Some((16 << 20) + 32 * u64::from(width));
    let bytes = Cursor::new(&picture.bytes);
    let decoded = match picture.format {
        PictureFormat::Jpeg => JpegDecoder::new(bytes).and_then(|mut decoder| {
            decoder.set_limits(limits)?;
            DynamicImage::from_decoder(decoder)
        }),
        // The decoder refuses other formats.
        _ => PngDecoder::with_limits(bytes, limits).and_then(DynamicImage::from_decoder),
    };
    decoded.map_err(|source| RenderError::Texture {
        name: picture.name.clone(),
        source: Box::new(source),
    })
}

/// Converts linear light to the sRGB values of pictures.
#[cfg(feature = "textures")]
fn srgb(linear: f32) -> f32 {
    linear.clamp(0.0, 1.0).powf(1.0 / 2.2)
}

#[cfg(test)]
mod tests {
    use image::{DynamicImage, GenericImageView, ImageBuffer, Luma};

    /// A pixel that is converted when it is sampled is the pixel of the converted picture.
    #[test]
    fn pixels_have_eight_bits() {
        let deep = DynamicImage::from(ImageBuffer::from_fn(256, 256, |x, y| {
            Luma([u16::try_from(256 * y + x).unwrap()])
        }));
        let converted = deep.to_rgba8();
        assert!(deep.pixels().all(|(x, y, pixel)| pixel == *converted.get_pixel(x, y)));
    }
}
