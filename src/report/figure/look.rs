//! How series are told apart, with colour and without, and how a figure fits its reader's page.

use plotters::style::{Color, RGBColor, ShapeStyle};

/// Stands for the colour of text, whatever that is where the figure is read: plotters knows only
/// colours, so those that mean something else are exchanged once all is drawn.
pub(in crate::report) const INK: RGBColor = RGBColor(1, 2, 3);

/// Colours that colour-blind people can tell apart (Okabe & Ito 2008), the text's in the place of
/// black.
const COLOURS: [RGBColor; 8] = [
    RGBColor(0, 114, 178),
    RGBColor(230, 159, 0),
    RGBColor(0, 158, 115),
    RGBColor(213, 94, 0),
    RGBColor(86, 180, 233),
    RGBColor(204, 121, 167),
    RGBColor(130, 130, 130),
    INK,
];

/// Lengths of strokes and of gaps between them.
const DASHES: [&str; 8] = ["", "9 4", "3 3", "12 4 3 4", "18 5", "6 3", "12 4 3 4 3 4", "2 5"];

const LINE_WIDTH: u32 = 2;

/// Shape of the mark at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Mark {
    Disc,
    Square,
    Triangle,
    Diamond,
    Ring,
    Frame,
    Cross,
    Wedge,
}

const MARKS: [Mark; 8] = [
    Mark::Disc,
    Mark::Square,
    Mark::Triangle,
    Mark::Diamond,
    Mark::Ring,
    Mark::Frame,
    Mark::Cross,
    Mark::Wedge,
];

/// Of the series of a number: 64 differ, 8 of them in colour, mark and dash alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::report) struct Look {
    pub colour: RGBColor,
    pub(super) mark: Mark,
    number: u8,
}

impl Look {
    pub fn of(series: usize) -> Self {
        let number = series % 64;
        let (round, step) = (number / 8, number % 8);
        Self { colour: COLOURS[step], mark: MARKS[(step + round) % 8], number: number as u8 }
    }

    /// Its colour and its dashes, by a colour that stands for both.
    pub fn line(self) -> ShapeStyle {
        self.stand_in().stroke_width(LINE_WIDTH)
    }

    fn stand_in(self) -> RGBColor {
        RGBColor(2, 3, self.number)
    }

    fn dashes(self) -> &'static str {
        DASHES[usize::from(self.number % 8 + self.number / 8) % 8]
    }
}

/// For what has no page around it: the colours of its reader's system, on paper black on white.
const FILE_STYLE: &str = "<style>svg:root{color:#1a1a1a;background:#fff}\
    @media screen and (prefers-color-scheme:dark){svg:root{color:#e4e4e4;background:#16191d}}\
    </style>";
const FONT_FAMILY: &str = " font-family=\"sans-serif\"";
const NAMESPACE: &str = " xmlns=\"http://www.w3.org/2000/svg\"";

pub(in crate::report) fn as_file(drawn: &str, title: &str) -> String {
    with_head(&in_ink(drawn), title, FILE_STYLE)
}

pub(in crate::report) fn within_page(drawn: &str, title: &str) -> String {
    with_head(&in_ink(drawn).replacen(NAMESPACE, "", 1), title, "")
}

/// Exchanges the colours that stand for something. Text has no quotation marks: they are escaped.
fn in_ink(drawn: &str) -> String {
    let hex = |RGBColor(r, g, b): RGBColor| format!("#{r:02X}{g:02X}{b:02X}");
    let mut svg = drawn.to_owned();
    for look in (0..64).map(Look::of) {
        let stand_in = format!("stroke=\"{}\"", hex(look.stand_in()));
        if !svg.contains(&stand_in) {
            continue;
        }
        let dashes = match look.dashes() {
            "" => String::new(),
            dashes => format!(" stroke-dasharray=\"{dashes}\""),
        };
        let meant = format!("stroke=\"{}\" stroke-linejoin=\"round\"{dashes}", hex(look.colour));
        svg = svg.replace(&stand_in, &meant);
    }
    let svg = svg.replace(&format!("=\"{}\"", hex(INK)), "=\"currentColor\"");
    // What is everywhere, or goes without saying.
    svg.replace(FONT_FAMILY, "").replace(" opacity=\"1\"", "")
}

/// What a screen reader says in the place of the figure comes first.
fn with_head(svg: &str, title: &str, style: &str) -> String {
    let (tag, content) = svg.split_once('>').expect("plotters begins with the tag");
    let title = escaped(title);
    format!("{tag}{FONT_FAMILY} role=\"img\"><title>{title}</title>{style}{content}")
}

/// Text for XML and HTML, in quotation marks and out of them; characters that XML has no place for
/// become the replacement character.
pub(in crate::report) fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for character in text.chars() {
        match character {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            other => escaped.push(printable(other)),
        }
    }
    escaped
}

/// Not a control character, and allowed in XML 1.0.
pub(super) fn printable(character: char) -> char {
    match character {
        '\n' | '\t' => ' ',
        '\u{fffe}' | '\u{ffff}' => char::REPLACEMENT_CHARACTER,
        other if other.is_control() => char::REPLACEMENT_CHARACTER,
        other => other,
    }
}
