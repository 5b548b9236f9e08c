use glam::{DMat3, DVec3};

use super::{Files, brown, file, rows, rows_to_world, spaced};
use crate::scene::frame::Frame;

/// With a component of its own scale, groups, a disabled camera, one that is not aligned, and a calibration from before.
pub(super) fn metashape(frames: &[Frame]) -> Files {
    let (turn, scale, shift) =
        (DMat3::from_rotation_x(0.7) * DMat3::from_rotation_z(-0.4), 22.5, DVec3::new(4000.0, -300.0, 70.0));
    let camera = |(at, frame): (usize, &Frame)| {
        // Within the component: turn and shift undone.
        let to_world = DMat3::from_cols_array_2d(&rows_to_world(frame)).transpose();
        let (within, eye) = (turn.transpose() * to_world, turn.transpose() * (frame.pose.centre() - shift) / scale);
        let m = within.transpose().to_cols_array_2d();
        let rows = [
            [m[0][0], m[0][1], m[0][2], eye.x],
            [m[1][0], m[1][1], m[1][2], eye.y],
            [m[2][0], m[2][1], m[2][2], eye.z],
            [0.0, 0.0, 0.0, 1.0],
        ];
        let label = frame.name.trim_end_matches(".jpg");
        format!(
            "<camera id=\"{at}\" sensor_id=\"0\" component_id=\"0\" label=\"{label}\"><transform>{}</transform>\
             <orientation>6</orientation></camera>",
            spaced(rows.as_flattened())
        )
    };
    let lens = &frames[0].camera;
    let ([k1, k2, k3, p1, p2], focal, centre) = (brown(lens), lens.lens.focal(), lens.lens.centre());
    let cameras: Vec<String> = frames.iter().enumerate().map(camera).collect();
    let (first, others) = cameras.split_first().unwrap();
    let others = others.join("\n");
    let rotation = spaced(turn.transpose().to_cols_array_2d().as_flattened());
    let off = first.replacen("<camera ", "<camera enabled=\"false\" ", 1).replace("00000003", "off");
    let text = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<document version=\"2.0.0\"><chunk label=\"Chunk 1\" enabled=\"true\">\
         <sensors next_id=\"1\"><sensor id=\"0\" label=\"cam\" type=\"frame\"><resolution width=\"640\" height=\"480\"/>\
         <property name=\"layer_index\" value=\"0\"/>\
         <calibration type=\"frame\" class=\"initial\"><resolution width=\"640\" height=\"480\"/><f>1</f></calibration>\
         <calibration type=\"frame\" class=\"adjusted\"><resolution width=\"640\" height=\"480\"/>\
         <f>{}</f><b1>{}</b1><cx>{}</cx><cy>{}</cy><k1>{k1}</k1><k2>{k2}</k2><k3>{k3}</k3><p1>{p2}</p1><p2>{p1}</p2>\
         </calibration></sensor></sensors>\
         <components><component id=\"0\"><transform><rotation>{rotation}</rotation><translation>{}</translation>\
         <scale>{scale}</scale></transform></component></components>\
         <cameras>{first}<group id=\"0\" label=\"g\">{others}</group>{off}\
         <camera id=\"90\" sensor_id=\"0\" label=\"lost\"/></cameras></chunk></document>",
        focal.y,
        focal.x - focal.y,
        centre.x - 320.0,
        centre.y - 240.0,
        spaced(&shift.to_array()),
    );
    file("cameras.xml", text)
}

pub(super) fn realitycapture(frames: &[Frame]) -> Files {
    let mut files = Files::new();
    for frame in frames {
        let ([k1, k2, k3, t1, t2], lens) = (brown(&frame.camera), &frame.camera.lens);
        let (focal, centre) = (lens.focal().x * 36.0 / 640.0, (lens.centre() - glam::DVec2::new(320.0, 240.0)) / 640.0);
        let text = format!(
            "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
             <rdf:Description xcr:Version=\"3\" xcr:PosePrior=\"exact\" xcr:Coordinates=\"relative\" \
             xcr:DistortionModel=\"brown3t2\" xcr:FocalLength35mm=\"{focal}\" xcr:Skew=\"0\" xcr:AspectRatio=\"1\" \
             xcr:PrincipalPointU=\"{}\" xcr:PrincipalPointV=\"{}\" \
             xmlns:xcr=\"http://www.capturingreality.com/ns/xcr/1.1#\">\
             <xcr:Rotation>{}</xcr:Rotation><xcr:Position>{}</xcr:Position>\
             <xcr:DistortionCoeficients>{k1} {k2} {k3} 0 {t1} {t2}</xcr:DistortionCoeficients>\
             </rdf:Description></rdf:RDF></x:xmpmeta>",
            centre.x,
            centre.y,
            spaced(rows(frame).as_flattened()),
            spaced(&frame.pose.centre().to_array()),
        );
        files.extend(file(&frame.name.replace(".jpg", ".xmp"), text));
    }
    files
}

