//! The lines and columns of byte offsets in one text. As many may be asked for as the text has bytes.

use super::problem::Position;

/// Bytes of a block; at most so many are looked at for one position.
const BLOCK: usize = 64;

/// A text whose blocks know where they start.
pub(super) struct Places<'t> {
    text: &'t str,
    /// Line and column of the first byte of each block.
    blocks: Vec<(usize, usize)>,
}

impl<'t> Places<'t> {
    /// Looks through a text once.
    pub(super) fn of(text: &'t str) -> Self {
        let mut at = (1, 1);
        let mut blocks = vec![at];
        for block in text.as_bytes().chunks_exact(BLOCK) {
            at = block.iter().fold(at, after);
            blocks.push(at);
        }
        Places { text, blocks }
    }

    /// The position of a byte offset; that of the end for an offset beyond it.
    pub(super) fn position(&self, offset: usize) -> Position {
        let offset = offset.min(self.text.len());
        let block = offset / BLOCK;
        let (line, column) = self.text.as_bytes()[block * BLOCK..offset].iter().fold(self.blocks[block], after);
        Position::File { line, column }
    }
}

/// Line and column after a byte. Columns count characters, which begin with their first byte.
fn after((line, column): (usize, usize), byte: &u8) -> (usize, usize) {
    match byte {
        b'\n' => (line + 1, 1),
        0x80..=0xbf => (line, column),
        _ => (line, column + 1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_offset_is_where_counting_from_the_start_says() {
        let lines = ["", "a", "äöü€😀", "[scene]", &"x".repeat(63), &"ä".repeat(70), ""];
        for text in [lines.join("\n"), lines.concat(), "\n".repeat(200), String::new(), "x".repeat(BLOCK)] {
            let places = Places::of(&text);
            for (offset, _) in text.char_indices().chain([(text.len(), ' ')]) {
                let before = &text[..offset];
                let start = before.rfind('\n').map_or(0, |newline| newline + 1);
                let (line, column) = (before.matches('\n').count() + 1, before[start..].chars().count() + 1);
                assert_eq!(places.position(offset), Position::File { line, column }, "{offset} of {text:?}");
            }
            assert_eq!(places.position(text.len() + 9), places.position(text.len()));
        }
    }
}
