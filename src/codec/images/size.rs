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

    /// What tells this size of an image from the one that its camera has, if that is plain.
    pub(super) fn compared(self, camera: Size) -> Option<String> {
        if (self.width, self.height) == (camera.height, camera.width) {
            return Some(
                "it has been turned; turn it back, since the poses are of the image as it was stored".to_owned(),
            );
        }
        // Programs round halves in either direction.
        let times = |small: Size, large: Size| {
            (2..=64u32).find(|&k| {
                let close = |small: u32, large: u32| small == large / k || small == large.div_ceil(k);
                close(small.width, large.width) && close(small.height, large.height)
            })
        };
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
