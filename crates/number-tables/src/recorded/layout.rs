//! Where the numbers stand in the text of a recording: preambles, separators, the rows of names and of units.

use std::io::Read;
use std::path::Path;

use super::Layout;
use super::stamp::stamp;
use crate::csv_file::number;
use crate::files::{self, FileError};
use fmu_import::units::known;

/// The longest recording that is read, MiB.
const MOST: u64 = 4096;
/// Lines among which the first numbers are looked for.
const SAMPLE: usize = 2000;
const SEPARATORS: [u8; 4] = *b"\t;, ";
/// What Windows has where Latin-1 has control characters.
const WINDOWS: &str = "€\u{81}‚ƒ„…†‡ˆ‰Š‹Œ\u{8d}Ž\u{8f}\u{90}‘’“”•–—˜™š›œ\u{9d}žŸ";
/// How files of other formats begin; a zip archive is one by its ending.
const BINARY: [(&[u8], &str); 8] = [
    (b"MDF ", "mf4"),
    (b"UnFinMF", "mf4"),
    (b"TDSm", "tdms"),
    (b"\x89HDF", "h5"),
    (b"MATLAB 5", "mat"),
    (b"PAR1", "parquet"),
    (b"PK\x03\x04", "xlsx"),
    (b"\xd0\xcf\x11\xe0", "xls"),
];

/// Endings of further binary files that the Python package converts.
const CONVERTED: [&str; 5] = ["mat", "dat", "mdf", "mf4", "hdf"];

/// How a file of a known binary format becomes one that is read here.
pub(super) fn advice(path: &Path) -> Option<FileError> {
    let mut begin = [0; 8];
    files::open(path).ok()?.read_exact(&mut begin).ok()?;
    let is_known = BINARY.iter().any(|(known, _)| begin.starts_with(known));
    is_known.then(|| text(path).err()).flatten()
}

/// Reads a recording as text: UTF-8, UTF-16, or what Windows writes in Western Europe.
pub(super) fn text(path: &Path) -> Result<String, FileError> {
    let wrong = |message: String| FileError::new(path, message);
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let bytes = files::open(path).and_then(|file| match file.metadata()?.len() > MOST << 20 {
        true => Err(std::io::Error::other(format!("larger than {MOST} MiB; divide it"))),
        false => std::fs::read(path),
    });
    let bytes = bytes.map_err(|error| FileError::read(path, error))?;
    let convert = |kind: &str| {
        let file = path.display();
        wrong(format!(
            "no text, but {kind}: convert it with `python -m fmu_orchestrator convert {file}`, and give the csv files"
        ))
    };
    let begins = |(begin, _): &&(&[u8], &str)| bytes.starts_with(begin);
    match BINARY.iter().find(begins) {
        Some((_, "xlsx")) if ending != "xlsx" => {
            return Err(wrong("a zip archive; unpack it, or save the table as csv".to_owned()));
        }
        Some((_, "xls")) => {
            return Err(wrong("an old spreadsheet; save the table as xlsx or csv".to_owned()));
        }
        Some((_, kind)) => return Err(convert(kind)),
        None => {}
    }
    let decoded = decode(bytes);
    match decoded.chars().take(4000).any(|c| c == '\0') {
        true if CONVERTED.contains(&ending.as_str()) => Err(convert(&ending)),
        true => Err(wrong("no text: export it as csv from the program that wrote it".to_owned())),
        false => Ok(decoded),
    }
}

