//! Protocol Buffers on the wire: a message is a row of fields, each a number and a value.
//!
//! Layout (protobuf.dev, "Encoding"): a field starts with a varint, `number << 3 | type`. Type 0 is a varint; 1 is 8 bytes; 2 is
//! a varint `n` and `n` bytes (a text, a message, a packed list); 5 is 4 bytes. A varint holds 7 bits a byte, the lowest
//! first, and the top bit of each byte but the last is set.
//!
//! A length is a claim. It is held against the bytes that are there, and nothing is allocated.

/// The value of a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Value<'a> {
    /// A varint.
    Number(u64),
    /// A text, a message or a packed list.
    Bytes(&'a [u8]),
    /// 4 or 8 bytes.
    Fixed(&'a [u8]),
}

/// One field of a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Field<'a> {
    /// The field's number in its message.
    pub(super) number: u64,
    /// The field's value.
    pub(super) value: Value<'a>,
    /// The field's bytes, number and type included.
    pub(super) raw: &'a [u8],
}

impl<'a> Field<'a> {
    /// The message or the packed list that the field holds.
    pub(super) fn bytes(&self) -> Result<&'a [u8], Fault> {
        match self.value {
            Value::Bytes(bytes) => Ok(bytes),
            _ => Err("a field has the wrong type"),
        }
    }

    /// The text that the field holds.
    pub(super) fn text(&self) -> Result<&'a str, Fault> {
        std::str::from_utf8(self.bytes()?).map_err(|_| "a text is not UTF-8")
    }

    /// The number that the field holds.
    pub(super) fn number(&self) -> Result<u64, Fault> {
        match self.value {
            Value::Number(number) => Ok(number),
            _ => Err("a field has the wrong type"),
        }
    }
}

/// The reason why bytes are no message.
pub(super) type Fault = &'static str;

const CUT_SHORT: Fault = "a field is cut short";

/// The largest field number.
const MOST_FIELDS: u64 = (1 << 29) - 1;

/// The fields of a message, in the order of the file. After a fault there are no more.
pub(super) fn fields(message: &[u8]) -> impl Iterator<Item = Result<Field<'_>, Fault>> {
    let mut rest = message;
    std::iter::from_fn(move || {
        let found = (!rest.is_empty()).then(|| field(&mut rest))?;
        if found.is_err() {
            rest = &[];
        }
        Some(found)
    })
}

fn field<'a>(rest: &mut &'a [u8]) -> Result<Field<'a>, Fault> {
    let whole = *rest;
    let tag = varint(rest)?;
    let value = match tag & 7 {
        0 => Value::Number(varint(rest)?),
        1 => Value::Fixed(take(rest, 8)?),
        2 => {
            let length = varint(rest)?;
            Value::Bytes(take(rest, length)?)
        }
        5 => Value::Fixed(take(rest, 4)?),
        _ => return Err("a field has a type that is not in use"),
    };
    match tag >> 3 {
        number @ 1..=MOST_FIELDS => Ok(Field { number, value, raw: &whole[..whole.len() - rest.len()] }),
        _ => Err("a field has a number that is not in use"),
    }
}

fn take<'a>(rest: &mut &'a [u8], length: u64) -> Result<&'a [u8], Fault> {
    let length = usize::try_from(length).map_err(|_| CUT_SHORT)?;
    let (taken, after) = rest.split_at_checked(length).ok_or(CUT_SHORT)?;
    *rest = after;
    Ok(taken)
}

fn varint(rest: &mut &[u8]) -> Result<u64, Fault> {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (&byte, after) = rest.split_first().ok_or(CUT_SHORT)?;
        *rest = after;
        let bits = u64::from(byte & 0x7f);
        if shift == 63 && bits > 1 {
            break;
        }
        value |= bits << shift;
        if byte < 0x80 {
            return Ok(value);
        }
    }
    Err("a number has more than 64 bits")
}

/// The message in field `number`, which may be there once: parsers differ on which of two counts.
pub(super) fn only(message: &[u8], number: u64) -> Result<Option<&[u8]>, Fault> {
    let mut found = None;
    for field in fields(message) {
        let field = field?;
        if field.number == number && found.replace(field.bytes()?).is_some() {
            return Err("a field that may be there once is there twice");
        }
    }
    Ok(found)
}

