//! Trajectories of Tanks and Temples, `.log` (its tutorial, "Camera poses"; Open3D writes the same).
//!
//! ```text
//! i j 0
//! a camera-to-world matrix, four rows; the identity where j is -1: the image is not registered
//! ```
//!
//! i counts the images sorted by name. Axes are ours. There is no lens: `cameras.txt`, as COLMAP writes it, with one camera,
//! must lie beside. Where `*_trans.txt` lies beside, poses are moved by it: it leads to the laser scan.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec3};

use super::colmap::only_camera;
use super::format::{PoseFormat, Posed, Target};
use super::photographs::Photographs;
use super::words::Words;
use super::{found, posed, whole};
use crate::base::{Error, Result};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// Tanks and Temples' trajectory.
pub(crate) const TANKS_AND_TEMPLES: PoseFormat = PoseFormat {
    name: "tanks_and_temples",
    programs: "Tanks and Temples, Open3D",
    target: Target::Either,
    advice: "name the .log file or the folder that holds it, with cameras.txt beside it",
    is_at: |path| file(path).is_some_and(|file| is_one(&file)),
    missing: |path| found::missing(path, file(path).is_some(), "must be a .log file or hold one"),
    read,
};

fn file(path: &Path) -> Option<PathBuf> {
    found::told(path, &[".log"], is_one)
}

/// Whether a file begins with three whole numbers and 16 others.
fn is_one(file: &Path) -> bool {
    let text = whole::start_text(file, 1024);
    let mut words = Words::of(&text);
    let head = words.line().unwrap_or_default().split_ascii_whitespace().map(str::parse::<i64>);
    head.filter(Result::is_ok).count() == 3 && words.numbers::<12>("a matrix").is_ok()
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no .log file is there"))?;
    let folder = file.parent().unwrap_or(Path::new(""));
    let cameras = folder.join("cameras.txt");
    if !cameras.is_file() {
        let found = "it holds no lens: put cameras.txt beside it, as COLMAP writes it, with one camera (the guide of Tanks \
                     and Temples guesses a focal length of 0.7 image widths)";
        return Err(Error::malformed(&file, found));
    }
    let camera = Arc::new(only_camera(&cameras)?);
    let text = whole::text(&file)?;
    let stations = stations(&text).map_err(|why| Error::malformed(&file, why))?;
    let (scan, mut notes) = match found::ending(folder, &["_trans.txt"]).into_iter().next() {
        Some(file) => {
            let note =
                format!("poses are moved by {}: the mesh must be in the coordinates of the scan", file.display());
            (Some(alignment(&file)?), vec![note])
        }
        None => (None, Vec::new()),
    };
    let names = photographs.names()?;
    let (mut frames, mut unposed) = (Vec::new(), Vec::new());
    for Station { image, matrix } in stations {
        let name = usize::try_from(image).ok().and_then(|at| names.get(at)).ok_or_else(|| {
            let there = names.len();
            let found = format!("pose {image} counts the images sorted by name, and {there} are there");
            Error::malformed(&file, format!("{found}: name the folder of all photographs"))
        })?;
        let Some(matrix) = matrix else {
            unposed.push(name.clone());
            continue;
        };
        let pose = pose(matrix, scan).map_err(|why| Error::malformed(&file, format!("pose {image}: {why}")))?;
        frames.push(Frame { name: name.clone(), camera: Arc::clone(&camera), pose });
    }
    notes.push("the lens is that of cameras.txt".to_owned());
    Ok(Posed { frames, unposed, notes, ..Posed::default() })
}

/// A pose of the file; no matrix where the image is not registered.
struct Station {
    image: u64,
    matrix: Option<DMat4>,
}

fn stations(text: &str) -> Result<Vec<Station>, String> {
    let (mut words, mut all) = (Words::of(text), Vec::new());
    while let Some(word) = words.word() {
        let image: u64 = super::words::number(word, "an image's number")
            .map_err(|why| format!("line {}: {why}", words.line_number()))?;
        let other: i64 = words.number("the second number")?;
        let _: f64 = words.number("the third number")?;
        let matrix = matrix(&mut words)?;
        all.push(Station { image, matrix: (other >= 0).then_some(matrix) });
    }
    Ok(all)
}

/// The next 16 numbers, by rows.
fn matrix(words: &mut Words<'_>) -> Result<DMat4, String> {
    let matrix = words.numbers::<16>("a matrix")?;
    if matrix[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(format!("line {}: the last row is {:?}; it must be 0 0 0 1", words.line_number(), &matrix[12..]));
    }
    Ok(DMat4::from_cols_array(&matrix).transpose())
}

/// A similarity: scale, rotation, shift.
type Similarity = (f64, DMat3, DVec3);

/// The way from the poses' world to the scan.
fn alignment(file: &Path) -> Result<Similarity> {
    let text = whole::text(file)?;
    let read = |text: &str| -> Result<Similarity, String> {
        let matrix = matrix(&mut Words::of(text))?;
        let linear = DMat3::from_mat4(matrix);
        let scale = linear.determinant().cbrt();
        if !(scale.is_finite() && scale > 1e-9) {
            return Err(format!("its determinant is {}; it must be above 0", linear.determinant()));
        }
        let turn = DMat3::from_quat(posed::rotation(linear * (1.0 / scale))?);
        Ok((scale, turn, matrix.w_axis.truncate()))
    };
    read(&text).map_err(|why| Error::malformed(file, why))
}

fn pose(to_world: DMat4, scan: Option<Similarity>) -> Result<Pose, String> {
    let (turned, centre) = (DMat3::from_mat4(to_world), to_world.w_axis.truncate());
    match scan {
        Some((scale, turn, shift)) => posed::at_centre((turn * turned).transpose(), turn * centre * scale + shift),
        None => posed::at_centre(turned.transpose(), centre),
    }
}
