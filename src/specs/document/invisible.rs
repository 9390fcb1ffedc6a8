//! Characters that nobody sees: text that is pasted from a web page or a PDF has them where a space
//! is meant, and YAML does not take them for one.

/// The name of an invisible character; `None` for any other.
fn name(character: char) -> Option<&'static str> {
    Some(match character {
        '\u{85}' | '\u{2028}' | '\u{2029}' => "a line separator",
        '\u{a0}' => "a no-break space",
        '\u{ad}' => "a soft hyphen",
        '\u{2000}'..='\u{200a}' | '\u{1680}' | '\u{205f}' | '\u{3000}' => {
            "a space of an unusual width"
        }
        '\u{200b}' => "a zero-width space",
        '\u{200c}' | '\u{200d}' => "a zero-width joiner or non-joiner",
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => {
            "a mark of writing direction"
        }
        '\u{202f}' => "a narrow no-break space",
        '\u{2060}' => "a word joiner",
        '\u{feff}' => "a byte order mark",
        _ => return None,
    })
}

/// The first invisible character of `text` and what it follows: ``a no-break space (U+00A0) after
/// `radius_m:` ``.
pub(super) fn describe(text: &str) -> Option<String> {
    let (at, character, name) =
        text.char_indices().find_map(|(at, character)| Some((at, character, name(character)?)))?;
    let what = format!("{name} (U+{:04X})", character as u32);
    let is_break = |c: char| c.is_whitespace() || self::name(c).is_some();
    let before = text[..at].rsplit(is_break).next().unwrap_or_default();
    let after = text[at..].split(is_break).find(|word| !word.is_empty()).unwrap_or_default();
    Some(match (before, after) {
        ("", "") => what,
        ("", after) => format!("{what} before `{after}`"),
        (before, _) => format!("{what} after `{before}`"),
    })
}

/// `found`, the text of an error, with the name of the first invisible character in it.
pub(super) fn named(found: String) -> String {
    let text = unescaped(&found);
    // The words of the error around a value are no part of it.
    let inside = text.split(['`', '"']).find_map(describe);
    match inside.or_else(|| describe(&text)) {
        Some(invisible) => format!("{text}, with {invisible}"),
        None => found,
    }
}

/// `text` with the escapes of invisible characters, `\u{a0}`, as the characters.
fn unescaped(text: &str) -> String {
    let mut parts = text.split("\\u{");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let character = part.split_once('}').and_then(|(digits, rest)| {
            let character = char::from_u32(u32::from_str_radix(digits, 16).ok()?)?;
            name(character).map(|_| (character, rest))
        });
        match character {
            Some((character, rest)) => {
                out.push(character);
                out.push_str(rest);
            }
            None => {
                out.push_str("\\u{");
                out.push_str(part);
            }
        }
    }
    out
}

/// Lines before the one in which the parser gives up that are searched: a value that does not end
/// where it should is found out in the next line.
const LINES_BEFORE: usize = 2;

/// The last invisible character near line `line` (from 1) of a text: its line and column, and what
/// it is.
pub(super) fn near(text: &str, line: usize) -> Option<(usize, usize, String)> {
    let first = line.saturating_sub(LINES_BEFORE + 1);
    let lines: Vec<(usize, &str)> = text.split('\n').enumerate().take(line).skip(first).collect();
    lines.into_iter().rev().find_map(|(number, line)| {
        // A comment may hold what it likes.
        let code = line.find(" #").map_or(line, |at| &line[..at]);
        let column = code.chars().position(|character| name(character).is_some())? + 1;
        Some((number + 1, column, describe(code)?))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn invisible_characters_are_named_with_what_they_follow() {
        for (text, expected) in [
            ("radius_m:\u{a0}0.020", "a no-break space (U+00A0) after `radius_m:`"),
            ("\u{feff}robot", "a byte order mark (U+FEFF) before `robot`"),
            ("a: se_ard\u{200b}", "a zero-width space (U+200B) after `se_ard`"),
            ("\u{2009}", "a space of an unusual width (U+2009)"),
        ] {
            assert_eq!(describe(text).as_deref(), Some(expected), "{text:?}");
        }
        assert_eq!(describe("plain text, µm and é"), None);
        assert_eq!(
            named("text \"0.02\\u{a0}\"".to_owned()),
            "text \"0.02\u{a0}\", with a no-break space (U+00A0) after `0.02`"
        );
        assert_eq!(named("text \"\\u{1}\"".to_owned()), "text \"\\u{1}\"");
    }

    #[test]
    fn they_are_searched_near_the_line_of_an_error_and_not_in_comments() {
        let text = "a: 1 # \u{a0}\nb:\u{a0}2\nc: 3\nd: 4\ne: 5\n";
        assert_eq!(near(text, 1), None);
        let found = near(text, 3).unwrap();
        assert_eq!(
            (found.0, found.1, found.2.as_str()),
            (2, 3, "a no-break space (U+00A0) after `b:`")
        );
        assert_eq!(near(text, 5), None);
    }
}
