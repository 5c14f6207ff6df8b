//! JSON files with a checksum over their own text.
//!
//! ```text
//! {
//!   "version": 2,
//!   "run": "...",                  the checksum of run.json; in run.json itself a random number
//!   "file": "level-0/plan.json",   where the file belongs
//!   "inputs": "...",               the checksum over the checksums of what the content was made from
//!   "content": ...,
//!   "sha256": "..."                the checksum of this text, with 64 zeros in place of it
//! }
//! ```
//! So the reader detects a record that was changed, that belongs to another run or place, or that was made from files
//! that have changed since. The checksum protects against damage and mistakes. It is not a signature: anyone who can
//! write to the folder can also compute it. So the folder is private, and contents are checked as well.

use std::io::Read;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::error::Error;
use crate::private_files;

/// The version of work folders.
pub(crate) const VERSION: u32 = 2;

/// The text after the checksum.
const END: &[u8] = b"\"\n}";
/// The digits of a checksum.
const DIGITS: usize = 64;

/// The header of a file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Origin<'o> {
    /// The run that the file belongs to.
    pub(crate) run: &'o str,
    /// Its path within the work folder, with `/` between names.
    pub(crate) file: &'o str,
    /// The checksum over the checksums of the inputs of the content.
    pub(crate) inputs: &'o str,
}

/// A file as it is written.
#[derive(Serialize)]
struct Written<'w, T> {
    version: u32,
    run: &'w str,
    file: &'w str,
    inputs: &'w str,
    content: &'w T,
    sha256: &'w str,
}

/// A file as it is read.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Sealed<T> {
    version: u32,
    pub(crate) run: String,
    file: String,
    /// The checksum over the checksums of the inputs of the content.
    pub(crate) inputs: String,
    /// The data.
    pub(crate) content: T,
    /// The checksum of the file.
    #[serde(rename = "sha256")]
    pub(crate) seal: String,
}

/// The version of a file of any version.
#[derive(Deserialize)]
struct AnyVersion {
    version: u32,
}

/// Writes a file, and returns its checksum.
pub(crate) fn write<T: Serialize>(
    path: &Path,
    origin: Origin<'_>,
    content: &T,
) -> Result<String, Error> {
    let Origin { run, file, inputs } = origin;
    let zeros = "0".repeat(DIGITS);
    let written = Written { version: VERSION, run, file, inputs, content, sha256: &zeros };
    let mut text = serde_json::to_string_pretty(&written)
        .map_err(|error| Error::damaged(path, error.to_string()))?;
    let seal = hex(&Sha256::digest(text.as_bytes()));
    text.truncate(text.len() - END.len() - DIGITS);
    text += &seal;
    text += &String::from_utf8_lossy(END);
    private_files::replace(path, |writer| writer.write_all(text.as_bytes()))
        .map_err(Error::io(path))?;
    Ok(seal)
}

/// Reads a file of at most `limit` bytes that belongs at `file` within its folder. `None` if it does not exist.
pub(crate) fn read<T: DeserializeOwned>(
    path: &Path,
    file: &str,
    limit: u64,
) -> Result<Option<Sealed<T>>, Error> {
    let damaged = |reason: &str| Error::damaged(path, reason);
    let opened = match private_files::open(path) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        opened => opened.map_err(Error::io(path))?,
    };
    let mut bytes = Vec::new();
    opened.take(limit + 1).read_to_end(&mut bytes).map_err(Error::io(path))?;
    if bytes.len() as u64 > limit {
        return Err(Error::damaged(
            path,
            format!("longer than the {limit} bytes that it may have"),
        ));
    }
    if let Ok(AnyVersion { version }) = serde_json::from_slice(&bytes)
        && version != VERSION
    {
        let reason = format!("this folder has version {version}; this program writes {VERSION}");
        return Err(Error::damaged(path, reason));
    }
    let seal = take_seal(&mut bytes).ok_or_else(|| damaged("there is no checksum at its end"))?;
    if hex(&Sha256::digest(&bytes)) != seal {
        return Err(damaged("its text does not fit its checksum; it was changed"));
    }
    let mut sealed: Sealed<T> =
        serde_json::from_slice(&bytes).map_err(|error| Error::damaged(path, error.to_string()))?;
    if sealed.version != VERSION {
        return Err(damaged("it has two versions"));
    }
    if sealed.file != file {
        return Err(Error::damaged(path, format!("it belongs at {:?}", sealed.file)));
    }
    sealed.seal = seal;
    Ok(Some(sealed))
}

/// Extracts the checksum from a text, and puts zeros in its place.
fn take_seal(bytes: &mut [u8]) -> Option<String> {
    let end = bytes.len().checked_sub(END.len())?;
    let start = end.checked_sub(DIGITS)?;
    if bytes.get(end..)? != END {
        return None;
    }
    let digits = bytes.get_mut(start..end)?;
    let seal = is_checksum(digits).then(|| String::from_utf8_lossy(digits).into_owned());
    digits.fill(b'0');
    seal
}

/// Whether these are the hexadecimal digits of a SHA-256 checksum.
pub(crate) fn is_checksum(digits: &[u8]) -> bool {
    digits.len() == DIGITS
        && digits.iter().all(|digit| digit.is_ascii_digit() || (b'a'..=b'f').contains(digit))
}

/// The checksum over several checksums, in order.
pub(crate) fn combine<S: AsRef<str>>(seals: impl IntoIterator<Item = S>) -> String {
    let mut sum = Sha256::new();
    seals.into_iter().for_each(|seal| sum.update(seal.as_ref()));
    hex(&sum.finalize())
}

/// Hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    const ORIGIN: Origin<'_> = Origin { run: "a run", file: "here.json", inputs: "from there" };

    #[test]
    fn every_change_of_a_byte_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("here.json");
        let seal = write(&path, ORIGIN, &vec![1.5, 0.25]).unwrap();
        let read_back = || read::<Vec<f64>>(&path, "here.json", 4096);
        let found = read_back().unwrap().unwrap();
        assert_eq!((found.seal, found.content), (seal, vec![1.5, 0.25]));
        let bytes = std::fs::read(&path).unwrap();
        for place in 0..bytes.len() {
            for bit in 0..8 {
                let mut changed = bytes.clone();
                changed[place] ^= 1 << bit;
                std::fs::write(&path, &changed).unwrap();
                assert!(matches!(read_back(), Err(Error::Damaged { .. })), "{place} {bit}");
            }
            std::fs::write(&path, &bytes[..place]).unwrap();
            assert!(matches!(read_back(), Err(Error::Damaged { .. })), "{place}");
        }
    }

    #[test]
    fn files_in_other_places_and_long_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("there.json");
        assert!(read::<u32>(&path, "there.json", 10).unwrap().is_none());
        write(&path, ORIGIN, &7).unwrap();
        assert!(matches!(read::<u32>(&path, "there.json", 4096), Err(Error::Damaged { .. })));
        assert!(matches!(read::<u32>(&path, "here.json", 20), Err(Error::Damaged { .. })));
        assert_eq!(read::<u32>(&path, "here.json", 4096).unwrap().unwrap().content, 7);
    }
}
