use glam::DVec3;

use super::{Files, brown, file, rows, rows_to_world, spaced};
use crate::codec::poses::colmap::{Encoding, write_model};
use crate::scene::camera::Projection;
use crate::scene::frame::Frame;

fn colmap(frames: &[Frame], encoding: Encoding, names: &[&str]) -> Files {
    let folder = tempfile::tempdir().unwrap();
    write_model(folder.path(), frames, encoding).unwrap();
    let read = |name: &&str| ((*name).to_owned(), std::fs::read(folder.path().join(name)).unwrap());
    names.iter().map(read).collect()
}

pub(super) fn colmap_binary(frames: &[Frame]) -> Files {
    colmap(frames, Encoding::Binary, &["cameras.bin", "images.bin"])
}

pub(super) fn colmap_text(frames: &[Frame]) -> Files {
    colmap(frames, Encoding::Text, &["cameras.txt", "images.txt"])
}

/// Heading, pitch and roll, degrees, of a rotation Rz(-heading) Rx(pitch) Ry(roll) of the axes right, up, back.
fn angles(frame: &Frame) -> [f64; 3] {
    let m = rows_to_world(frame).map(|[x, y, z]| [x, -y, -z]);
    [m[0][1].atan2(m[1][1]), m[2][1].asin(), (-m[2][0]).atan2(m[2][2])].map(f64::to_degrees)
}

pub(super) fn realitycapture(frames: &[Frame]) -> Files {
    let mut text = "#name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2\n".to_owned();
    for frame in frames {
        let ([k1, k2, k3, t1, t2], lens, eye) = (brown(&frame.camera), &frame.camera.lens, frame.pose.centre());
        let [heading, pitch, roll] = angles(frame);
        let (focal, centre) = (lens.focal().x * 36.0 / 640.0, (lens.centre() - glam::DVec2::new(320.0, 240.0)) / 640.0);
        let (x, y, z, u, v) = (eye.x, eye.y, eye.z, centre.x, centre.y);
        let name = &frame.name;
        text += &format!("{name},{x},{y},{z},{heading},{pitch},{roll},{focal},{u},{v},{k1},{k2},{k3},0,{t1},{t2}\n");
    }
    file("registration.csv", text)
}

pub(super) fn blendedmvs(frames: &[Frame]) -> Files {
    let mut files = Files::new();
    for frame in frames {
        let ([a, b, c], t, lens) = (rows(frame), frame.pose.translation, &frame.camera.lens);
        let text = format!(
            "extrinsic\n{} {}\n{} {}\n{} {}\n0 0 0 1\n\nintrinsic\n{} 0 {}\n0 {} {}\n0 0 1\n\n425.0 2.5 128 933.8\n",
            spaced(&a),
            t.x,
            spaced(&b),
            t.y,
            spaced(&c),
            t.z,
            lens.focal().x,
            lens.centre().x,
            lens.focal().y,
            lens.centre().y,
        );
        files.extend(file(&format!("cams/{}", frame.name.replace(".jpg", "_cam.txt")), text));
    }
    files
}

/// In a world that `_trans.txt` leads back from.
pub(super) fn tanks_and_temples(frames: &[Frame]) -> Files {
    let (scale, shift) = (2.0, DVec3::new(1.0, -3.0, 8.0));
    let mut text = String::new();
    for (at, frame) in frames.iter().enumerate() {
        let ([a, b, c], eye) = (rows_to_world(frame), (frame.pose.centre() - shift) / scale);
        let [a, b, c] = [a, b, c].map(|row| spaced(&row));
        text += &format!("{at} {at} 0\n{a} {}\n{b} {}\n{c} {}\n0 0 0 1\n", eye.x, eye.y, eye.z);
    }
    let mut files = file("scene_COLMAP.log", text);
    let alignment = format!("{scale} 0 0 {}\n0 {scale} 0 {}\n0 0 {scale} {}\n0 0 0 1\n", shift.x, shift.y, shift.z);
    files.extend(file("scene_trans.txt", alignment));
    files.extend(colmap(frames, Encoding::Text, &["cameras.txt"]));
    files
}

