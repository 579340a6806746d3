//! Reads the closed outline of an SVG drawing.
//!
//! W3C, "Scalable Vector Graphics (SVG) 1.1": elements `path`, `polygon`, `rect` and `circle`. In SVG y points down;
//! outlines are seen from above with y up, as the drawing shows them.

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use super::curves::{ellipse, push_arc, push_bezier};
use super::{Corners, only, wrong, wrong_at};
use crate::formats::Diagnostic;

const EXPECTED: &str = "one closed path, polygon, rect or circle";
const PATH: &str = "a closed path of M L H V C Q A Z, absolute or relative";

/// Corners of the only closed outline of the drawing `text`, and the line in which the outline begins.
pub(super) fn outline(text: &str) -> Result<(Corners, u32), Diagnostic> {
    let mut reader = Reader::from_str(text);
    let mut found = Vec::new();
    let mut is_drawing = false;
    // Lines are counted from the previous element, because counting from the beginning each time is quadratic.
    let (mut line, mut counted) = (1, 0);
    loop {
        let before = usize::try_from(reader.buffer_position()).unwrap_or(usize::MAX).min(text.len());
        let begins = (text.len() - text[before..].trim_start().len()).max(counted);
        // The number of lines of a file in memory fits the type.
        line += text.as_bytes()[counted..begins].iter().filter(|byte| **byte == b'\n').count() as u32;
        counted = begins;
        let element = match reader.read_event() {
            Err(error) => return Err(wrong(line, format!("is no XML: {error}"), "an SVG drawing")),
            Ok(Event::Eof) => break,
            Ok(Event::Start(element) | Event::Empty(element)) => element,
            Ok(_) => continue,
        };
        let name = element.local_name().as_ref().to_owned();
        is_drawing |= name == "svg";
        let attributes = attributes(&element, line)?;
        if let Some((_, value)) = attributes.iter().find(|(key, _)| key == "transform") {
            let refused = wrong(line, "is a transformation", "none: coordinates as they are drawn");
            return Err(wrong_at("transform", value.as_str(), refused));
        }
        let number = |key: &str, default: Option<f64>| number(&attributes, (&name, key), default, line);
        let mut corners = match name.as_str() {
            "path" => path(text_of(&attributes, (&name, "d"), line)?, line)?,
            "polygon" => polygon(text_of(&attributes, (&name, "points"), line)?, line)?,
            "circle" => ellipse([number("cx", Some(0.0))?, number("cy", Some(0.0))?], [number("r", None)?; 2]),
            "rect" => {
                if number("rx", Some(0.0))? != 0.0 || number("ry", Some(0.0))? != 0.0 {
                    return Err(wrong(line, "is a rect with round corners", "a rect without rx and ry, or a path"));
                }
                let [x, y] = [number("x", Some(0.0))?, number("y", Some(0.0))?];
                let [width, height] = [number("width", None)?, number("height", None)?];
                vec![[x, y], [x + width, y], [x + width, y + height], [x, y + height]]
            }
            "ellipse" | "line" | "polyline" | "text" | "image" | "use" => {
                return Err(wrong(line, format!("is a {name}"), EXPECTED));
            }
            _ => continue,
        };
        corners.iter_mut().for_each(|corner| corner[1] = -corner[1]);
        found.push((corners, line));
    }
    if is_drawing { only(found, EXPECTED) } else { Err(wrong(None, "is no SVG drawing", EXPECTED)) }
}

/// Names, without prefixes, and values of the attributes of an element.
fn attributes(element: &BytesStart<'_>, line: u32) -> Result<Vec<(String, String)>, Diagnostic> {
    let read = element.attributes().map(|attribute| match attribute {
        Ok(attribute) => Ok((attribute.key.local_name().as_ref().to_owned(), attribute.value.as_ref().to_owned())),
        Err(error) => Err(wrong(line, format!("has an attribute that cannot be read: {error}"), "an SVG drawing")),
    });
    read.collect()
}

fn text_of<'a>(
    attributes: &'a [(String, String)],
    (name, key): (&str, &str),
    line: u32,
) -> Result<&'a str, Diagnostic> {
    let found = attributes.iter().find(|(own, _)| own == key).map(|(_, value)| value.as_str());
    found.ok_or_else(|| wrong(line, format!("is a {name} without {key}"), EXPECTED))
}

fn number(
    attributes: &[(String, String)],
    (name, key): (&str, &str),
    default: Option<f64>,
    line: u32,
) -> Result<f64, Diagnostic> {
    if let (Some(default), true) = (default, attributes.iter().all(|(own, _)| own != key)) {
        return Ok(default);
    }
    let value = text_of(attributes, (name, key), line)?;
    // A unit should scale the whole drawing: one outline has one unit.
    let digits = value.trim().trim_end_matches("mm").trim_end_matches("px");
    let read = digits.parse().ok().filter(|read: &f64| read.is_finite());
    read.ok_or_else(|| {
        let refused = wrong(line, "is no number", "a number without a unit, or in mm or px");
        wrong_at(&format!("{name}.{key}"), value, refused)
    })
}

fn polygon(points: &str, line: u32) -> Result<Corners, Diagnostic> {
    let mut numbers = Tokens { rest: points, line, key: "polygon.points" };
    let mut corners = Vec::new();
    while let Some(x) = numbers.number()? {
        corners.push([x, numbers.needed()?]);
    }
    numbers.end()?;
    Ok(corners)
}

