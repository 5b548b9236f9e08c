//! Any files under the names of any pose format. The first byte chooses names; each file but the last comes after its length, two
//! bytes.

use std::fs;
use std::path::{Component, Path};

use gonio::Result;
use gonio::internals::codec::images::Size;
use gonio::internals::codec::poses::{self, Photographs};
use gonio::internals::scene::frame::Frame;

use super::{BUFFERS, Target};
use crate::input;

/// An element of XML or a value of JSON takes two bytes or more of a file, and some ten words of memory.
pub const POSES: Target = Target { name: "poses", read, may_hold: |bytes| BUFFERS + 256 * bytes };

/// The names of the files of each format.
const NAMES: [(&str, &[&str]); 18] = [
    ("colmap", &["cameras.bin", "images.bin"]),
    ("colmap", &["cameras.txt", "images.txt"]),
    (
        "opendronemap",
        &[
            "cameras.json",
            "odm_georeferencing/coords.txt",
            "odm_georeferencing/odm_georeferencing_model_geo.txt",
            "odm_report/shots.geojson",
        ],
    ),
    ("opensfm", &["reconstruction.json"]),
    ("opensfm", &["reconstruction.json"]),
    ("metashape", &["cameras.xml"]),
    ("transforms", &["transforms.json"]),
    ("realitycapture", &["registration.csv"]),
    ("realitycapture", &["00000003.xmp", "00000004.xmp"]),
    ("blendedmvs", &["cams/00000003_cam.txt", "cams/00000004_cam.txt"]),
    ("tanks_and_temples", &["cameras.txt", "scene_COLMAP.log", "scene_trans.txt"]),
    ("alicevision", &["cameras.sfm"]),
    ("openmvs", &["scene.mvs"]),
    ("bundler", &["bundle.out", "list.txt"]),
    ("nvm", &["scene.nvm"]),
    ("pix4d", &["p_calibrated_camera_parameters.txt", "p_offset.xyz"]),
    ("micmac", &["AutoCal_Foc-28000_Cam-X.xml", "Orientation-00000003.jpg.xml", "Orientation-00000004.jpg.xml"]),
    ("blocks_exchange", &["blocks.xml"]),
];

/// Photographs that are nowhere.
struct Listed(Vec<String>);

impl Photographs for Listed {
    fn names(&self) -> Result<&[String]> {
        Ok(&self.0)
    }

    fn size(&self, _: &str) -> Result<Size> {
        Ok(Size { width: 640, height: 480 })
    }
}

fn read(bytes: &[u8]) -> bool {
    let Some((kind, mut rest)) = input::kind(bytes, NAMES.len() as u8) else { return false };
    let (format, names) = NAMES[usize::from(kind)];
    let format = poses::FORMATS.iter().find(|one| one.name == format).unwrap();
    let folder = input::folder().join(format!("poses{kind}"));
    for (at, name) in names.iter().enumerate() {
        let length = if at + 1 == names.len() {
            rest.len()
        } else {
            let Some((length, after)) = rest.split_first_chunk() else { return false };
            rest = after;
            usize::from(u16::from_le_bytes(*length)).min(rest.len())
        };
        let (file, after) = rest.split_at(length);
        rest = after;
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, file).unwrap();
    }
    let photographs = Listed((3..7).map(|number| format!("{number:08}.jpg")).collect());
    // Whatever the files hold, every format can say whether they are its own.
    poses::FORMATS.iter().for_each(|format| {
        (format.is_at)(&folder);
    });
    let frames = match poses::read(format, &folder, &photographs) {
        Ok(frames) => frames,
        Err(why) => {
            let said = why.to_string();
            assert!(said.len() < 4096 && !said.contains(char::is_control), "an error of {} bytes", said.len());
            return false;
        }
    };
    hold_sound(&frames);
    true
}

/// Fails unless every frame has a name that leads nowhere else, a pose and a size.
pub fn hold_sound(frames: &[Frame]) {
    for frame in frames {
        assert!(Path::new(&frame.name).components().all(|c| matches!(c, Component::Normal(_))), "{:?}", frame.name);
        assert!(!frame.name.contains(char::is_control), "{:?}", frame.name);
        assert!(frame.pose.translation.is_finite() && frame.pose.rotation.is_normalized());
        assert!(frame.camera.width > 0 && frame.camera.height > 0);
    }
}