pub(super) fn openmvs(frames: &[Frame]) -> Files {
    let mut bytes = b"MVSI".to_vec();
    let mut put = |part: &[u8]| bytes.extend_from_slice(part);
    let name = |text: &str| [&(text.len() as u64).to_le_bytes(), text.as_bytes()].concat();
    let numbers = |all: &[f64]| all.iter().flat_map(|n| n.to_le_bytes()).collect::<Vec<u8>>();
    let (lens, identity) = (&frames[0].camera.lens, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let (focal, centre) = (lens.focal(), lens.centre());
    put(&[6u32.to_le_bytes(), 0u32.to_le_bytes()].concat());
    put(&1u64.to_le_bytes());
    put(&name("platform000"));
    put(&1u64.to_le_bytes());
    put(&[name("PINHOLE"), name("")].concat());
    put(&[640u32.to_le_bytes(), 480u32.to_le_bytes()].concat());
    // The centre of the first pixel is at 0.
    put(&numbers(&[focal.x, 0.0, centre.x - 0.5, 0.0, focal.y, centre.y - 0.5, 0.0, 0.0, 1.0]));
    put(&numbers(&identity));
    put(&numbers(&[0.0; 3]));
    put(&(frames.len() as u64).to_le_bytes());
    for frame in frames {
        put(&numbers(rows(frame).as_flattened()));
        put(&numbers(&frame.pose.centre().to_array()));
    }
    put(&(frames.len() as u64).to_le_bytes());
    for (at, frame) in (0u32..).zip(frames) {
        put(&[name(&format!("undistorted/images/{}", frame.name)), name("")].concat());
        put(&[0u32, 0, at, at].map(u32::to_le_bytes).concat());
    }
    put(&[0; 40]);
    Files::from([("scene.mvs".to_owned(), bytes)])
}

pub(super) fn bundler(frames: &[Frame]) -> Files {
    let mut text = format!("# Bundle file v0.3\n{} 0\n", frames.len() + 1);
    let mut list = String::new();
    for frame in frames {
        let ([k1, k2, ..], [a, b, c], t) = (brown(&frame.camera), rows(frame), frame.pose.translation);
        // Up and back instead of down and forward.
        let [b, c] = [b, c].map(|row| row.map(|n| -n));
        let [a, b, c] = [a, b, c].map(|row| spaced(&row));
        text += &format!("{} {k1} {k2}\n{a}\n{b}\n{c}\n{} {} {}\n", frame.camera.lens.focal().x, t.x, -t.y, -t.z);
        list += &format!("./{} 0 512.5\n", frame.name);
    }
    text += "0 0 0\n0 0 0\n0 0 0\n0 0 0\n0 0 0\n";
    let mut files = file("bundle.out", text);
    files.extend(file("list.txt", list + "lost.jpg\n"));
    files
}

pub(super) fn nvm(frames: &[Frame]) -> Files {
    let mut text = format!("NVM_V3 \n\n{}\n", frames.len());
    for frame in frames {
        let (q, eye, lens) = (frame.pose.rotation, frame.pose.centre(), &frame.camera.lens);
        let Projection::Inward(d) = lens.projection() else { panic!("another lens") };
        let pose = spaced(&[q.w, q.x, q.y, q.z, eye.x, eye.y, eye.z]);
        text += &format!("my images/{}\t{} {pose} {} 0\n", frame.name, lens.focal().x, d.radial[0]);
    }
    file("scene.nvm", text + "\n0\n\n0\n")
}

pub(super) fn pix4d(frames: &[Frame]) -> Files {
    let mut text =
        "fileName imageWidth imageHeight \ncamera matrix K [3x3]\nradial distortion [3x1]\ntangential distortion \
                    [2x1]\ncamera position t [3x1]\ncamera rotation R [3x3]\ncamera model m = K [R|-Rt] X\n\n"
            .to_owned();
    for frame in frames {
        let ([k1, k2, k3, t1, t2], lens) = (brown(&frame.camera), &frame.camera.lens);
        let (focal, centre, [a, b, c]) = (lens.focal(), lens.centre(), rows(frame).map(|row| spaced(&row)));
        let eye = spaced(&frame.pose.centre().to_array());
        text += &format!("{} 640 480\n{} 0 {}\n0 {} {}\n0 0 1\n", frame.name, focal.x, centre.x, focal.y, centre.y);
        text += &format!("{k1} {k2} {k3}\n{t1} {t2}\n{eye}\n{a}\n{b}\n{c}\n");
    }
    let mut files = file("p_calibrated_camera_parameters.txt", text);
    files.extend(file("p_offset.xyz", "368109.000 3956043.000 96.000"));
    files
}
