//! The memory limit, held against the real process: its anonymous memory, sampled while it runs, stays under the limit, and
//! what it leaves is the same.

use std::fs::{self, OpenOptions};
use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

use gonio::internals::codec::images::write_jpeg;
use gonio::internals::codec::poses::colmap::{self, Encoding};
use gonio::internals::codec::poses::{self, COLMAP};
use gonio::internals::scene::camera::{Camera, Lens};
use gonio::internals::scene::frame::Frame;
use image::{Rgb, Rgb32FImage};
use tempfile::TempDir;

use crate::files::{city, outputs};
use crate::ran::Ran;

/// Between two looks at the process.
const LOOK: Duration = Duration::from_millis(2);

/// Bytes of a mebibyte.
const MIB: u64 = 1 << 20;

/// The city photographed through a lens so wide that most rays miss it, which makes them quick. All photographs are the
/// same, written by `shot` under the name that it is given.
fn city_seen(frames: usize, (width, height): (u32, u32), ending: &str, shot: impl FnOnce(&Path)) -> TempDir {
    let dir = city();
    let (model, images) = (dir.path().join("sparse/0"), dir.path().join("images"));
    let posed = poses::read(&COLMAP, &model, &poses::NoPhotographs).unwrap();
    let centre = [f64::from(width) / 2.0, f64::from(height) / 2.0];
    let lens = Lens::pinhole([f64::from(width) * 0.15; 2].into(), centre.into());
    let camera: Arc<Camera> = Camera { width, height, lens }.into();
    let first = images.join(format!("00.{ending}"));
    shot(&first);
    let frame = |k: usize| {
        let name = format!("{k:02}.{ending}");
        if k > 0 {
            fs::hard_link(&first, images.join(&name)).unwrap();
        }
        Frame { name, camera: Arc::clone(&camera), ..posed[k % posed.len()].clone() }
    };
    colmap::write_model(&model, &(0..frames).map(frame).collect::<Vec<_>>(), Encoding::Binary).unwrap();
    dir
}

/// The scene in floats, 12 bytes a pixel: all its photographs together, and all its maps, want more than a gibibyte.
fn wants_much() -> TempDir {
    let shade = |x: u32, y: u32| Rgb([(x % 97) as f32 / 100.0, (y % 89) as f32 / 100.0, 0.4]);
    city_seen(48, (1600, 1200), "hdr", |path| Rgb32FImage::from_fn(1600, 1200, shade).save(path).unwrap())
}

/// A run of `p.toml` under a limit, started within a shell that first does `before`.
fn start(dir: &Path, work: &str, limit: u64, before: &str) -> Child {
    let mut command = Command::new("sh");
    command.current_dir(dir).stdout(Stdio::null()).stderr(Stdio::piped());
    command.args(["-c", &format!("{before} exec \"$0\" \"$@\""), env!("CARGO_BIN_EXE_gonio"), "run", "p.toml"]);
    let (work, limit) = (format!("run.work={work}"), format!("run.memory={}MiB", limit / MIB));
    for set in [&work, &limit, "run.threads=16", "gather.group=4", "infer.batch=4096", "export.formats=[]"] {
        command.args(["--set", set]);
    }
    command.spawn().unwrap()
}

fn ended_well(child: Child) {
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success(), "{}: {}", output.status, String::from_utf8_lossy(&output.stderr));
}

/// Runs it to its good end, and gives the most anonymous memory that the process was seen to hold.
fn peak(dir: &Path, work: &str, limit: u64) -> u64 {
    let mut child = start(dir, work, limit, "");
    let peak = watched(&mut child);
    ended_well(child);
    peak
}

/// The most anonymous memory that a process is seen to hold until it ends.
fn watched(child: &mut Child) -> u64 {
    let status = format!("/proc/{}/status", child.id());
    let mut peak = 0;
    while child.try_wait().unwrap().is_none() {
        let held = fs::read_to_string(&status).ok().as_deref().and_then(gonio::internals::base::memory::anonymous);
        peak = peak.max(held.unwrap_or(0));
        thread::sleep(LOOK);
    }
    peak
}

fn tables(dir: &Path, work: &str) -> [Vec<u8>; 2] {
    ["materials.npy", "evidence.npy"].map(|name| fs::read(dir.join(work).join(name)).unwrap())
}

#[test]
fn the_process_stays_under_its_limit_and_leaves_the_same() {
    let dir = wants_much();
    let wanted = peak(dir.path(), "free", 16 << 30);
    assert!(wanted > 1024 * MIB, "the scene asks for too little to show anything: {} MiB", wanted / MIB);
    let expected = tables(dir.path(), "free");
    for limit in [256, 512, 1024] {
        let work = format!("limit-{limit}");
        let held = peak(dir.path(), &work, limit * MIB);
        println!("{} MiB of {limit} MiB; without a limit {} MiB", held / MIB, wanted / MIB);
        assert!(held <= limit * MIB, "{} MiB held under {limit} MiB", held / MIB);
        assert!(tables(dir.path(), &work) == expected, "under {limit} MiB");
    }
    match Cgroup::new(256 * MIB) {
        Some(group) => {
            ended_well(start(dir.path(), "group", 256 * MIB, &group.enter()));
            assert!(tables(dir.path(), "group") == expected, "in a cgroup of 256 MiB");
        }
        None => println!("no cgroup may be made here: a limit on all pages, mapped ones too, is not tried"),
    }
}

