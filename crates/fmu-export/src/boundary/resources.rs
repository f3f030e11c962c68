//! The resources' folder from the URI that the host passes (RFC 8089).

use std::path::PathBuf;

/// The folder that a URI such as `file:/a`, `file:///a%20b` or `file://localhost/a` names. Some hosts pass a plain
/// absolute path, which is taken, too. `None` if it is not a local folder, or not in UTF-8.
pub fn folder(uri: &str) -> Option<PathBuf> {
    if uri.contains(char::REPLACEMENT_CHARACTER) {
        return None;
    }
    let path = match scheme(uri) {
        Some(rest) => decode(local_path(rest)?)?,
        None => uri.to_owned(),
    };
    let folder = PathBuf::from(without_slash_before_drive(&path));
    folder.is_absolute().then_some(folder)
}

/// The part after `file:`, which may be in capitals.
fn scheme(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_at_checked(5)?;
    scheme.eq_ignore_ascii_case("file:").then_some(rest)
}

/// The path after the host's name, which must be this machine's.
fn local_path(rest: &str) -> Option<&str> {
    let Some(authority) = rest.strip_prefix("//") else { return Some(rest) };
    let start = authority.find('/')?;
    let (host, path) = authority.split_at(start);
    (host.is_empty() || host.eq_ignore_ascii_case("localhost")).then_some(path)
}

fn decode(text: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        if *first != b'%' {
            bytes.push(*first);
            continue;
        }
        let (digits, tail) = tail.split_at_checked(2)?;
        if !digits.iter().all(u8::is_ascii_hexdigit) {
            return None;
        }
        bytes.push(u8::from_str_radix(std::str::from_utf8(digits).ok()?, 16).ok()?);
        rest = tail;
    }
    String::from_utf8(bytes).ok()
}

/// On Windows, `/C:/folder` without its first slash.
fn without_slash_before_drive(path: &str) -> &str {
    match path.as_bytes() {
        [b'/', drive, b':', ..] if cfg!(windows) && drive.is_ascii_alphabetic() => &path[1..],
        _ => path,
    }
}

#[cfg(test)]
#[cfg(unix)]
mod tests {
    use super::*;

    #[test]
    fn all_ways_to_write_a_local_folder() {
        for uri in [
            "file:/tmp/a%20b/r%C3%A9s",
            "file:///tmp/a%20b/r%c3%a9s",
            "file://localhost/tmp/a%20b/rés",
            "FILE:///tmp/a b/rés",
            "/tmp/a b/rés",
        ] {
            assert_eq!(folder(uri), Some(PathBuf::from("/tmp/a b/rés")), "{uri}");
        }
    }

    #[test]
    fn other_uris_name_no_local_folder() {
        for uri in [
            "",
            "file:",
            "file://",
            "file://server/share",
            "http://a/b",
            "a/b",
            "file:///%4",
            "file:///%zz",
            "file:///%ff",
            "file:///tmp/r\u{fffd}s",
        ] {
            assert_eq!(folder(uri), None, "{uri}");
        }
    }
}
