//! The numbers of a study, one line each in a file. An aborted study continues from there.

use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::failure::Failure;

/// A file of numbers that grows.
pub struct Numbers {
    path: PathBuf,
    writer: csv::Writer<File>,
}

impl Numbers {
    /// Opens a file, or creates one with a header. Also returns the rows of an earlier run; rows that `parse` rejects
    /// are omitted, and will be computed again.
    pub fn open<R>(
        path: PathBuf,
        header: &[&str],
        parse: impl Fn(&csv::StringRecord) -> Option<R>,
    ) -> Result<(Self, Vec<R>), Failure> {
        let rows = read(&path, parse);
        let is_new = !path.exists();
        let file = OpenOptions::new().create(true).append(true).open(&path);
        let file = file.map_err(Failure::writing(&path))?;
        let writer = csv::WriterBuilder::new().has_headers(false).from_writer(file);
        let mut numbers = Self { path, writer };
        if is_new {
            numbers.add(header)?;
        }
        Ok((numbers, rows))
    }

    /// Adds a line and flushes it.
    pub fn add(&mut self, record: &[impl AsRef<[u8]>]) -> Result<(), Failure> {
        let Self { path, writer } = self;
        writer.write_record(record).map_err(Failure::writing(path))?;
        writer.flush().map_err(Failure::writing(path))
    }

    /// Adds a line of the fields of a struct.
    pub fn add_fields(&mut self, fields: &impl Serialize) -> Result<(), Failure> {
        let Self { path, writer } = self;
        writer.serialize(fields).map_err(Failure::writing(path))?;
        writer.flush().map_err(Failure::writing(path))
    }
}

fn read<R>(path: &Path, parse: impl Fn(&csv::StringRecord) -> Option<R>) -> Vec<R> {
    let Ok(mut reader) = csv::Reader::from_path(path) else { return Vec::new() };
    reader.records().filter_map(|record| parse(&record.ok()?)).collect()
}

#[cfg(test)]
mod tests {
    use super::Numbers;

    #[test]
    fn a_file_goes_on_where_it_ended() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("numbers.csv");
        let parse = |record: &csv::StringRecord| {
            Some((record.get(0)?.to_owned(), record.get(1)?.parse::<f64>().ok()?))
        };
        let (mut numbers, rows) = Numbers::open(path.clone(), &["name", "number"], parse).unwrap();
        assert!(rows.is_empty());
        numbers.add(&["with, a comma", "0.5"]).unwrap();
        numbers.add(&["broken", "off"]).unwrap();
        let (mut numbers, rows) = Numbers::open(path.clone(), &["name", "number"], parse).unwrap();
        assert_eq!(rows, [("with, a comma".to_owned(), 0.5)]);
        numbers.add(&["last", "2"]).unwrap();
        let (_, rows) = Numbers::open(path, &["name", "number"], parse).unwrap();
        assert_eq!(rows.len(), 2);
    }
}
