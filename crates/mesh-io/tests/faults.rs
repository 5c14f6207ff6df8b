//! Truncated streams, full disks and vanishing targets, for every format and encoding.
#![cfg(all(feature = "obj", feature = "gltf"))]
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use mesh_io::{
    Encoding, Format, Image, ImageData, Model, ReadErrorKind, ReadOptions, Scalars, WriteError,
    WriteOptions, read_from, stage, write, write_levels, write_to,
};
use std::io::{Error, ErrorKind, Read, Write};

const WAYS: [(Format, Encoding); 12] = [
    (Format::Obj, Encoding::Text),
    (Format::Ply, Encoding::Text),
    (Format::Ply, Encoding::LittleEndian),
    (Format::Ply, Encoding::BigEndian),
    (Format::Stl, Encoding::Text),
    (Format::Stl, Encoding::LittleEndian),
    (Format::Off, Encoding::Text),
    (Format::Off, Encoding::BigEndian),
    (Format::Gltf, Encoding::Text),
    (Format::Gltf, Encoding::Usual),
    (Format::Glb, Encoding::LittleEndian),
    (Format::Glb, Encoding::Usual),
];

fn options(encoding: Encoding) -> WriteOptions {
    WriteOptions { encoding, ..WriteOptions::default() }
}

/// Two triangles and a quad with every attribute.
fn rich() -> Model {
    let obj = "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nv 0 0 1.25 1 1 1\n\
        v 1 1 0.1 0 0 0\nvt 0 0\nvt 1 0\nvt 0.5 1\nvn 0 0 1\nvn 1 0 0\no body\ng a\nusemtl red\n\
        f 1/1/1 2/2/1 3/3/1\nf 1/1/2 4/2/2 2/3/2\ng b\nusemtl blue\nf 2/1/1 5/2/1 3/3/1 4/1/2\n";
    let mut model = read_from(&mut obj.as_bytes(), &ReadOptions::default()).unwrap();
    model.vertex_normals = Some(vec![[0.0, 0.0, 1.0]; 5]);
    let values = vec![0.5, 1.5, 2.5, 0.1, 1e9];
    model.vertex_scalars.push(Scalars::new("quality", values));
    model.face_scalars.push(Scalars::new("area", vec![1.0, 2.0, 3.0]));
    model.face_colors = Some(vec![[0.0, 0.5, 1.0, 1.0]; 3]);
    model.materials[0].base_color = [1.0, 0.0, 0.0, 1.0];
    model.materials[0].base_color_image = Some(0);
    let data = ImageData::Bytes(b"\x89PNG\r\n\x1a\n, not really".to_vec());
    model.images = vec![Image { name: "paint".into(), media_type: "image/png".into(), data }];
    model
}

/// Accepts `room` bytes, then the disk is full; sometimes accepts only a part of a buffer.
struct FullDisk {
    room: usize,
    calls: usize,
}

impl Write for FullDisk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.calls += 1;
        if self.calls.is_multiple_of(5) {
            return Err(ErrorKind::Interrupted.into());
        }
        if self.room == 0 {
            return Err(ErrorKind::StorageFull.into());
        }
        let step = bytes.len().min(self.room).min(7);
        self.room -= step;
        Ok(step)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// Accepts everything, and fails on flush.
struct LateDisk;

impl Write for LateDisk {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Err(ErrorKind::StorageFull.into())
    }
}

#[test]
fn a_disk_that_is_full_at_any_byte_is_an_error_in_every_format() {
    let model = rich();
    for (format, encoding) in WAYS {
        let options = options(encoding);
        let mut whole = Vec::new();
        write_to(&mut whole, &model, format, &options).unwrap();
        for room in 0..whole.len() {
            let mut disk = FullDisk { room, calls: 0 };
            let result = write_to(&mut disk, &model, format, &options);
            let Err(WriteError::Io { source, .. }) = result else {
                panic!("{format} {encoding:?} at byte {room}: {result:?}")
            };
            assert_eq!(source.kind(), ErrorKind::StorageFull, "{format} {encoding:?} {room}");
        }
        let mut disk = FullDisk { room: whole.len(), calls: 0 };
        assert!(write_to(&mut disk, &model, format, &options).is_ok(), "{format} {encoding:?}");
        let late = write_to(&mut LateDisk, &model, format, &options);
        assert!(matches!(late, Err(WriteError::Io { .. })), "{format} {encoding:?}");
    }
}

