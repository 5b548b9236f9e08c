//! Decode: an image file becomes linear radiance on the pixel grid that its pose was solved on.

use std::path::Path;

use serde::Serialize;

use super::{Choice, Fault};
use crate::base::Result;
use crate::base::ids::FrameId;
use crate::codec::image::{self, Curve, Need};
use crate::flow::{Map, Outlet, Reservation, Skipped};
use crate::scene::frame::{Frame, LinearImage};

/// Section `[decode]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// How stored values become linear radiance.
    pub transfer: Transfer,
    /// The exponent of [`Transfer::Gamma`], 0.2 to 5; none with any other transfer.
    pub gamma: Option<f64>,
    /// What is done about exposures that differ between frames.
    pub exposure: Exposure,
    /// By how much images are smaller, each way, than their cameras say: 1 to 64. Pixels that do not fill a whole one of
    /// the smaller are cut off, so 1617 by 1208 pixels become 808 by 604.
    pub downscale: u32,
}

/// How stored values in [0, 1] become linear radiance. Floating-point files are linear and are never changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Transfer {
    /// The inverse of IEC 61966-2-1: what a camera's JPEG holds.
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

/// What is done about exposures that differ between frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Exposure {
    /// Nothing: frames are taken to be exposed alike.
    AsIs,
}

impl Choice for Exposure {
    const NAMES: &'static [(&'static str, Self)] = &[("as_is", Exposure::AsIs)];
}

impl Default for Config {
    fn default() -> Self {
        Config { transfer: Transfer::Srgb, gamma: None, exposure: Exposure::AsIs, downscale: 1 }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        let mut faults = self.check_gamma();
        faults.extend(Fault::unless_within("downscale", self.downscale, 1..=64));
        faults
    }

    /// The tables of the transfer.
    pub fn curve(&self) -> Curve {
        Curve::new(match (self.transfer, self.gamma) {
            (Transfer::Srgb, _) => image::Transfer::Srgb,
            (Transfer::Gamma, Some(gamma)) => image::Transfer::Gamma(gamma as f32),
            (Transfer::Linear | Transfer::Gamma, _) => image::Transfer::Linear,
        })
    }

    fn check_gamma(&self) -> Vec<Fault> {
        match (self.transfer, self.gamma) {
            (Transfer::Gamma, None) => {
                vec![Fault::new("gamma", "is needed where transfer = \"gamma\"", "nothing").hint("add `gamma = 2.2`")]
            }
            (Transfer::Gamma, Some(gamma)) => Fault::unless_within("gamma", gamma, 0.2..=5.0).into_iter().collect(),
            (other, Some(gamma)) => {
                let rule = format!("has no meaning where transfer = \"{}\"", other.name());
                vec![Fault::new("gamma", rule, gamma).hint("take it out, or set transfer = \"gamma\"")]
            }
            (_, None) => Vec::new(),
        }
    }
}

/// A frame that may be read, or why it is skipped.
pub struct Lent {
    /// Which frame.
    pub frame: FrameId,
    /// The memory that it may take.
    pub memory: Result<Reservation, Skipped>,
}

/// A frame whose image has been read, or why it is skipped.
pub struct Decoded {
    /// Which frame.
    pub frame: FrameId,
    /// Its pixels, and the memory that they are held in.
    pub image: Result<(LinearImage, Reservation), Skipped>,
}

/// Reads images.
#[derive(Clone)]
pub struct Decode<'a> {
    /// All frames, sorted by name.
    pub frames: &'a [Frame],
    /// The folder that their names are relative to.
    pub images: &'a Path,
    /// The folder of masks, if there is one.
    pub masks: Option<&'a Path>,
    /// By how much images are smaller than their cameras say.
    pub downscale: u32,
    /// How stored samples become radiance.
    pub curve: Curve,
    /// The command that shows what one frame sees, but for the frame's name.
    pub replay: &'a str,
}

impl Decode<'_> {
    /// What reading one frame's image and its mask will take.
    ///
    /// # Errors
    /// A file that is not there, or whose header is not that of such an image.
    pub fn need(&self, frame: &Frame) -> Result<Need> {
        let size = self.size(frame);
        let image = image::need(&self.images.join(&frame.name), size)?;
        self.masks.map_or(Ok(image), |masks| Ok(image.then(image::mask_need(masks, &frame.name, size)?)))
    }

    /// Reads one frame's image and its mask within this many bytes.
    pub fn read(&self, frame: &Frame, memory: u64) -> Result<LinearImage> {
        let size = self.size(frame);
        let mut image = image::read_image(&self.images.join(&frame.name), size, &self.curve, memory)?;
        if let Some(masks) = self.masks {
            image.mask = image::read_mask(masks, &frame.name, size, memory.saturating_sub(image.bytes()))?;
        }
        Ok(image)
    }

    /// Columns and rows that a frame's image must have.
    fn size(&self, frame: &Frame) -> (u32, u32) {
        let by = self.downscale.max(1);
        (frame.camera.width / by, frame.camera.height / by)
    }
}

/// A frame to be skipped: why, and the command that tries it alone.
pub fn skipped(frame: &Frame, why: impl ToString, replay: &str) -> Skipped {
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
        let posed = &self.frames[frame as usize];
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

    #[test]
    fn gamma_belongs_to_its_transfer() {
        let faults = |transfer, gamma| Config { transfer, gamma, ..Config::default() }.check().len();
        assert_eq!(Config { downscale: 0, ..Config::default() }.check().len(), 1);
        assert_eq!(faults(Transfer::Srgb, None), 0);
        assert_eq!(faults(Transfer::Gamma, Some(2.2)), 0);
        for (transfer, gamma) in [
            (Transfer::Gamma, None),
            (Transfer::Gamma, Some(0.0)),
            (Transfer::Gamma, Some(f64::NAN)),
            (Transfer::Linear, Some(2.2)),
        ] {
            assert_eq!(faults(transfer, gamma), 1, "{transfer:?} {gamma:?}");
        }
    }
}
