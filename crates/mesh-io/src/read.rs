//! Reading a file of any format.

use crate::budget::Budget;
use crate::error::{ReadError, ReadErrorKind};
use crate::external::{External, Files};
use crate::input::Input;
use crate::text::quote;
use crate::{Format, Model};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// The number of bytes that are examined to detect the format.
const HEAD: usize = 4096;

/// Options of the readers. The defaults are safe for untrusted files.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "serde", derive(serde::Serialize, serde::Deserialize))]
#[cfg_attr(feature = "serde", serde(default, deny_unknown_fields))]
pub struct ReadOptions {
    /// The format. By default it is detected by the content, then by the extension.
    pub format: Option<Format>,
    /// The folder to which file names in the content are relative (material libraries, buffers). [`read`] and
    /// [`read_with`] use the folder of the file by default. A stream has no folder: without this option,
    /// [`read_from`] reads no other file, whatever `external` says.
    pub folder: Option<PathBuf>,
    /// Which files named in the content are read.
    pub external: External,
    /// The length of the stream in bytes. If it is known, a header that announces more is refused at once, and
    /// binary STL that starts with `solid` is recognised. [`read`] and [`read_with`] use the length of the file.
    pub size: Option<u64>,
    /// Limit in bytes for the memory of the model and of the reader. An upper bound of the need is compared with
    /// it. The default is 64 MiB plus 60 bytes for each byte of the file and of the files that it names. That is
    /// enough except for scenes that draw one mesh very often.
    pub max_memory: Option<u64>,
    /// Whether a file without vertices and faces is an empty model. By default it is an error
    /// ([`ReadErrorKind::Empty`]).
    pub allow_empty: bool,
}

/// Reads a mesh file.
///
/// # Errors
/// A [`ReadError`] that names the file, the place in it, what was expected and what was found.
pub fn read(path: impl AsRef<Path>) -> Result<Model, ReadError> {
    read_with(path, &ReadOptions::default())
}

/// Reads a mesh file with these options.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Model, ReadError> {
    let path = path.as_ref();
    let read = || -> Result<Model, ReadError> {
        let (mut file, options) = open(path, options)?;
        read_stream(&mut file, &options, Some(path))
    };
    read().map_err(|error| error.at_path(path))
}

/// Opens a file, and adds its known properties to the options.
pub(crate) fn open(path: &Path, options: &ReadOptions) -> Result<(File, ReadOptions), ReadError> {
    let file = File::open(path).map_err(ReadErrorKind::Io)?;
    let metadata = file.metadata().map_err(ReadErrorKind::Io)?;
    let options = ReadOptions {
        folder: options.folder.clone().or_else(|| path.parent().map(Path::to_owned)),
        size: options.size.or_else(|| metadata.is_file().then_some(metadata.len())),
        ..options.clone()
    };
    Ok((file, options))
}

/// Reads a mesh from a stream, which need not be buffered. Files named in the content are read only if the options name
/// their folder.
///
/// # Errors
/// As [`read`]; the error has no path.
pub fn read_from(reader: &mut dyn Read, options: &ReadOptions) -> Result<Model, ReadError> {
    read_stream(reader, options, None)
}

fn read_stream(
    reader: &mut dyn Read,
    options: &ReadOptions,
    path: Option<&Path>,
) -> Result<Model, ReadError> {
    let mut input = Input::new(reader, options.size, Budget::new(options.max_memory));
    let (format, size) = detect(&mut input, options, path)?;
    let files = Files { folder: options.folder.as_deref(), external: options.external };
    let mut model = match format {
        Format::Ply => crate::ply::read(&mut input),
        Format::Stl => crate::stl::read(&mut input, size),
        Format::Off => crate::off::read(&mut input),
        #[cfg(feature = "obj")]
        Format::Obj => crate::obj::read(&mut input, &files),
        #[cfg(feature = "gltf")]
        Format::Gltf | Format::Glb => crate::gltf::read(&mut input, &files),
        #[cfg(not(all(feature = "obj", feature = "gltf")))]
        format => {
            let _ = files;
            Err(ReadErrorKind::FormatDisabled(format))
        }
    }?;
    crate::color_range::to_unit_range(&mut model);
    crate::whole_numbers::mark_labels(&mut model);
    let empty = model.soup.vertex_count() == 0 && model.soup.face_count() == 0;
    if empty && !options.allow_empty {
        return Err(ReadErrorKind::Empty { notes: model.notes }.into());
    }
    Ok(model)
}

/// The format of the input, and its length if known.
pub(crate) fn detect(
    input: &mut Input<'_>,
    options: &ReadOptions,
    path: Option<&Path>,
) -> Result<(Format, Option<u64>), ReadErrorKind> {
    let head = input.peek(HEAD)?;
    // A stream that ends within the head has a known length.
    let size = options.size.or_else(|| (head.len() < HEAD).then_some(head.len() as u64));
    match options.format.or_else(|| Format::detect(head, size, path)) {
        Some(format) => Ok((format, size)),
        None => {
            let found = quote(&head[..head.len().min(16)]);
            let known = FOREIGN.iter().find(|(start, _)| head.starts_with(start));
            let what = known.map(|(_, what)| format!(" ({what})"));
            Err(ReadErrorKind::UnknownFormat { found: found + &what.unwrap_or_default() })
        }
    }
}

/// The first bytes of files that people take for meshes, and what to do with such a file.
const FOREIGN: [(&[u8], &str); 8] = [
    (b"\x1f\x8b", "packed by gzip: unpack it first"),
    (b"PK\x03\x04", "a ZIP archive, as 3MF and USDZ files are: unpack or export the mesh first"),
    (b"BZh", "packed by bzip2: unpack it first"),
    (b"\xfd7zXZ", "packed by xz: unpack it first"),
    (b"\x28\xb5\x2f\xfd", "packed by zstd: unpack it first"),
    (b"Kaydara FBX", "FBX: export it as glTF first"),
    (b"BLENDER", "a Blender file: export it as glTF first"),
    (b"ISO-10303-21", "STEP, which has exact surfaces: export triangles from a CAD program first"),
];