/// The last text in field `number`, or an empty one.
pub(super) fn text_in(message: &[u8], number: u64) -> Result<&str, Fault> {
    fields(message).try_fold("", |last, field| {
        let field = field?;
        if field.number == number { field.text() } else { Ok(last) }
    })
}

/// The last number in field `number`, or 0.
pub(super) fn number_in(message: &[u8], number: u64) -> Result<u64, Fault> {
    fields(message).try_fold(0, |last, field| {
        let field = field?;
        if field.number == number { field.number() } else { Ok(last) }
    })
}

/// Appends a field that holds a text or a message.
pub(super) fn hold(out: &mut Vec<u8>, number: u64, bytes: &[u8]) {
    write_varint(out, number << 3 | 2);
    write_varint(out, bytes.len() as u64);
    out.extend(bytes);
}

/// Appends a field that holds a number.
pub(super) fn count(out: &mut Vec<u8>, number: u64, value: u64) {
    write_varint(out, number << 3);
    write_varint(out, value);
}

fn write_varint(out: &mut Vec<u8>, mut value: u64) {
    while value >= 0x80 {
        out.push(value.to_le_bytes()[0] | 0x80);
        value >>= 7;
    }
    out.push(value.to_le_bytes()[0]);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all(message: &[u8]) -> Result<Vec<(u64, Value<'_>)>, Fault> {
        fields(message).map(|f| f.map(|f| (f.number, f.value))).collect()
    }

    #[test]
    fn fields_are_read_as_they_were_written() {
        assert_eq!(all(&[]), Ok(vec![]));
        assert_eq!(all(&[0x08, 0x96, 0x01]), Ok(vec![(1, Value::Number(150))]));
        let message = [&[0x12, 2, b'h', b'i'][..], &[0x1d, 1, 2, 3, 4], &[0x21, 1, 2, 3, 4, 5, 6, 7, 8]].concat();
        assert_eq!(
            all(&message),
            Ok(vec![
                (2, Value::Bytes(b"hi")),
                (3, Value::Fixed(&[1, 2, 3, 4])),
                (4, Value::Fixed(&[1, 2, 3, 4, 5, 6, 7, 8]))
            ])
        );
        let largest = [&[0x08][..], &[0xff; 9], &[0x01]].concat();
        assert_eq!(all(&largest), Ok(vec![(1, Value::Number(u64::MAX))]));
    }

    #[test]
    fn what_is_written_is_read() {
        let mut message = Vec::new();
        hold(&mut message, 1, b"text");
        count(&mut message, 400, u64::MAX);
        assert_eq!(all(&message), Ok(vec![(1, Value::Bytes(b"text")), (400, Value::Number(u64::MAX))]));
        assert_eq!(
            (text_in(&message, 1), number_in(&message, 400), number_in(&message, 2)),
            (Ok("text"), Ok(u64::MAX), Ok(0))
        );
        let again: Vec<u8> = fields(&message).flat_map(|f| f.unwrap().raw).copied().collect();
        assert_eq!(again, message);
        assert!(only(&message.repeat(2), 1).is_err());
    }

    #[test]
    fn what_is_no_message_is_refused() {
        let long = [&[0x08][..], &[0xff; 9], &[0x02]].concat();
        let longer = [&[0x08][..], &[0x80; 10], &[0x00]].concat();
        // A claim of 2^63 - 1 bytes.
        let huge = [&[0x12][..], &[0xff; 8], &[0x7f]].concat();
        for message in [
            &[0x12, 3, b'h', b'i'][..],
            &[0x08],
            &[0x08, 0x80],
            &[0x1d, 1, 2, 3],
            &[0x21, 1, 2, 3, 4],
            &[0x00, 0x00],
            &[0x0b],
            &[0x0c],
            &[0x0e],
            &[0x0f],
            &[0xff; 64],
            &long,
            &longer,
            &huge,
        ] {
            assert!(all(message).is_err(), "{message:?}");
            assert!(fields(message).count() <= message.len());
        }
    }

    #[test]
    fn a_value_of_another_type_is_refused() {
        let field = |value| Field { number: 1, value, raw: &[] };
        assert!(field(Value::Number(1)).bytes().is_err());
        assert!(field(Value::Fixed(&[0; 4])).number().is_err());
        assert!(field(Value::Bytes(b"\xff")).text().is_err());
        assert_eq!(field(Value::Bytes(b"a")).text(), Ok("a"));
    }
}
