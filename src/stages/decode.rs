//! Decode: an image file becomes linear radiance on the pixel grid that its pose was solved on.

use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::base::convert::to_f32;
use crate::base::ids::FrameId;
use crate::base::patience::Patience;
use crate::base::shown::quoted;
use crate::base::{Error, Result, key};
use crate::codec::images::{self, Curve, Encoded, Need, Size};
use crate::config::{Choice, Effect, Key, Keys, Problem, Section, Settings, Value, outside};
use crate::flow::{Map, Outlet, Reservation, Skipped};
use crate::scene::frame::{Frame, LinearImage};

/// Section `[decode]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// How stored values become linear radiance.
    pub transfer: Transfer,
    /// The exponent of [`Transfer::Gamma`], 0.2 to 5; none with any other transfer.
    pub gamma: Option<f64>,
    /// How much smaller images are, each way, than their cameras: 1 to 64. A side that it does not divide may be rounded down or up:
    /// 1617 by 1208 pixels become 808 or 809 by 604.
    pub downscale: u32,
    /// How the exposure of each frame is taken into account.
    pub exposure: Exposure,
}

/// How the exposure of each frame is taken into account.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Exposure {
    /// The gain of each frame against the others is found from triangles that several frames see, and divided out.
    Solve,
    /// All frames are taken to be exposed alike.
    AsIs,
}

impl Choice for Exposure {
    const NAMES: &'static [(&'static str, Self)] = &[("solve", Exposure::Solve), ("as_is", Exposure::AsIs)];
}

/// How stored values in [0, 1] become linear radiance. Floating-point files are linear and are never changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Transfer {
    /// By the inverse of IEC 61966-2-1: a camera's JPEG holds such values.
    Srgb,
    /// Stored values are linear.
    Linear,
    /// Stored values to the power of `gamma`.
    Gamma,
}

impl Choice for Transfer {
    const NAMES: &'static [(&'static str, Self)] =
        &[("srgb", Transfer::Srgb), ("linear", Transfer::Linear), ("gamma", Transfer::Gamma)];
}

impl Section for Config {
    const NAME: &'static str = "decode";
    const ABOUT: &'static str = "How photographs become linear radiance.";
    const KEYS: &'static [Key] = &[
        Key {
            name: "transfer",
            doc: "What the stored values mean: \"srgb\", as cameras and phones write them; \"linear\"; or \"gamma\" with an \
                  exponent.",
            value: Value::Default("\"srgb\""),
        },
        Key {
            name: "gamma",
            doc: "The exponent, 0.2 to 5, with transfer = \"gamma\" only.",
            value: Value::Optional("2.2"),
        },
        Key {
            name: "downscale",
            doc: "How much smaller the photographs are, each way, than the cameras of the poses, 1 to 64.",
            value: Value::Default("1"),
        },
        Key {
            name: "exposure",
            doc: "\"solve\": how much brighter or darker each photograph was exposed than the others is found from what several \
                  of them see, and divided out. \"as_is\": all are taken to be exposed alike.",
            value: Value::Default("\"solve\""),
        },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let transfer = keys.choice("transfer");
        let gamma = keys.optional("gamma");
        // A transfer that cannot be read may be the one that needs a gamma.
        if keys.is_good("transfer") {
            check_gamma(keys, transfer, gamma);
        }
        let (downscale, exposure) = (keys.within("downscale", 1..=64), keys.choice("exposure"));
        Config { transfer, gamma, downscale, exposure }
    }

    fn settings(&self) -> Settings {
        let Config { transfer, gamma, downscale, exposure } = self;
        Settings::of(Self::NAME)
            .with("transfer", transfer.name(), Effect::Cast)
            .optional("gamma", *gamma, Effect::Cast)
            .with("downscale", downscale, Effect::Cast)
            .with("exposure", exposure.name(), Effect::Look)
    }
}

fn check_gamma(keys: &Keys<'_>, transfer: Transfer, gamma: Option<f64>) {
    let problem = match (transfer, gamma) {
        (Transfer::Gamma, None) => Some(Problem::new("is needed where transfer = \"gamma\"").hint("add `gamma = 2.2`")),
        (Transfer::Gamma, Some(gamma)) => outside(&(0.2..=5.0), &gamma),
        (other, Some(_)) => {
            let rule = format!("has no meaning where transfer = \"{}\"", other.name());
            Some(Problem::new(rule).hint("take it out, or set transfer = \"gamma\""))
        }
        (_, None) => None,
    };
    if let Some(problem) = problem {
        keys.check("gamma", false, problem);
    }
}

