//! Which pictures of materials are loaded, and how often.
#![allow(clippy::unwrap_used)]

use std::fs;
use std::path::Path;

use mesh_io::{
    External, Image, ImageData, Material, Model, PictureError, PictureFormat, PictureOptions,
    Pictures, copy_pictures,
};

/// The start of a PNG file of this size: the signature, and the header without its checksum.
fn png([width, height]: [u32; 2], depth: u8) -> Vec<u8> {
    let mut bytes = b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR".to_vec();
    bytes.extend(width.to_be_bytes());
    bytes.extend(height.to_be_bytes());
    bytes.extend([depth, 2, 0, 0, 0]);
    bytes
}

/// A JPEG file of this size: a comment, tables, padding, and a progressive frame.
fn jpeg([width, height]: [u16; 2]) -> Vec<u8> {
    let mut bytes = b"\xFF\xD8\xFF\xFE\0\x06abcd\xFF\xC4\0\x03x\xFF\xFF\xFF\xC2\0\x11\x08".to_vec();
    bytes.extend(height.to_be_bytes());
    bytes.extend(width.to_be_bytes());
    bytes.extend([3; 10]);
    bytes
}

fn webp(chunk: &[u8; 4], header: &[u8]) -> Vec<u8> {
    let size = (header.len() as u32).to_le_bytes();
    [b"RIFF\0\0\0\0WEBP", &chunk[..], &size, header].concat()
}

/// A model with a material for each image.
fn model(images: impl IntoIterator<Item = ImageData>) -> Model {
    let image = |data| Image { name: String::new(), media_type: String::new(), data };
    let images: Vec<Image> = images.into_iter().map(image).collect();
    let material = |image| Material { base_color_image: Some(image), ..Material::default() };
    let materials = (0..images.len() as u32).map(material).collect();
    Model { images, materials, ..Model::default() }
}

fn within(folder: &Path) -> PictureOptions {
    PictureOptions { folder: Some(folder.to_owned()), ..PictureOptions::default() }
}

#[test]
fn formats_and_sizes_are_those_of_the_first_bytes() {
    use PictureFormat::{Jpeg, Ktx2, Png, WebP};
    let lossless = [0x2F, 0x0F, 0xC0, 0x04, 0];
    let lossy = [0, 0, 0, 0x9D, 0x01, 0x2A, 0x10, 0x40, 0x14, 0x80];
    let extended = [0, 0, 0, 0, 0x0F, 0, 0, 0x13, 0, 0];
    let ktx = [&b"\xABKTX 20\xBB\r\n\x1a\n\0\0\0\0\x01\0\0\0\x10\0\0\0\x14\0\0\0"[..], &[0; 40]];
    let cases = [
        (png([16, 20], 8), Png),
        (jpeg([16, 20]), Jpeg),
        (webp(b"VP8L", &lossless), WebP),
        (webp(b"VP8 ", &lossy), WebP),
        (webp(b"VP8X", &extended), WebP),
        (ktx.concat(), Ktx2),
    ];
    for (bytes, format) in cases {
        assert_eq!(PictureFormat::of(&bytes), Some(format));
        assert_eq!(format.size(&bytes), Some([16, 20]), "{format:?}");
        for end in 0..bytes.len() {
            let _ = format.size(&bytes[..end]);
        }
        for place in 0..bytes.len() {
            let mut changed = bytes.clone();
            changed[place] ^= 0xFF;
            let _ = format.size(&changed);
        }
    }
    for other in [&b""[..], b"PNG", b"GIF89a", b"<svg>", b"BM", b"RIFF\0\0\0\0WAVE"] {
        assert_eq!(PictureFormat::of(other), None);
    }
}

