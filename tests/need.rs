//! Compares the need of an image with the memory that this process holds while it reads the image. The test is alone in
//! its binary, so that nothing else is held beside it.
#![cfg(target_os = "linux")]
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread;
use std::time::Duration;

use gonio::internals::base::memory;
use gonio::internals::codec::images::{Curve, Size, Transfer, need, read_image, write_jpeg};
use image::{DynamicImage, ImageBuffer, Luma, Rgb, Rgba};

const SIZE: Size = Size { width: 2400, height: 1800 };

/// Memory that comes and goes between two looks is missed, and blocks that were free before are taken again.
const SLACK: u64 = 2 << 20;

fn noise(x: u32, y: u32) -> [u8; 3] {
    let v = x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b);
    [v as u8, (v >> 9) as u8, (v >> 18) as u8]
}

/// Runs `work`, and gives the most anonymous memory that was held beyond what was held before.
fn grown(work: impl FnOnce()) -> u64 {
    memory::trim();
    let before = memory::resident().unwrap();
    let (done, most) = (AtomicBool::new(false), AtomicU64::new(0));
    thread::scope(|scope| {
        scope.spawn(|| {
            while !done.load(Ordering::SeqCst) {
                most.fetch_max(memory::resident().unwrap(), Ordering::SeqCst);
                thread::sleep(Duration::from_micros(200));
            }
        });
        work();
        done.store(true, Ordering::SeqCst);
    });
    most.into_inner().saturating_sub(before)
}

fn write(path: &Path) {
    let Size { width: w, height: h } = SIZE;
    let rgb = ImageBuffer::from_fn(w, h, |x, y| Rgb(noise(x, y)));
    match path.file_stem().unwrap().to_str().unwrap() {
        "photo" => {
            let pixels: Vec<[u8; 3]> = rgb.pixels().map(|p| p.0).collect();
            write_jpeg(path, &pixels, w, h, 90).unwrap();
        }
        "rgb8" => rgb.save(path).unwrap(),
        "rgba16" => {
            let wide = |x, y| Rgba([x as u16, y as u16, (x * y) as u16, 65_535]);
            DynamicImage::from(ImageBuffer::from_fn(w, h, wide)).save(path).unwrap();
        }
        "grey16" => DynamicImage::from(ImageBuffer::from_fn(w, h, |x, y| Luma([(x * y) as u16]))).save(path).unwrap(),
        _ => ImageBuffer::from_fn(w, h, |x, y| Rgb(noise(x, y).map(|v| f32::from(v) / 255.0))).save(path).unwrap(),
    }
}

#[test]
fn no_image_takes_more_than_its_header_says() {
    memory::return_what_is_freed();
    let dir = tempfile::tempdir().unwrap();
    let curve = Curve::new(Transfer::Srgb);
    let files =
        ["photo.jpg", "rgb8.png", "rgba16.png", "grey16.png", "rgb8.tif", "rgba16.tif", "float.hdr", "float.exr"];
    for name in files {
        let path = dir.path().join(name);
        write(&path);
        let said = need(&path, SIZE).unwrap();
        let mut held = 0;
        let peak = grown(|| held = read_image(&path, SIZE, &curve, said.peak).unwrap().bytes());
        println!("{name}: {:.1} MiB of {:.1} MiB", peak as f64 / 1048576.0, said.peak as f64 / 1048576.0);
        assert_eq!(held, said.held, "{name}");
        assert!(peak <= said.peak + SLACK, "{name}: {peak} bytes, where {} were said", said.peak);
        assert!(peak + SLACK >= held, "{name}: {peak} bytes cannot be all: {held} are held");
    }
}
