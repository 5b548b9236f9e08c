//! Pictures of every format, whole and damaged.

mod damage;
mod layers;

use std::fs;
use std::path::{Path, PathBuf};

use image::{DynamicImage, ImageFormat, Rgb, Rgb32FImage, RgbImage, Rgba, Rgba32FImage};

use super::*;
use crate::scene::frame::LinearImage;

/// More memory than any of these images takes.
const PLENTY: u64 = 1 << 30;

fn sized(width: u32, height: u32) -> Size {
    Size { width, height }
}

fn linear() -> Curve {
    Curve::new(Transfer::Linear)
}

fn saved(name: &str, picture: &DynamicImage) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(name);
    picture.save(&path).unwrap();
    (folder, path)
}

fn gradient() -> RgbImage {
    RgbImage::from_fn(6, 4, |x, y| Rgb([x as u8 * 40, y as u8 * 60, 254]))
}

fn rgb(image: &LinearImage, at: usize) -> [f32; 3] {
    image.pixel(at).unwrap().rgb
}

#[test]
fn every_format_gives_its_own_samples() {
    let eight = DynamicImage::from(gradient());
    let bright = Rgb32FImage::from_fn(6, 4, |x, _| Rgb([x as f32 * 2.5, 0.5, 1.0]));
    for (name, picture, tolerance) in [
        ("a.png", eight.clone(), 0.0),
        ("b.png", DynamicImage::from(eight.to_rgb16()), 0.0),
        ("c.tiff", eight.clone(), 0.0),
        ("d.tiff", DynamicImage::from(eight.to_rgb16()), 0.0),
        ("e.jpg", eight.clone(), 0.12),
        ("f.exr", DynamicImage::from(bright.clone()), 0.0),
        ("g.hdr", DynamicImage::from(bright), 0.05),
    ] {
        let (_folder, path) = saved(name, &picture);
        let image = read_image(&path, sized(6, 4), &linear(), PLENTY).unwrap();
        let expected = picture.to_rgb32f();
        for (at, pixel) in expected.pixels().enumerate() {
            for c in 0..3 {
                let error = (rgb(&image, at)[c] - pixel.0[c]).abs();
                assert!(error <= tolerance + 1e-6, "{name} pixel {at}: {error}");
            }
        }
    }
}

#[test]
fn grey_and_alpha_are_read_as_rgb() {
    for picture in [DynamicImage::from(gradient()).to_luma8().into(), DynamicImage::from(gradient()).to_rgba8().into()]
    {
        let picture: DynamicImage = picture;
        let (_folder, path) = saved("a.png", &picture);
        assert_eq!(read_image(&path, sized(6, 4), &linear(), PLENTY).unwrap().len(), 24);
    }
}

#[test]
fn pictures_are_masked_where_alpha_is_0() {
    // The first column is clear, the second nearly so.
    let clear = DynamicImage::from(Rgba32FImage::from_fn(6, 4, |x, _| Rgba([0.5, 0.5, 0.5, x as f32 / 6.0])));
    for (name, picture) in [
        ("a.png", clear.to_rgba8().into()),
        ("b.png", clear.to_luma_alpha16().into()),
        ("c.tiff", clear.to_rgba16().into()),
        ("d.exr", clear.clone()),
    ] {
        let picture: DynamicImage = picture;
        let (_folder, path) = saved(name, &picture);
        assert_eq!(size(&path).unwrap(), sized(6, 4));
        let read = read_image(&path, sized(6, 4), &linear(), PLENTY).unwrap();
        for at in 0..24 {
            assert_eq!(read.pixel(at).is_none(), at % 6 == 0, "{name} pixel {at}");
        }
        assert!((rgb(&read, 1)[2] - 0.5).abs() < 2e-3, "{name}");
        // A mask file takes away from what is there.
        let masked = read.clone().masked(Some((0..24).map(|at| u8::from(at % 6 != 3)).collect()));
        (0..24).for_each(|at| assert_eq!(masked.pixel(at).is_none(), at % 6 == 0 || at % 6 == 3, "{name} pixel {at}"));
        assert_eq!(read.clone().masked(None).mask, read.mask);
    }
    let (_folder, path) = saved("e.png", &gradient().into());
    assert!(read_image(&path, sized(6, 4), &linear(), PLENTY).unwrap().mask.is_none());
}

