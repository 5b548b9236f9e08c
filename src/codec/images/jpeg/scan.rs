//! A scan: the coded blocks of some components (T.81, B.2.3).

use super::bits::Bits;
use super::block::{Band, Fault, first_dc, sequential};
use super::huffman::{Runs, Table};
use super::junk::Junk;

/// A component of the image, and what scans have sent of it so far.
#[derive(Debug, Clone)]
pub(super) struct Component {
    /// The component's id, by which scans name it.
    pub id: u8,
    /// The blocks of a unit, across times down, where components are interleaved.
    pub unit: u32,
    /// Columns and rows of the blocks that hold pixels.
    pub blocks: (u32, u32),
    /// The lowest bit of each coefficient that has been sent; [`NEVER`] where none has.
    pub sent: [u8; 64],
    /// The coefficients of each block that are not 0, where later scans depend on it.
    pub there: Vec<u64>,
}

/// The lowest bit of a coefficient of which no bit has been sent.
pub(super) const NEVER: u8 = u8::MAX;

/// What is defined where a scan begins.
#[derive(Default)]
pub(super) struct Defined {
    /// The tables of first coefficients.
    pub dc: [Option<Table>; 4],
    /// The tables of the other coefficients.
    pub ac: [Option<Table>; 4],
    /// The units between two restarts; 0 for no restarts.
    pub interval: u32,
}

/// The header of a scan.
pub(super) struct Scan {
    /// The components' positions, and the numbers of their two tables.
    components: Vec<(usize, usize, usize)>,
    /// Whether coefficients come in several scans.
    progressive: bool,
    /// The first and the last coefficient.
    band: (u8, u8),
    /// The bit that was sent before, 0 for none.
    before: u8,
    /// The bit that is sent.
    now: u8,
}

impl Scan {
    /// Reads the header of a scan of some of these components.
    pub(super) fn read(segment: &[u8], all: &[Component], progressive: bool) -> Result<Scan, String> {
        let cut = || "the JPEG is damaged: the header of a scan is cut short".to_owned();
        let (&count, rest) = segment.split_first().ok_or_else(cut)?;
        let (named, rest) = rest.split_at_checked(2 * usize::from(count)).ok_or_else(cut)?;
        let &[first, last, bits] = rest.first_chunk::<3>().ok_or_else(cut)?;
        let find = |&[id, tables]: &[u8; 2]| {
            let at = all.iter().position(|component| component.id == id);
            let at =
                at.ok_or_else(|| format!("the JPEG is damaged: a scan is of component {id}, and there is none"))?;
            Ok((at, usize::from(tables >> 4), usize::from(tables & 15)))
        };
        let components = named.as_chunks::<2>().0.iter().map(find).collect::<Result<Vec<_>, String>>()?;
        if components.is_empty() {
            return Err("the JPEG is damaged: a scan is of no component".to_owned());
        }
        // Of a sequential scan the rest says nothing, and some cameras write anything there.
        let (band, before, now) = if progressive { ((first, last), bits >> 4, bits & 15) } else { ((0, 63), 0, 0) };
        let whole = !progressive || (first == 0 && last == 0);
        if !whole && (first == 0 || first > last || last > 63 || components.len() > 1) {
            return Err(format!(
                "the JPEG is damaged: a scan is of the coefficients {first} to {last} of {count} components"
            ));
        }
        Ok(Scan { components, progressive, band, before, now })
    }

    /// Whether the scan is of one component.
    pub(super) fn is_alone(&self) -> bool {
        self.components.len() == 1
    }

    /// Notes what the scan sends.
    pub(super) fn send(&self, all: &mut [Component]) -> Result<(), String> {
        let Scan { before, now, band: (first, last), .. } = *self;
        for &(at, ..) in &self.components {
            for sent in &mut all[at].sent[usize::from(first)..=usize::from(last)] {
                if if before == 0 { *sent != NEVER } else { *sent != before || now + 1 != before } {
                    return Err("the JPEG is damaged: a scan does not go on from those before it; one is missing, or comes twice".to_owned());
                }
                *sent = now;
            }
        }
        Ok(())
    }

