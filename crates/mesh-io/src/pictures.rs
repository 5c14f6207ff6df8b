//! The pictures of materials, checked before anybody decodes or embeds them.
//!
//! A model can name any file, and a picture can state any size. So a file is accepted only if it starts as a picture,
//! is not hidden, and the pixels of all pictures fit into the memory limit for their files. Equal contents are stored
//! once, however many materials or names refer to them.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::ffi::OsStr;
use std::fs;
use std::hash::BuildHasher;
use std::io::Read;
use std::path::{Path, PathBuf};

use mesh_core::as_u32;

use crate::budget::{FLOOR, PER_BYTE};
use crate::external::{External, Files, open};
use crate::model::{ImageData, Model};
use crate::picture_format::PictureFormat;

/// Options for loading pictures.
#[derive(Clone, Debug)]
pub struct PictureOptions {
    /// The folder that names of pictures are relative to. Without a folder, only embedded pictures are loaded.
    pub folder: Option<PathBuf>,
    /// Which files of the folder may be opened.
    pub external: External,
    /// The formats that the caller can use.
    pub formats: &'static [PictureFormat],
    /// The limit in bytes for the pixels of all pictures. `None` for 64 MiB plus 60 bytes for each byte of the
    /// pictures.
    pub max_memory: Option<u64>,
    /// Whether the caller decodes the pictures, one after the other. Then the working memory of a decoder is counted,
    /// too.
    pub are_decoded: bool,
}

impl Default for PictureOptions {
    fn default() -> Self {
        Self {
            folder: None,
            external: External::default(),
            formats: PictureFormat::ALL,
            max_memory: None,
            are_decoded: false,
        }
    }
}

/// A picture of a material.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Picture {
    /// The name of the file, or the name within the model.
    pub name: String,
    /// Whether the picture is a file of its own.
    pub is_file: bool,
    /// The format, detected by the first bytes.
    pub format: PictureFormat,
    /// Width and height in pixels, from the header.
    pub size: [u32; 2],
    /// The bytes of the file.
    pub bytes: Vec<u8>,
}

/// The reason why a picture was left out.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum PictureError {
    /// The file cannot be opened or read.
    #[error("{0}")]
    Read(String),
    /// The name has a part that begins with a dot.
    #[error("it is a hidden file; rename it if it is a picture")]
    Hidden,
    /// The first bytes belong to no format of pictures.
    #[error("it does not begin as PNG, JPEG, WebP or KTX2; convert it to PNG")]
    NoPicture,
    /// The caller cannot use the format.
    #[error("{} cannot be shown here; convert it to PNG", .0.name())]
    Format(PictureFormat),
    /// The header does not state a size.
    #[error("its header has no size; write the picture again")]
    Header,
    /// Another file has the place of its copy.
    #[error("another file of this name is there already; remove it, or write to another folder")]
    Taken,
    /// The pixels need too much memory.
    #[error(
        "{} by {} pixels need {} MiB with the pictures before it, and {} MiB are allowed; scale it down, or raise \
         --max-memory",
        size[0], size[1], needed.div_ceil(1 << 20), limit >> 20
    )]
    Memory {
        /// Width and height in pixels.
        size: [u32; 2],
        /// The bytes that it needs with the pictures before it.
        needed: u64,
        /// The bytes that pictures may need.
        limit: u64,
    },
}

/// The pictures of the materials of a model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Pictures {
    /// The pictures, each content once.
    pub pictures: Vec<Picture>,
    /// For each image of the model, its index among the pictures. `None` for images that were left out or that no
    /// material uses.
    pub of_image: Vec<Option<u32>>,
    /// The names of the images that were left out, and why.
    pub left_out: Vec<(String, PictureError)>,
}

impl Pictures {
    /// Loads the pictures that the materials of a model use.
    #[must_use]
    pub fn of_model(model: &Model, options: &PictureOptions) -> Self {
        let mut is_used = vec![false; model.images.len()];
        for image in model.materials.iter().filter_map(|material| material.base_color_image) {
            if let Some(is_used) = is_used.get_mut(image as usize) {
                *is_used = true;
            }
        }
        let mut loader = Loader {
            options,
            folder: options.folder.as_deref().and_then(|folder| {
                fs::canonicalize(if folder == "" { Path::new(".") } else { folder }).ok()
            }),
            by_hash: HashMap::default(),
            file_bytes: 0,
            pixel_bytes: 0,
            working_bytes: 0,
        };
        let (mut of_name, mut of_path) = (HashMap::new(), HashMap::new());
        let mut loaded = Self::default();
        for (number, (image, is_used)) in model.images.iter().zip(is_used).enumerate() {
            let place = match &image.data {
                _ if !is_used => None,
                // The reader has reported that it is missing.
                ImageData::Bytes(bytes) if bytes.is_empty() => None,
                ImageData::Bytes(bytes) => {
                    let name = match &*image.name {
                        "" => format!("image {number}"),
                        name => name.to_owned(),
                    };
                    loaded.add(&mut loader, name, false, |_| Ok(bytes.clone()))
                }
                ImageData::Uri(name) => match of_name.get(name) {
                    Some(known) => *known,
                    None => {
                        let place = loaded.add_file(&mut loader, name, &mut of_path);
                        of_name.insert(name, place);
                        place
                    }
                },
            };
            loaded.of_image.push(place);
        }
        loaded
    }

    /// The picture of an image of the model.
    #[must_use]
    pub fn of_image(&self, image: u32) -> Option<u32> {
        self.of_image.get(image as usize).copied().flatten()
    }

