//! A frame: the camera and the pose of one photograph, and its pixels as linear radiance.

use std::sync::Arc;

use super::camera::Camera;
use super::pose::Pose;

/// A posed photograph without its pixels.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// The image's name as the poses give it, relative to the image folder, with `/` between folders.
    pub name: String,
    /// The camera's intrinsics, shared between frames.
    pub camera: Arc<Camera>,
    /// The camera's extrinsics.
    pub pose: Pose,
}

/// The samples of an image as stored: red, green, blue, pixel by pixel, rows from the top.
#[derive(Debug, Clone)]
pub enum Samples {
    /// 8 bits.
    U8(Vec<u8>),
    /// 16 bits.
    U16(Vec<u16>),
    /// Floating point, taken as linear.
    F32(Vec<f32>),
}

/// A decoded photograph. Samples stay as narrow as they were stored (a 150-megapixel JPEG is 450 MB here, not 1.8 GB)
/// and become linear radiance when they are read, through a table.
#[derive(Debug, Clone)]
pub struct LinearImage {
    /// Columns of pixels.
    pub width: u32,
    /// Rows of pixels.
    pub height: u32,
    /// The samples as stored.
    pub samples: Samples,
    /// The linear radiance of every stored value: 256 or 65,536 entries, none for `F32`.
    pub table: Arc<[f32]>,
    /// The mask: 0 where a pixel is not an observation; `None` if all pixels are.
    pub mask: Option<Vec<u8>>,
}

/// The value of one pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pixel {
    /// Linear radiance.
    pub rgb: [f32; 3],
    /// Whether any channel is at 254/255 or above.
    pub clipped: bool,
}

impl LinearImage {
    /// Number of pixels.
    pub fn len(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// Whether there are no pixels.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The number of pixels that the mask does not ignore.
    pub fn unmasked(&self) -> u64 {
        self.mask.as_ref().map_or(self.len(), |mask| mask.iter().filter(|&&pixel| pixel != 0).count()) as u64
    }

    /// The image without what this mask ignores either; masks have a byte a pixel.
    #[must_use]
    pub fn masked(self, mask: Option<Vec<u8>>) -> LinearImage {
        let both = match (self.mask, mask) {
            (Some(one), Some(mut both)) => {
                both.iter_mut().zip(one).filter(|(_, one)| *one == 0).for_each(|(pixel, _)| *pixel = 0);
                Some(both)
            }
            (one, other) => other.or(one),
        };
        LinearImage { mask: both, ..self }
    }

    /// The pixel at `row * width + column`; `None` where the pixel is masked or not finite.
    #[inline]
    pub fn pixel(&self, index: usize) -> Option<Pixel> {
        if self.mask.as_ref().is_some_and(|m| m[index] == 0) {
            return None;
        }
        let at = 3 * index;
        let pixel = match &self.samples {
            Samples::U8(s) => {
                let rgb = [s[at], s[at + 1], s[at + 2]];
                Pixel { rgb: rgb.map(|v| self.table[usize::from(v)]), clipped: rgb.iter().any(|&v| v >= 254) }
            }
            Samples::U16(s) => {
                let rgb = [s[at], s[at + 1], s[at + 2]];
                // 254/255 of 65535.
                Pixel { rgb: rgb.map(|v| self.table[usize::from(v)]), clipped: rgb.iter().any(|&v| v >= 65_278) }
            }
            Samples::F32(s) => Pixel { rgb: [s[at], s[at + 1], s[at + 2]], clipped: false },
        };
        pixel.rgb.iter().all(|v| v.is_finite()).then_some(pixel)
    }

    /// Bytes of memory that the image holds.
    pub fn bytes(&self) -> u64 {
        let sample = match &self.samples {
            Samples::U8(_) => 3,
            Samples::U16(_) => 6,
            Samples::F32(_) => 12,
        };
        self.len() as u64 * (sample + u64::from(self.mask.is_some()))
    }
}
