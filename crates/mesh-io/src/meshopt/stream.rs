//! The parts of all streams: numbers, and errors.

/// The reason why a stream cannot be decoded.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum Broken {
    /// The values cannot have this size, or not this number.
    #[error("{count} values of {stride} bytes, which this kind of compression does not have")]
    Layout { count: usize, stride: usize },
    /// The first byte belongs to another form or version.
    #[error("data that start with the byte {0:#04x}")]
    Header(u8),
    /// The stream is too short.
    #[error("data that end too early")]
    Short,
    /// The stream is too long.
    #[error("{0} bytes too many")]
    Long(usize),
    /// The differences are stored in an unknown way.
    #[error("the unknown channel mode {0:#04x}")]
    Channel(u8),
    /// The table of the corners refers to corners that are stored apart.
    #[error("a table of corners that is out of range")]
    Table,
}

/// The unread part of a stream.
pub(super) struct Reader<'b>(pub(super) &'b [u8]);

impl<'b> Reader<'b> {
    pub(super) fn byte(&mut self) -> Result<u8, Broken> {
        let (&first, rest) = self.0.split_first().ok_or(Broken::Short)?;
        self.0 = rest;
        Ok(first)
    }

    pub(super) fn take(&mut self, count: usize) -> Result<&'b [u8], Broken> {
        let (taken, rest) = self.0.split_at_checked(count).ok_or(Broken::Short)?;
        self.0 = rest;
        Ok(taken)
    }

    /// A number in groups of seven bits, least significant first. Bits beyond the 32nd are ignored.
    pub(super) fn number(&mut self) -> Result<u32, Broken> {
        let mut number = 0;
        for shift in [0, 7, 14, 21, 28] {
            let byte = self.byte()?;
            number |= u32::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                break;
            }
        }
        Ok(number)
    }

    pub(super) fn end(&self) -> Result<(), Broken> {
        if self.0.is_empty() { Ok(()) } else { Err(Broken::Long(self.0.len())) }
    }
}

/// The signed number that a zigzag code stands for, modulo 2³².
pub(super) fn unzigzag(code: u32) -> u32 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}

/// The code of a signed number.
pub(super) fn zigzag(number: i32) -> u32 {
    ((number << 1) ^ (number >> 31)).cast_unsigned()
}

/// Appends a number in groups of seven bits, least significant first.
pub(super) fn write_number(stream: &mut Vec<u8>, mut number: u32) {
    loop {
        let [low, ..] = number.to_le_bytes();
        number >>= 7;
        if number == 0 {
            stream.push(low & 0x7f);
            return;
        }
        stream.push(low | 0x80);
    }
}
