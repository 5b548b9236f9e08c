//! When, where and how a photograph was taken, as its EXIF tells. Only the first mebibyte of a file is looked at, where cameras put it.

use std::io::{self, Cursor, Read};
use std::path::Path;

use exif::{DateTime, Exif, In, Reader, Tag, Value};

use super::exposure::Exposure;
use crate::base::convert::Cut;
use crate::base::input::Input;
use crate::scene::moment::Moment;

/// The bytes of a file that are looked at.
const MOST: u64 = 1 << 20;

/// When, where and how a photograph was taken.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Taken {
    /// Latitude, north positive, and longitude, east positive, degrees.
    pub place: Option<[f64; 2]>,
    /// The moment. Where the camera does not tell the zone, the receiver's clock does, which runs on UTC.
    pub time: Option<Moment>,
    /// How it was exposed.
    pub exposure: Exposure,
}

/// Reads what a photograph tells; nothing where it tells nothing, or nothing that can be.
///
/// # Errors
/// The system's.
pub(crate) fn taken(path: &Path) -> io::Result<Taken> {
    let mut start = Vec::new();
    Input::open(path)?.take(MOST).read_to_end(&mut start)?;
    // A field that is damaged does not hide the others.
    let read = Reader::new().continue_on_error(true).read_from_container(&mut Cursor::new(start));
    let exif = read.or_else(|error| error.distill_partial_result(|_| ()));
    Ok(exif.map(|exif| told(&exif)).unwrap_or_default())
}

fn told(exif: &Exif) -> Taken {
    let camera = camera_clock(exif);
    let time = camera.filter(|moment| moment.zone.is_some()).or_else(|| receiver_clock(exif)).or(camera);
    Taken { place: place(exif), time, exposure: Exposure::of(exif) }
}

/// The text of a tag.
fn text(exif: &Exif, tag: Tag) -> Option<&[u8]> {
    match &exif.get_field(tag, In::PRIMARY)?.value {
        Value::Ascii(lines) => lines.first().map(Vec::as_slice),
        _ => None,
    }
}

/// The three numbers of a tag.
fn three(exif: &Exif, tag: Tag) -> Option<[f64; 3]> {
    match &exif.get_field(tag, In::PRIMARY)?.value {
        Value::Rational(all) => Some([all.first()?.to_f64(), all.get(1)?.to_f64(), all.get(2)?.to_f64()]),
        _ => None,
    }
}

/// What the camera's clock showed.
fn camera_clock(exif: &Exif) -> Option<Moment> {
    let mut shown = DateTime::from_ascii(text(exif, Tag::DateTimeOriginal)?).ok()?;
    if let Some(offset) = text(exif, Tag::OffsetTimeOriginal).or_else(|| text(exif, Tag::OffsetTime)) {
        // A zone that cannot be read is none.
        let _ = shown.parse_offset(offset);
    }
    let DateTime { year, month, day, hour, minute, second, offset, .. } = shown;
    Moment::new(
        [year.into(), month.into(), day.into()],
        [hour.into(), minute.into(), second.into()],
        offset.map(i32::from),
    )
}

/// What the receiver of satellites showed.
fn receiver_clock(exif: &Exif) -> Option<Moment> {
    let date = std::str::from_utf8(text(exif, Tag::GPSDateStamp)?).ok()?;
    let date: Vec<i64> = date.split(':').map(|part| part.trim().parse().ok()).collect::<Option<_>>()?;
    let time = three(exif, Tag::GPSTimeStamp)?.map(i64::cut);
    Moment::new(date.try_into().ok()?, time, Some(0))
}

/// Where it was taken. Receivers that know nothing write zeros.
fn place(exif: &Exif) -> Option<[f64; 2]> {
    let degrees = |tag: Tag, side: Tag, negative: u8, most: f64| {
        let [degrees, minutes, seconds] = three(exif, tag)?;
        let value = degrees + minutes / 60.0 + seconds / 3600.0;
        let sign = if text(exif, side)?.first()?.eq_ignore_ascii_case(&negative) { -1.0 } else { 1.0 };
        (0.0..=most).contains(&value).then_some(sign * value)
    };
    let latitude = degrees(Tag::GPSLatitude, Tag::GPSLatitudeRef, b'S', 90.0)?;
    let longitude = degrees(Tag::GPSLongitude, Tag::GPSLongitudeRef, b'W', 180.0)?;
    (latitude != 0.0 || longitude != 0.0).then_some([latitude, longitude])
}

#[cfg(test)]
pub(crate) mod tests {
    use std::fs;

    use exif::experimental::Writer;
    use exif::{Field, Rational};

    use super::*;

    /// A tag that holds a value.
    pub(crate) fn field(tag: Tag, value: Value) -> Field {
        Field { tag, ifd_num: In::PRIMARY, value }
    }

    /// A tag that holds a text.
    pub(crate) fn said(tag: Tag, text: &str) -> Field {
        field(tag, Value::Ascii(vec![text.as_bytes().to_vec()]))
    }

