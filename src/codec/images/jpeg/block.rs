//! Blocks of 64 coefficients as they are coded (T.81, annexes F and G). The code here goes past them; it keeps no more than
//! which coefficients are not 0, and that only where later bits depend on it.

use super::bits::{Bits, Ended};
use super::huffman::{Code, Run, Runs, Table};

/// What is wrong with coded data.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fault {
    /// The data end before the last block.
    Ended,
    /// Bits that no code begins with.
    NoCode,
    /// A symbol that stands for nothing here.
    NoSymbol,
    /// A coefficient past the last of its block.
    Overrun,
}

impl From<Ended> for Fault {
    fn from(_: Ended) -> Self {
        Fault::Ended
    }
}

/// The coefficients of a block.
const BLOCK: u32 = 64;

/// The coefficients that the symbol `0xf0` goes past.
const SIXTEEN: u32 = 16;

/// Goes past a code and gives its symbol.
#[inline(always)]
fn symbol(bits: &mut Bits<'_>, table: &Table) -> Result<u8, Fault> {
    let Code { symbol, length } = table.code(bits.peek());
    if length == 0 {
        return Err(Fault::NoCode);
    }
    bits.take(length.into())?;
    Ok(symbol)
}

/// Goes past the first bits of a block's first coefficient.
#[inline(always)]
pub(super) fn first_dc(bits: &mut Bits<'_>, dc: &Table) -> Result<(), Fault> {
    let Code { symbol: size, length } = dc.code(bits.peek());
    match (length, size) {
        (0, _) => Err(Fault::NoCode),
        (_, 17..) => Err(Fault::NoSymbol),
        (length, size) => Ok(bits.take(u32::from(length) + u32::from(size))?),
    }
}

/// Goes past a block of a sequential scan.
#[inline(always)]
pub(super) fn sequential(bits: &mut Bits<'_>, dc: &Table, ac: (&Table, &Runs)) -> Result<(), Fault> {
    first_dc(bits, dc)?;
    let mut next = 1;
    while next < BLOCK {
        let looked = bits.peek();
        let run: Run = ac.1.starting(looked);
        if run.bits() > 0 && next + run.coefficients() < BLOCK {
            bits.take(run.bits())?;
            next += run.coefficients();
            if run.ends() {
                return Ok(());
            }
            continue;
        }
        let Code { symbol, length } = ac.0.code(looked);
        if length == 0 {
            return Err(Fault::NoCode);
        }
        let (zeros, size) = (u32::from(symbol >> 4), u32::from(symbol & 15));
        // Code and value together: at most 31 bits.
        bits.take(u32::from(length) + size)?;
        next += match (zeros, size) {
            (0, 0) => return Ok(()),
            (15, 0) => SIXTEEN,
            (_, 0) => return Err(Fault::NoSymbol),
            (zeros, _) => zeros + 1,
        };
    }
    if next == BLOCK { Ok(()) } else { Err(Fault::Overrun) }
}

/// A scan of some of the coefficients after the first (T.81, G.1.2).
pub(super) struct Band {
    /// The first coefficient.
    pub first: u32,
    /// The last coefficient.
    pub last: u32,
    /// The blocks that follow and of which nothing new is coded.
    pub empty: u32,
}

impl Band {
    /// Goes past the first bits of a block's coefficients; notes in `there` those that are not 0.
    pub(super) fn first(&mut self, bits: &mut Bits<'_>, ac: &Table, there: &mut u64) -> Result<(), Fault> {
        if self.empty > 0 {
            self.empty -= 1;
            return Ok(());
        }
        let mut next = self.first;
        while next <= self.last {
            let symbol = symbol(bits, ac)?;
            match (u32::from(symbol >> 4), u32::from(symbol & 15)) {
                (15, 0) => next += SIXTEEN,
                (run, 0) => {
                    self.empty = (1 << run) - 1 + bits.number(run)?;
                    return Ok(());
                }
                (zeros, size) => {
                    next += zeros;
                    if next > self.last {
                        return Err(Fault::Overrun);
                    }
                    *there |= 1 << next;
                    bits.pass(size)?;
                    next += 1;
                }
            }
        }
        if next == self.last + 1 { Ok(()) } else { Err(Fault::Overrun) }
    }

    /// Goes past a further bit of a block's coefficients; notes in `there` those that were 0 until now.
    pub(super) fn further(&mut self, bits: &mut Bits<'_>, ac: &Table, there: &mut u64) -> Result<(), Fault> {
        let mut next = self.first;
        while self.empty == 0 && next <= self.last {
            let symbol = symbol(bits, ac)?;
            let (mut zeros, size) = (u32::from(symbol >> 4), u32::from(symbol & 15));
            match (zeros, size) {
                (15, 0) => {}
                (run, 0) => {
                    self.empty = (1 << run) + bits.number(run)?;
                    break;
                }
                // Its sign.
                (_, 1) => bits.pass(1)?,
                _ => return Err(Fault::NoSymbol),
            }
            // Those that are there have a bit each; the symbol counts the others.
            while next <= self.last && (zeros > 0 || *there >> next & 1 == 1) {
                if *there >> next & 1 == 1 {
                    bits.pass(1)?;
                } else {
                    zeros -= 1;
                }
                next += 1;
            }
            if next > self.last {
                return Err(Fault::Overrun);
            }
            if size == 1 {
                *there |= 1 << next;
            }
            next += 1;
        }
        if self.empty > 0 {
            self.empty -= 1;
            let rest = if next > self.last { 0 } else { *there >> next & u64::MAX >> (BLOCK - 1 - (self.last - next)) };
            let count = rest.count_ones();
            bits.pass(count / 2)?;
            bits.pass(count - count / 2)?;
        }
        Ok(())
    }
}