#[test]
fn samples_at_254_and_above_count_as_clipped() {
    for (value, clipped) in [(253, false), (254, true), (255, true)] {
        let (_folder, path) = saved("a.png", &RgbImage::from_pixel(2, 2, Rgb([9, value, 9])).into());
        assert_eq!(
            read_image(&path, sized(2, 2), &linear(), PLENTY).unwrap().pixel(3).unwrap().clipped,
            clipped,
            "{value}"
        );
    }
}

#[test]
fn another_size_is_refused_before_it_is_decoded() {
    let (_folder, path) = saved("a.png", &gradient().into());
    for size in [sized(6, 5), sized(5, 4), sized(3, 2), sized(60, 40)] {
        let error = read_image(&path, size, &linear(), PLENTY).unwrap_err().to_string();
        assert!(error.contains("a.png") && error.contains(&size.to_string()), "{error}");
    }
    for (camera, hint) in [((4, 6), "been turned"), ((13, 8), "2 times smaller each way"), ((3, 2), "2 times larger")] {
        let error = read_image(&path, sized(camera.0, camera.1), &linear(), PLENTY).unwrap_err().to_string();
        assert!(error.contains("6 x 4 pixels") && error.contains(hint), "{error}");
    }
}

#[test]
fn every_cut_is_refused_and_none_panics() {
    for name in ["a.png", "b.tiff", "c.exr", "d.hdr", "e.jpg"] {
        let picture: DynamicImage = match name {
            "c.exr" | "d.hdr" => DynamicImage::from(gradient()).to_rgb32f().into(),
            _ => gradient().into(),
        };
        let (_folder, path) = saved(name, &picture);
        let bytes = fs::read(&path).unwrap();
        for length in 0..bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            let read = read_image(&path, sized(6, 4), &linear(), PLENTY);
            // A PNG may lack its last chunk and still hold every pixel, and a JPEG its last marker.
            let spare = match name {
                "a.png" => 16,
                "e.jpg" => 2,
                _ => 0,
            };
            assert!(read.is_err() || length + spare >= bytes.len(), "{name} cut to {length} of {}", bytes.len());
        }
    }
}

#[test]
fn a_thumbnail_in_a_jpeg_is_not_its_end() {
    let (_folder, path) = saved("e.jpg", &gradient().into());
    let bytes = fs::read(&path).unwrap();
    let thumbnail = [&[0xff, 0xe1], &(2 + bytes.len() as u16).to_be_bytes()[..], &bytes].concat();
    let whole = [&bytes[..2], &thumbnail, &bytes[2..], b"what cameras append"].concat();
    for (length, read) in [(whole.len(), true), (whole.len() - 22, false), (2 + thumbnail.len() + 100, false)] {
        fs::write(&path, &whole[..length]).unwrap();
        assert_eq!(read_image(&path, sized(6, 4), &linear(), PLENTY).is_ok(), read, "{length}");
    }
}

#[test]
fn a_header_that_claims_more_than_the_camera_has_allocates_nothing() {
    let (_folder, path) = saved("a.png", &gradient().into());
    let mut bytes = fs::read(&path).unwrap();
    bytes[16..24].copy_from_slice(&[0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff]);
    let crc = crc32fast::hash(&bytes[12..29]);
    bytes[29..33].copy_from_slice(&crc.to_be_bytes());
    fs::write(&path, bytes).unwrap();
    assert!(read_image(&path, sized(6, 4), &linear(), PLENTY).is_err());
    // Nor one that claims more than any picture, where there is no camera.
    assert!(size(&path).unwrap_err().to_string().contains("larger than 65535 x 65535 pixels"));
}

fn read_mask(folder: &Path, name: &str, size: Size) -> crate::base::Result<Option<Vec<u8>>> {
    mask_path(folder, Path::new("images"), name)?
        .map(|path| Encoded::read(&path, PLENTY)?.mask(size, PLENTY))
        .transpose()
}

