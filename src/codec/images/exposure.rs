//! How a photograph was exposed, as its EXIF tells.

use std::fmt;

use exif::{Exif, In, Tag, Value};

/// The settings of an exposure, as far as they are told.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Exposure {
    /// Seconds that the shutter was open.
    pub seconds: Option<f64>,
    /// The f-number.
    pub aperture: Option<f64>,
    /// The sensitivity, ISO.
    pub iso: Option<u32>,
}

impl Exposure {
    pub(super) fn of(exif: &Exif) -> Exposure {
        let value = |tag: Tag| exif.get_field(tag, In::PRIMARY).map(|field| &field.value);
        let ratio = |tag: Tag| match value(tag)? {
            Value::Rational(all) => all.first().map(|ratio| ratio.to_f64()).filter(|v| v.is_finite() && *v > 0.0),
            _ => None,
        };
        Exposure {
            seconds: ratio(Tag::ExposureTime),
            aperture: ratio(Tag::FNumber),
            iso: value(Tag::PhotographicSensitivity).and_then(|iso| iso.get_uint(0)),
        }
    }

    /// The light that it lets in, times the sensitivity: what it makes the same radiance brighter by.
    pub(crate) fn factor(&self) -> Option<f64> {
        Some(self.seconds? * f64::from(self.iso?) / self.aperture.unwrap_or(1.0).powi(2))
    }

    /// Whether shutter and sensitivity are told: some lenses have one aperture and do not tell it.
    pub(crate) fn is_told(&self) -> bool {
        self.seconds.is_some() && self.iso.is_some()
    }
}

impl fmt::Display for Exposure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.seconds.map(|s| if s < 0.5 { format!("1/{:.0} s", 1.0 / s) } else { format!("{s} s") });
        let aperture = self.aperture.map(|number| format!("f/{number}"));
        let iso = self.iso.map(|iso| format!("ISO {iso}"));
        f.write_str(&[seconds, aperture, iso].into_iter().flatten().collect::<Vec<_>>().join(", "))
    }
}
