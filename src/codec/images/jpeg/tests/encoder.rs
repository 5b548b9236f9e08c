//! A JPEG writer that makes every kind of scan, of coefficients that are given. Its Huffman codes are the symbols themselves in
//! eight bits.

/// A component: sampling factors, and quantised coefficients in zigzag order, block by block, row by row, for the whole grid of
/// units.
#[derive(Clone)]
pub(super) struct Part {
    pub across: usize,
    pub down: usize,
    pub blocks: Vec<[i32; 64]>,
}

/// An image to be written.
#[derive(Clone)]
pub(super) struct Picture {
    pub width: usize,
    pub height: usize,
    pub parts: Vec<Part>,
}

/// A scan: components, first and last coefficient, the bit sent before and the bit sent now.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan(pub &'static [usize], pub usize, pub usize, pub u32, pub u32);

/// A file, and the ranges of its scans with their headers, and of the coded data in each.
pub(super) struct Written {
    pub file: Vec<u8>,
    pub scans: Vec<(std::ops::Range<usize>, std::ops::Range<usize>)>,
}

impl Picture {
    /// An image with coefficients as a photograph has them: a few low ones in most blocks.
    pub(super) fn new(width: usize, height: usize, samplings: &[(usize, usize)]) -> Picture {
        let most = |f: fn(&(usize, usize)) -> usize| samplings.iter().map(f).max().unwrap();
        let (columns, rows) = (width.div_ceil(8 * most(|s| s.0)), height.div_ceil(8 * most(|s| s.1)));
        let mut random = 12345u32;
        let mut next = move || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 16) as i32
        };
        let part = |&(across, down): &(usize, usize)| {
            let mut block = || {
                let mut block = [0; 64];
                block[0] = next() % 60 - 30;
                for _ in 0..next() % 9 {
                    block[(next() % 40 + 1) as usize] = next() % 13 - 6;
                }
                block
            };
            let blocks = (0..columns * across * rows * down).map(|_| block()).collect();
            Part { across, down, blocks }
        };
        Picture { width, height, parts: samplings.iter().map(part).collect() }
    }

    fn units(&self) -> (usize, usize) {
        let most = |f: fn(&Part) -> usize| self.parts.iter().map(f).max().unwrap();
        (self.width.div_ceil(8 * most(|p| p.across)), self.height.div_ceil(8 * most(|p| p.down)))
    }

    /// The blocks of each unit of a scan: pairs of component and block.
    fn order(&self, parts: &[usize]) -> Vec<Vec<(usize, usize)>> {
        let (columns, rows) = self.units();
        let most = |f: fn(&Part) -> usize| self.parts.iter().map(f).max().unwrap();
        if let &[one] = parts {
            let Part { across, down, .. } = self.parts[one];
            let wide = (self.width * across).div_ceil(8 * most(|p| p.across));
            let high = (self.height * down).div_ceil(8 * most(|p| p.down));
            let each = |y: usize| (0..wide).map(move |x| vec![(one, y * columns * across + x)]);
            return (0..high).flat_map(each).collect();
        }
        let unit = |n: usize| {
            let (ux, uy) = (n % columns, n / columns);
            let of_part = |&part: &usize| {
                let Part { across, down, .. } = self.parts[part];
                let place = move |k: usize| (uy * down + k / across) * columns * across + ux * across + k % across;
                (0..across * down).map(move |k| (part, place(k))).collect::<Vec<_>>()
            };
            parts.iter().flat_map(of_part).collect()
        };
        (0..columns * rows).map(unit).collect()
    }

    /// Writes a file with these scans; none are one sequential scan of all components. `interval` is 0 for no restarts.
    pub(super) fn write(&self, plans: &[Plan], interval: usize) -> Written {
        let progressive = plans.iter().any(|plan| plan.2 != 63);
        let mut file = vec![0xff, 0xd8, 0xff, 0xdb, 0, 67, 0];
        file.extend((0..64).map(|k| 2 + k / 8));
        let size = [self.height >> 8, self.height & 255, self.width >> 8, self.width & 255].map(|b| b as u8);
        let count = self.parts.len();
        file.extend([0xff, if progressive { 0xc2 } else { 0xc0 }, 0, 8 + 3 * count as u8, 8]);
        file.extend(size);
        file.push(count as u8);
        for (at, part) in self.parts.iter().enumerate() {
            file.extend([at as u8 + 1, (part.across << 4 | part.down) as u8, 0]);
        }
        for (class, symbols) in [(0x00, 12), (0x10, 255u8)] {
            let [high, low] = (19 + u16::from(symbols)).to_be_bytes();
            file.extend([0xff, 0xc4, high, low, class]);
            file.extend([0, 0, 0, 0, 0, 0, 0, symbols, 0, 0, 0, 0, 0, 0, 0, 0]);
            file.extend(0..symbols);
        }
        if interval > 0 {
            file.extend([0xff, 0xdd, 0, 4, (interval >> 8) as u8, interval as u8]);
        }
        let mut scans = Vec::new();
        for plan in plans {
            let start = file.len();
            file.extend([0xff, 0xda, 0, 6 + 2 * plan.0.len() as u8, plan.0.len() as u8]);
            plan.0.iter().for_each(|&part| file.extend([part as u8 + 1, 0]));
            file.extend([plan.1 as u8, plan.2 as u8, (plan.3 << 4 | plan.4) as u8]);
            let data = file.len();
            self.scan(plan, interval, &mut file);
            scans.push((start..file.len(), data..file.len()));
        }
        file.extend([0xff, 0xd9]);
        Written { file, scans }
    }

    fn scan(&self, plan: &Plan, interval: usize, file: &mut Vec<u8>) {
        let mut coder = Coder { file, held: 0, count: 0, run: 0, corrections: Vec::new() };
        let mut before = vec![0; self.parts.len()];
        for (n, unit) in self.order(plan.0).into_iter().enumerate() {
            if interval > 0 && n > 0 && n % interval == 0 {
                coder.end();
                coder.file.extend([0xff, 0xd0 + (n / interval - 1) as u8 % 8]);
                before.fill(0);
            }
            for (part, at) in unit {
                coder.block(plan, &self.parts[part].blocks[at], &mut before[part]);
            }
        }
        coder.end();
    }
}

