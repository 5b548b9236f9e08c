use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};
use serde_json::{Value, json};

use super::{Files, array, brown, file, rows_to_world};
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;

fn opensfm_camera(camera: &Camera) -> Value {
    let (m, [k1, k2, k3, p1, p2]) = (640.0, brown(camera));
    let (focal, centre) = (camera.lens.focal(), camera.lens.centre());
    json!({
        "projection_type": "brown", "width": 640, "height": 480, "focal_x": focal.x / m, "focal_y": focal.y / m,
        "c_x": (centre.x - 320.0) / m, "c_y": (centre.y - 240.0) / m, "k1": k1, "k2": k2, "k3": k3, "p1": p1, "p2": p2,
    })
}

fn axis(rotation: DQuat) -> [f64; 3] {
    array(rotation.to_scaled_axis())
}

/// A reconstruction after a smaller one; with a panorama that no shot uses.
fn reconstruction(frames: &[Frame], shots: BTreeMap<String, Value>, rigs: Value) -> Files {
    let cameras = json!({"v2 one": opensfm_camera(&frames[0].camera), "round": {"projection_type": "spherical"}});
    let small = json!({"cameras": {}, "shots": {}});
    let mut one =
        json!({"cameras": cameras, "shots": shots, "points": {"1": {"color": [1, 2, 3], "coordinates": [0, 0, 1]}}});
    for (key, value) in rigs.as_object().unwrap() {
        one[key] = value.clone();
    }
    file("reconstruction.json", json!([small, one]).to_string())
}

pub(super) fn opensfm(frames: &[Frame]) -> Files {
    let shot = |frame: &Frame| {
        let translation = array(frame.pose.translation);
        json!({"camera": "v2 one", "rotation": axis(frame.pose.rotation), "translation": translation, "orientation": 6})
    };
    reconstruction(frames, frames.iter().map(|frame| (frame.name.clone(), shot(frame))).collect(), json!({}))
}

/// Shots without poses: each is the second camera of a rig that stood once.
pub(super) fn opensfm_rigs(frames: &[Frame]) -> Files {
    let within = (DQuat::from_rotation_y(0.4) * DQuat::from_rotation_x(-0.2), DVec3::new(0.1, -0.3, 0.2));
    let instance = |frame: &Frame| {
        // camera = within (rig): rig = within^-1 camera.
        let rotation = within.0.inverse() * frame.pose.rotation;
        let translation = within.0.inverse() * (frame.pose.translation - within.1);
        json!({"rotation": axis(rotation), "translation": array(translation), "rig_camera_ids": {&frame.name: "second"}})
    };
    let instances: BTreeMap<String, Value> = frames.iter().map(|frame| (frame.name.clone(), instance(frame))).collect();
    let cameras = json!({"second": {"rotation": axis(within.0), "translation": array(within.1)}});
    let shots = frames.iter().map(|frame| (frame.name.clone(), json!({"camera": "v2 one"}))).collect();
    reconstruction(frames, shots, json!({"rig_instances": instances, "rig_cameras": cameras}))
}

pub(super) fn opendronemap(frames: &[Frame]) -> Files {
    let offset = DVec3::new(482_706.698_847_3, 1_557_461.395_505_8, 0.0);
    let feature = |frame: &Frame| {
        let centre = array(frame.pose.centre() + offset);
        let properties = json!({
            "filename": frame.name, "focal": frame.camera.lens.focal().x / 640.0, "width": 640, "height": 480,
            "translation": centre, "rotation": axis(frame.pose.rotation),
        });
        json!({"type": "Feature", "properties": properties, "geometry": {"type": "Point", "coordinates": [0.0, 0.0, 0.0]}})
    };
    let features: Vec<Value> = frames.iter().map(feature).collect();
    let mut other = opensfm_camera(&frames[0].camera);
    other["focal_x"] = json!(0.5);
    let cameras = json!({"brown one": opensfm_camera(&frames[0].camera), "brown two": other});
    let mut files = file("cameras.json", cameras.to_string());
    files.extend(file(
        "odm_report/shots.geojson",
        json!({"type": "FeatureCollection", "features": features}).to_string(),
    ));
    let geo = format!("WGS84 UTM 16N\n{} {}\n", offset.x, offset.y);
    files.extend(file("odm_georeferencing/odm_georeferencing_model_geo.txt", geo));
    files.extend(file("odm_georeferencing/coords.txt", "WGS84 UTM 16N\n482706 1557461\n1 2 3\n"));
    files
}