fn decode(bytes: Vec<u8>) -> String {
    let wide = |bytes: &[u8], of: fn([u8; 2]) -> u16| {
        let units: Vec<u16> = bytes.chunks_exact(2).map(|pair| of([pair[0], pair[1]])).collect();
        String::from_utf16_lossy(&units)
    };
    match bytes.as_slice() {
        [0xff, 0xfe, rest @ ..] => return wide(rest, u16::from_le_bytes),
        [0xfe, 0xff, rest @ ..] => return wide(rest, u16::from_be_bytes),
        [first, 0, second, 0, ..] if *first > 0 && *second > 0 => {
            return wide(&bytes, u16::from_le_bytes);
        }
        _ => {}
    }
    let windows = |byte: u8| match byte {
        0x80..=0x9f => WINDOWS.chars().nth(usize::from(byte - 0x80)).unwrap_or('?'),
        _ => char::from(byte),
    };
    let text = String::from_utf8(bytes);
    let text = text.unwrap_or_else(|error| error.as_bytes().iter().map(|&byte| windows(byte)).collect());
    composed(text.strip_prefix('\u{feff}').map(str::to_owned).unwrap_or(text))
}

/// The text with umlauts as one character each, as keyboards write them: some systems write them as two.
pub fn composed(text: String) -> String {
    const UMLAUTS: [(&str, &str); 7] = [
        ("a\u{308}", "ä"),
        ("o\u{308}", "ö"),
        ("u\u{308}", "ü"),
        ("A\u{308}", "Ä"),
        ("O\u{308}", "Ö"),
        ("U\u{308}", "Ü"),
        ("e\u{301}", "é"),
    ];
    let is_split = |text: &str| text.contains(['\u{308}', '\u{301}']);
    match is_split(&text) {
        true => UMLAUTS.iter().fold(text, |text, (split, whole)| text.replace(split, whole)),
        false => text,
    }
}

/// Names, units and the place of the numbers.
#[derive(Debug, PartialEq)]
pub(super) struct Found {
    pub separator: u8,
    pub names: Vec<String>,
    pub units: Vec<Option<String>>,
    /// The first line of numbers, from 0.
    pub first: usize,
    /// The first line of another table above, from 1, and how many rows of numbers that has.
    pub above: Option<(u64, usize)>,
}

/// The cells of a line.
pub(super) fn cells(line: &str, separator: u8) -> Vec<String> {
    if separator == b' ' {
        return line.split_whitespace().map(str::to_owned).collect();
    }
    let mut reader = csv::ReaderBuilder::new();
    let reader = reader.has_headers(false).delimiter(separator).trim(csv::Trim::All);
    let mut record = csv::StringRecord::new();
    match reader.from_reader(line.as_bytes()).read_record(&mut record) {
        Ok(true) => record.iter().map(str::to_owned).collect(),
        _ => Vec::new(),
    }
}

/// How many cells a row has up to the last one that is not empty.
fn filled(cells: &[String]) -> usize {
    let last = cells.iter().rposition(|cell| !cell.is_empty());
    last.map_or(0, |last| last + 1)
}

/// How many cells a row of numbers has; `None` of any other line. With `texts`, some cells may be words.
fn numbers(cells: &[String], separator: u8, form: Option<&str>, texts: bool) -> Option<usize> {
    let is_value = |cell: &String| number(separator, cell).is_some() || stamp(cell, form).is_some();
    let missing = |cell: &String| cell.is_empty() || !cell.contains(|c: char| c.is_alphanumeric());
    let some = cells.iter().any(is_value);
    let all = texts || cells.iter().all(|cell| is_value(cell) || missing(cell));
    (some && all).then(|| filled(cells))
}

/// The longest run of rows of numbers: its first line, its length, its most cells.
fn run(lines: &[&str], separator: u8, layout: &Layout, texts: bool) -> Option<(usize, usize, usize)> {
    let after = layout.header.unwrap_or(0);
    let mut best: Option<(usize, usize, usize)> = None;
    let mut now: Option<(usize, usize, usize)> = None;
    for (k, line) in lines.iter().enumerate().skip(after) {
        if line.trim().is_empty() || (line.starts_with('#') && now.is_some()) {
            continue;
        }
        let count = numbers(&cells(line, separator), separator, layout.format.as_deref(), texts);
        now = match (count, now) {
            (None, _) => None,
            // With words in it, only rows of as many cells belong together.
            (Some(count), Some((first, rows, most))) if !texts || count == most => {
                Some((first, rows + 1, most.max(count)))
            }
            (Some(count), _) => Some((k, 1, count)),
        };
        if now.is_some_and(|(_, rows, _)| best.is_none_or(|(_, most, _)| rows > most)) {
            best = now;
        }
    }
    best
}