#[test]
fn a_decoder_that_panics_costs_no_more_than_its_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.jpg");
    // A progressive JPEG whose sampling the decoder's upsampling does not expect, on some processors. It is damaged, too.
    fs::write(&path, include_bytes!("../../../../tests/fuzz/seeds/image/refused-upsampling.jpg")).unwrap();
    let why = read_image(&path, size(&path).unwrap(), &linear(), PLENTY).err().map(|why| why.to_string());
    assert!(why.is_none_or(|why| why.contains("a.jpg")));
}

#[test]
fn a_decoder_that_repeats_what_it_found_is_cut_short() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    // Width, height, bits, RGB, and 16,163 samples a pixel, whose bits are all told.
    let entries = [[256u16, 7], [257, 5], [258, 8], [262, 2], [273, 8], [277, 16_163], [279, 9]].map(|[tag, value]| {
        [&tag.to_le_bytes()[..], &3u16.to_le_bytes(), &1u32.to_le_bytes(), &u32::from(value).to_le_bytes()].concat()
    });
    fs::write(&path, [b"II*\0\x08\0\0\0\x07\0", &entries.concat()[..], &[0; 99]].concat()).unwrap();
    let why = size(&path).unwrap_err().to_string();
    assert!(why.ends_with("...") && why.len() < 1000, "{} bytes: {}", why.len(), &why[..why.len().min(200)]);
}

#[test]
fn an_attribute_of_an_exr_is_not_gathered_before_there_is_memory_for_it() {
    let (_folder, path) = saved("a.exr", &DynamicImage::from(gradient()).to_rgb32f().into());
    let whole = fs::read(&path).unwrap();
    for (bytes, read) in [(1 << 10, true), (1 << 17, false)] {
        let attribute = [b"note\0blob\0", &(bytes as u32).to_le_bytes()[..], &vec![b'a'; bytes]].concat();
        // Positions of blocks count from the start of the file; a reader that goes front to back does not look at them.
        fs::write(&path, [&whole[..8], &attribute, &whole[8..]].concat()).unwrap();
        let found = size(&path).map_err(|why| why.to_string());
        assert_eq!(found.is_ok(), read, "{found:?}");
        let why = found.err().unwrap_or_default();
        assert!(read || why.contains("longer than 131072 bytes"), "{why}");
    }
}

#[test]
fn the_need_of_an_exr_counts_its_blocks_and_the_tables_of_piz() {
    use ::exr::prelude::{
        Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, SpecificChannels, Vec2, WritableImage,
    };
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let peak = |compression, side| {
        let encoding =
            Encoding { compression, blocks: Blocks::Tiles(Vec2(side, side)), line_order: LineOrder::Increasing };
        let pixels = SpecificChannels::rgb(|_: Vec2<usize>| (0.5f32, 0.5f32, 0.5f32));
        let layer = Layer::new((256, 256), LayerAttributes::default(), encoding, pixels);
        Image::from_layer(layer).write().non_parallel().to_file(&path).unwrap();
        need(&path, sized(256, 256)).unwrap().peak
    };
    let plain = peak(Compression::Uncompressed, 64);
    // The bytes that were measured where they were not said.
    assert!(peak(Compression::Uncompressed, 4) + (64 - 4) * 64 * 12 * 4 >= plain + 4080 * 82);
    assert!(peak(Compression::PIZ, 64) >= plain + 1_200_000);
}

#[test]
fn masks_are_found_by_the_names_that_programs_give_them() {
    let folder = tempfile::tempdir().unwrap();
    let mask = image::GrayImage::from_fn(6, 4, |x, _| image::Luma([if x == 2 { 0 } else { 7 }]));
    assert_eq!(read_mask(folder.path(), "one.jpg", sized(6, 4)).unwrap(), None);
    let names = ["one.jpg.png", "two.png", "a_mask.png", "b.mask.png", "c.jpg.mask.PNG", "d.PNG", "e.tif", "a.b.png"];
    for (at, file) in names.into_iter().enumerate() {
        let name = ["one.jpg", "two.jpg", "a.jpg", "b.jpg", "c.jpg", "d.jpg", "e.jpg", "a.b.jpg"][at];
        let format = if file.ends_with("tif") { ImageFormat::Tiff } else { ImageFormat::Png };
        mask.save_with_format(folder.path().join(file), format).unwrap();
        let read = read_mask(folder.path(), name, sized(6, 4)).unwrap().unwrap();
        assert_eq!((read[2], read[3]), (0, 7), "{file}");
        assert!(read_mask(folder.path(), name, sized(4, 6)).is_err());
    }
    // A photograph in the folder of masks is no mask.
    assert_eq!(mask_path(folder.path(), folder.path(), "two.png").unwrap(), None);
}

