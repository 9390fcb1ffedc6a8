//! Texts of an SVG, measured with the font that they are drawn in: none may lie on another or leave
//! the picture.

use std::sync::Once;

use plotters::style::{FontDesc, FontFamily, FontStyle, register_font};

const FAMILY: &str = "figures";
/// What the SVG's size is divided by to get the em, and the em's ascent plus descent.
const FONT_HEIGHT: f64 = 1.164;

/// A text's rectangle: left, top, right, bottom, in the units of the SVG.
struct Text {
    words: String,
    box_: [f64; 4],
}

fn attribute<'a>(tag: &'a str, name: &str) -> Option<&'a str> {
    tag.split_once(&format!("{name}=\""))?.1.split('"').next()
}

fn number(tag: &str, name: &str) -> f64 {
    attribute(tag, name).and_then(|value| value.parse().ok()).unwrap_or(0.0)
}

fn width(words: &str, size: f64, bold: bool) -> f64 {
    static FONTS: Once = Once::new();
    FONTS.call_once(|| {
        assert!(register_font(FAMILY, FontStyle::Normal, dejavu::sans::regular()).is_ok());
        assert!(register_font(FAMILY, FontStyle::Bold, dejavu::sans::bold()).is_ok());
    });
    let style = if bold { FontStyle::Bold } else { FontStyle::Normal };
    let font = FontDesc::new(FontFamily::Name(FAMILY), size * FONT_HEIGHT, style);
    let ((left, _), (right, _)) = font.layout_box(words).unwrap();
    f64::from(right - left)
}

fn texts(svg: &str) -> Vec<Text> {
    let mut found = Vec::new();
    for piece in svg.split("<text ").skip(1) {
        let (tag, rest) = piece.split_once('>').unwrap();
        let words = rest.split("</text>").next().unwrap().trim();
        let words = words
            .replace("&lt;", "<")
            .replace("&gt;", ">")
            .replace("&quot;", "\"")
            .replace("&apos;", "'")
            .replace("&amp;", "&");
        if words.is_empty() {
            continue;
        }
        let (size, wide) = (number(tag, "font-size"), 0.0);
        let bold = tag.contains("bold");
        let wide = wide + width(&words, size, bold);
        let left = match attribute(tag, "text-anchor") {
            Some("middle") => -0.5 * wide,
            Some("end") => -wide,
            _ => 0.0,
        };
        // From the baseline: what capitals and figures reach up, and what letters hang down.
        let along = [left, left + wide];
        let (up, down) = (0.72 * size, 0.16 * size);
        let [x, y] = [number(tag, "x"), number(tag, "y")];
        let base = 0.76 * size;
        let box_ = if tag.contains("rotate(270") {
            [x + base - up, y - along[1], x + base + down, y - along[0]]
        } else {
            [x + along[0], y + base - up, x + along[1], y + base + down]
        };
        found.push(Text { words, box_ });
    }
    found
}

/// Fails where two texts touch or one leaves the picture.
pub(crate) fn assert_apart(name: &str, svg: &[u8]) {
    let svg = String::from_utf8_lossy(svg);
    let view: Vec<f64> = attribute(&svg, "viewBox")
        .unwrap()
        .split(' ')
        .map(|number| number.parse().unwrap())
        .collect();
    let texts = texts(&svg);
    for (index, one) in texts.iter().enumerate() {
        let [left, top, right, bottom] = one.box_;
        let inside = left >= 0.0 && top >= 0.0 && right <= view[2] && bottom <= view[3];
        assert!(inside, "{name}: `{}` leaves the picture: {:?} of {view:?}", one.words, one.box_);
        for other in &texts[index + 1..] {
            let [a, b, c, d] = other.box_;
            let apart = right < a || c < left || bottom < b || d < top;
            assert!(
                apart,
                "{name}: `{}` lies on `{}`: {:?}, {:?}",
                one.words, other.words, one.box_, other.box_
            );
        }
    }
}