    /// Goes past the scan's data, which begin at `start`, and gives the position of the marker behind them. `units` are the
    /// columns and rows of units where components are interleaved.
    pub(super) fn pass(
        &self,
        start: usize,
        all: &mut [Component],
        defined: &Defined,
        units: (u32, u32),
        junk: &mut Junk<'_>,
    ) -> Result<usize, String> {
        let mut coder = Coder::new(self, defined)?;
        // The blocks of a component that comes alone come row by row, and those that hold no pixels do not come.
        let alone = if let [(at, ..)] = self.components[..] { Some(at) } else { None };
        let (columns, rows) = alone.map_or(units, |at| all[at].blocks);
        let counts: Vec<u32> = self.components.iter().map(|&(at, ..)| alone.map_or(all[at].unit, |_| 1)).collect();
        let mut none = Vec::new();
        let there = if self.band.0 > 0 { alone.map_or(&mut none, |at| &mut all[at].there) } else { &mut none };
        let mut bits = Bits::new(junk.file, start);
        let (mut left, mut restarts) = (defined.interval, 0u8);
        for row in 0..rows {
            let fault = |fault: Fault| format!("{}, in row {row} of the {rows} rows of blocks", words(fault));
            for column in 0..columns {
                if left == 0 && defined.interval > 0 {
                    coder.end_run().map_err(fault)?;
                    let (at, marker) = junk.next_marker(bits)?;
                    if marker != Some(0xd0 + restarts % 8) {
                        return Err(format!(
                            "the JPEG is damaged: a restart marker is missing, in row {row} of the {rows} rows of blocks"
                        ));
                    }
                    bits = Bits::new(junk.file, at + 2);
                    (left, restarts) = (defined.interval, restarts.wrapping_add(1));
                }
                left = left.wrapping_sub(1);
                let there = there.get_mut(row as usize * columns as usize + column as usize);
                bits = coder.pass_unit(bits, &counts, there).map_err(fault)?;
            }
        }
        coder.end_run().map_err(|fault| words(fault).to_owned())?;
        Ok(junk.next_marker(bits)?.0)
    }
}

/// Goes past the units of a scan.
enum Coder<'t> {
    /// Whole blocks.
    Sequential(Vec<(&'t Table, &'t Table, Runs)>),
    /// The first bits of first coefficients.
    Dc(Vec<&'t Table>),
    /// A further bit of first coefficients.
    DcBit,
    /// The first bits of other coefficients.
    Ac(Band, &'t Table),
    /// A further bit of other coefficients.
    AcBit(Band, &'t Table),
}

impl<'t> Coder<'t> {
    fn new(scan: &Scan, defined: &'t Defined) -> Result<Self, String> {
        let find = |all: &'t [Option<Table>; 4], number: usize| {
            let table = all.get(number).and_then(Option::as_ref);
            table.ok_or_else(|| {
                format!("the JPEG lacks Huffman table {number}, as frames of video do: write it anew with its tables")
            })
        };
        let (first, last) = (u32::from(scan.band.0), u32::from(scan.band.1));
        let parts = &scan.components;
        Ok(match (scan.progressive, first, scan.before) {
            (false, ..) => {
                let tables = |&(_, dc, ac): &(usize, usize, usize)| {
                    let ac = find(&defined.ac, ac)?;
                    Ok((find(&defined.dc, dc)?, ac, Runs::of(ac)))
                };
                Coder::Sequential(parts.iter().map(tables).collect::<Result<_, String>>()?)
            }
            (true, 0, 0) => Coder::Dc(parts.iter().map(|&(_, dc, _)| find(&defined.dc, dc)).collect::<Result<_, _>>()?),
            (true, 0, _) => Coder::DcBit,
            (true, _, before) => {
                let band = Band { first, last, empty: 0 };
                let ac = find(&defined.ac, parts[0].2)?;
                if before == 0 { Coder::Ac(band, ac) } else { Coder::AcBit(band, ac) }
            }
        })
    }

    /// Goes past a unit: `counts` blocks of each component. `there` is of the block where it is one of other coefficients.
    fn pass_unit<'a>(
        &mut self,
        mut bits: Bits<'a>,
        counts: &[u32],
        there: Option<&mut u64>,
    ) -> Result<Bits<'a>, Fault> {
        match (self, there) {
            (Coder::Sequential(tables), _) => {
                for (&count, (dc, ac, runs)) in counts.iter().zip(tables) {
                    (0..count).try_for_each(|_| sequential(&mut bits, dc, (ac, runs)))?;
                }
            }
            (Coder::Dc(tables), _) => {
                for (&count, dc) in counts.iter().zip(tables) {
                    (0..count).try_for_each(|_| first_dc(&mut bits, dc))?;
                }
            }
            (Coder::DcBit, _) => (0..counts.iter().sum()).try_for_each(|_| bits.pass(1))?,
            (Coder::Ac(band, ac), Some(there)) => band.first(&mut bits, ac, there)?,
            (Coder::AcBit(band, ac), Some(there)) => band.further(&mut bits, ac, there)?,
            (Coder::Ac(..) | Coder::AcBit(..), None) => return Err(Fault::Overrun),
        }
        Ok(bits)
    }

    /// Ends a run of blocks: none may go past a restart or the end.
    fn end_run(&self) -> Result<(), Fault> {
        match self {
            Coder::Ac(band, _) | Coder::AcBit(band, _) if band.empty > 0 => Err(Fault::Ended),
            _ => Ok(()),
        }
    }
}

fn words(fault: Fault) -> &'static str {
    match fault {
        Fault::Ended => "the JPEG is cut short: its coded data end before the last block",
        Fault::NoCode => "the JPEG is damaged: its coded data hold bits that are no code",
        Fault::NoSymbol => "the JPEG is damaged: its coded data hold a code that means nothing",
        Fault::Overrun => "the JPEG is damaged: a block has too many coefficients",
    }
}
