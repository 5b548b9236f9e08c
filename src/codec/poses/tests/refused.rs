use super::writers::WRITTEN;
use super::{Listed, Says, read, scene, write};
use crate::codec::poses::{NoPhotographs, Posed, look};

/// What is read where `from` stands as `to` in every file of a format.
fn changed(name: &str, from: &str, to: &str) -> Result<Posed, String> {
    let written = WRITTEN.iter().find(|written| written.name == name).unwrap();
    let frames = scene(written.says);
    let mut files = (written.write)(&frames);
    let mut seen = false;
    for bytes in files.values_mut() {
        let text = String::from_utf8(bytes.clone()).unwrap();
        seen |= text.contains(from);
        *bytes = text.replace(from, to).into_bytes();
    }
    assert!(seen, "{name} has no {from}");
    read(written.format, &files, &Listed::of(&frames)).map_err(|why| why.to_string())
}

/// Holds that a format's files in which a text is replaced by another are refused with these words.
fn refuses(cases: &[(&str, &str, &str, &str)]) {
    for (name, from, to, words) in cases {
        let why = changed(name, from, to).unwrap_err();
        assert!(why.contains(words), "{name}: {why}");
    }
}

#[test]
fn what_no_lens_can_say_is_refused_by_its_name() {
    refuses(&[
        ("opensfm", "\"brown\"", "\"dual\"", "the projection \"dual\" is not read"),
        ("opensfm", "\"brown\"", "\"spherical\"", "the projection \"spherical\" is not read"),
        ("transforms", "\"OPENCV\"", "\"EQUIRECTANGULAR\"", "camera_model is \"EQUIRECTANGULAR\""),
        ("transforms", "\"k1\"", "\"k5\":0.5,\"k1\"", "the lens has k5 = 0.5"),
        ("transforms", "\"k1\"", "\"ftheta_p0\":0,\"k1\"", "it has ftheta_p0, and no lens"),
        ("transforms", "\"k1\"", "\"latlong\":true,\"k1\"", "it has latlong, and no lens"),
        ("metashape", "<f>", "<b2>9.5</b2><f>", "b2 = 9.5"),
        ("metashape", "<f>", "<p3>0.5</p3><f>", "p3 = 0.5"),
        ("metashape", "type=\"frame\" class=\"adj", "type=\"spherical\" class=\"adj", "it is \"spherical\""),
        ("realitycapture, xmp", "brown3t2", "division", "DistortionCoeficients 2"),
        ("realitycapture, xmp", "brown3t2", "wavy", "DistortionModel is \"wavy\""),
        ("realitycapture, xmp", "Skew=\"0\"", "Skew=\"0.1\"", "Skew = 0.1"),
        ("alicevision", "\"brown\"", "\"3deradial4\"", "its lens is \"3deradial4\""),
        ("pix4d", "512.5 0 331.25", "512.5 2 331.25", "skew = 2"),
        ("blendedmvs", "512.5 0 331.25", "512.5 2 331.25", "skew = 2"),
        ("micmac", "ModRad", "ModPhgrStd", "its distortion is ModPhgrStd"),
        ("micmac", "<CDist>331.25", "<CDist>335.25", "about CDist, 4.00 pixels from PP"),
        ("micmac", "eConvApero_DistM2C", "eConvApero_DistC2M", "its convention is \"eConvApero_DistC2M\""),
        ("blocks_exchange", "Perspective", "Fisheye", "CameraModelType is \"Fisheye\""),
        ("nvm", "NVM_V3", "NVM_V3_R9T", "the version is \"NVM_V3_R9T\""),
    ]);
}

#[test]
fn what_is_no_pose_is_refused_in_words() {
    refuses(&[
        ("opensfm, rigs", "rig_camera_ids", "rig_ids", "neither a pose nor a rig"),
        (
            "opendronemap",
            "\"width\":640},\"type\"",
            "\"width\":641},\"type\"",
            "no camera of cameras.json is of 641 x 480",
        ),
        ("metashape", "<scale>22.5", "<scale>-1", "the scale is -1"),
        ("bundler", "lost.jpg", "", "5 cameras, and list.txt names 4"),
        ("tanks_and_temples", "2 0 0 1", "0 0 0 1", "its determinant is 0"),
        (
            "blocks_exchange",
            "<Block>",
            "<SRS><Id>1</Id><Definition>EPSG:4326</Definition></SRS><Block><SRSId>1</SRSId>",
            "its coordinates are of SRS \"1\" (EPSG:4326), in degrees",
        ),
        (
            "alicevision",
            "[\"1\",\"2\",\"6\"]",
            "[\"2\",\"0\",\"0\"]",
            "it is of version 2.0.0; versions up to 1 are read",
        ),
        ("blocks_exchange", "M_00", "N_00", "export rotation matrices"),
        ("blocks_exchange", "XRightYDown", "XRightYRight", "as XRightYDown is needed"),
    ]);
}

#[test]
fn axes_of_blocks_are_turned_as_they_are_named() {
    // Up and back instead of down and forward: the same as a rotation of the camera about x.
    let posed = changed("blocks_exchange", "XRightYDown", "XRightYUp").unwrap_err();
    assert!(posed.contains("CameraOrientation of its own"), "{posed}");
}

#[test]
fn what_has_no_size_asks_for_the_photographs() {
    for written in WRITTEN.iter().filter(|written| matches!(written.says, Says::Radial | Says::Inward)) {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), &(written.write)(&scene(written.says)));
        let why = look(written.format, folder.path(), &NoPhotographs).unwrap_err().to_string();
        assert!(why.contains("name the folder of the photographs"), "{why}");
    }
}

#[test]
fn a_trajectory_asks_for_its_lens_and_for_its_photographs() {
    let written = WRITTEN.iter().find(|written| written.name == "tanks_and_temples").unwrap();
    let frames = scene(written.says);
    let mut files = (written.write)(&frames);
    let why = read(written.format, &files, &NoPhotographs).unwrap_err().to_string();
    assert!(why.contains("counts the images sorted by name, and 0 are there"), "{why}");
    files.remove("cameras.txt");
    let why = read(written.format, &files, &Listed::of(&frames)).unwrap_err().to_string();
    assert!(why.contains("it holds no lens: put cameras.txt beside it"), "{why}");
}
