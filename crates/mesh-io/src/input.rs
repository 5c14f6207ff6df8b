//! A sliding window over a stream that knows its position in the file.

use crate::budget::Budget;
#[cfg(feature = "gltf")]
use crate::budget::GROWING;
use crate::error::{Location, ReadErrorKind};
use crate::text::{BYTE_ORDER_MARK, quote};
use std::io::Read;
use std::ops::Range;

/// The number of bytes per read.
const WINDOW: usize = 1 << 16;
/// The longest line of a text file; a longer line means that the file is not text.
const LONGEST_LINE: usize = 1 << 24;
/// The number of bytes to reserve memory for when the length of the stream is unknown.
const BLIND_RESERVE: u64 = 1 << 20;

/// A stream that is read line by line or byte by byte, and never held as a whole.
pub(crate) struct Input<'a> {
    source: &'a mut dyn Read,
    window: Vec<u8>,
    /// `window[start..]` has been fetched and not yet consumed.
    start: usize,
    /// The file offset of `window[start]`.
    offset: u64,
    /// The number of the last returned line.
    line: u64,
    /// The length of the file, if known.
    size: Option<u64>,
    /// Whether the first line ended in a carriage return alone.
    bare_returns: bool,
    budget: Budget,
}

/// A line of text without its line break.
#[derive(Clone, Copy)]
pub(crate) struct Line<'a> {
    /// Counted from one.
    pub number: u64,
    pub text: &'a [u8],
}

impl<'a> Input<'a> {
    pub(crate) fn new(source: &'a mut dyn Read, size: Option<u64>, budget: Budget) -> Self {
        let (window, bare_returns) = (Vec::new(), false);
        Self { source, window, start: 0, offset: 0, line: 0, size, bare_returns, budget }
    }

    /// Records memory for the model before it is allocated; an error if it exceeds the limit for a file of this length.
    pub(crate) fn spend(
        &mut self,
        bytes: u64,
        at: impl FnOnce() -> Location,
    ) -> Result<(), ReadErrorKind> {
        let size = self.size_so_far();
        self.budget.spend(bytes, size, at)
    }

    /// Checks that memory is available which is about to be reserved and will be recorded as it is filled.
    pub(crate) fn require(
        &self,
        bytes: u64,
        at: impl FnOnce() -> Location,
    ) -> Result<(), ReadErrorKind> {
        self.budget.require(bytes, self.size_so_far(), at)
    }

    /// The memory that the content may still use.
    #[cfg(feature = "gltf")]
    pub(crate) fn memory_left(&self) -> u64 {
        self.budget.left(self.size_so_far())
    }

    /// The known part of the length of the file.
    fn size_so_far(&self) -> u64 {
        let there = self.offset + (self.window.len() - self.start) as u64;
        self.size.unwrap_or(0).max(there)
    }

    /// As [`Input::spend`], for the last returned line.
    pub(crate) fn spend_on_line(&mut self, bytes: u64) -> Result<(), ReadErrorKind> {
        let line = self.line_number();
        self.spend(bytes, || Location::Line(line))
    }

    /// Counts a file that the content refers to.
    #[cfg(any(feature = "obj", feature = "gltf"))]
    pub(crate) fn add_file(&mut self, bytes: u64) {
        self.budget.add_file(bytes);
    }

    /// The number of remaining bytes, if known.
    pub(crate) fn rest_known(&self) -> Option<u64> {
        Some(self.size?.saturating_sub(self.offset))
    }

    /// The number of consumed bytes.
    pub(crate) fn offset(&self) -> u64 {
        self.offset
    }

    /// The location of the next byte.
    pub(crate) fn here(&self) -> Location {
        Location::Byte(self.offset)
    }

    /// The number of the last returned line, at least 1.
    pub(crate) fn line_number(&self) -> u64 {
        self.line.max(1)
    }

    /// The bytes that are read and not yet consumed.
    pub(crate) fn window(&self) -> &[u8] {
        &self.window[self.start..]
    }

    /// Marks bytes as consumed.
    pub(crate) fn consume(&mut self, count: usize) {
        let count = count.min(self.window.len() - self.start);
        self.start += count;
        self.offset += count as u64;
    }

    /// Reads until `wanted` bytes are in the window or the stream ends, and returns the window.
    pub(crate) fn peek(&mut self, wanted: usize) -> Result<&[u8], ReadErrorKind> {
        while self.window.len() - self.start < wanted && self.fetch()? {}
        Ok(&self.window[self.start..])
    }