#[test]
fn a_mesh_that_does_not_fit_is_refused_before_it_is_read() {
    let dir = city();
    // Ten million vertices in a file of holes, 114 MiB in memory, and one triangle.
    let header = "ply\nformat binary_little_endian 1.0\nelement vertex 10000000\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar uchar vertex_indices\nend_header\n";
    let mut file = fs::File::create(dir.path().join("mesh.ply")).unwrap();
    file.write_all(header.as_bytes()).unwrap();
    file.seek(SeekFrom::Current(120_000_000)).unwrap();
    file.write_all(&[3, 0, 1, 2]).unwrap();
    let mut child = start(dir.path(), "work", 128 * MIB, "");
    let held = watched(&mut child);
    let output = child.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("too small: the mesh takes 114.4 MiB") && said.contains("fewer triangles"), "{said}");
    assert!(held < 100 * MIB, "{} MiB", held / MIB);
}

#[test]
fn a_frame_that_does_not_fit_is_skipped_until_it_does() {
    let dir = city();
    let (model, large) = (dir.path().join("sparse/0"), "frame_004.hdr");
    let mut frames = poses::read(&COLMAP, &model, &poses::NoPhotographs).unwrap();
    let (width, height) = (5000, 4000);
    let lens =
        Lens::pinhole([f64::from(width) * 0.15; 2].into(), [f64::from(width) / 2.0, f64::from(height) / 2.0].into());
    frames[4] = Frame { name: large.into(), camera: Camera { width, height, lens }.into(), ..frames[4].clone() };
    colmap::write_model(&model, &frames, Encoding::Binary).unwrap();
    Rgb32FImage::from_pixel(width, height, Rgb([0.2, 0.3, 0.4])).save(dir.path().join("images").join(large)).unwrap();
    let gonio = |command: &str, work: &str, memory: &str| {
        let sets = format!("--set run.work={work} --set run.memory={memory} --set gather.group=2");
        // Exposures stay as they were first found, and a run that had the frame all along would have found others.
        let as_is = "--set decode.exposure=as_is --set light.mode=unknown";
        Ran::gonio(dir.path(), &format!("{command} {sets} {as_is}"))
    };
    gonio("plan p.toml", "work", "200MiB").ends(0).says("1 of 10 frames: reading one takes up to 231");
    let ran = gonio("run p.toml", "work", "200MiB");
    ran.ends(3)
        .says("skipped frame_004.hdr: reading it takes 231")
        .says("[run] memory = \"200 MiB\"")
        .says("downscale");
    gonio("run p.toml", "work", "200MiB").ends(3).says("10 (0 cast, 9 from before, 1 skipped)");
    gonio("maps p.toml --triangles 1 --out m.npz", "work", "200MiB").ends(0);
    // With memory for it, its group is done over, and the result is that of a run that had it all along.
    gonio("explain p.toml", "work", "1GiB").ends(0).says("frames         2 of 10").says("frame_004.hdr fits");
    gonio("run p.toml", "work", "1GiB").ends(0).says("10 (2 cast, 8 from before, 0 skipped)");
    gonio("run p.toml", "fresh", "1GiB").ends(0);
    assert!(outputs(&dir.path().join("work")) == outputs(&dir.path().join("fresh")));
    // What has been cast stays.
    gonio("run p.toml", "work", "200MiB").ends(0).says("10 (0 cast, 10 from before, 0 skipped)");
}

#[test]
#[ignore = "takes minutes where the process is not optimised"]
fn a_frame_of_150_megapixels_is_cast_within_a_gibibyte() {
    let size = (15_000, 10_000);
    let dir = city_seen(1, size, "jpg", |path| {
        let pixels: Vec<[u8; 3]> =
            (0..size.0 * size.1).map(|i| [(i % 251) as u8, (i / size.0 % 241) as u8, 90]).collect();
        write_jpeg(path, &pixels, size.0, size.1, 90).unwrap();
    });
    let held = peak(dir.path(), "work", 1024 * MIB);
    println!("{} MiB", held / MIB);
    assert!(held <= 1024 * MIB, "{} MiB", held / MIB);
}

/// A control group of this test's own, whose processes may hold no more than a limit in all.
struct Cgroup(PathBuf);

impl Cgroup {
    /// `None` where none may be made, or where memory is not controlled.
    fn new(limit: u64) -> Option<Cgroup> {
        let name = format!("gonio-test-{}", std::process::id());
        // Version 2 and version 1.
        [("/sys/fs/cgroup", "memory.max"), ("/sys/fs/cgroup/memory", "memory.limit_in_bytes")].into_iter().find_map(
            |(root, file)| {
                let folder = Path::new(root).join(&name);
                fs::create_dir(&folder).ok()?;
                let group = Cgroup(folder);
                // Where no controller is mounted, a folder is but a folder, without this file.
                let mut file = OpenOptions::new().write(true).open(group.0.join(file)).ok()?;
                file.write_all(limit.to_string().as_bytes()).ok()?;
                Some(group)
            },
        )
    }

    /// What a shell does to enter it.
    fn enter(&self) -> String {
        format!("echo $$ > {}/cgroup.procs &&", self.0.display())
    }
}

impl Drop for Cgroup {
    fn drop(&mut self) {
        fs::remove_dir(&self.0).unwrap_or_default();
    }
}
