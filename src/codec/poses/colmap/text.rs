//! `cameras.txt` and `images.txt`. Lines that begin with `#` are comments.
//!
//! ```text
//! cameras   id MODEL width height parameters...
//! images    two lines each: id qw qx qy qz tx ty tz camera name; then the 2D points, or nothing
//! ```

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::str::FromStr;

use super::models;
use super::posed::{Cameras, Image};
use crate::base::input::Input;
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::meshes::line_end;
use crate::scene::frame::Frame;

/// The most bytes of a line: a million 2D points.
const LONGEST_LINE: u64 = 64 << 20;

/// Gives each line that says something to `line`, which answers whether the line after it is a list of 2D points. A byte-order mark
/// before the first is passed over.
fn each_line(path: &Path, mut line: impl FnMut(&str) -> Result<bool, String>) -> Result<()> {
    let mut file = BufReader::new(Input::open(path).map_err(Error::io("open", path))?);
    let (mut bytes, mut skip) = (Vec::new(), false);
    let end = line_end(file.fill_buf().map_err(Error::io("read", path))?);
    for number in 1.. {
        bytes.clear();
        let read = std::io::Read::take(&mut file, LONGEST_LINE).read_until(end, &mut bytes);
        if read.map_err(Error::io("read", path))? == 0 {
            break;
        }
        let fault = |why: String| Error::malformed(path, format!("line {number}: {why}"));
        if bytes.len() as u64 == LONGEST_LINE {
            return Err(fault("it is longer than 64 MiB".to_owned()));
        }
        let text = std::str::from_utf8(&bytes).map_err(|_| fault("it is not UTF-8".to_owned()))?;
        let text = text.trim_start_matches('\u{feff}').trim();
        if std::mem::take(&mut skip) {
            if !is_points(text) {
                let rule = "each image has two lines, of which the second, with points or empty, is missing here";
                return Err(fault(format!("it is no list of 2D points (x y id): {rule}")));
            }
            continue;
        }
        if !text.is_empty() && !text.starts_with('#') {
            skip = line(text).map_err(fault)?;
        }
    }
    file.get_ref().check_unchanged().map_err(Error::io("read", path))
}

/// Whether a line may be a list of 2D points: threes of numbers, of which the last is whole.
fn is_points(line: &str) -> bool {
    let mut words = line.split_ascii_whitespace();
    let first = words.next().is_none_or(|word| word.parse::<f64>().is_ok());
    let last = words.next_back().is_none_or(|word| word.parse::<i64>().is_ok());
    // A short line may be of the other kind; a long one is none.
    first && last && (line.is_empty() || line.split_ascii_whitespace().count().is_multiple_of(3))
}

/// Takes the next word of a line as a number.
fn number<T: FromStr>(rest: &mut &str, what: &str) -> Result<T, String> {
    let (word, after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
    *rest = after.trim_start();
    word.parse().map_err(|_| format!("{what} is {}; a number of its kind is needed", shown(word)))
}

fn numbers<const N: usize>(rest: &mut &str, what: &str) -> Result<[f64; N], String> {
    let mut all = [0.0; N];
    all.iter_mut().try_for_each(|v| number(rest, what).map(|n| *v = n))?;
    Ok(all)
}

/// Reads `cameras.txt`.
pub(super) fn cameras(path: &Path) -> Result<Cameras> {
    let mut all = Cameras::default();
    each_line(path, |mut line| {
        let id = number(&mut line, "the id")?;
        let (name, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let model = models::by_name(name)?;
        line = rest.trim_start();
        let (width, height) = (number(&mut line, "the width")?, number(&mut line, "the height")?);
        let mut parameters = Vec::new();
        while !line.is_empty() {
            parameters.push(number(&mut line, "a parameter")?);
        }
        all.add(id, model.camera(width, height, &parameters)?)?;
        Ok(false)
    })?;
    Ok(all)
}

/// Reads `images.txt`.
pub(super) fn images(path: &Path, cameras: &Cameras) -> Result<Vec<Frame>> {
    let mut all = Vec::new();
    each_line(path, |mut line| {
        let _: u32 = number(&mut line, "the id")?;
        let quaternion = numbers(&mut line, "the quaternion")?;
        let translation = numbers(&mut line, "the translation")?;
        let camera = number(&mut line, "the camera")?;
        all.push(Image { name: line.to_owned(), quaternion, translation, camera }.frame(cameras)?);
        Ok(true)
    })?;
    Ok(all)
}
