//! Any file under the name of a photograph, a picture to compare, or a mask. What its header says of memory holds.

use std::sync::LazyLock;

use gonio::Error;
use gonio::internals::codec::images::{self, Curve, Encoded, Size, Transfer};

use super::{BUFFERS, Target};
use crate::{input, memory};

pub const IMAGE: Target = Target { name: "image", read, may_hold: |_| BUFFERS + GIVEN };

/// The memory that reading is given.
const GIVEN: u64 = 32 << 20;

/// What reading a header may hold: the decoders' buffers, and the metadata of a PNG while it is gathered.
const HEADER: u64 = 16 << 20;

static CURVE: LazyLock<Curve> = LazyLock::new(|| Curve::new(Transfer::Srgb));

fn read(bytes: &[u8]) -> bool {
    LazyLock::force(&CURVE);
    let path = input::file("any.png", bytes);
    let (size, held) = memory::most(|| images::size(&path));
    assert!(held <= HEADER, "the header took {held} bytes");
    let Ok(size) = size.map_err(short) else { return false };
    let need = images::need(&path, size).unwrap();
    let (picture, held) = memory::most(|| images::read_image(&path, size, &CURVE, GIVEN));
    assert!(held <= need.peak || need.peak > GIVEN && held <= HEADER, "{held} bytes, where {need:?} was said");
    let taken = picture.map_err(short).inspect(|picture| assert_eq!(picture.bytes(), need.held)).is_ok();
    let mask = Encoded::read(&path, GIVEN).and_then(|encoded| encoded.mask(size, GIVEN));
    if let Ok(mask) = mask.map_err(short) {
        assert_eq!(mask.len() as u64, size.pixels());
    }
    let other = Size { width: size.width + 1, height: size.height };
    assert!(images::read_image(&path, other, &CURVE, GIVEN).is_err());
    taken
}

/// Errors are for people.
fn short(why: Error) {
    let length = why.to_string().len();
    assert!(length < 2048, "an error of {length} bytes");
}
