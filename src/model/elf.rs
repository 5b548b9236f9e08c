//! Whether the file of a Linux shared library is complete. The system's loader maps all that the header promises, and if the
//! file is cut short, the first touch of a missing page kills the process; so the promise is checked first.
//!
//! ELF-64, System V ABI 4.1 "Object Files": the section table ends the file (`e_shoff`, `e_shentsize`, `e_shnum`), and
//! every program header's `p_offset + p_filesz` lies within it.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;

use crate::base::input::Input;

/// Checks that a library's file is complete. Files of other systems' formats pass.
pub fn complete(path: &Path) -> Result<(), String> {
    let mut file = Input::open(path).map_err(|e| e.to_string())?;
    let length = file.length();
    match segments_end(&mut file) {
        Ok(Some(end)) if end > length => {
            Err(format!("it is cut short: {length} bytes of at least {end}; copy or install it again"))
        }
        Ok(_) => Ok(()),
        Err(e) => Err(format!("it is no complete shared library: {e}")),
    }
}

/// The least length of a complete file, or `None` if the file is no ELF-64 file.
fn segments_end(file: &mut Input) -> io::Result<Option<u64>> {
    let mut header = [0u8; 64];
    let mut magic = 0;
    while magic < header.len() {
        match file.read(&mut header[magic..])? {
            0 => break,
            n => magic += n,
        }
    }
    if !header.starts_with(b"\x7fELF\x02\x01") {
        return Ok(None);
    }
    if magic < header.len() {
        return Ok(Some(header.len() as u64));
    }
    let sections = u64_at(&header, 40).saturating_add(u16_at(&header, 58) * u16_at(&header, 60));
    let (start, size, count) = (u64_at(&header, 32), u16_at(&header, 54), u16_at(&header, 56));
    let mut end = sections.max(start.saturating_add(size * count));
    if size < 56 || end > file.length() {
        return Ok(Some(end.max(64)));
    }
    for i in 0..count {
        let mut program = [0u8; 56];
        file.seek(SeekFrom::Start(start + i * size))?;
        file.read_exact(&mut program)?;
        end = end.max(u64_at(&program, 8).saturating_add(u64_at(&program, 32)));
    }
    Ok(Some(end))
}

fn u16_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]))
}

fn u64_at(bytes: &[u8], at: usize) -> u64 {
    let mut eight = [0; 8];
    eight.copy_from_slice(&bytes[at..at + 8]);
    u64::from_le_bytes(eight)
}
