//! The list of pose formats.

use super::alicevision::ALICEVISION;
use super::blendedmvs::BLENDEDMVS;
use super::blocks_exchange::BLOCKS_EXCHANGE;
use super::bundler::BUNDLER;
use super::colmap::COLMAP;
use super::format::PoseFormat;
use super::metashape::METASHAPE;
use super::micmac::MICMAC;
use super::nvm::NVM;
use super::opendronemap::OPENDRONEMAP;
use super::openmvs::OPENMVS;
use super::opensfm::OPENSFM;
use super::pix4d::PIX4D;
use super::realitycapture::REALITYCAPTURE;
use super::tanks_and_temples::TANKS_AND_TEMPLES;
use super::transforms::TRANSFORMS;

/// Every pose format that gonio reads.
pub const FORMATS: &[&PoseFormat] = &[
    &COLMAP,
    &OPENDRONEMAP,
    &OPENSFM,
    &METASHAPE,
    &TRANSFORMS,
    &REALITYCAPTURE,
    &BLENDEDMVS,
    &TANKS_AND_TEMPLES,
    &ALICEVISION,
    &OPENMVS,
    &BUNDLER,
    &NVM,
    &PIX4D,
    &MICMAC,
    &BLOCKS_EXCHANGE,
];

/// The formats by their names.
pub(crate) const NAMES: [(&str, &PoseFormat); FORMATS.len()] = {
    let mut names = [("", FORMATS[0]); FORMATS.len()];
    let mut at = 0;
    while at < FORMATS.len() {
        names[at] = (FORMATS[at].name, FORMATS[at]);
        at += 1;
    }
    names
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_plain_and_each_has_one_format() {
        for format in FORMATS {
            let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
            assert!(!format.name.is_empty() && format.name.chars().all(plain), "{format:?}");
            let named: Vec<_> = NAMES.iter().filter(|(name, _)| *name == format.name).collect();
            assert_eq!(named, [&(format.name, *format)]);
        }
    }
}