/// A unit without brackets around it, by its usual letters.
pub(super) fn unit(cell: &str) -> String {
    let bare = cell.trim_matches(|c: char| "[]()".contains(c) || c.is_whitespace());
    bare.replace('°', "deg").replace(['·', '*'], ".")
}

/// Whether a cell can hardly be anything but a unit.
fn is_unit(cell: &str) -> bool {
    let enclosed = [('[', ']'), ('(', ')')];
    let enclosed = enclosed.iter().any(|(from, to)| cell.starts_with(*from) && cell.ends_with(*to));
    enclosed || known::usual(&unit(cell)).is_some()
}

/// Why a row has more cells than there are names.
pub(super) fn unequal(cells: usize, names: usize) -> String {
    format!("has {cells} cells instead of {names} as the names; a decimal comma needs semicolons between cells")
}

/// Looks for the numbers in a text, and for the names above them.
pub(super) fn find(path: &Path, text: &str, layout: &Layout) -> Result<Found, FileError> {
    let lines: Vec<&str> = text.lines().take(SAMPLE).collect();
    let separators = match &layout.delimiter {
        Some(delimiter) => vec![separator(path, delimiter)?],
        None => SEPARATORS.to_vec(),
    };
    let best = |texts: bool| {
        let each = separators.iter().filter_map(|&s| Some((s, run(&lines, s, layout, texts)?)));
        // More than one column, then more rows, then more columns; of equals the first.
        let rank = |&(_, (_, rows, columns)): &(u8, (usize, usize, usize))| (columns > 1, rows, columns);
        each.rev().max_by_key(rank)
    };
    let found = best(false).or_else(|| best(true).filter(|(_, (_, rows, _))| *rows > 2 || lines.len() < 4));
    let Some((separator, (first, _, columns))) = found else {
        let message = "no rows of numbers in its first lines; export the recording as csv, or name `header` (the line of the \
                       names) and `delimiter` in the settings";
        return Err(FileError::new(path, message));
    };
    let form = layout.format.as_deref();
    let is_value = |cell: &String| number(separator, cell).is_some() || stamp(cell, form).is_some();
    let model = cells(lines[first], separator);
    // Rows with a remark in them belong to the numbers, too; a number as the unit of a ratio makes none of them.
    let is_row = |line: &usize| {
        let row = cells(lines[*line], separator);
        let known = row.iter().filter(|cell| !cell.is_empty()).count();
        let values = row.iter().filter(|cell| is_value(cell)).count();
        let timed = row.first().is_some_and(is_value);
        let units = !timed && row.first().is_some_and(|cell| is_unit(cell));
        let enough = values == known || values > 1 || timed;
        row.len() == model.len() && values > 0 && 2 * values >= known && enough && !units
    };
    let least = layout.header.unwrap_or(0);
    let back = |from: usize| {
        let mut first = from;
        for line in (least..from).rev() {
            match is_row(&line) {
                true => first = line,
                false if lines[line].starts_with('#') && line > 0 && is_row(&(line - 1)) => {}
                false => break,
            }
        }
        first
    };
    // Numbers where this row has them: of the same table, whatever stands between.
    let is_alike = |line: &usize| {
        let row = cells(lines[*line], separator);
        let fits = |(cell, model): (&String, &String)| is_value(cell) == is_value(model);
        row.len() == model.len() && row.iter().zip(&model).all(fits)
    };
    let earliest = match layout.header {
        Some(header) => (header..first).find(is_row),
        // A single row may hold the numbers of channels.
        None => (0..first.saturating_sub(1)).find(|line| is_alike(line) && is_row(&(line + 1))),
    };
    let is_other =
        |begin: &usize| layout.header.is_none() && is_other_table(&lines[..first], *begin, separator, &is_value);
    let other = earliest.filter(is_other);
    let above_rows = |begin: usize| (begin as u64 + 1, (begin..first).filter(is_row).count());
    let (above_it, earliest) = (other.map(above_rows), earliest.filter(|_| other.is_none()));
    let first = back(earliest.unwrap_or(first));
    let named = |line: usize| head(lines[line], separator, columns);
    let (names, units) = match layout.header {
        Some(header) if header > 0 && header <= first && !is_row(&(header - 1)) => {
            let names = named(header - 1).unwrap_or_else(|| cells(lines[header - 1], separator));
            let are_units = |row: &Vec<String>| *row != names && !row.iter().any(|cell| is_missing(cell));
            let units = (header..first).find_map(named).filter(are_units);
            (Some(names), units)
        }
        Some(header) => {
            let message =
                format!("line {header} is no line of names above the numbers, which begin on line {}", first + 1);
            return Err(FileError::new(path, message));
        }
        None => above(first, &lines, separator, named),
    };
    if names.is_none() && separator == b',' && first > 0 {
        // `0,1,5` below `t,F` are two numbers with decimal commas.
        let above = cells(lines[first - 1], separator).len();
        if above > 1 {
            let message = format!("line {} {}", first + 1, unequal(columns, above));
            return Err(FileError::new(path, message));
        }
    }
    let mut names = names.unwrap_or_default();
    names.extend((names.len()..columns).map(|k| (k + 1).to_string()));
    let unit_at = |k: usize| units.as_ref().and_then(|row| row.get(k)).map(|cell| unit(cell));
    let units = (0..names.len()).map(|k| unit_at(k).filter(|unit| !unit.is_empty()));
    Ok(Found { separator, units: units.collect(), names: distinct(names), first, above: above_it })
}

