//! Bytes of an XML file to text.

use std::borrow::Cow;

/// How the bytes of a file are to be read.
enum Encoding {
    Utf8,
    /// In Latin-1 every byte is the code point of its character.
    Latin,
    Little,
    Big,
}

impl Encoding {
    /// As a byte-order mark, the zero byte of the first `<` or the XML declaration says.
    fn of(bytes: &[u8]) -> Self {
        match bytes {
            [0xff, 0xfe, ..] | [b'<', 0, ..] => Self::Little,
            [0xfe, 0xff, ..] | [0, b'<', ..] => Self::Big,
            _ if declared(bytes, &["iso-8859-1", "latin1", "windows-1252"]) => Self::Latin,
            _ => Self::Utf8,
        }
    }
}

/// The text of the bytes: UTF-8 unless a byte-order mark, the XML declaration or the bytes
/// themselves say that it is UTF-16 or Latin-1.
pub fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let latin = || Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect());
    match Encoding::of(bytes) {
        Encoding::Little => Cow::Owned(utf16(bytes, u16::from_le_bytes)),
        Encoding::Big => Cow::Owned(utf16(bytes, u16::from_be_bytes)),
        Encoding::Latin => latin(),
        Encoding::Utf8 => {
            let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
            std::str::from_utf8(bytes).map_or_else(|_| latin(), Cow::Borrowed)
        }
    }
}

fn utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.as_chunks::<2>().0.iter().map(|pair| unit(*pair));
    let text = char::decode_utf16(units).map(|c| c.unwrap_or('\u{fffd}'));
    // The byte-order mark is no part of the text.
    text.skip_while(|c| *c == '\u{feff}').collect()
}

/// Whether the XML declaration names one of these encodings.
fn declared(bytes: &[u8], names: &[&str]) -> bool {
    let declaration = String::from_utf8_lossy(&bytes[..bytes.len().min(200)]).to_lowercase();
    let declaration = declaration.split("?>").next().unwrap_or_default();
    names.iter().any(|name| declaration.contains(name))
}

/// The line in which bytes stop to be the encoding that they are declared to be, and what is wrong there.
pub fn misread(bytes: &[u8]) -> Option<(usize, &'static str)> {
    const UTF16: &str = "the bytes are UTF-16, but the file is declared as UTF-8: save it as UTF-8";
    const OTHER: &str = "not UTF-8, as which the file is declared: save it as UTF-8";
    match Encoding::of(bytes) {
        Encoding::Latin => None,
        Encoding::Little | Encoding::Big => {
            let text = decode(bytes);
            let is = |names: &[&str]| declared(text.as_bytes(), names);
            (is(&["encoding"]) && !is(&["utf-16"])).then_some((1, UTF16))
        }
        Encoding::Utf8 => {
            let sound = std::str::from_utf8(bytes).err()?.valid_up_to();
            let ends = bytes[..sound].iter().filter(|byte| **byte == b'\n').count();
            Some((ends + 1, OTHER))
        }
    }
}