impl Config {
    /// The tables of the transfer.
    pub fn curve(&self) -> Curve {
        Curve::new(match (self.transfer, self.gamma) {
            (Transfer::Srgb, _) => images::Transfer::Srgb,
            (Transfer::Gamma, Some(gamma)) => images::Transfer::Gamma(to_f32(gamma)),
            (Transfer::Linear | Transfer::Gamma, _) => images::Transfer::Linear,
        })
    }
}

/// What was found under the name of an input file, as a recipe has it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Content {
    /// Bytes with this key, whole or broken.
    Bytes(key::Key),
    /// Nothing that could be read: the next run tries again.
    NotRead,
    /// An image that does not fit under the limit.
    TooLarge,
}

impl fmt::Display for Content {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Content::Bytes(key) => key.fmt(f),
            Content::NotRead => f.write_str("not read"),
            Content::TooLarge => f.write_str("too large"),
        }
    }
}

/// What was found under the names of a frame's files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Contents {
    /// The image.
    pub image: Content,
    /// The mask; `None` if there is none, or if the image's bytes were not read.
    pub mask: Option<Content>,
}

impl Contents {
    /// The contents of a frame whose image was not read for this reason.
    pub(crate) fn without(image: Content) -> Contents {
        Contents { image, mask: None }
    }
}

/// A frame that is skipped: why, and what was found of its files.
#[derive(Debug)]
pub(crate) struct Unread {
    /// What is told of the frame.
    pub skipped: Skipped,
    /// What was found.
    pub contents: Contents,
}

/// A frame that may be read, or why it is skipped.
pub(crate) struct Lent {
    /// The frame.
    pub frame: FrameId,
    /// The memory that reading the frame may take.
    pub memory: Result<Reservation, Unread>,
}

/// A frame whose image has been read, or why it is skipped.
pub(crate) struct Decoded {
    /// The frame.
    pub frame: FrameId,
    /// What was found under the names of the frame's files.
    pub contents: Contents,
    /// The frame's pixels, and the memory that holds them.
    pub image: Result<(LinearImage, Reservation), Skipped>,
}

/// Reads images.
#[derive(Clone)]
pub(crate) struct Decode<'a> {
    /// All frames, sorted by name.
    pub frames: &'a [Frame],
    /// The folder of the images.
    pub images: &'a Path,
    /// The folder of masks, if there is one.
    pub masks: Option<&'a Path>,
    /// How much smaller images are, each way, than their cameras.
    pub downscale: u32,
    /// How stored samples become radiance.
    pub curve: Curve,
    /// The command that shows what one frame sees, but for the frame's name.
    pub replay: String,
    /// What is waited for where a file cannot be read.
    pub(crate) patience: Arc<Patience>,
}

impl Decode<'_> {
    /// The memory that reading a frame's image and mask takes.
    ///
    /// # Errors
    /// A file that is missing, or has the header of another image.
    pub(crate) fn need(&self, frame: &Frame) -> Result<Need> {
        let size = self.size(frame);
        let image = images::need(&self.images.join(&frame.name), size)?;
        let mask = self.mask(frame)?.map(|mask| images::mask_need(&mask, size)).transpose()?;
        Ok(image.then(mask.unwrap_or_default()))
    }

    /// The memory that reading a frame's image takes, where it is the mask whose header is broken; 0 where it is the image's own.
    pub(crate) fn image_need(&self, frame: &Frame) -> u64 {
        images::need(&self.images.join(&frame.name), self.size(frame)).map_or(0, |need| need.peak)
    }

    /// Reads a frame's image and mask within this many bytes.
    pub(crate) fn read(&self, frame: &Frame, memory: u64) -> Result<LinearImage> {
        self.read_with_contents(frame, memory).0
    }

    /// The same, and what was read: the result is that of these contents, whatever the files hold later.
    fn read_with_contents(&self, frame: &Frame, memory: u64) -> (Result<LinearImage>, Contents) {
        let (size, path) = (self.size(frame), self.images.join(&frame.name));
        let encoded = match Encoded::read(&path, memory) {
            Ok(encoded) => encoded,
            Err(why) => return (Err(why), Contents::without(Content::NotRead)),
        };
        let mut contents = Contents::without(Content::Bytes(encoded.key));
        let image = encoded.image(size, &self.curve, memory);
        if image.as_ref().is_err_and(|why| !is_broken(why)) {
            contents.image = Content::NotRead;
        }
        drop(encoded);
        if contents.image == Content::NotRead {
            return (image, contents);
        }
        let left = memory.saturating_sub(image.as_ref().map_or(0, LinearImage::bytes));
        let mask = self.mask(frame).and_then(|path| match path {
            Some(path) => {
                let encoded = Encoded::read(&path, left)?;
                contents.mask = Some(Content::Bytes(encoded.key));
                encoded.mask(size, left).map(Some)
            }
            None => Ok(None),
        });
        if mask.as_ref().is_err_and(|why| !is_broken(why)) {
            contents.mask = Some(Content::NotRead);
        }
        let both = image.and_then(|image| mask.map(|mask| image.masked(mask)));
        (both, contents)
    }

    /// The mask of a frame, if there is one.
    fn mask(&self, frame: &Frame) -> Result<Option<PathBuf>> {
        self.masks.map_or(Ok(None), |masks| images::mask_path(masks, self.images, &frame.name))
    }

    /// The bytes of a frame's image and mask, as far as the system tells.
    pub(crate) fn bytes(&self, frame: &Frame) -> u64 {
        let mask = self.mask(frame).unwrap_or_default();
        let files = [Some(self.images.join(&frame.name)), mask];
        files.iter().flatten().filter_map(|path| path.metadata().ok()).map(|found| found.len()).sum()
    }

    /// The size that a frame's image must have.
    fn size(&self, frame: &Frame) -> Size {
        let by = self.downscale.max(1);
        Size { width: frame.camera.width / by, height: frame.camera.height / by }
    }
}

