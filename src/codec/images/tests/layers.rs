//! EXRs of named layers, of one channel, and of parts of their display windows.

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, IntegerBounds, Layer, LayerAttributes, Vec2, WritableImage,
};

use super::{PLENTY, linear, read_image, sized};
use crate::scene::frame::LinearImage;

/// Writes 6 x 4 pixels, whose samples are those of their channel: 1 for the first in the list, and so on.
fn write(path: &Path, names: &[&str]) {
    let channel = |(at, name): (usize, &&str)| AnyChannel::new(*name, FlatSamples::F32(vec![at as f32 + 1.0; 24]));
    let channels = AnyChannels::sort(names.iter().enumerate().map(channel).collect());
    let layer = Layer::new((6, 4), LayerAttributes::default(), Encoding::UNCOMPRESSED, channels);
    Image::from_layer(layer).write().to_file(path).unwrap();
}

fn read(path: &Path) -> Result<LinearImage, String> {
    read_image(path, sized(6, 4), &linear(), PLENTY).map_err(|why| why.to_string())
}

#[test]
fn the_one_picture_of_an_exr_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for (names, expected) in [
        (&["R", "G", "B"][..], [1.0, 2.0, 3.0]),
        (
            &["View.Combined.R", "View.Combined.G", "View.Combined.B", "View.Combined.A", "View.Depth.Z"],
            [1.0, 2.0, 3.0],
        ),
        (&["a.R", "a.G", "a.B", "R", "G", "B"], [4.0, 5.0, 6.0]),
        (&["Y"], [1.0; 3]),
        (&["a.Y", "a.A"], [1.0; 3]),
        (&["Y", "R", "G", "B"], [2.0, 3.0, 4.0]),
    ] {
        write(&path, names);
        assert_eq!(read(&path).unwrap().pixel(7).unwrap().rgb, expected, "{names:?}");
    }
}

#[test]
fn an_exr_without_one_picture_lists_what_it_has() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    for (names, said) in [
        (&["a.R", "a.G", "a.B", "b.R", "b.G", "b.B"][..], "2 of its layers are pictures: a, b"),
        (&["Z", "a.R", "a.G"], "these are there: Z, a.G, a.R"),
        (&["Y", "RY", "BY"], "luminance and chroma"),
        (&["X", "Y", "Z"], "the colours of CIE"),
        (&["bR", "bG", "bB"], "no layer has the channels R, G and B"),
    ] {
        write(&path, names);
        let why = read(&path).unwrap_err();
        assert!(why.contains(said), "{names:?}: {why}");
    }
}

#[test]
fn what_is_outside_of_the_data_window_is_no_observation() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let channel = |name| AnyChannel::new(name, FlatSamples::F32(vec![0.5; 8]));
    let channels = AnyChannels::sort(["R", "G", "B"].map(channel).into_iter().collect());
    let attributes = LayerAttributes { layer_position: Vec2(1, 2), ..LayerAttributes::default() };
    let layer = Layer::new((4, 2), attributes, Encoding::UNCOMPRESSED, channels);
    let mut image = Image::from_layer(layer);
    image.attributes.display_window = IntegerBounds::new((0, 0), (6, 4));
    image.write().to_file(&path).unwrap();
    let read = read(&path).unwrap();
    for at in 0..24 {
        let inside = (1..5).contains(&(at % 6)) && (2..4).contains(&(at / 6));
        assert_eq!(read.pixel(at).is_some(), inside, "pixel {at}");
    }
}

/// The file with other bounds of its data window, first to last, x before y.
fn with_data_window(mut file: Vec<u8>, bounds: [i32; 4]) -> Vec<u8> {
    let name = b"dataWindow\0box2i\0\x10\0\0\0";
    let at = file.windows(name.len()).position(|w| w == name).unwrap() + name.len();
    file.splice(at..at + 16, bounds.into_iter().flat_map(i32::to_le_bytes));
    file
}

/// Samples of a layer that fall outside of the display window must cost nothing: a header may claim 2^58 of them.
#[test]
fn a_data_window_far_larger_than_the_display_window_ends_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    write(&path, &["R", "G", "B"]);
    let whole = std::fs::read(&path).unwrap();
    const FAR: i32 = (1 << 29) - 1;
    for bounds in [[-FAR, -FAR, FAR, FAR], [0, 0, 1 << 20, 1 << 17], [-FAR, 0, 5, 3], [0, -(1 << 18), 5, 1 << 18]] {
        std::fs::write(&path, with_data_window(whole.clone(), bounds)).unwrap();
        read(&path).unwrap_err();
    }
}
