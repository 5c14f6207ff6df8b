//! Reading a file as a stream of vertices and faces, which are not kept.

use crate::Format;
use crate::budget::Budget;
use crate::error::{ReadError, ReadErrorKind};
#[cfg(feature = "gltf")]
use crate::external::Files;
use crate::input::Input;
use crate::item::{Item, Visit};
use crate::lost::Lost;
use crate::notes::Notes;
use crate::read::{ReadOptions, detect, open};
use std::io::Read;
use std::ops::ControlFlow;
use std::path::Path;

/// The result of a scan.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Scanned {
    /// The format.
    pub format: Format,
    /// Content that was skipped, in words.
    pub notes: Vec<String>,
    /// The content of the file that was not visited. Each loss is in the notes as well.
    pub lost: Vec<Lost>,
    /// Whether the file was read to its end; false if the visitor stopped the scan.
    pub is_whole: bool,
}

/// Reads the vertices and faces of a file one by one, in memory that does not depend on the size of the file. All other
/// content is skipped, and named in the notes. The bytes of a glTF file are read as a whole, since their order is free.
///
/// ```no_run
/// use core::ops::ControlFlow;
/// use mesh_io::{Item, ReadOptions, scan};
///
/// let mut faces = 0_u64;
/// scan("huge.ply", &ReadOptions::default(), &mut |item| {
///     faces += u64::from(!matches!(item, Item::Vertex(_)));
///     ControlFlow::Continue(())
/// })?;
/// # Ok::<(), mesh_io::ReadError>(())
/// ```
///
/// # Errors
/// As [`read_with`](crate::read_with), and [`ReadErrorKind::Unsupported`] for OFF files that are binary and little-endian.
pub fn scan(
    path: impl AsRef<Path>,
    options: &ReadOptions,
    visit: &mut dyn FnMut(Item<'_>) -> ControlFlow<()>,
) -> Result<Scanned, ReadError> {
    let path = path.as_ref();
    let mut scan = || -> Result<Scanned, ReadError> {
        let (mut file, options) = open(path, options)?;
        scan_stream(&mut file, &options, Some(path), visit)
    };
    scan().map_err(|error| error.at_path(path))
}

/// As [`scan`], from a stream, which need not be buffered.
///
/// # Errors
/// As [`scan`]; the error has no path.
pub fn scan_from(
    reader: &mut dyn Read,
    options: &ReadOptions,
    visit: &mut dyn FnMut(Item<'_>) -> ControlFlow<()>,
) -> Result<Scanned, ReadError> {
    scan_stream(reader, options, None, visit)
}

fn scan_stream(
    reader: &mut dyn Read,
    options: &ReadOptions,
    path: Option<&Path>,
    visit: &mut Visit<'_>,
) -> Result<Scanned, ReadError> {
    let mut input = Input::new(reader, options.size, Budget::new(options.max_memory));
    let (format, size) = detect(&mut input, options, path)?;
    let mut items = 0_u64;
    let mut notes = Notes::default();
    let counted = &mut |item: Item<'_>| {
        items += 1;
        visit(item)
    };
    let flow = match format {
        Format::Ply => crate::ply::scan(&mut input, counted, &mut notes),
        Format::Stl => crate::stl::scan(&mut input, size, counted, &mut notes),
        #[cfg(feature = "obj")]
        Format::Obj => crate::obj::scan(&mut input, counted, &mut notes),
        #[cfg(not(feature = "obj"))]
        Format::Obj => Err(ReadErrorKind::FormatDisabled(format)),
        Format::Off => crate::off::scan(&mut input, counted, &mut notes),
        #[cfg(feature = "gltf")]
        Format::Gltf | Format::Glb => {
            let files = Files { folder: options.folder.as_deref(), external: options.external };
            crate::gltf::scan(&mut input, &files, counted, &mut notes)
        }
        #[cfg(not(feature = "gltf"))]
        Format::Gltf | Format::Glb => Err(ReadErrorKind::FormatDisabled(format)),
    }?;
    if items == 0 && !options.allow_empty {
        return Err(ReadErrorKind::Empty { notes: notes.finish().0 }.into());
    }
    let (notes, lost) = notes.finish();
    Ok(Scanned { format, notes, lost, is_whole: flow.is_continue() })
}
