//! `gonio eval images`, on pictures whose errors are known.

use std::fs;
use std::path::Path;

use image::{DynamicImage, Rgb, Rgb32FImage, RgbImage, Rgba, RgbaImage};
use serde_json::Value;
use tempfile::TempDir;

use crate::ran::Ran;

/// Saves pictures under their names, in folders that are made.
fn saved(pictures: &[(&str, DynamicImage)]) -> TempDir {
    let dir = TempDir::new().unwrap();
    for (name, picture) in pictures {
        let path = dir.path().join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        picture.save(path).unwrap();
    }
    dir
}

fn even(width: u32, height: u32, value: u8) -> DynamicImage {
    RgbImage::from_pixel(width, height, Rgb([value; 3])).into()
}

fn json(folder: &Path, args: &str, code: i32) -> Value {
    serde_json::from_str(&Ran::gonio(folder, &format!("eval images {args} --json")).ends(code).stdout()).unwrap()
}

fn close(value: &Value, expected: f64) {
    assert!((value.as_f64().unwrap() - expected).abs() < 1e-5 * expected.abs(), "{value} {expected}");
}

#[test]
fn two_pictures_are_compared_in_linear_radiance_or_in_srgb() {
    let dir = saved(&[("a.png", even(9, 8, 51)), ("b.png", even(9, 8, 102))]);
    let gonio = |args: &str| Ran::gonio(dir.path(), &format!("eval images {args}"));
    gonio("a.png b.png").ends(0).says("linear radiance").says("a.png  ").says("72");
    // 51 and 102 of 255 are 0.2 and 0.4: 0.0331048 and 0.1328683 of linear radiance.
    let (x, y, c1) = (0.033_104_8, 0.132_868_3, 1e-4);
    let linear = json(dir.path(), "a.png b.png", 0);
    assert_eq!((&linear["space"], linear["pictures"].as_array().unwrap().len()), (&"linear".into(), 1));
    let all = &linear["all"];
    close(&all["mae"], y - x);
    close(&all["psnr"], -20.0 * (y - x).log10());
    close(&all["nrmse"], (y - x) / x);
    close(&all["dssim"], 0.5 - 0.5 * (2.0 * x * y + c1) / (x * x + y * y + c1));
    let srgb = json(dir.path(), "a.png b.png --space srgb", 0);
    close(&srgb["all"]["mae"], 0.2);
    close(&srgb["all"]["nrmse"], 1.0);
    // Equal pictures: the signal is beyond all noise, which JSON has no number for.
    let equal = json(dir.path(), "a.png a.png", 0);
    assert!(equal["all"]["psnr"].is_null() && equal["all"]["mae"] == 0.0, "{equal}");
    // Floating-point files are linear as they are.
    let bright = Rgb32FImage::from_pixel(9, 8, Rgb([y as f32; 3]));
    DynamicImage::from(bright).save(dir.path().join("b.exr")).unwrap();
    close(&json(dir.path(), "a.png b.exr", 0)["all"]["mae"], y - x);
}

#[test]
fn what_is_transparent_in_the_truth_is_not_compared_and_in_the_other_is_wrong() {
    let holed = |value| RgbaImage::from_fn(9, 8, |x, _| Rgba([value, value, value, if x == 0 { 0 } else { 255 }]));
    let dir = saved(&[("a.png", holed(255).into()), ("b.png", even(9, 8, 255)), ("c.png", holed(255).into())]);
    let all = json(dir.path(), "a.png b.png", 0)["all"].clone();
    assert_eq!((&all["pixels"], &all["missing"], &all["mae"]), (&64.into(), &0.into(), &0.0.into()));
    let wrong = json(dir.path(), "b.png c.png", 0)["all"].clone();
    assert_eq!((&wrong["pixels"], &wrong["missing"]), (&72.into(), &8.into()));
    close(&wrong["mae"], 1.0 / 9.0);
    Ran::gonio(dir.path(), "eval images b.png c.png").ends(0).says("8 pixels are nothing");
}

#[test]
fn two_sizes_are_named_and_compared_with_nothing() {
    let dir = saved(&[("a.png", even(9, 8, 51)), ("b.jpg", even(8, 9, 51))]);
    let ran = Ran::gonio(dir.path(), "eval images a.png b.jpg");
    ran.ends(1).says("b.jpg: 8 x 9 pixels, where a.png has 9 x 8");
    assert_eq!(ran.stdout(), "", "{ran}");
    Ran::gonio(dir.path(), "eval images a.png nowhere.png").ends(1).says("cannot open nowhere.png");
    Ran::gonio(dir.path(), "eval images a.png .").ends(1).says(". is a folder and a.png is a file");
}

#[test]
fn folders_are_compared_by_name_and_what_cannot_be_is_listed() {
    let dir = saved(&[
        ("a/left/0.png", even(9, 8, 51)),
        ("a/right/0.png", even(9, 8, 0)),
        ("a/lone.png", even(9, 8, 51)),
        ("a/cut.png", even(9, 8, 51)),
        ("a/other.png", even(9, 8, 51)),
        ("b/left/0.png", even(9, 8, 102)),
        ("b/right/0.png", even(9, 8, 255)),
        ("b/new.jpg", even(9, 8, 51)),
        ("b/other.png", even(9, 9, 51)),
    ]);
    fs::write(dir.path().join("a/notes.txt"), "no picture").unwrap();
    let whole = fs::read(dir.path().join("a/cut.png")).unwrap();
    fs::write(dir.path().join("b/cut.png"), &whole[..whole.len() / 2]).unwrap();
    let ran = Ran::gonio(dir.path(), "eval images a b");
    ran.ends(3).says("all 2 together").says("skipped lone.png: not in b").says("skipped new.jpg: not in a");
    ran.says("skipped cut.png: b/cut.png: ")
        .says("skipped other.png: b/other.png: 9 x 9 pixels, where a/other.png has 9 x 8");
    let both = json(dir.path(), "a b --space srgb", 3);
    let names: Vec<_> = both["pictures"].as_array().unwrap().iter().map(|p| p["name"].as_str().unwrap()).collect();
    assert_eq!((names, both["skipped"].as_array().unwrap().len()), (vec!["left/0.png", "right/0.png"], 4));
    close(&both["all"]["mae"], 0.6);
    close(&both["all"]["psnr"], -10.0 * 0.52_f64.log10());
    // Where nothing is left there are no figures.
    let ran = Ran::gonio(dir.path(), "eval images a/left b");
    ran.ends(1).says("no picture in a/left has one of the same name in b");
    fs::create_dir(dir.path().join("c")).unwrap();
    fs::write(dir.path().join("c/cut.png"), "").unwrap();
    Ran::gonio(dir.path(), "eval images a c").ends(1).says("none of 1 pictures of a can be compared").says("c/cut.png");
}