/// Whether it is a file's bytes that are wrong, and not that they could not be had.
pub(crate) fn is_broken(why: &Error) -> bool {
    why.malformed_file().is_some()
}

/// A frame that is skipped, with the reason and the command that tries the frame alone.
pub(crate) fn skipped(frame: &Frame, why: &str, replay: &str) -> Skipped {
    Skipped {
        item: frame.name.clone(),
        why: why.to_owned(),
        replay: format!("{replay} --frame {}", quoted(&frame.name)),
    }
}

/// What is said of an input file that was not read.
pub(crate) fn not_read(why: &Error) -> String {
    format!("not read: {why}; the next run tries it again")
}

impl Map for Decode<'_> {
    type In = Lent;
    type Out = Decoded;
    type Scratch = ();

    fn scratch(&self) -> Result<()> {
        Ok(())
    }

    fn apply(&self, _: &mut (), lent: Lent, out: &mut Outlet<'_, Decoded>) -> Result<()> {
        let Lent { frame, memory } = lent;
        let posed = &self.frames[frame.index()];
        let (image, contents) = match memory {
            Ok(mut memory) => {
                let mut contents = Contents::without(Content::NotRead);
                let read = self.patience.with(|| {
                    let (image, found) = self.read_with_contents(posed, memory.bytes());
                    contents = found;
                    image
                });
                let image = read.map_err(|why| {
                    let why = if is_broken(&why) { why.to_string() } else { not_read(&why) };
                    skipped(posed, &why, &self.replay)
                });
                let held = image.as_ref().map_or(0, LinearImage::bytes);
                memory.shrink(memory.bytes().saturating_sub(held));
                (image.map(|image| (image, memory)), contents)
            }
            Err(unread) => (Err(unread.skipped), unread.contents),
        };
        match &image {
            Ok((image, _)) => out.count_bytes(image.bytes()),
            Err(skipped) => out.skip(skipped.clone()),
        }
        out.send(Decoded { frame, contents, image })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::read_text;

    #[test]
    fn gamma_belongs_to_its_transfer() {
        for (text, fields) in [
            ("downscale = 0", &["decode.downscale"][..]),
            ("", &[]),
            ("transfer = 'gamma'\ngamma = 2.2", &[]),
            ("transfer = 'gamma'", &["decode.gamma"]),
            ("transfer = 'gamma'\ngamma = 0", &["decode.gamma"]),
            ("transfer = 'gamma'\ngamma = nan", &["decode.gamma"]),
            ("transfer = 'linear'\ngamma = 2.2", &["decode.gamma"]),
            ("gamma = 'much'", &["decode.gamma"]),
            ("transfer = 'gama'\ngamma = 2.2", &["decode.transfer"]),
        ] {
            let (_, problems) = read_text::<Config>(text);
            assert_eq!(problems.iter().map(|p| p.field.as_str()).collect::<Vec<_>>(), fields, "{text}");
        }
    }
}