#[test]
fn a_mask_ignores_what_is_0_in_all_colours_or_clear() {
    use image::{GrayImage, ImageBuffer, Luma, LumaA};
    let folder = tempfile::tempdir().unwrap();
    // The first column is ignored.
    let masks: [DynamicImage; 7] = [
        GrayImage::from_fn(6, 4, |x, _| Luma([x as u8])).into(),
        ImageBuffer::from_fn(6, 4, |x, _| Luma([x as u16])).into(),
        RgbImage::from_fn(6, 4, |x, _| Rgb([0, 0, x as u8])).into(),
        ImageBuffer::from_fn(6, 4, |x, _| Rgb([x as u16, 0, 0])).into(),
        image::RgbaImage::from_fn(6, 4, |x, _| Rgba([255, 255, 255, x as u8])).into(),
        ImageBuffer::from_fn(6, 4, |x, _| LumaA([65_535, x as u16])).into(),
        ImageBuffer::from_fn(6, 4, |x, _| Rgba([x as u16, 0, 0, 65_535])).into(),
    ];
    for mask in masks {
        mask.save(folder.path().join("a.png")).unwrap();
        let read = read_mask(folder.path(), "a.jpg", sized(6, 4)).unwrap().unwrap();
        (0..24).for_each(|at| assert_eq!(read[at] == 0, at % 6 == 0, "{:?} pixel {at}", mask.color()));
    }
}

#[test]
fn a_png_with_megabytes_of_text_is_read() {
    let (_folder, path) = saved("a.png", &gradient().into());
    let whole = fs::read(&path).unwrap();
    let text = damage::chunk(b"tEXt", &[b"a\0".to_vec(), vec![b'b'; 9 << 20]].concat());
    fs::write(&path, [&whole[..33], &text, &whole[33..]].concat()).unwrap();
    assert_eq!(rgb(&read_image(&path, sized(6, 4), &linear(), PLENTY).unwrap(), 2)[0], 80.0 / 255.0);
    assert!(need(&path, sized(6, 4)).unwrap().peak < 16 << 20);
}

#[test]
fn a_big_tiff_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.tif");
    let bytes = gradient();
    let mut encoder = ::tiff::encoder::TiffEncoder::new_big(fs::File::create(&path).unwrap()).unwrap();
    encoder.write_image::<::tiff::encoder::colortype::RGB8>(6, 4, &bytes).unwrap();
    assert_eq!(rgb(&read_image(&path, sized(6, 4), &linear(), PLENTY).unwrap(), 2)[0], 80.0 / 255.0);
    let whole = fs::read(&path).unwrap();
    for length in 0..whole.len() {
        fs::write(&path, &whole[..length]).unwrap();
        assert!(read_image(&path, sized(6, 4), &linear(), PLENTY).is_err(), "{length}");
    }
}

#[test]
fn transfers_end_in_0_and_1_and_srgb_comes_back() {
    for transfer in [Transfer::Srgb, Transfer::Linear, Transfer::Gamma(2.2)] {
        let curve = Curve::new(transfer);
        assert_eq!((curve.eight[0], curve.eight[255], curve.sixteen[65_535]), (0.0, 1.0, 1.0));
    }
    let srgb = Curve::new(Transfer::Srgb);
    (0..=255u8).for_each(|v| assert_eq!(to_srgb8(srgb.eight[usize::from(v)]), v));
    assert!((srgb.eight[188] - 0.502_886).abs() < 1e-5);
    assert_eq!((to_srgb8(f32::NAN), to_srgb8(-1.0), to_srgb8(9.0)), (0, 0, 255));
}