/// In a world that was turned, and with a lens of its own in the first frame.
pub(super) fn transforms(frames: &[Frame]) -> Files {
    let applied = DMat4::from_cols_array_2d(&[
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0, 0.0],
        [0.3, -0.2, 5.0, 1.0],
    ]);
    let frame = |frame: &Frame| {
        let [a, b, c] = rows_to_world(frame);
        let eye = frame.pose.centre();
        // Up and back instead of down and forward.
        let matrix = [
            [a[0], -a[1], -a[2], eye.x],
            [b[0], -b[1], -b[2], eye.y],
            [c[0], -c[1], -c[2], eye.z],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let moved = applied * DMat4::from_cols_array_2d(&matrix).transpose();
        json!({"file_path": format!("./images/{}", frame.name), "transform_matrix": moved.transpose().to_cols_array_2d()})
    };
    let camera = &frames[0].camera;
    let ([k1, k2, k3, p1, p2], focal, centre) = (brown(camera), camera.lens.focal(), camera.lens.centre());
    let rows = applied.transpose().to_cols_array_2d();
    let mut all = json!({
        "camera_model": "OPENCV", "w": 640, "h": 480, "fl_x": 600.0, "fl_y": focal.y, "cx": centre.x, "cy": centre.y,
        "k1": k1, "k2": k2, "k3": k3, "p1": p1, "p2": p2, "aabb_scale": 16, "applied_transform": [rows[0], rows[1], rows[2]],
        "frames": frames.iter().map(frame).collect::<Vec<_>>(),
    });
    for frame in all["frames"].as_array_mut().unwrap() {
        frame["fl_x"] = json!(focal.x);
    }
    file("transforms.json", all.to_string())
}

/// Numbers as strings, Windows paths, and a view without a pose.
pub(super) fn alicevision(frames: &[Frame]) -> Files {
    let text = |n: f64| Value::String(n.to_string());
    let texts = |all: &[f64]| all.iter().map(|n| text(*n)).collect::<Vec<_>>();
    let camera = &frames[0].camera;
    let (focal, centre) = (camera.lens.focal(), camera.lens.centre());
    let intrinsic = json!({
        "intrinsicId": "77", "width": "640", "height": "480", "sensorWidth": "6.4", "sensorHeight": "4.8", "type": "brown",
        "focalLength": text(focal.x * 6.4 / 640.0), "pixelRatio": "1",
        "principalPoint": texts(&[centre.x - 320.0, centre.y - 240.0]), "distortionParams": texts(&brown(camera)),
    });
    let view = |(at, frame): (usize, &Frame)| {
        let id = at.to_string();
        json!({
            "viewId": id, "poseId": id, "intrinsicId": "77", "path": format!("C:\\photos\\{}", frame.name), "width": "640",
            "height": "480",
        })
    };
    let pose = |(at, frame): (usize, &Frame)| {
        let transform = json!({"rotation": texts(rows_to_world(frame).as_flattened()), "center": texts(&array(frame.pose.centre()))});
        json!({"poseId": at.to_string(), "pose": {"transform": transform, "locked": "0"}})
    };
    let mut views: Vec<Value> = frames.iter().enumerate().map(view).collect();
    views.push(json!({"viewId": "9", "poseId": "9", "intrinsicId": "77", "path": "C:\\photos\\lost.jpg", "width": "640", "height": "480"}));
    let poses: Vec<Value> = frames.iter().enumerate().map(pose).collect();
    let all = json!({"version": ["1", "2", "6"], "views": views, "intrinsics": [intrinsic], "poses": poses});
    file("cameras.sfm", all.to_string())
}
