//! Reading a file of any format.

use crate::error::{ReadError, ReadErrorKind, quote};
use crate::input::Input;
use crate::{Format, Model};
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

/// How many bytes tell the format.
const HEAD: usize = 4096;

/// How to read.
#[derive(Clone, Debug, Default)]
pub struct ReadOptions {
    /// The format; found out from the content, then the extension, when absent.
    pub format: Option<Format>,
    /// The folder that file names in the content (material libraries, buffers) are relative to;
    /// without it, files that the content names are not read. [`read`] takes the file's folder.
    pub folder: Option<PathBuf>,
    /// The length of the stream in bytes. When known, headers that promise more than that are
    /// refused at once, and binary STL that starts with `solid` is recognised by its length.
    pub size: Option<u64>,
}

/// Reads a mesh file.
///
/// # Errors
/// A [`ReadError`] that names the file, the place in it, what was expected and what was found.
pub fn read(path: impl AsRef<Path>) -> Result<Model, ReadError> {
    read_with(path, &ReadOptions::default())
}

/// Reads a mesh file as the options say.
///
/// # Errors
/// As [`read`].
pub fn read_with(path: impl AsRef<Path>, options: &ReadOptions) -> Result<Model, ReadError> {
    let path = path.as_ref();
    let open = || -> Result<Model, ReadError> {
        let mut file = File::open(path).map_err(ReadErrorKind::Io)?;
        let metadata = file.metadata().map_err(ReadErrorKind::Io)?;
        let options = ReadOptions {
            folder: options.folder.clone().or_else(|| path.parent().map(Path::to_owned)),
            size: options.size.or_else(|| metadata.is_file().then_some(metadata.len())),
            ..options.clone()
        };
        read_stream(&mut file, &options, Some(path))
    };
    open().map_err(|error| error.at_path(path))
}

/// Reads a mesh from a stream, which need not be buffered.
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
    let mut input = Input::new(reader, options.size);
    let head = input.peek(HEAD)?;
    // A stream that ends within the head has told its length.
    let size = options.size.or_else(|| (head.len() < HEAD).then_some(head.len() as u64));
    let Some(format) = options.format.or_else(|| Format::detect(head, size, path)) else {
        let found = quote(&head[..head.len().min(16)]);
        return Err(ReadErrorKind::UnknownFormat { found }.into());
    };
    let folder = options.folder.as_deref();
    let model = match format {
        Format::Ply => crate::ply::read(&mut input),
        Format::Stl => crate::stl::read(&mut input, size),
        Format::Off => crate::off::read(&mut input),
        #[cfg(feature = "obj")]
        Format::Obj => crate::obj::read(&mut input, folder),
        #[cfg(feature = "gltf")]
        Format::Gltf | Format::Glb => crate::gltf::read(&mut input, folder),
        #[cfg(not(all(feature = "obj", feature = "gltf")))]
        format => {
            let _ = folder;
            Err(ReadErrorKind::FormatDisabled(format))
        }
    }?;
    Ok(model)
}
