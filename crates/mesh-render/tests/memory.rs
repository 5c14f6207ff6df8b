//! The memory of decoded pictures.
#![allow(clippy::unwrap_used)]

use std::io::Cursor;

use image::{DynamicImage, ImageBuffer, ImageFormat};
use mesh_io::{Image, ImageData, Material, Model, PictureOptions, Pictures};
use mesh_render::Texture;
use peak_alloc::PeakAlloc;

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

const SIDE: u32 = 2000;
/// A decoder may need this much besides the pixels.
const WORK: usize = 20 << 20;

fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

/// A triangle with one picture.
fn textured(bytes: Vec<u8>) -> (Model, Pictures) {
    let image =
        Image { name: String::new(), media_type: String::new(), data: ImageData::Bytes(bytes) };
    let material = Material { base_color_image: Some(0), ..Material::default() };
    let model = Model {
        corner_uvs: Some(vec![[0.0; 2]; 3]),
        images: vec![image],
        materials: vec![material],
        ..Model::default()
    };
    let options = PictureOptions { are_decoded: true, ..PictureOptions::default() };
    let pictures = Pictures::of_model(&model, &options);
    assert_eq!(pictures.left_out, []);
    (model, pictures)
}

/// Whether decoding succeeds, and the peak of the memory for it.
fn decode(bytes: Vec<u8>) -> (bool, usize) {
    let (model, pictures) = textured(bytes);
    let before = MEMORY.current_usage();
    MEMORY.reset_peak_usage();
    let texture = Texture::of_model(&model, &[0], &[[0, 1, 2]], &pictures);
    (texture.is_ok(), MEMORY.peak_usage() - before)
}

fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let mut sum = u32::MAX;
    for byte in kind.iter().chain(data) {
        sum ^= u32::from(*byte);
        for _ in 0..8 {
            sum = if sum & 1 == 1 { 0xEDB8_8320 ^ (sum >> 1) } else { sum >> 1 };
        }
    }
    let length = u32::try_from(data.len()).unwrap();
    [&length.to_be_bytes(), &kind[..], data, &(!sum).to_be_bytes()].concat()
}

/// One test, because the allocator counts for all threads.
#[test]
fn decoded_pictures_take_the_memory_of_their_pixels() {
    use ImageFormat::{Jpeg, Png};
    let images: [(DynamicImage, ImageFormat, usize); 6] = [
        (ImageBuffer::<image::Luma<u16>, _>::new(SIDE, SIDE).into(), Png, 2),
        (ImageBuffer::<image::Rgb<u8>, _>::new(SIDE, SIDE).into(), Png, 3),
        (ImageBuffer::<image::Rgb<u8>, _>::new(SIDE, SIDE).into(), Jpeg, 3),
        (ImageBuffer::<image::Rgba<u8>, _>::new(SIDE, SIDE).into(), Png, 4),
        (ImageBuffer::<image::Rgb<u16>, _>::new(SIDE, SIDE).into(), Png, 6),
        (ImageBuffer::<image::Rgba<u16>, _>::new(SIDE, SIDE).into(), Png, 8),
    ];
    let pixels = (SIDE * SIDE) as usize;
    for (image, format, bytes) in images {
        let (is_read, peak) = decode(encoded(&image, format));
        assert!(is_read && peak < bytes * pixels + WORK, "{:?}: {peak}", image.color());
    }
    // A profile of 64 MiB: deflate blocks that repeat a zero, 1032 times smaller.
    let png = encoded(&ImageBuffer::<image::Rgb<u8>, _>::new(SIDE, SIDE).into(), Png);
    let zeros = encoded(&ImageBuffer::<image::Luma<u8>, _>::new(8192, 8192).into(), Png);
    let mut data = Vec::new();
    let mut rest = &zeros[8..];
    while let Some(length) = rest.first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        if &rest[4..8] == b"IDAT" {
            data.extend(&rest[8..8 + length]);
        }
        rest = &rest[12 + length..];
    }
    let profile = chunk(b"iCCP", &[b"x\0\0", &data[..]].concat());
    // After the signature and the header.
    let (is_read, peak) = decode([&png[..33], &profile, &png[33..]].concat());
    assert!(peak < 3 * pixels + 2 * WORK, "{is_read}: {peak}");
}
