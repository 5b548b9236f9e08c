//! `cameras.bin` and `images.bin`, little endian:
//!
//! ```text
//! cameras   u64 count; each u32 id, i32 model, u64 width, u64 height, f64 parameters, as many as the model has
//! images    u64 count; each u32 id, f64 quaternion w x y z, f64 translation x y z, u32 camera, name, 0,
//!           u64 points; each f64 x, f64 y, u64 point
//! ```

use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use super::models;
use super::posed::{Cameras, Image};
use crate::base::input::Input;
use crate::base::{Error, Result};
use crate::scene::frame::Frame;

/// The bytes of a 2D point.
const POINT: u64 = 24;
/// The most bytes of an image's name, its 0 among them.
const LONGEST_NAME: u64 = 4096;

/// A file that is read front to back, up to the length that it had when it was opened.
struct Bytes {
    file: BufReader<Input>,
    left: u64,
    /// The system's error, if there was one: it says nothing of what the file holds.
    failed: Option<io::Error>,
}

impl Bytes {
    fn open(path: &Path) -> Result<Bytes> {
        let file = Input::open(path).map_err(Error::io("open", path))?;
        let left = file.length();
        Ok(Bytes { file: BufReader::new(file), left, failed: None })
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        const CUT: &str = "the file ends within it; it was cut short";
        let mut bytes = [0; N];
        self.left = self.left.checked_sub(N as u64).ok_or(CUT)?;
        self.file.read_exact(&mut bytes).map_err(|why| self.keep(why, CUT))?;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, String> {
        self.take().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Result<u64, String> {
        self.take().map(u64::from_le_bytes)
    }

    fn f64(&mut self) -> Result<f64, String> {
        self.take().map(f64::from_le_bytes)
    }

    fn f64s<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut all = [0.0; N];
        all.iter_mut().try_for_each(|v| self.f64().map(|read| *v = read))?;
        Ok(all)
    }

    fn name(&mut self) -> Result<String, String> {
        let mut bytes = Vec::new();
        let read = (&mut self.file).take(LONGEST_NAME.min(self.left)).read_until(0, &mut bytes);
        self.left -= read.map_err(|why| self.keep(why, "its name cannot be read"))? as u64;
        if bytes.pop() != Some(0) {
            return Err(format!("its name does not end within {LONGEST_NAME} bytes"));
        }
        String::from_utf8(bytes).map_err(|_| "its name is not UTF-8".to_owned())
    }

    fn skip(&mut self, bytes: Option<u64>) -> Result<(), String> {
        let bytes = bytes.filter(|&n| n <= self.left).ok_or("it claims more points than the file has bytes for")?;
        self.left -= bytes;
        let seek = i64::try_from(bytes).map_err(|e| e.to_string())?;
        self.file.seek_relative(seek).map_err(|why| self.keep(why, "its points cannot be skipped"))
    }

    /// Keeps an error of the system; gives what else there is to say.
    fn keep(&mut self, why: io::Error, words: &str) -> String {
        if why.kind() != ErrorKind::UnexpectedEof {
            self.failed = Some(why);
        }
        words.to_owned()
    }

    /// Reads elements and the end after them; says in words what is wrong.
    fn each(&mut self, what: &str, mut one: impl FnMut(&mut Bytes) -> Result<(), String>) -> Result<(), String> {
        let count = self.u64()?;
        for i in 0..count {
            one(self).map_err(|why| format!("{what} {} of {count}: {why}", i + 1))?;
        }
        if self.left == 0 { Ok(()) } else { Err(format!("{} bytes follow its {count} {what}s", self.left)) }
    }
}

/// Reads the elements of a file; errors name the number of the element.
fn each(path: &Path, what: &str, one: impl FnMut(&mut Bytes) -> Result<(), String>) -> Result<()> {
    let mut bytes = Bytes::open(path)?;
    let read = bytes.each(what, one);
    let failed = bytes.failed.take().map_or_else(|| bytes.file.get_ref().check_unchanged(), Err);
    failed.map_err(Error::io("read", path))?;
    read.map_err(|found| Error::malformed(path, found))
}

/// Reads `cameras.bin`.
pub(super) fn cameras(path: &Path) -> Result<Cameras> {
    let mut all = Cameras::default();
    each(path, "camera", |bytes| {
        let id = bytes.u32()?;
        let model = i32::from_le_bytes(bytes.take()?);
        let (width, height) = (bytes.u64()?, bytes.u64()?);
        let model = models::by_id(model)?;
        let parameters = (0..model.count()).map(|_| bytes.f64()).collect::<Result<Vec<f64>, String>>()?;
        all.add(id, model.camera(width, height, &parameters)?)
    })?;
    Ok(all)
}

/// Reads `images.bin`.
pub(super) fn images(path: &Path, cameras: &Cameras) -> Result<Vec<Frame>> {
    let mut all = Vec::new();
    each(path, "image", |bytes| {
        bytes.u32()?;
        let (quaternion, translation) = (bytes.f64s()?, bytes.f64s()?);
        let camera = bytes.u32()?;
        let name = bytes.name()?;
        let points = bytes.u64()?;
        bytes.skip(points.checked_mul(POINT))?;
        all.push(Image { name, quaternion, translation, camera }.frame(cameras)?);
        Ok(())
    })?;
    Ok(all)
}