    /// Reads more bytes; false at the end of the stream.
    fn fetch(&mut self) -> Result<bool, ReadErrorKind> {
        self.window.drain(..self.start);
        self.start = 0;
        let before = self.window.len();
        self.window.resize(before + WINDOW, 0);
        let read = loop {
            match self.source.read(&mut self.window[before..]) {
                Ok(read) => break read,
                Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
                Err(error) => {
                    self.window.truncate(before);
                    return Err(error.into());
                }
            }
        };
        self.window.truncate(before + read);
        Ok(read > 0)
    }

    /// The next line, without `\n`, `\r\n`, `\r` or a byte-order mark; `None` at the end.
    pub(crate) fn line(&mut self) -> Result<Option<Line<'_>>, ReadErrorKind> {
        Ok(self.advance_line()?.map(|range| Line { number: self.line, text: &self.window[range] }))
    }

    /// Whether more content follows; in text, empty lines and comments are no content.
    pub(crate) fn has_more(&mut self, is_text: bool) -> Result<bool, ReadErrorKind> {
        if !is_text {
            return Ok(!self.peek(1)?.is_empty());
        }
        while let Some(range) = self.advance_line()? {
            if self.window[range].trim_ascii_start().first().is_some_and(|&b| b != b'#') {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// The next line that is neither empty nor a comment. The end of the stream is an error that names the expected
    /// content.
    pub(crate) fn data_line(&mut self, expected: &str) -> Result<Line<'_>, ReadErrorKind> {
        while let Some(range) = self.advance_line()? {
            if self.window[range.clone()].trim_ascii_start().first().is_some_and(|&b| b != b'#') {
                return Ok(Line { number: self.line, text: &self.window[range] });
            }
        }
        Err(ReadErrorKind::malformed(
            Location::Line(self.line_number()),
            expected,
            "the end of the file",
        ))
    }

    /// Consumes a line, and returns its range in the window.
    fn advance_line(&mut self) -> Result<Option<Range<usize>>, ReadErrorKind> {
        let mut searched = 0;
        let (length, ending) = loop {
            let window = &self.window[self.start..];
            let is_break = |&byte: &u8| byte == b'\n' || byte == b'\r';
            if let Some(found) = window[searched..].iter().position(is_break) {
                let length = searched + found;
                match (window[length], window.get(length + 1)) {
                    (b'\n', _) => break (length, 1),
                    // Binary data may follow a header with such lines.
                    (_, Some(b'\n')) if self.bare_returns => break (length, 1),
                    (_, Some(b'\n')) => break (length, 2),
                    (_, Some(_)) => break (length, 1),
                    // It is not known yet whether a line feed follows.
                    (_, None) => searched = length,
                }
                if !self.fetch()? {
                    break (length, 1);
                }
                continue;
            }
            searched = window.len();
            if searched > LONGEST_LINE {
                return Err(ReadErrorKind::malformed(
                    Location::Line(self.line + 1),
                    "a line of text",
                    format!("{LONGEST_LINE} bytes without a line break"),
                ));
            }
            if !self.fetch()? {
                break (searched, 0);
            }
        };
        if length == 0 && ending == 0 {
            return Ok(None);
        }
        let mut range = self.start..self.start + length;
        let bare_return = ending == 1 && self.window[range.end] == b'\r';
        self.bare_returns |= self.line == 0 && bare_return;
        self.line += 1;
        self.consume(length + ending);
        if self.line == 1 && self.window[range.clone()].starts_with(BYTE_ORDER_MARK) {
            range.start += 3;
        }
        Ok(Some(range))
    }

    /// The next `N` bytes, which belong to `what`.
    pub(crate) fn array<const N: usize>(&mut self, what: &str) -> Result<[u8; N], ReadErrorKind> {
        if let Some(&bytes) = self.window[self.start..].first_chunk::<N>() {
            self.consume(N);
            return Ok(bytes);
        }
        match self.peek(N)?.first_chunk::<N>().copied() {
            Some(bytes) => {
                self.consume(N);
                Ok(bytes)
            }
            None => Err(self.too_short(what, N as u64)),
        }
    }

    /// Skips `count` bytes of `what`.
    pub(crate) fn skip(&mut self, mut count: u64, what: &str) -> Result<(), ReadErrorKind> {
        while count > 0 {
            let there = self.peek(1)?.len();
            if there == 0 {
                return Err(self.too_short(what, count));
            }
            let step = count.min(there as u64) as usize;
            self.consume(step);
            count -= step as u64;
        }
        Ok(())
    }

    /// The error of a file that ends within `what`, with `wanted` bytes missing.
    pub(crate) fn too_short(&self, what: &str, wanted: u64) -> ReadErrorKind {
        ReadErrorKind::malformed(
            self.here(),
            format!("{wanted} bytes of {what}"),
            format!("the end of the file after {} bytes", self.window().len()),
        )
    }

    /// The number of records, of `count` with at least `bytes` bytes each, to reserve memory for: all if the rest of
    /// the file can hold them, few if its length is unknown.
    ///
    /// A header that announces more than the file can hold is an error before any allocation.
    pub(crate) fn plausible(
        &self,
        count: u64,
        bytes: u64,
        at: Location,
        what: &str,
    ) -> Result<usize, ReadErrorKind> {
        let Some(size) = self.size else {
            return Ok(count.min(BLIND_RESERVE / bytes.max(16)) as usize);
        };
        // A file that grows while it is read may be longer than its recorded size.
        let rest = size.saturating_sub(self.offset);
        // The last line of a text may lack its line break.
        if count.saturating_mul(bytes.max(1)) > rest + 1 {
            return Err(ReadErrorKind::malformed(
                at,
                format!("room for {count} {what} of at least {bytes} bytes each"),
                format!("{rest} bytes before the end of the file"),
            ));
        }
        Ok(count as usize)
    }

    /// The next `length` bytes as one block; memory grows only as bytes arrive.
    #[cfg(feature = "gltf")]
    pub(crate) fn block(&mut self, length: u64, what: &str) -> Result<Vec<u8>, ReadErrorKind> {
        let room = self.plausible(length, 1, self.here(), what)?.min(1 << 26);
        self.require(room as u64, || self.here())?;
        let mut block = Vec::with_capacity(room);
        while (block.len() as u64) < length {
            let missing = length - block.len() as u64;
            let there = self.peek(1)?;
            if there.is_empty() {
                return Err(self.too_short(what, missing));
            }
            let step = missing.min(there.len() as u64) as usize;
            block.extend_from_slice(&there[..step]);
            self.consume(step);
            let at = self.here();
            self.spend(GROWING * step as u64, || at)?;
        }
        Ok(block)
    }

    /// Everything up to the end of the stream.
    #[cfg(feature = "gltf")]
    pub(crate) fn rest(&mut self) -> Result<Vec<u8>, ReadErrorKind> {
        let mut rest = Vec::new();
        while !self.peek(1)?.is_empty() {
            rest.extend_from_slice(self.window());
            let at = self.here();
            self.spend(GROWING * self.window().len() as u64, || at)?;
            self.consume(usize::MAX);
        }
        Ok(rest)
    }
}

impl<'a> Line<'a> {
    pub(crate) fn location(&self) -> Location {
        Location::Line(self.number)
    }

    /// The words of the line, up to a comment.
    pub(crate) fn words(&self) -> Words<'a> {
        Words { rest: self.text }
    }

    /// The error of a line that does not contain `expected`.
    pub(crate) fn unexpected(&self, expected: impl Into<String>, found: &[u8]) -> ReadErrorKind {
        let found = if found.is_empty() { "the end of the line".to_owned() } else { quote(found) };
        ReadErrorKind::malformed(self.location(), expected, found)
    }
}