pub(super) fn micmac(frames: &[Frame]) -> Files {
    let camera = &frames[0].camera;
    let ([k1, k2, k3, ..], f, point) = (brown(camera), camera.lens.focal().x, camera.lens.centre());
    let point = format!("{} {}", point.x, point.y);
    let text = format!(
        "<?xml version=\"1.0\" ?><ExportAPERO><CalibrationInternConique><KnownConv>eConvApero_DistM2C</KnownConv>\
         <PP>{point}</PP><F>{f}</F><SzIm>640 480</SzIm><CalibDistortion><ModRad><CDist>{point}</CDist>\
         <CoeffDist>{}</CoeffDist><CoeffDist>{}</CoeffDist><CoeffDist>{}</CoeffDist></ModRad></CalibDistortion>\
         </CalibrationInternConique></ExportAPERO>",
        k1 / f.powi(2),
        k2 / f.powi(4),
        k3 / f.powi(6),
    );
    let mut files = file("AutoCal_Foc-28000_Cam-X.xml", text);
    for frame in frames {
        let [l1, l2, l3] = rows_to_world(frame);
        let text = format!(
            "<?xml version=\"1.0\" ?><ExportAPERO><OrientationConique><OrIntImaM2C><I00>0 0</I00><V10>1 0</V10>\
             <V01>0 1</V01></OrIntImaM2C><TypeProj>eProjStenope</TypeProj>\
             <FileInterne>Ori-All/AutoCal_Foc-28000_Cam-X.xml</FileInterne><Externe>\
             <KnownConv>eConvApero_DistM2C</KnownConv><Centre>{}</Centre><ParamRotation><CodageMatr><L1>{}</L1>\
             <L2>{}</L2><L3>{}</L3></CodageMatr></ParamRotation></Externe></OrientationConique></ExportAPERO>",
            spaced(&frame.pose.centre().to_array()),
            spaced(&l1),
            spaced(&l2),
            spaced(&l3),
        );
        files.extend(file(&format!("Orientation-{}.xml", frame.name), text));
    }
    files
}

pub(super) fn blocks_exchange(frames: &[Frame]) -> Files {
    let camera = &frames[0].camera;
    let ([k1, k2, k3, p1, p2], focal, centre) = (brown(camera), camera.lens.focal(), camera.lens.centre());
    let photo = |(at, frame): (usize, &Frame)| {
        let (rows, eye) = (rows(frame), frame.pose.centre());
        let element = |(at, value): (usize, &f64)| format!("<M_{r}{c}>{value}</M_{r}{c}>", r = at / 3, c = at % 3);
        let matrix: String = rows.as_flattened().iter().enumerate().map(element).collect();
        format!(
            "<Photo><Id>{at}</Id><ImagePath>D:/flight/{}</ImagePath><Pose><Rotation>{matrix}</Rotation><Center><x>{}</x>\
             <y>{}</y><z>{}</z></Center></Pose></Photo>",
            frame.name, eye.x, eye.y, eye.z
        )
    };
    let photos: String = frames.iter().enumerate().map(photo).collect();
    let text = format!(
        "<?xml version=\"1.0\" encoding=\"utf-8\"?><BlocksExchange version=\"2.1\"><Block><Photogroups><Photogroup>\
         <ImageDimensions><Width>640</Width><Height>480</Height></ImageDimensions>\
         <CameraModelType>Perspective</CameraModelType><FocalLength>{}</FocalLength><SensorSize>6.4</SensorSize>\
         <CameraOrientation>XRightYDown</CameraOrientation><PrincipalPoint><x>{}</x><y>{}</y></PrincipalPoint>\
         <Distortion><K1>{k1}</K1><K2>{k2}</K2><K3>{k3}</K3><P1>{p2}</P1><P2>{p1}</P2></Distortion>{photos}\
         <Photo><Id>77</Id><ImagePath>D:/flight/lost.jpg</ImagePath></Photo></Photogroup></Photogroups></Block>\
         </BlocksExchange>",
        focal.x * 6.4 / 640.0,
        centre.x,
        centre.y,
    );
    file("blocks.xml", text)
}
