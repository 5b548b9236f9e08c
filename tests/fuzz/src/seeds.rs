//! Seeds: small inputs that readers take, so that a target begins beyond the first check. Those that gonio's own writers can
//! make are written here; `README.md` says where the others come from.

use std::fs;
use std::path::{Path, PathBuf};

use glam::DVec3;
use gonio::internals::base::ids::ShardId;
use gonio::internals::base::key::Key;
use gonio::internals::cache;
use gonio::internals::disk::{MemStore, Store};
use gonio::internals::scene::Mesh;
use gonio::internals::scene::reflectance::BinSum;
use gonio::internals::shard::block::Columns;
use gonio::internals::shard::rows::ROW;
use gonio::{TriangleId, template};
use image::{DynamicImage, ImageFormat, Rgb, Rgb32FImage, RgbImage};

use crate::targets::TARGETS;

fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("seeds")
}

/// Reads the seeds of every target, and ends the program with 1 unless each has some and takes every one; those whose names
/// begin with `refused` are there for what they reach.
pub fn check() {
    let mut good = true;
    for target in TARGETS {
        let shared = (target.name == "model").then(|| folder().join("../../data/models"));
        let folders = shared.unwrap_or_else(|| folder().join(target.name));
        let files = fs::read_dir(&folders).into_iter().flatten().map(|file| file.unwrap().path());
        let (mut taken, mut all) = (0, 0);
        for path in files {
            let was = target.run(&fs::read(&path).unwrap());
            // The models are those of other tests, and most are there to be refused.
            if target.name != "model" && was == path.file_name().unwrap().to_string_lossy().starts_with("refused") {
                println!("{}: {}", path.display(), if was { "taken" } else { "refused" });
                good = false;
            }
            (taken, all) = (taken + u32::from(was), all + 1);
        }
        println!("{}: {taken} of {all} seeds are taken", target.name);
        good &= taken > 0;
    }
    std::process::exit(i32::from(!good));
}

/// Writes the seeds that gonio can make.
pub fn write() {
    images();
    compressed();
    small_files();
    work_folder();
}

fn put(name: &str, bytes: &[u8]) {
    let path = folder().join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, bytes).unwrap();
}

/// An input of this kind.
fn of_kind(name: &str, kind: u8, bytes: &[u8]) {
    put(name, &[&[kind], bytes].concat());
}

fn images() {
    let eight = DynamicImage::from(RgbImage::from_fn(5, 3, |x, y| Rgb([x as u8 * 50, y as u8 * 80, 200])));
    let float = DynamicImage::from(Rgb32FImage::from_fn(5, 3, |x, y| Rgb([x as f32, y as f32 * 0.25, 0.5])));
    for (name, picture, format) in [
        ("rgb8.png", eight.clone(), ImageFormat::Png),
        ("grey16a.png", eight.to_luma_alpha16().into(), ImageFormat::Png),
        ("rgb16.tif", eight.to_rgb16().into(), ImageFormat::Tiff),
        ("rgba8.tif", eight.to_rgba8().into(), ImageFormat::Tiff),
        ("baseline.jpg", eight.clone(), ImageFormat::Jpeg),
        ("grey.jpg", eight.to_luma8().into(), ImageFormat::Jpeg),
        ("rgb.exr", float.clone(), ImageFormat::OpenExr),
        ("rgba.exr", float.to_rgba32f().into(), ImageFormat::OpenExr),
        ("rgb.hdr", float, ImageFormat::Hdr),
    ] {
        let mut bytes = std::io::Cursor::new(Vec::new());
        picture.write_to(&mut bytes, format).unwrap();
        put(&format!("image/{name}"), bytes.get_ref());
    }
}

/// Every way of cutting an EXR into blocks and of compressing them.
fn compressed() {
    use exr::prelude::{
        Blocks, Compression, Encoding, Image, Layer, LayerAttributes, LineOrder, SpecificChannels, Vec2, WritableImage,
    };
    for (name, compression, blocks) in [
        ("rle-tiles", Compression::RLE, Blocks::Tiles(Vec2(4, 4))),
        ("zip1", Compression::ZIP1, Blocks::ScanLines),
        ("zip16-tiles", Compression::ZIP16, Blocks::Tiles(Vec2(3, 2))),
        ("piz", Compression::PIZ, Blocks::ScanLines),
        ("pxr24", Compression::PXR24, Blocks::ScanLines),
        ("b44-tiles", Compression::B44, Blocks::Tiles(Vec2(4, 4))),
    ] {
        let pixels = SpecificChannels::rgba(|at: Vec2<usize>| (at.x() as f32, at.y() as f32, 0.5f32, 1.0f32));
        let encoding = Encoding { compression, blocks, line_order: LineOrder::Increasing };
        let mut bytes = std::io::Cursor::new(Vec::new());
        let image = Image::from_layer(Layer::new((7, 5), LayerAttributes::default(), encoding, pixels));
        image.write().non_parallel().to_buffered(&mut bytes).unwrap();
        put(&format!("image/{name}.exr"), bytes.get_ref());
    }
}