/// Splits the value of an attribute into numbers, letters and flags.
struct Tokens<'a> {
    rest: &'a str,
    line: u32,
    key: &'static str,
}

impl Tokens<'_> {
    fn skip_blank(&mut self) {
        self.rest = self.rest.trim_start_matches(|letter: char| letter.is_ascii_whitespace() || letter == ',');
    }

    fn wrong(&self, reason: &str) -> Diagnostic {
        let shown: String = self.rest.chars().take(20).collect();
        wrong_at(self.key, shown, wrong(self.line, reason, PATH))
    }

    /// Reads the letter of a command; `None` if no letter follows.
    fn letter(&mut self) -> Option<char> {
        self.skip_blank();
        let letter = self.rest.chars().next().filter(char::is_ascii_alphabetic)?;
        self.rest = &self.rest[1..];
        Some(letter)
    }

    /// Reads a number; `None` if no number follows.
    fn number(&mut self) -> Result<Option<f64>, Diagnostic> {
        self.skip_blank();
        let bytes = self.rest.as_bytes();
        let digits = |from: usize| bytes[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        let mut end = usize::from(matches!(bytes.first(), Some(b'+' | b'-')));
        let whole = digits(end);
        end += whole;
        let mut fraction = 0;
        if bytes.get(end) == Some(&b'.') {
            fraction = digits(end + 1);
            end += 1 + fraction;
        }
        if whole + fraction == 0 {
            return Ok(None);
        }
        if matches!(bytes.get(end), Some(b'e' | b'E')) {
            let sign = usize::from(matches!(bytes.get(end + 1), Some(b'+' | b'-')));
            let exponent = digits((end + 1 + sign).min(bytes.len()));
            if exponent > 0 {
                end += 1 + sign + exponent;
            }
        }
        let read: Option<f64> = self.rest[..end].parse().ok();
        let read = read.filter(|read| read.is_finite()).ok_or_else(|| self.wrong("is no finite number"))?;
        self.rest = &self.rest[end..];
        Ok(Some(read))
    }

    fn needed(&mut self) -> Result<f64, Diagnostic> {
        self.number()?.ok_or_else(|| self.wrong("is where a number should stand"))
    }

    /// Reads a flag of an arc, 0 or 1, which needs no separator after it.
    fn flag(&mut self) -> Result<bool, Diagnostic> {
        self.skip_blank();
        let flag = match self.rest.as_bytes().first() {
            Some(b'0') => false,
            Some(b'1') => true,
            _ => return Err(self.wrong("is where a flag, 0 or 1, should stand")),
        };
        self.rest = &self.rest[1..];
        Ok(flag)
    }

    fn end(&mut self) -> Result<(), Diagnostic> {
        self.skip_blank();
        if self.rest.is_empty() { Ok(()) } else { Err(self.wrong("is nothing that is known")) }
    }
}

/// Corners of the only closed subpath of the path `data`.
fn path(data: &str, line: u32) -> Result<Corners, Diagnostic> {
    let mut tokens = Tokens { rest: data, line, key: "path.d" };
    let mut corners: Corners = Vec::new();
    let (mut at, mut is_closed) = ([0.0; 2], false);
    while let Some(letter) = tokens.letter() {
        let refuse =
            |reason: &str, expected: &str| Err(wrong_at("path.d", letter.to_string(), wrong(line, reason, expected)));
        let is_relative = letter.is_ascii_lowercase();
        let command = letter.to_ascii_uppercase();
        if is_closed || (command == 'M' && !corners.is_empty()) {
            return refuse("has a second subpath", "one: a cavity has no holes and is one piece");
        }
        if corners.is_empty() && command != 'M' {
            return refuse("begins without M", PATH);
        }
        if command == 'Z' {
            is_closed = true;
            continue;
        }
        // Further numbers after a command repeat the command.
        let mut next = Some(tokens.needed()?);
        while let Some(first) = next {
            let origin = if is_relative { at } else { [0.0; 2] };
            let point = |tokens: &mut Tokens<'_>| -> Result<[f64; 2], Diagnostic> {
                Ok([origin[0] + tokens.needed()?, origin[1] + tokens.needed()?])
            };
            at = match command {
                'M' | 'L' => {
                    let end = [origin[0] + first, origin[1] + tokens.needed()?];
                    corners.push(end);
                    end
                }
                'H' | 'V' => {
                    let end = if command == 'H' { [origin[0] + first, at[1]] } else { [at[0], origin[1] + first] };
                    corners.push(end);
                    end
                }
                'C' | 'Q' => {
                    let mut points = vec![at, [origin[0] + first, origin[1] + tokens.needed()?]];
                    for _ in 0..if command == 'C' { 2 } else { 1 } {
                        points.push(point(&mut tokens)?);
                    }
                    push_bezier(&mut corners, &points);
                    points[points.len() - 1]
                }
                'A' => {
                    let shape = ([first, tokens.needed()?], tokens.needed()?);
                    let flags = [tokens.flag()?, tokens.flag()?];
                    let end = point(&mut tokens)?;
                    push_arc(&mut corners, at, end, shape, flags);
                    end
                }
                _ => return refuse("is a command that is not read", PATH),
            };
            next = tokens.number()?;
        }
    }
    tokens.end()?;
    let ends = corners.first().zip(corners.last());
    if !is_closed && ends.is_none_or(|(first, last)| first != last) {
        return Err(wrong(line, "is not closed", "a path that ends with Z, or where it began"));
    }
    Ok(corners)
}
