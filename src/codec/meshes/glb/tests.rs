use super::*;

/// A fan of `n` triangles about a UTM corner, and `n` materials that differ.
fn fan(n: usize) -> (Mesh, Vec<[f32; Material::LEN]>) {
    let centre = DVec3::new(500_000.0, 5_800_000.0, 80.0);
    let rim = (0..=n).map(|i| centre + DVec3::new((i as f64 * 0.01).cos(), (i as f64 * 0.01).sin(), 0.0));
    let vertices: Vec<DVec3> = [centre].into_iter().chain(rim).collect();
    let triangles = (0..n as u32).map(|i| [0, i + 1, i + 2]).collect();
    let rows = (0..n).map(|i| {
        let v = i as f32 / n as f32;
        [v, 0.5, 1.0 - v, 0.5 * v, 0.25 * v, 0.0, v]
    });
    (Mesh::new(&vertices, triangles).unwrap(), rows.collect())
}

fn number(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()) as usize
}

/// The document and the binary chunk of a file.
fn written(mesh: &Mesh, rows: &[[f32; Material::LEN]], up: DVec3) -> (Value, Vec<u8>) {
    let mut bytes = Vec::new();
    let place = Georeference { crs: "UTM 33N".parse().ok(), offset: [0.5, 0.0, 1.0] };
    write(&mut bytes, Path::new("scene.glb"), mesh, rows, up, Some(&place)).unwrap();
    assert_eq!((&bytes[..4], number(&bytes, 4), number(&bytes, 8)), (&b"glTF"[..], 2, bytes.len()));
    let json = number(&bytes, 12);
    assert_eq!((&bytes[16..20], json % 4), (&b"JSON"[..], 0));
    let binary = &bytes[20 + json..];
    assert_eq!((number(binary, 0), &binary[4..8]), (binary.len() - 8, &b"BIN\0"[..]));
    (serde_json::from_slice(&bytes[20..20 + json]).unwrap(), binary[8..].to_vec())
}

fn view<'a>(document: &Value, binary: &'a [u8], index: usize) -> &'a [u8] {
    let view = &document["bufferViews"][index];
    let at = |key: &str| view[key].as_u64().unwrap() as usize;
    &binary[at("byteOffset")..at("byteOffset") + at("byteLength")]
}

fn floats(bytes: &[u8]) -> Vec<f32> {
    bytes.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect()
}

#[test]
fn every_corner_points_at_its_triangles_material() {
    let (mesh, rows) = fan(70);
    let (document, binary) = written(&mesh, &rows, DVec3::Z);
    let uv = floats(view(&document, &binary, 1));
    let images: Vec<_> =
        (2..5).map(|i| image::load_from_memory(view(&document, &binary, i)).unwrap().to_rgba8()).collect();
    assert_eq!(images[0].dimensions(), (16, 8));
    for (corner, uv) in uv.chunks_exact(2).enumerate() {
        let row = rows[corner / 3];
        let texel = |i: usize| {
            let image: &image::RgbaImage = &images[i];
            image.get_pixel((uv[0] * image.width() as f32) as u32, (uv[1] * image.height() as f32) as u32).0
        };
        let near = |byte: u8, value: f32| (f32::from(byte) / 255.0 - value).abs() <= 0.5001 / 255.0;
        assert_eq!(texel(0)[0], to_srgb(row[0]));
        assert!(near(texel(1)[1], row[6]) && texel(1)[2] == 0, "corner {corner}");
        assert!(near(texel(2)[3], row[3]), "corner {corner}");
        // ks.g is half of ks.r, which is the largest.
        let color = if row[3] > 0.0 { [255, to_srgb(0.5), 0] } else { [255; 3] };
        assert_eq!(texel(2)[..3], color, "corner {corner}");
    }
}

fn to_srgb(v: f32) -> u8 {
    crate::codec::images::to_srgb8(v)
}

#[test]
fn positions_are_about_the_origin_and_bounded() {
    let (mesh, rows) = fan(5);
    let (document, binary) = written(&mesh, &rows, DVec3::Z);
    let positions = floats(view(&document, &binary, 0));
    let expected: Vec<f32> = (0..5).flat_map(|t| mesh.corners(TriangleId(t))).flat_map(|p| p.to_array()).collect();
    assert_eq!(positions, expected);
    let accessor = &document["accessors"][0];
    for (axis, bound) in [(0, "min"), (1, "min"), (2, "max"), (0, "max")] {
        let along = positions.iter().skip(axis).step_by(3).copied();
        let exact = if bound == "min" { along.fold(f32::MAX, f32::min) } else { along.fold(f32::MIN, f32::max) };
        assert_eq!(accessor[bound][axis].as_f64().unwrap() as f32, exact, "{bound} {axis}");
    }
    let extras = &document["asset"]["extras"];
    assert_eq!(extras["origin"][1].as_f64(), Some(mesh.origin.y));
    assert_eq!((&extras["crs"], &extras["offset"]), (&json!("EPSG:32633"), &json!([0.5, 0.0, 1.0])));
}

#[test]
fn up_becomes_y() {
    let (mesh, rows) = fan(1);
    for up in [DVec3::Z, DVec3::NEG_Y, DVec3::new(3.0, -4.0, 5.0), DVec3::Y * 1e-3] {
        let (document, _) = written(&mesh, &rows, up);
        let turn: Vec<f64> = serde_json::from_value(document["nodes"][0]["rotation"].clone()).unwrap();
        let turned = DQuat::from_slice(&turn) * up.normalize();
        assert!(turned.distance(DVec3::Y) < 1e-9, "{up}: {turned}");
    }
}

#[test]
fn the_unknown_is_grey_and_matte() {
    let (mesh, _) = fan(1);
    let (document, binary) = written(&mesh, &[[f32::NAN; 7]], DVec3::Z);
    let texel = |i| image::load_from_memory(view(&document, &binary, i)).unwrap().to_rgba8().get_pixel(0, 0).0;
    assert_eq!((texel(2)[0], texel(3)[1], texel(4)[3]), (128, 255, 0));
}

#[test]
fn layouts_hold_all_triangles_and_no_more_than_twice() {
    for n in [1, 2, 3, 4, 5, 1000, 50_000, 268_435_456] {
        let texels = Texels::new(n).unwrap();
        let [u, v] = texels.centre(TriangleId(n as u32 - 1));
        assert!(u < 1.0 && v < 1.0 && u > 0.0 && v > 0.0, "{n}: {u} {v}");
    }
    assert!(Texels::new(268_435_457).is_none());
}

#[test]
fn what_is_longer_than_its_length_field_is_no_file() {
    assert!(Container::new([u64::from(u32::MAX)].into_iter(), |_| json!({})).is_none());
}