fn small_files() {
    for (descr, width) in [("<f4", 4), ("<f8", 8)] {
        let header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (2, 7), }}\n");
        let start = [b"\x93NUMPY\x01\x00", &(header.len() as u16).to_le_bytes()[..], header.as_bytes()].concat();
        put(&format!("npy/{}", &descr[1..]), &[start, vec![0; 14 * width]].concat());
    }
    put("pipeline/refused-template.toml", template().as_bytes());
    let files =
        "[scene]\nmesh = \"any.toml\"\nimages = \".\"\nposes = { format = \"colmap\", path = \"model\" }\n[run]\n";
    let sets = "\0infer.estimator=fit\0light.mode=known\0light.sun=[0, 0, 1]\0light.sky=[0.1, 0.1, 0.1]\0run.work=w";
    put("pipeline/sets", format!("{files}{sets}").as_bytes());
    let elf = {
        let mut elf = [&b"\x7fELF\x02\x01"[..], &[0; 58 + 56]].concat();
        elf[32] = 64; // The program headers begin behind the header,
        elf[54] = 56; // have so many bytes each,
        elf[56] = 1; // and there is one.
        elf
    };
    put("library/one-segment", &elf);
}

fn work_folder() {
    let mesh =
        Mesh::new(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.5)], vec![[0, 1, 2], [1, 3, 2], [0, 0, 1]]);
    let store = MemStore::new();
    cache::write(&mesh.unwrap(), &store, "scene", &|| false).unwrap();
    let file = store.open("scene").unwrap();
    of_kind("cache/whole", 0, &file);
    of_kind("cache/body", 1, &file[..file.len() - 24]);

    let mut columns = Columns::default();
    columns.begin(ShardId(3));
    let sum = |radiance: f32, count: u32| BinSum { count, ..BinSum::one([radiance, 0.5, 0.25], count > 1) };
    columns.push(ShardId(3).first(), 1, &[(5, sum(0.1, 1))]);
    columns.push(TriangleId(ShardId(3).first().0 + 7), 5, &[(3, sum(0.2, 3)), (12, sum(0.3, 2))]);
    let mut block = Vec::new();
    columns.write(&mut block);
    of_kind("segment/columns", 2, &[&[2, 0, 3, 0, 0, 0], &block[..]].concat());
    of_kind("segment/compressed", 3, &[&[2, 0, 3, 0, 0, 0], &zstd::encode_all(&block[..], 1).unwrap()[..]].concat());
    let row = |triangle: u32| [&triangle.to_le_bytes()[..], &[0; ROW - 4]].concat();
    let rows = [&1u32.to_le_bytes()[..], &2u32.to_le_bytes(), &row(4096), &row(5000)].concat();
    of_kind("rows/two", 2, &rows);
    of_kind("rows/blocks", 3, &[[1; 20], [2; 20]].concat());

    let record = r#"{"phase":"load","what":"scene","ingredients":{"mesh":"a"},"files":[{"name":"scene.cache","bytes":6,"checksum":"CHECKSUM"}]}"#;
    let record = record.replace("CHECKSUM", &Key::of_bytes(b"a file").to_string());
    of_kind("record/own-name", 2, record.as_bytes());
    of_kind("record/refused-other-name", 1, record.as_bytes());
    let lost =
        r#"{"phase":"cast","what":"0","ingredients":{},"files":[{"name":"a/b.seg","bytes":1,"checksum":"CHECKSUM"}]}"#;
    of_kind("record/refused-lost", 2, lost.replace("CHECKSUM", &Key::of_bytes(b"").to_string()).as_bytes());
    of_kind("record/page", 4, br#"[{"frames":["a.jpg","b.jpg"]},{"frames":["c.jpg"]}]"#);
    let words = "The folder of a run of gonio. It removes here what it made and needs no more. Id 0123456789abcdef\n";
    of_kind("record/mark", 5, words.as_bytes());
}
