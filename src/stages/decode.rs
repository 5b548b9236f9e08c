//! Decode: an image file becomes linear radiance on the pixel grid that its pose was solved on.

use std::path::Path;

use crate::base::Result;
use crate::base::convert::to_f32;
use crate::base::ids::FrameId;
use crate::codec::images::{self, Curve, Need, Size};
use crate::config::{Choice, Effect, Former, Key, Keys, Now, Problem, Section, Settings, Value, outside};
use crate::flow::{Map, Outlet, Reservation, Skipped};
use crate::scene::frame::{Frame, LinearImage};

/// Section `[decode]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// How stored values become linear radiance.
    pub transfer: Transfer,
    /// The exponent of [`Transfer::Gamma`], 0.2 to 5; none with any other transfer.
    pub gamma: Option<f64>,
    /// How much smaller images are, each way, than their cameras: 1 to 64. The pixels left over at the edge are cut off, so
    /// 1617 by 1208 pixels become 808 by 604.
    pub downscale: u32,
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
    ];
    const FORMER: &'static [Former] =
        &[Former { name: "exposure", now: Now::Gone("all frames are taken to be exposed alike") }];

    fn read(keys: &Keys<'_>) -> Self {
        let transfer = keys.choice("transfer");
        let gamma = keys.optional("gamma");
        // A transfer that cannot be read may be the one that needs a gamma.
        if keys.is_good("transfer") {
            check_gamma(keys, transfer, gamma);
        }
        Config { transfer, gamma, downscale: keys.within("downscale", 1..=64) }
    }

    fn settings(&self) -> Settings {
        let Config { transfer, gamma, downscale } = self;
        Settings::of(Self::NAME)
            .with("transfer", transfer.name(), Effect::Cast)
            .optional("gamma", *gamma, Effect::Cast)
            .with("downscale", downscale, Effect::Cast)
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

/// A frame that may be read, or why it is skipped.
pub struct Lent {
    /// The frame.
    pub frame: FrameId,
    /// The memory that reading the frame may take.
    pub memory: Result<Reservation, Skipped>,
}

/// A frame whose image has been read, or why it is skipped.
pub struct Decoded {
    /// The frame.
    pub frame: FrameId,
    /// The frame's pixels, and the memory that holds them.
    pub image: Result<(LinearImage, Reservation), Skipped>,
}

/// Reads images.
#[derive(Clone)]
pub struct Decode<'a> {
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
    pub replay: &'a str,
}

impl Decode<'_> {
    /// The memory that reading a frame's image and mask takes.
    ///
    /// # Errors
    /// A file that is missing, or has the header of another image.
    pub fn need(&self, frame: &Frame) -> Result<Need> {
        let size = self.size(frame);
        let image = images::need(&self.images.join(&frame.name), size)?;
        self.masks.map_or(Ok(image), |masks| Ok(image.then(images::mask_need(masks, &frame.name, size)?)))
    }

    /// Reads a frame's image and mask within this many bytes.
    pub fn read(&self, frame: &Frame, memory: u64) -> Result<LinearImage> {
        let size = self.size(frame);
        let mut image = images::read_image(&self.images.join(&frame.name), size, &self.curve, memory)?;
        if let Some(masks) = self.masks {
            image.mask = images::read_mask(masks, &frame.name, size, memory.saturating_sub(image.bytes()))?;
        }
        Ok(image)
    }

    /// The size that a frame's image must have.
    fn size(&self, frame: &Frame) -> Size {
        let by = self.downscale.max(1);
        Size { width: frame.camera.width / by, height: frame.camera.height / by }
    }
}

/// A frame that is skipped, with the reason and the command that tries the frame alone.
pub(crate) fn skipped(frame: &Frame, why: impl ToString, replay: &str) -> Skipped {
    Skipped { item: frame.name.clone(), why: why.to_string(), replay: format!("{replay} --frame {}", frame.name) }
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
        let image = memory.and_then(|mut memory| {
            let image = self.read(posed, memory.bytes()).map_err(|why| skipped(posed, why, self.replay))?;
            memory.shrink(memory.bytes().saturating_sub(image.bytes()));
            Ok((image, memory))
        });
        match &image {
            Ok((image, _)) => out.count_bytes(image.bytes()),
            Err(skipped) => out.skip(skipped.clone()),
        }
        out.send(Decoded { frame, image })
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