/// The words of a line, separated by white space; a word that starts with `#` ends the line.
#[derive(Clone)]
pub(crate) struct Words<'a> {
    rest: &'a [u8],
}

impl<'a> Words<'a> {
    /// Whether only white space is left. Unlike [`remainder`](Self::remainder), it does not look at the end of the line.
    #[cfg(feature = "obj")]
    pub(crate) fn is_at_end(&self) -> bool {
        self.rest.trim_ascii_start().is_empty()
    }

    /// The rest of the line, without surrounding white space.
    pub(crate) fn remainder(&self) -> &'a [u8] {
        self.rest.trim_ascii()
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = &'a [u8];

    fn next(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest.trim_ascii_start();
        if rest.first().is_none_or(|&byte| byte == b'#') {
            self.rest = &[];
            return None;
        }
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        let (word, after) = rest.split_at(end);
        self.rest = after;
        Some(word)
    }
}

/// A number in the notation of any text format, including the output of C runtimes for non-finite values.
pub(crate) fn number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    text.parse().ok().or_else(|| {
        let (sign, text) = match text.strip_prefix('-') {
            Some(rest) => (-1.0, rest),
            None => (1.0, text.strip_prefix('+').unwrap_or(text)),
        };
        let text = text.to_ascii_lowercase();
        if text.starts_with("nan") || text.starts_with("1.#qnan") || text.starts_with("1.#ind") {
            Some(f64::NAN)
        } else if text.starts_with("1.#inf") {
            Some(sign * f64::INFINITY)
        } else {
            None
        }
    })
}

/// A whole number.
pub(crate) fn integer<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}
