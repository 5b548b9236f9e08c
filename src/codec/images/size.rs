//! The size of an image.

use std::fmt;

/// Columns and rows of an image.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    /// Columns, pixels.
    pub width: u32,
    /// Rows, pixels.
    pub height: u32,
}

impl Size {
    /// The largest picture whose size is not known beforehand: a JPEG has no longer sides.
    pub(super) const MOST: Size = Size { width: 65_535, height: 65_535 };

    /// What is said of a picture that is larger than [`Size::MOST`].
    pub(super) fn too_large(self) -> Option<String> {
        let most = Size::MOST;
        let larger = self.width > most.width || self.height > most.height;
        larger.then(|| format!("it is larger than {most} pixels, the most that is expected"))
    }

    /// The number of pixels.
    pub fn pixels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Whether an image of this size is `by` times smaller, each way, than that of a camera; programs round sides up or down.
    pub(crate) fn is_smaller(self, camera: Size, by: u32) -> bool {
        let close = |small: u32, large: u32| small == large / by.max(1) || small == large.div_ceil(by.max(1));
        close(self.width, camera.width) && close(self.height, camera.height)
    }

    /// What tells this size of an image from the one that its camera has, if that is plain.
    pub(super) fn compared(self, camera: Size) -> Option<String> {
        if (self.width, self.height) == (camera.height, camera.width) {
            return Some(
                "it has been turned; turn it back, since the poses are of the image as it was stored".to_owned(),
            );
        }
        let times = |small: Size, large: Size| (2..=64u32).find(|&k| small.is_smaller(large, k));
        let smaller = times(self, camera).map(|k| format!("it is {k} times smaller each way; see [decode] downscale"));
        let larger = || {
            let times = times(camera, self)?;
            Some(format!(
                "it is {times} times larger each way; are these the originals, and the poses of smaller images?"
            ))
        };
        smaller.or_else(larger)
    }
}

/// `WIDTH x HEIGHT`.
impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} x {}", self.width, self.height)
    }
}