    /// Adds a file. A file can have many names, and is read once.
    fn add_file(
        &mut self,
        loader: &mut Loader<'_>,
        name: &str,
        of_path: &mut HashMap<PathBuf, Option<u32>>,
    ) -> Option<u32> {
        let path = resolve(loader.options, loader.folder.as_deref(), name);
        if let Some(known) = path.as_ref().ok().and_then(|path| of_path.get(path)) {
            return *known;
        }
        let read = |loader: &Loader<'_>| {
            path.as_deref().map_err(Clone::clone).and_then(|path| loader.read(path))
        };
        let place = self.add(loader, name.to_owned(), true, read);
        if let Ok(path) = path {
            of_path.insert(path, place);
        }
        place
    }

    fn add(
        &mut self,
        loader: &mut Loader<'_>,
        name: String,
        is_file: bool,
        read: impl FnOnce(&Loader<'_>) -> Result<Vec<u8>, PictureError>,
    ) -> Option<u32> {
        match read(loader).and_then(|bytes| loader.accept(bytes, &self.pictures)) {
            Ok(Found::Known(place)) => Some(place),
            Ok(Found::New { format, size, bytes }) => {
                self.pictures.push(Picture { name, is_file, format, size, bytes });
                Some(as_u32(self.pictures.len() - 1))
            }
            Err(error) => {
                self.left_out.push((name, error));
                None
            }
        }
    }
}

struct Loader<'o> {
    options: &'o PictureOptions,
    /// The folder, without links.
    folder: Option<PathBuf>,
    /// The index of a picture, by the hash of its content.
    by_hash: HashMap<u64, u32, foldhash::fast::RandomState>,
    /// The bytes of all pictures.
    file_bytes: u64,
    /// The bytes that the pixels of all pictures need.
    pixel_bytes: u64,
    /// The bytes that the decoder of a picture needs besides the pixels, for the picture that needs most.
    working_bytes: u64,
}

/// A content that was accepted.
enum Found {
    Known(u32),
    New { format: PictureFormat, size: [u32; 2], bytes: Vec<u8> },
}

/// The number of bytes that determine a format.
pub(crate) const HEAD: u64 = 12;

/// The path of a file without links. Neither the name nor the path has a hidden part. `folder` is the folder of the
/// options without links.
pub(crate) fn resolve(
    options: &PictureOptions,
    folder: Option<&Path>,
    name: &str,
) -> Result<PathBuf, PictureError> {
    if name.split(['/', '\\']).any(|part| is_hidden(part.as_ref())) {
        return Err(PictureError::Hidden);
    }
    if options.folder.is_none() {
        return Err(PictureError::Read("files are not read here".into()));
    }
    let files = Files { folder: options.folder.as_deref(), external: options.external };
    let path = files.resolve(name).map_err(PictureError::Read)?;
    // The folder itself may be below a hidden one.
    let folder = folder.into_iter().flat_map(Path::components);
    let shared = path.components().zip(folder).take_while(|(a, b)| a == b).count();
    if path.components().skip(shared).any(|part| is_hidden(part.as_os_str())) {
        return Err(PictureError::Hidden);
    }
    Ok(path)
}

impl Loader<'_> {
    /// Reads a file, if it starts as a picture.
    fn read(&self, path: &Path) -> Result<Vec<u8>, PictureError> {
        let failed = |error: std::io::Error| PictureError::Read(error.to_string());
        let (mut file, _) = open(path).map_err(PictureError::Read)?;
        let mut bytes = Vec::new();
        (&mut file).take(HEAD).read_to_end(&mut bytes).map_err(failed)?;
        self.format(&bytes)?;
        let room = self.options.max_memory.unwrap_or(u64::MAX - 1);
        file.take(room.saturating_sub(self.file_bytes)).read_to_end(&mut bytes).map_err(failed)?;
        Ok(bytes)
    }

    fn format(&self, bytes: &[u8]) -> Result<PictureFormat, PictureError> {
        let format = PictureFormat::of(bytes).ok_or(PictureError::NoPicture)?;
        let is_usable = self.options.formats.contains(&format);
        is_usable.then_some(format).ok_or(PictureError::Format(format))
    }

    /// Checks a content, unless it is known.
    fn accept(&mut self, bytes: Vec<u8>, known: &[Picture]) -> Result<Found, PictureError> {
        let format = self.format(&bytes)?;
        let entry = self.by_hash.entry(self.by_hash.hasher().hash_one(&bytes));
        if let Entry::Occupied(place) = &entry
            && known.get(*place.get() as usize).is_some_and(|picture| picture.bytes == bytes)
        {
            return Ok(Found::Known(*place.get()));
        }
        let size = format.size(&bytes).ok_or(PictureError::Header)?;
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let pixel_bytes =
            self.pixel_bytes.saturating_add(pixels.saturating_mul(format.pixel_bytes(&bytes)));
        let working_bytes = match self.options.are_decoded {
            true => self.working_bytes.max(pixels.saturating_mul(format.working_bytes(&bytes))),
            false => 0,
        };
        let needed = pixel_bytes.saturating_add(working_bytes);
        let file_bytes = self.file_bytes.saturating_add(bytes.len() as u64);
        let limit = self
            .options
            .max_memory
            .unwrap_or_else(|| FLOOR.saturating_add(file_bytes.saturating_mul(PER_BYTE)));
        if needed > limit {
            return Err(PictureError::Memory { size, needed, limit });
        }
        self.file_bytes = file_bytes;
        (self.pixel_bytes, self.working_bytes) = (pixel_bytes, working_bytes);
        entry.insert_entry(as_u32(known.len()));
        Ok(Found::New { format, size, bytes })
    }
}

fn is_hidden(part: &OsStr) -> bool {
    part.as_encoded_bytes().starts_with(b".") && part != "." && part != ".."
}
