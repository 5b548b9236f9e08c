//! The bits of coded data, up to the next marker. A byte 0 after 0xff is left out: the 0xff was data.

/// Reads the bits of a file's coded data.
#[derive(Clone, Copy)]
pub(super) struct Bits<'a> {
    file: &'a [u8],
    /// The position of the next byte that is not in the buffer.
    at: usize,
    /// The next bits, from the highest down; the rest is 0.
    buffer: u64,
    /// The number of bits in the buffer.
    held: u32,
}

/// The coded data end before what was to be read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Ended;

/// The bits that are in the buffer at least, unless the data end.
const READY: u32 = 32;

impl<'a> Bits<'a> {
    /// The coded data at this position of a file.
    pub(super) fn new(file: &'a [u8], at: usize) -> Self {
        Bits { file, at, buffer: 0, held: 0 }
    }

    /// The next 16 bits, without going past them; 0 after the end.
    #[inline(always)]
    pub(super) fn peek(&mut self) -> usize {
        self.fill();
        (self.buffer >> 48) as usize
    }

    /// Goes past up to 32 bits, the first of which have just been looked at.
    #[inline(always)]
    pub(super) fn take(&mut self, count: u32) -> Result<(), Ended> {
        if self.held < count {
            return Err(Ended);
        }
        self.buffer <<= count;
        self.held -= count;
        Ok(())
    }

    /// Goes past up to 32 bits.
    #[inline(always)]
    pub(super) fn pass(&mut self, count: u32) -> Result<(), Ended> {
        self.fill();
        self.take(count)
    }

    /// The next bits, up to 16, as a number.
    pub(super) fn number(&mut self, count: u32) -> Result<u32, Ended> {
        self.fill();
        let value = self.buffer.checked_shr(64 - count).unwrap_or(0);
        self.take(count)?;
        Ok(u32::try_from(value).unwrap_or(u32::MAX))
    }

    #[inline(always)]
    fn fill(&mut self) {
        if self.held >= READY {
            return;
        }
        if let Some(next) = self.file.get(self.at..).and_then(<[u8]>::first_chunk::<4>) {
            let word = u32::from_be_bytes(*next);
            // A byte is 0xff where one of the inverted word is 0.
            if (!word).wrapping_sub(0x0101_0101) & word & 0x8080_8080 == 0 {
                self.buffer |= u64::from(word) << (32 - self.held);
                (self.held, self.at) = (self.held + 32, self.at + 4);
                return;
            }
        }
        // By value: nothing else keeps the reader out of registers.
        *self = self.filled_bytewise();
    }

    #[cold]
    #[inline(never)]
    fn filled_bytewise(mut self) -> Self {
        while self.held <= 56 {
            let Some(&byte) = self.file.get(self.at) else { break };
            let long = match (byte, self.file.get(self.at + 1)) {
                (0xff, Some(0)) => 2,
                // A marker, fill bytes before one, or the end of the file.
                (0xff, _) => break,
                _ => 1,
            };
            self.buffer |= u64::from(byte) << (56 - self.held);
            (self.held, self.at) = (self.held + 8, self.at + long);
        }
        self
    }

    /// The position in the file of the first byte of which no bit has been read, and whether the bits that are left of the byte
    /// before it are all 1, as an encoder fills its last byte.
    pub(super) fn rest(&self) -> (usize, bool) {
        let mut at = self.at;
        for _ in 0..self.held / 8 {
            let stuffed = at >= 2 && self.file[at - 1] == 0 && self.file[at - 2] == 0xff;
            at -= if stuffed { 2 } else { 1 };
        }
        let left = self.held % 8;
        (at, left == 0 || self.buffer >> (64 - left) == (1 << left) - 1)
    }
}