#[test]
fn a_size_that_the_file_does_not_account_for_is_refused() {
    let lying = || model([ImageData::Bytes(png([20_000, 20_000], 8))]);
    let pictures = Pictures::of_model(&lying(), &PictureOptions::default());
    let [(name, PictureError::Memory { needed, limit, .. })] = &pictures.left_out[..] else {
        panic!("{:?}", pictures.left_out)
    };
    assert_eq!((&**name, *needed), ("image 0", 1_600_000_000));
    assert!((64 << 20..65 << 20).contains(limit));
    assert_eq!((pictures.pictures.len(), pictures.of_image(0)), (0, None));
    let more = PictureOptions { max_memory: Some(1_600_000_000), ..PictureOptions::default() };
    assert_eq!(Pictures::of_model(&lying(), &more).pictures.len(), 1);
    // 16 bits per channel take twice as much.
    let deep = model([ImageData::Bytes(png([20_000, 20_000], 16))]);
    assert_eq!(Pictures::of_model(&deep, &more).pictures.len(), 0);
    // The sum counts, not the size of each.
    let sizes = (0..40).map(|i| ImageData::Bytes(png([1500, 1500 + i], 8)));
    let pictures = Pictures::of_model(&model(sizes), &PictureOptions::default());
    assert_eq!((pictures.pictures.len(), pictures.left_out.len()), (7, 33));
}

#[test]
fn each_content_is_there_once() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.png", "b.png"] {
        fs::write(folder.path().join(name), png([8, 8], 8)).unwrap();
    }
    let names = (0..60).map(|i| ImageData::Uri(["a.png", "b.png"][i % 2].into()));
    let images = names.chain([ImageData::Bytes(png([8, 8], 8)), ImageData::Bytes(png([8, 9], 8))]);
    let pictures = Pictures::of_model(&model(images), &within(folder.path()));
    assert_eq!(pictures.pictures.len(), 2);
    assert!((0..61).all(|image| pictures.of_image(image) == Some(0)));
    assert_eq!((pictures.of_image(61), pictures.of_image(62)), (Some(1), None));
    assert!(pictures.pictures[0].is_file && !pictures.pictures[1].is_file);
}

#[test]
fn only_pictures_in_the_folder_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let below = folder.path().join("in");
    fs::create_dir_all(below.join(".ssh")).unwrap();
    for (name, content) in [
        ("in/.ssh/key", png([8, 8], 8)),
        ("in/.hidden.png", png([8, 8], 8)),
        ("outside.png", png([8, 8], 8)),
        ("in/secret.png", b"root:x:0:0".to_vec()),
        ("in/short", b"\x89PN".to_vec()),
        ("in/no-size.png", b"\x89PNG\r\n\x1a\nxxxxxxxx".to_vec()),
        ("in/good.png", png([8, 8], 8)),
    ] {
        fs::write(folder.path().join(name), content).unwrap();
    }
    let names = [
        ".ssh/key",
        "./.ssh/key",
        ".hidden.png",
        "../outside.png",
        "secret.png",
        "short",
        "no-size.png",
        "missing.png",
        "good.png",
    ];
    let used = model(names.map(|name| ImageData::Uri(name.into())));
    let pictures = Pictures::of_model(&used, &within(&below));
    let reasons: Vec<&PictureError> = pictures.left_out.iter().map(|(_, why)| why).collect();
    use PictureError::{Header, Hidden, NoPicture, Read};
    assert!(
        matches!(
            reasons[..],
            [Hidden, Hidden, Hidden, Read(_), NoPicture, NoPicture, Header, Read(_)]
        ),
        "{reasons:?}"
    );
    assert_eq!(pictures.of_image(8), Some(0));
    // No folder, no files; and only images used by a material.
    let nowhere = Pictures::of_model(&used, &PictureOptions::default());
    assert!(nowhere.pictures.is_empty());
    let unused = Model { materials: Vec::new(), ..used };
    let pictures = Pictures::of_model(&unused, &within(&below));
    assert!(pictures.pictures.is_empty() && pictures.left_out.is_empty());
    // A format that the caller cannot use.
    let webp = model([ImageData::Bytes(webp(b"VP8L", &[0x2F, 0, 0, 0, 0]))]);
    let formats = &[PictureFormat::Png];
    let pictures = Pictures::of_model(&webp, &PictureOptions { formats, ..Default::default() });
    assert_eq!(pictures.left_out[0].1, PictureError::Format(PictureFormat::WebP));
}