/// Whether a cell says that there is no value.
fn is_missing(cell: &str) -> bool {
    const WORDS: [&str; 5] = ["n/a", "#n/a", "na", "nan", "null"];
    WORDS.iter().any(|word| cell.eq_ignore_ascii_case(word))
}

/// Whether what follows a block of rows is a table of its own: behind a blank line it has names that are not above the block.
fn is_other_table(lines: &[&str], block: usize, separator: u8, is_value: &impl Fn(&String) -> bool) -> bool {
    let width = cells(lines[block], separator).len();
    let blank = lines[block..].iter().position(|line| line.trim().is_empty());
    let are_names = |line: &&&str| {
        let row = cells(line, separator);
        let texts = row.iter().all(|cell| !cell.is_empty() && !is_value(cell));
        row.len() == width && texts && !lines[..block].contains(*line)
    };
    blank.is_some_and(|blank| lines[block + blank..].iter().any(|line| are_names(&line)))
}

/// The rows of names and of units above the first numbers.
fn above(
    first: usize,
    lines: &[&str],
    separator: u8,
    named: impl Fn(usize) -> Option<Vec<String>>,
) -> (Option<Vec<String>>, Option<Vec<String>>) {
    let blank = |line: &&usize| lines[**line].trim().is_empty();
    let places: Vec<usize> = (0..first).rev().collect();
    let gap = places.iter().take_while(blank).count();
    let block: Vec<Vec<String>> = places[gap..].iter().map_while(|&line| named(line)).collect();
    let are_units = |row: &Vec<String>| {
        let said: Vec<&String> = row.iter().filter(|cell| !cell.is_empty()).collect();
        !said.is_empty() && 2 * said.iter().filter(|cell| is_unit(cell)).count() >= said.len()
    };
    // Between the units and the numbers stands at most one row of remarks.
    let place = (0..block.len().saturating_sub(1).min(2)).find(|&k| are_units(&block[k]));
    // Two lines at the top are names and units, known or not; words of a title are none.
    let place = place.or((separator != b' ' && block.len() == 2 && gap + 2 == places.len()).then_some(0));
    match place {
        Some(k) => (block.get(k + 1).cloned(), block.get(k).cloned()),
        None => (block.first().cloned(), None),
    }
}