/// Returns a number of bytes, in pieces of any size, then fails.
struct BadDisk<'b> {
    bytes: &'b [u8],
    random: fastrand::Rng,
}

impl Read for BadDisk<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        if self.bytes.is_empty() {
            return Err(Error::other("bad sector"));
        }
        if self.random.u8(..4) == 0 {
            return Err(ErrorKind::Interrupted.into());
        }
        let most = buffer.len().min(self.bytes.len());
        let step = self.random.usize(1..=most);
        buffer[..step].copy_from_slice(&self.bytes[..step]);
        self.bytes = &self.bytes[step..];
        Ok(step)
    }
}

/// The part read so far is no mesh, because the file is longer.
#[test]
fn a_read_error_at_any_byte_is_an_error_in_every_format() {
    let model = rich();
    for (format, encoding) in WAYS {
        let mut whole = Vec::new();
        write_to(&mut whole, &model, format, &options(encoding)).unwrap();
        for length in 0..whole.len() {
            let random = fastrand::Rng::with_seed(length as u64);
            let mut disk = BadDisk { bytes: &whole[..length], random };
            let options = ReadOptions { format: Some(format), ..ReadOptions::default() };
            let error = read_from(&mut disk, &options).expect_err("half a file");
            let is_io = matches!(&error.kind, ReadErrorKind::Io(source) if source.to_string() == "bad sector");
            assert!(is_io, "{format} {encoding:?} at byte {length}: {error}");
        }
    }
}

fn names(folder: &std::path::Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<_> =
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

#[test]
fn a_target_that_goes_away_is_an_error_in_every_format() {
    let model = rich();
    for &format in Format::ALL {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("folder");
        let path = folder.join("mesh").with_extension(format.extension());
        // There is no folder.
        assert!(matches!(
            write(&path, &model, &WriteOptions::default()),
            Err(WriteError::Io { .. })
        ));
        // It disappears while the file is written.
        std::fs::create_dir(&folder).unwrap();
        let staged = stage(&path, &model, &WriteOptions::default()).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert!(matches!(staged.commit(), Err(WriteError::Io { .. })), "{format}");
        // A folder appears in its place.
        std::fs::create_dir(&folder).unwrap();
        let staged = stage(&path, &model, &WriteOptions::default()).unwrap();
        std::fs::create_dir(&path).unwrap();
        std::fs::write(path.join("note"), "mine").unwrap();
        assert!(matches!(staged.commit(), Err(WriteError::Io { .. })), "{format}");
        assert_eq!(std::fs::read(path.join("note")).unwrap(), b"mine");
        let stray = names(&folder).iter().any(|name| name.starts_with(".mesh-io-"));
        assert!(!stray, "{format}: {:?}", names(&folder));
    }
}

/// Functions that write into the target, and writes that are refused half-way, after the temporary file exists.
#[test]
fn a_failed_write_leaves_the_old_file_and_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let record = folder.path().join("run.lod");
    std::fs::write(&record, "old").unwrap();
    let failed = mesh_io::replace_file(&record, |writer| {
        writer.write_all(&[0; 100_000])?;
        Err(Error::other("no"))
    });
    assert!(matches!(failed, Err(WriteError::Io { path: Some(_), .. })));
    let levels = folder.path().join("levels.glb");
    std::fs::write(&levels, "old").unwrap();
    let mut far = rich();
    far.soup.positions_mut()[1].x = 1e39;
    let failed = write_levels(&levels, &[rich(), far], &[0.5, 0.0], &WriteOptions::default());
    assert!(matches!(failed, Err(WriteError::OutOfSingleRange { vertex: 1, .. })), "{failed:?}");
    assert_eq!(names(folder.path()), ["levels.glb", "run.lod"]);
    assert_eq!(std::fs::read(&levels).unwrap(), b"old");
    assert_eq!(std::fs::read(&record).unwrap(), b"old");
}