/// Thousands of names of one large file would make loading quadratic.
#[test]
fn a_file_with_many_names_is_read_once() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("in")).unwrap();
    fs::write(folder.path().join("in/a.png"), png([20_000, 20_000], 8)).unwrap();
    let names = ["in/a.png", "./in/a.png", "in//a.png", "in\\.\\a.png", "in/././a.png"];
    let used = model(names.map(|name| ImageData::Uri(name.into())));
    let pictures = Pictures::of_model(&used, &within(folder.path()));
    // A file that was read again would be left out again.
    let [(name, PictureError::Memory { .. })] = &pictures.left_out[..] else {
        panic!("{:?}", pictures.left_out)
    };
    assert_eq!(name, "in/a.png");
    fs::write(folder.path().join("in/a.png"), png([20, 20], 8)).unwrap();
    let pictures = Pictures::of_model(&used, &within(folder.path()));
    assert!(pictures.pictures.len() == 1 && (0..5).all(|i| pictures.of_image(i) == Some(0)));
}

#[cfg(unix)]
#[test]
fn links_to_hidden_files_are_not_followed() {
    let folder = tempfile::tempdir().unwrap();
    // A hidden folder above the model hides nothing.
    let inner = folder.path().join(".models");
    fs::create_dir_all(inner.join(".private")).unwrap();
    for name in [".private/a.png", ".b.png", "c.png"] {
        fs::write(inner.join(name), png([8, 8], 8)).unwrap();
    }
    for (link, target) in [
        ("folder", ".private"),
        ("a.png", ".private/a.png"),
        ("b.png", ".b.png"),
        ("d.png", "c.png"),
    ] {
        std::os::unix::fs::symlink(target, inner.join(link)).unwrap();
    }
    let names = ["folder/a.png", "a.png", "b.png", "c.png", "d.png"];
    let used = model(names.map(|name| ImageData::Uri(name.into())));
    for external in [External::Folder, External::Any] {
        let options = PictureOptions { external, ..within(&inner) };
        let pictures = Pictures::of_model(&used, &options);
        let hidden = pictures.left_out.iter().filter(|(_, why)| *why == PictureError::Hidden);
        assert_eq!((hidden.count(), pictures.left_out.len()), (3, 3), "{external:?}");
        assert_eq!([3, 4].map(|image| pictures.of_image(image)), [Some(0); 2]);
    }
}

/// A decoder of progressive pictures keeps 16 bits for each number of the whole picture, besides its pixels.
#[test]
fn the_working_memory_of_decoders_is_counted_once() {
    // A frame, and a scan of some components.
    let file = |frame: u8, scan: u8, [width, height]: [u16; 2]| {
        let mut bytes = b"\xFF\xD8\xFF".to_vec();
        bytes.extend([frame, 0, 17, 8]);
        bytes.extend([height.to_be_bytes(), width.to_be_bytes()].concat());
        bytes.extend([3, 1, 17, 0, 2, 17, 0, 3, 17, 0, 0xFF, 0xDA, 0, 8, scan]);
        ImageData::Bytes(bytes)
    };
    let needed = |image: ImageData, are_decoded: bool| {
        let options = PictureOptions { max_memory: Some(1), are_decoded, ..Default::default() };
        let pictures = Pictures::of_model(&model([image]), &options);
        match pictures.left_out[..] {
            [(_, PictureError::Memory { needed, .. })] => needed,
            _ => panic!("{:?}", pictures.left_out),
        }
    };
    let size = [100, 10];
    for (frame, scan, bytes) in [(0xC0, 3, 4), (0xC0, 1, 10), (0xC1, 3, 4), (0xC2, 3, 10)] {
        assert_eq!(needed(file(frame, scan, size), true), 1000 * bytes, "{frame:X} {scan}");
        assert_eq!(needed(file(frame, scan, size), false), 4000);
    }
    assert_eq!(needed(ImageData::Bytes(png([100, 10], 8)), true), 4000);
    // Pictures are decoded one after the other: the largest one counts.
    let three = || model([[100, 10], [100, 11], [100, 9]].map(|size| file(0xC2, 3, size)));
    for (max_memory, count) in [(4 * 3000 + 6 * 1100, 3), (4 * 3000 + 6 * 1100 - 1, 2)] {
        let options = PictureOptions {
            max_memory: Some(max_memory),
            are_decoded: true,
            ..PictureOptions::default()
        };
        assert_eq!(Pictures::of_model(&three(), &options).pictures.len(), count);
    }
}