/// The cells of a line above the numbers, where it has one for each column.
fn head(line: &str, separator: u8, columns: usize) -> Option<Vec<String>> {
    let line = line.trim_start_matches(['#', '%', '!']);
    let fits = |row: &Vec<String>| row.len() >= columns && filled(row) > 0;
    let joined = || {
        let mut row: Vec<String> = Vec::new();
        for cell in line.split_whitespace() {
            match row.last_mut() {
                Some(name) if cell.starts_with(['[', '(']) => *name += &format!(" {cell}"),
                _ => row.push(cell.to_owned()),
            }
        }
        row
    };
    let usual = match separator {
        // A unit belongs to the name before it.
        b' ' => joined(),
        _ => cells(line, separator),
    };
    let others = SEPARATORS.iter().map(|&other| cells(line, other));
    let mut rows = [usual].into_iter().chain(others);
    let row = rows.find(fits)?.into_iter();
    let row = row.map(|name| crate::csv_file::text(&name).into_owned());
    Some(row.collect())
}

/// Names that come again get a number.
fn distinct(names: Vec<String>) -> Vec<String> {
    let mut known: Vec<String> = Vec::new();
    for (place, name) in names.into_iter().enumerate() {
        let name = if name.is_empty() { (place + 1).to_string() } else { name };
        let count = known.iter().filter(|other| **other == name || other.starts_with(&format!("{name} ("))).count();
        let again = known.contains(&name);
        known.push(if again { format!("{name} ({})", count + 1) } else { name });
    }
    known
}

