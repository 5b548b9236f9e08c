//! Huffman tables (T.81, annex C).

use crate::base::convert::to_u8;

/// A Huffman table: the code that any 16 bits begin with.
pub(super) struct Table {
    /// Codes by their first bits, where those are all; what is looked up most lies closely together.
    short: Box<[Code]>,
    /// Codes by 16 bits.
    long: Box<[Code]>,
}

/// A code: its symbol, and its length in bits; 0 where no code begins so.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Code {
    /// The symbol.
    pub symbol: u8,
    /// The bits of the code.
    pub length: u8,
}

/// The longest code, bits.
const LONGEST: usize = 16;

/// The longest code that is looked up by its first bits.
const SHORT: usize = 10;

impl Table {
    /// The table at the head of `segment`, which has the number of codes of each length and then their symbols; and the rest of
    /// the segment. `None` where the segment is too short, or there are more codes than bits for them.
    pub(super) fn read(segment: &[u8]) -> Option<(Table, &[u8])> {
        let (counts, rest) = segment.split_first_chunk::<LONGEST>()?;
        let total: usize = counts.iter().map(|&count| usize::from(count)).sum();
        let (mut symbols, rest) = rest.split_at_checked(total)?;
        let mut long = vec![Code::default(); 1 << LONGEST].into_boxed_slice();
        let mut next = 0;
        for (length, &count) in (1..=LONGEST).zip(counts) {
            let reach = 1 << (LONGEST - length);
            let (own, later) = symbols.split_at(usize::from(count));
            symbols = later;
            for &symbol in own {
                long.get_mut(next..next + reach)?.fill(Code { symbol, length: to_u8(length) });
                next += reach;
            }
        }
        let within = |code: Code| if usize::from(code.length) <= SHORT { code } else { Code::default() };
        let short = long.iter().step_by(1 << (LONGEST - SHORT)).map(|&code| within(code)).collect();
        Some((Table { short, long }, rest))
    }

    /// The code that these 16 bits begin with.
    #[inline(always)]
    pub(super) fn code(&self, bits: usize) -> Code {
        let found = self.short[(bits >> (LONGEST - SHORT)) & ((1 << SHORT) - 1)];
        if found.length == 0 { self.long[bits & ((1 << LONGEST) - 1)] } else { found }
    }
}

/// What the coefficients of a sequential scan amount to whose codes and values lie within the next few bits, all at once.
pub(super) struct Runs(Box<[Run]>);

/// Some coefficients that follow each other, in as few bytes as may be: their bits from bit 8 on, then whether the block ends
/// after them, and in the lowest 7 bits how many they are, those included that are 0.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct Run(u16);

/// The bits that are looked at for coefficients.
const LOOKED: usize = 13;

impl Run {
    const ENDS: u16 = 1 << 7;

    /// The bits of all codes and values; 0 where not even one lies within the bits that are looked at.
    #[inline(always)]
    pub(super) fn bits(self) -> u32 {
        u32::from(self.0 >> 8)
    }

    /// The number of coefficients.
    #[inline(always)]
    pub(super) fn coefficients(self) -> u32 {
        u32::from(self.0 & (Self::ENDS - 1))
    }

    /// Whether the block ends after them.
    #[inline(always)]
    pub(super) fn ends(self) -> bool {
        self.0 & Self::ENDS != 0
    }
}

impl Runs {
    /// The runs that the codes of a table make.
    pub(super) fn of(table: &Table) -> Runs {
        Runs((0..1 << LOOKED).map(|bits| Runs::run(table, bits << (LONGEST - LOOKED))).collect())
    }

    fn run(table: &Table, bits: usize) -> Run {
        let (mut taken, mut count) = (0u16, 0u16);
        loop {
            let Code { symbol, length } = table.code(bits << taken);
            let (zeros, size) = (u16::from(symbol >> 4), u16::from(symbol & 15));
            let after = taken + u16::from(length) + size;
            let coefficients = match (zeros, size) {
                (0, 0) => 0,
                (15, 0) => 16,
                // There is no such symbol: whoever looks at it alone says so.
                (_, 0) => return Run(taken << 8 | count),
                (zeros, _) => zeros + 1,
            };
            // The bits that were not looked at are 0 here: a code within the others is that code whatever they are.
            if length == 0 || usize::from(after) > LOOKED || count + coefficients > 63 {
                return Run(taken << 8 | count);
            }
            (taken, count) = (after, count + coefficients);
            if coefficients == 0 {
                return Run(taken << 8 | Run::ENDS | count);
            }
        }
    }

    /// The run that these 16 bits begin with.
    #[inline(always)]
    pub(super) fn starting(&self, bits: usize) -> Run {
        self.0[(bits >> (LONGEST - LOOKED)) & ((1 << LOOKED) - 1)]
    }
}