/// Pictures go to the same names in another folder; nothing else does, and nothing is replaced.
#[test]
fn pictures_are_copied_and_nothing_else() {
    let root = tempfile::tempdir().unwrap();
    let (from, to) = (root.path().join("from"), root.path().join("to"));
    for folder in ["from/a/b", "from/.git", "to"] {
        fs::create_dir_all(root.path().join(folder)).unwrap();
    }
    let picture = png([16, 20], 8);
    let pictures = ["wood.png", "a/b/deep.png", "same.png", "other.png"];
    for name in pictures.iter().chain(&[".hidden.png", ".git/x.png", "../outside.png"]) {
        fs::write(from.join(name), &picture).unwrap();
    }
    fs::write(from.join("secret.png"), "-----BEGIN OPENSSH PRIVATE KEY-----").unwrap();
    fs::write(to.join("same.png"), &picture).unwrap();
    fs::write(to.join("other.png"), "mine").unwrap();
    let outside = root.path().join("outside.png").display().to_string();
    let refused = [
        ".git/x.png",
        ".hidden.png",
        "../outside.png",
        &outside,
        "a",
        "missing.png",
        "other.png",
        "secret.png",
    ];
    let names: Vec<&str> =
        pictures.into_iter().chain(refused).chain(["wood.png", "other.png"]).collect();
    let result = copy_pictures(&names, &from, &to);
    assert_eq!(result.copied, [to.join("a/b/deep.png"), to.join("wood.png")]);
    for name in ["a/b/deep.png", "wood.png", "same.png"] {
        assert_eq!(fs::read(to.join(name)).unwrap(), picture, "{name}");
    }
    assert_eq!(fs::read(to.join("other.png")).unwrap(), b"mine");
    let mut left_out: Vec<&str> = result.left_out.iter().map(|(name, _)| name.as_str()).collect();
    left_out.sort_unstable();
    let mut expected = refused.to_vec();
    expected.sort_unstable();
    assert_eq!(left_out, expected, "{:?}", result.left_out);
    let why = |name| result.left_out.iter().find(|left| left.0 == name).map(|left| &left.1);
    assert_eq!(why("other.png"), Some(&PictureError::Taken));
    assert_eq!(why("secret.png"), Some(&PictureError::NoPicture));
    assert_eq!(why(".git/x.png"), Some(&PictureError::Hidden));
    let count = |folder: &Path| fs::read_dir(folder).unwrap().count();
    assert_eq!([count(&to), count(&to.join("a")), count(&to.join("a/b"))], [4, 1, 1]);
    // A second time, or within one folder, there is nothing to do.
    assert!(copy_pictures(&pictures[..3], &from, &to).copied.is_empty());
    assert_eq!(copy_pictures(&names, &from, &from.join("a/..")), Default::default());
}

/// A link in the folder of the output is not followed.
#[cfg(unix)]
#[test]
fn pictures_are_not_copied_through_links() {
    let root = tempfile::tempdir().unwrap();
    let (from, to, other) =
        (root.path().join("from"), root.path().join("to"), root.path().join("other"));
    for folder in [&from.join("a/b"), &to, &other] {
        fs::create_dir_all(folder).unwrap();
    }
    for name in ["a/b/x.png", "y.png"] {
        fs::write(from.join(name), png([16, 20], 8)).unwrap();
    }
    std::os::unix::fs::symlink(&other, to.join("a")).unwrap();
    std::os::unix::fs::symlink(other.join("new.png"), to.join("y.png")).unwrap();
    let result = copy_pictures(&["a/b/x.png", "y.png"], &from, &to);
    assert!(result.copied.is_empty());
    assert!(
        result.left_out.iter().any(|left| left.0 == "a/b/x.png" && left.1 == PictureError::Taken)
    );
    assert_eq!(result.left_out.len(), 2);
    assert_eq!(fs::read_dir(&other).unwrap().count(), 0);
}
