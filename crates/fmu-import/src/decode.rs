//! Bytes of an XML file to text.

use std::borrow::Cow;

/// The text of the bytes: UTF-8 unless a byte-order mark, the XML declaration or the bytes
/// themselves say that it is UTF-16 or Latin-1.
pub(crate) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let utf16 = |decode: fn([u8; 2]) -> u16| {
        let units = bytes[2..]
            .chunks_exact(2)
            .map(|pair| decode([pair[0], pair[1]]));
        Cow::Owned(
            char::decode_utf16(units)
                .map(|c| c.unwrap_or('\u{fffd}'))
                .collect(),
        )
    };
    match bytes {
        [0xff, 0xfe, ..] => return utf16(u16::from_le_bytes),
        [0xfe, 0xff, ..] => return utf16(u16::from_be_bytes),
        _ => {}
    }
    let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    match std::str::from_utf8(bytes) {
        Ok(text) if !declared_latin(bytes) => Cow::Borrowed(text),
        // In Latin-1 every byte is the code point of its character.
        _ => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
    }
}

fn declared_latin(bytes: &[u8]) -> bool {
    let declaration = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).to_lowercase();
    ["iso-8859-1", "latin1", "windows-1252"]
        .iter()
        .any(|name| declaration.contains(name))
}

/// The line in which bytes stop to be the UTF-8 that they are declared to be.
pub(crate) fn misread(bytes: &[u8]) -> Option<usize> {
    if matches!(bytes, [0xff, 0xfe, ..] | [0xfe, 0xff, ..]) || declared_latin(bytes) {
        return None;
    }
    let sound = std::str::from_utf8(bytes).err()?.valid_up_to();
    let ends = bytes[..sound].iter().filter(|byte| **byte == b'\n').count();
    Some(ends + 1)
}