fn separator(path: &Path, delimiter: &str) -> Result<u8, FileError> {
    match delimiter {
        "\t" | "tab" => Ok(b'\t'),
        ";" => Ok(b';'),
        "," => Ok(b','),
        " " | "space" => Ok(b' '),
        "|" => Ok(b'|'),
        other => {
            let message = format!("delimiter `{other}` is none of `,` `;` `|` `tab` `space`");
            Err(FileError::new(path, message))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(text: &str) -> (char, String, String, usize) {
        let found = find(Path::new("m.csv"), text, &Layout::default()).unwrap();
        let units: Vec<String> = found.units.into_iter().map(Option::unwrap_or_default).collect();
        (char::from(found.separator), found.names.join("|"), units.join("|"), found.first)
    }

    #[test]
    fn names_and_units_stand_above_the_numbers() {
        for (text, separator, names, units, first) in [
            ("t,F\n0,1\n1,2\n", ',', "t|F", "|", 1),
            ("t;F\nfoo;bar\n0;1,5\n", ';', "t|F", "foo|bar", 2),
            // PicoScope.
            ("Zeit;Kanal A\n(ms);(V)\n\n-0,5;12,1\n0,0;12,2\n", ';', "Zeit|Kanal A", "ms|V", 3),
            // A preamble with numbers of its own, and a row of remarks.
            (
                "Bediener;Meier\nRate;1000\nDatum;22.11.2026 10:00:00\n\nt;p;T\ns;bar;°C\n1: MX840;2;3 b\n0;1,5;80\n1;1,6;81\n2;1,7;82\n",
                ';',
                "t|p|T",
                "s|bar|degC",
                7,
            ),
            ("# run 7\n# t F\n0 1\n1 2\n2 3\n", ' ', "t|F", "|", 2),
            ("Time (s)  Force (N)\n0 1\n1 2\n", ' ', "Time (s)|Force (N)", "|", 1),
            ("m,n,\n0,1,\n1,2,3\n", ',', "m|n|3", "||", 1),
            ("0,1\n1,2\n", ',', "1|2", "|", 0),
            ("t,F,t,F,\n0,1,0,2,\n1,1,1,2,\n", ',', "t|F|t (2)|F (2)|5", "||||", 1),
            (
                "day;p;state\n2026-11-22 10:00:00;1;on\n2026-11-22 10:00:01;1;on\n2026-11-22 10:00:02;1;on\n",
                ';',
                "day|p|state",
                "||",
                1,
            ),
        ] {
            let expected = (separator, names.to_owned(), units.to_owned(), first);
            assert_eq!(found(text), expected, "{text}");
        }
    }

    /// Once numbers began, a line of words among them is no header, early or late.
    #[test]
    fn words_among_the_numbers_are_no_header() {
        let row = |k: usize| format!("0.{k:03},{}", k % 7);
        let with = |place: usize, line: &str| {
            let mut rows: Vec<String> = (0..400).map(row).collect();
            rows.insert(place, line.to_owned());
            format!("t [s],y [degC]\n{}\n", rows.join("\n"))
        };
        for place in [1, 2, 3, 149, 399] {
            for line in ["0.5,n/a", "0.5,#N/A", "0.5,OVERLOAD", "0.5,", "# marker"] {
                let (_, names, units, first) = found(&with(place, line));
                assert_eq!((names.as_str(), units.as_str(), first), ("t [s]|y [degC]", "|", 1));
            }
        }
        for place in [2, 3, 149, 399] {
            for line in ["t [s],y [degC]", "Marker,third gear", "Marker;Gang 3", "\n"] {
                assert_eq!(found(&with(place, line)).3, 1, "{line} behind {place}");
            }
        }
        let stated = Layout { header: Some(1), ..Layout::default() };
        for line in ["0.5,n/a", "t [s],y [degC]", "0.5,OVERLOAD"] {
            for place in [0, 1, 3, 149] {
                let found = find(Path::new("m.csv"), &with(place, line), &stated).unwrap();
                let above = usize::from(place == 0 && line.starts_with('t'));
                assert_eq!((found.first, &found.units[1]), (1 + above, &None), "{line}");
            }
        }
    }

    /// A table of calibration above the recording, with names of its own.
    #[test]
    fn a_shorter_table_above_is_none_of_the_rows() {
        let text = "raw;bar\n0;0\n10;16\n\nt;p\n0;1,5\n1;1,6\n2;1,7\n";
        assert_eq!(found(text), (';', "t|p".to_owned(), "|".to_owned(), 5));
        // The numbers of channels.
        let text = "1;2;3\nt;p;mu\ns;1;1\n0;1,5;0\n1;1,6;0\n2;1,7;0\n";
        assert_eq!(found(text).1, "t|p|mu");
    }

    #[test]
    fn texts_of_every_coding_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("m.csv");
        let wide: Vec<u8> = "\u{feff}T;°C".encode_utf16().flat_map(u16::to_le_bytes).collect();
        for bytes in ["T;°C".as_bytes(), b"T;\xb0C", b"\xef\xbb\xbfT;\xc2\xb0C", &wide] {
            std::fs::write(&path, bytes).unwrap();
            assert_eq!(text(&path).unwrap(), "T;°C");
        }
        std::fs::write(&path, b"10 \x80").unwrap();
        assert_eq!(text(&path).unwrap(), "10 €");
        for (bytes, remedy) in [
            (b"MDF     4.10".as_slice(), "python -m fmu_orchestrator convert"),
            (b"PK\x03\x04", "save the table as csv"),
            (b"\x01\0\0\0\x01", "export it as csv"),
        ] {
            std::fs::write(&path, bytes).unwrap();
            let error = text(&path).unwrap_err().to_string();
            assert!(error.contains(remedy) && error.lines().count() == 1, "{error}");
        }
    }
}
