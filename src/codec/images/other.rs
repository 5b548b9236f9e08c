//! Files that stand where pictures are expected, and are none that is read: what they are, and what to do.

/// What a file is that begins so, in words.
pub(super) fn told(start: &[u8]) -> String {
    const READ: &str = "JPEG, PNG, TIFF, EXR or HDR";
    if start.is_empty() {
        return "it is empty".to_owned();
    }
    if start.starts_with(b"version https://git-lfs") {
        return "it is a pointer of Git LFS, not the file itself: fetch it with git lfs pull".to_owned();
    }
    let text = start.trim_ascii_start().to_ascii_lowercase();
    if text.starts_with(b"<!doctype html") || text.starts_with(b"<html") {
        return "it is a web page, not a picture: download it once more".to_owned();
    }
    match kind(start) {
        Some(kind) => format!("it is {kind}, which is not read: save it as {READ}"),
        None => format!("no image that gonio reads: {READ}"),
    }
}

/// The name of a format of pictures.
fn kind(start: &[u8]) -> Option<&'static str> {
    // The brand of a file of ISO base media (ISO/IEC 14496-12).
    if start.get(4..8) == Some(b"ftyp") {
        return match start.get(8..12)? {
            b"avif" | b"avis" => Some("AVIF"),
            b"crx " => Some("a raw file of Canon (CR3)"),
            b"heic" | b"heix" | b"hevc" | b"mif1" | b"msf1" => Some("HEIC"),
            _ => None,
        };
    }
    let starts: [(&[u8], &str); 10] = [
        (b"RIFF", "WebP"),
        (b"GIF8", "GIF"),
        (b"BM", "BMP"),
        (b"8BPS", "a Photoshop document"),
        (b"%PDF", "PDF"),
        (b"\0\0\0\x0cjP  ", "JPEG 2000"),
        (b"\xff\x4f\xff\x51", "JPEG 2000"),
        (b"\0\0\0\x0cJXL ", "JPEG XL"),
        (b"\xff\x0a", "JPEG XL"),
        (b"FUJIFILM", "a raw file of Fujifilm"),
    ];
    starts.into_iter().find(|(known, _)| start.starts_with(known)).map(|(_, name)| name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_picture_is_told_by_its_name() {
        for (start, words) in [
            (&b""[..], "it is empty"),
            (b"\0\0\0\x18ftypheic\0\0\0\0", "it is HEIC, which is not read: save it as JPEG, PNG"),
            (b"\0\0\0\x18ftypavif", "it is AVIF"),
            (b"RIFF\x10\0\0\0WEBPVP8 ", "it is WebP"),
            (b"GIF89a", "it is GIF"),
            (b"version https://git-lfs.github.com/spec/v1", "fetch it with git lfs pull"),
            (b"\n<!DOCTYPE html>", "a web page"),
            (b"hello", "no image that gonio reads: JPEG, PNG, TIFF, EXR or HDR"),
            (b"\0\0\0\x18ftyp", "no image that gonio reads"),
        ] {
            assert!(told(start).contains(words), "{start:?}: {}", told(start));
        }
    }
}