struct Coder<'a> {
    file: &'a mut Vec<u8>,
    held: u64,
    count: u32,
    /// Blocks that end and are not told of yet, and the bits of their coefficients that are there.
    run: u32,
    corrections: Vec<u32>,
}

impl Coder<'_> {
    fn put(&mut self, bits: u32, count: u32) {
        self.held = self.held << count | u64::from(bits) & ((1 << count) - 1);
        self.count += count;
        while self.count >= 8 {
            let byte = (self.held >> (self.count - 8)) as u8;
            self.file.push(byte);
            if byte == 0xff {
                self.file.push(0);
            }
            self.count -= 8;
        }
    }

    fn value(&mut self, run: u32, value: i32) {
        let size = 32 - value.unsigned_abs().leading_zeros();
        self.put(run << 4 | size, 8);
        self.put(if value < 0 { value - 1 } else { value } as u32, size);
    }

    fn end(&mut self) {
        self.end_run();
        self.put(0x7f, (8 - self.count % 8) % 8);
    }

    fn end_run(&mut self) {
        if self.run > 0 {
            let size = 31 - self.run.leading_zeros();
            self.put(size << 4, 8);
            self.put(self.run, size);
            self.run = 0;
        }
        std::mem::take(&mut self.corrections).into_iter().for_each(|bit| self.put(bit, 1));
    }

    fn block(&mut self, &Plan(_, first, last, before, now): &Plan, block: &[i32; 64], dc: &mut i32) {
        if first > 0 {
            return self.band(&block[first..=last], before, now);
        }
        if before > 0 {
            return self.put((block[0] >> now) as u32, 1);
        }
        let value = block[0] >> now;
        self.value(0, value - *dc);
        *dc = value;
        if last == 63 {
            self.others(block);
        }
    }

    /// The coefficients of a block after the first, whole.
    fn others(&mut self, block: &[i32; 64]) {
        let mut zeros = 0;
        for &value in &block[1..] {
            if value == 0 {
                zeros += 1;
                continue;
            }
            while zeros > 15 {
                self.put(0xf0, 8);
                zeros -= 16;
            }
            self.value(zeros, value);
            zeros = 0;
        }
        if zeros > 0 {
            self.put(0, 8);
        }
    }

    /// Some bits of some coefficients of a block.
    fn band(&mut self, band: &[i32], before: u32, now: u32) {
        let sent = |value: i32| before > 0 && value.abs() >> before != 0;
        let value = |value: i32| value.signum() * (value.abs() >> now);
        let end = band.iter().rposition(|&v| value(v) != 0 && !sent(v)).map_or(0, |last| last + 1);
        let (mut zeros, mut bits) = (0, Vec::new());
        for &whole in &band[..end] {
            if value(whole) == 0 {
                zeros += 1;
                continue;
            }
            while zeros > 15 {
                self.end_run();
                self.put(0xf0, 8);
                zeros -= 16;
                std::mem::take(&mut bits).into_iter().for_each(|bit| self.put(bit, 1));
            }
            if sent(whole) {
                bits.push(whole.unsigned_abs() >> now & 1);
                continue;
            }
            self.end_run();
            if before == 0 {
                self.value(zeros, value(whole));
            } else {
                self.put(zeros << 4 | 1, 8);
                self.put(u32::from(whole > 0), 1);
            }
            std::mem::take(&mut bits).into_iter().for_each(|bit| self.put(bit, 1));
            zeros = 0;
        }
        if end < band.len() {
            self.run += 1;
            let rest = band[end..].iter().filter(|&&v| sent(v));
            self.corrections.extend(rest.map(|v| v.unsigned_abs() >> now & 1));
        }
    }
}