    /// A tag that holds three numbers, to a ten-thousandth.
    pub(crate) fn numbers(tag: Tag, three: [f64; 3]) -> Field {
        let part = |v: f64| Rational { num: u32::cut(v * 1e4), denom: 10_000 };
        field(tag, Value::Rational(three.map(part).to_vec()))
    }

    /// Puts these fields into a JPEG file, after its first two bytes.
    pub(crate) fn tell(jpeg: &Path, fields: &[Field]) {
        let (mut writer, mut exif) = (Writer::new(), Cursor::new(Vec::new()));
        fields.iter().for_each(|field| writer.push_field(field));
        writer.write(&mut exif, false).unwrap();
        let exif = exif.into_inner();
        let length = u16::try_from(exif.len() + 8).unwrap().to_be_bytes();
        let whole = fs::read(jpeg).unwrap();
        let parts = [&whole[..2], &[0xff, 0xe1], &length, b"Exif\0\0", &exif, &whole[2..]];
        fs::write(jpeg, parts.concat()).unwrap();
    }

    /// What a photograph with these fields tells.
    fn of(fields: &[Field]) -> Taken {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        crate::codec::images::write_jpeg(&path, &[[9; 3]; 64], 8, 8, 90).unwrap();
        assert_eq!(taken(&path).unwrap(), Taken::default());
        tell(&path, fields);
        let whole = taken(&path).unwrap();
        // However little of it is left, nothing breaks.
        let bytes = fs::read(&path).unwrap();
        for end in 0..bytes.len().min(600) {
            fs::write(&path, &bytes[..end]).unwrap();
            taken(&path).unwrap();
        }
        whole
    }

    #[test]
    fn a_photograph_tells_when_and_where() {
        let time = |zone| Moment::new([2014, 5, 26], [12, 45, 30], zone);
        let camera = said(Tag::DateTimeOriginal, "2014:05:26 12:45:30");
        assert_eq!(of(std::slice::from_ref(&camera)), Taken { time: time(None), ..Taken::default() });
        let zone = said(Tag::OffsetTimeOriginal, "+02:00");
        let date = said(Tag::GPSDateStamp, "2014:05:26");
        let clock = numbers(Tag::GPSTimeStamp, [10.0, 45.0, 31.5]);
        assert_eq!(of(&[camera.clone(), zone, date.clone(), clock.clone()]).time, time(Some(120)));
        let receiver = Moment::new([2014, 5, 26], [10, 45, 31], Some(0));
        assert_eq!(of(&[camera, date, clock]).time, receiver);
        let south = [
            numbers(Tag::GPSLatitude, [33.0, 30.0, 36.0]),
            said(Tag::GPSLatitudeRef, "S"),
            numbers(Tag::GPSLongitude, [18.25, 0.0, 0.0]),
            said(Tag::GPSLongitudeRef, "E"),
        ];
        let [latitude, longitude] = of(&south).place.unwrap();
        assert!((latitude + 33.51).abs() < 1e-9 && (longitude - 18.25).abs() < 1e-9, "{latitude} {longitude}");
    }

    #[test]
    fn a_time_that_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        for zone in [None, Some(-210)] {
            let time = Moment::new([2024, 6, 21], [9, 0, 4], zone);
            crate::codec::images::write_jpeg_taken(&path, &[[9; 3]; 64], [8, 8], 90, time).unwrap();
            assert_eq!(taken(&path).unwrap(), Taken { time, ..Taken::default() });
        }
    }

    #[test]
    fn a_photograph_tells_how_it_was_exposed() {
        let ratio = |num, denom| Value::Rational(vec![Rational { num, denom }]);
        let all = |iso: u16| {
            let iso = field(Tag::PhotographicSensitivity, Value::Short(vec![iso]));
            of(&[field(Tag::ExposureTime, ratio(1, 800)), field(Tag::FNumber, ratio(28, 10)), iso]).exposure
        };
        assert_eq!((all(100).to_string().as_str(), all(100) == all(200)), ("1/800 s, f/2.8, ISO 100", false));
        let odd = of(&[field(Tag::ExposureTime, ratio(1, 0)), field(Tag::FNumber, ratio(0, 10))]).exposure;
        assert!(odd == Exposure::default() && !odd.is_told() && all(100).is_told());
    }

    #[test]
    fn what_cannot_be_is_not_told() {
        let at = |latitude: f64| {
            let zeros = numbers(Tag::GPSLongitude, [0.0; 3]);
            let latitude = numbers(Tag::GPSLatitude, [latitude, 0.0, 0.0]);
            of(&[latitude, said(Tag::GPSLatitudeRef, "N"), zeros, said(Tag::GPSLongitudeRef, "E")]).place
        };
        assert_eq!((at(0.0), at(91.0), at(52.0)), (None, None, Some([52.0, 0.0])));
        for text in ["0000:00:00 00:00:00", "2014:13:26 12:45:30", "    :  :     :  :  ", "yesterday"] {
            assert_eq!(of(&[said(Tag::DateTimeOriginal, text)]).time, None, "{text}");
        }
    }
}
