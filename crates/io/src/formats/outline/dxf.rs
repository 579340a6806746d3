//! Reads closed outlines from text DXF drawings.
//!
//! Autodesk, "Drawing Interchange and File Formats", Release 12: pairs of a group code and a value, each on a separate
//! line; sections; entities that begin with group 0 and stand on the layer of group 8. LWPOLYLINE was added in Release
//! 14.

use std::collections::BTreeSet;

use super::curves::{ellipse, push_bulge};
use super::{Corners, only, wrong, wrong_at};
use crate::formats::Diagnostic;

const EXPECTED: &str = "one closed POLYLINE, LWPOLYLINE or CIRCLE on the layer, of text DXF";
const STRICT: &str = "text DXF: a group code and its value in turn, each on a line of its own, from a section to EOF";

/// A group: code and value, with the line of the value.
#[derive(Clone, Copy)]
struct Group<'a> {
    code: i32,
    value: &'a str,
    line: u32,
}

impl Group<'_> {
    fn number(&self) -> Result<f64, Diagnostic> {
        let read: Option<f64> = self.value.parse().ok();
        read.filter(|value| value.is_finite()).ok_or_else(|| {
            let refused = wrong(self.line, "is no finite number", "a decimal number");
            wrong_at(&format!("group {}", self.code), self.value, refused)
        })
    }
}

/// An entity: its kind and its groups.
struct Entity<'a> {
    kind: &'a str,
    line: u32,
    groups: Vec<Group<'a>>,
}

impl Entity<'_> {
    fn find(&self, code: i32) -> Option<&Group<'_>> {
        self.groups.iter().find(|group| group.code == code)
    }

    fn layer(&self) -> &str {
        self.find(8).map_or("0", |group| group.value)
    }

    fn number(&self, code: i32) -> Result<Option<f64>, Diagnostic> {
        self.find(code).map(Group::number).transpose()
    }

    fn needed(&self, code: i32) -> Result<f64, Diagnostic> {
        let missing = || wrong(self.line, format!("{} without group {code}", self.kind), EXPECTED);
        self.number(code)?.ok_or_else(missing)
    }
}

/// Corners of the only closed outline on `layer`, or in the drawing if `layer` is `None`, and the line in which the
/// outline begins.
pub(super) fn outline(text: &str, layer: Option<&str>) -> Result<(Corners, u32), Diagnostic> {
    if text.starts_with("AutoCAD Binary DXF") {
        return Err(wrong(None, "is a binary DXF drawing", STRICT));
    }
    let entities = entities(text)?;
    let mut found = Vec::new();
    let mut others = BTreeSet::new();
    let mut place = 0;
    while let Some(entity) = entities.get(place) {
        place += 1;
        let mut own = &entities[place..place];
        if entity.kind == "POLYLINE" {
            // Vertices follow their polyline up to SEQEND.
            let vertices = entities[place..].iter().take_while(|entity| entity.kind == "VERTEX").count();
            own = &entities[place..place + vertices];
            place += vertices;
            if entities.get(place).is_none_or(|entity| entity.kind != "SEQEND") {
                return Err(wrong(entity.line, "is a POLYLINE without SEQEND", EXPECTED));
            }
            place += 1;
        }
        if layer.is_none_or(|layer| entity.layer() == layer) {
            found.push((corners(entity, own)?, entity.line));
        } else {
            others.insert(entity.layer());
        }
    }
    if let (true, Some(layer)) = (found.is_empty(), layer) {
        let others = Vec::from_iter(others).join(", ");
        let named = if others.is_empty() { "no layer at all" } else { &others };
        let refused = wrong(None, format!("holds nothing on that layer, but on {named}"), EXPECTED);
        return Err(wrong_at("layer", layer, refused));
    }
    only(found, EXPECTED)
}

/// Reads the entities of the section ENTITIES.
fn entities(text: &str) -> Result<Vec<Entity<'_>>, Diagnostic> {
    let mut lines = text.lines().zip(1_u32..);
    let mut entities: Vec<Entity<'_>> = Vec::new();
    // Sections begin with group 0 SECTION and their name in group 2.
    let (mut is_named_next, mut is_within, mut is_ended) = (false, false, false);
    while let Some((code, line)) = lines.next() {
        if is_ended {
            if code.trim().is_empty() { continue } else { break }
        }
        let refuse = |reason: &str| wrong_at("group", code.trim(), wrong(line, reason, STRICT));
        let number = code.trim().parse::<i32>().map_err(|_| refuse("is no group code"))?;
        let (value, line) = lines.next().ok_or_else(|| refuse("has no value after it"))?;
        let group = Group { code: number, value: value.trim(), line };
        match (group.code, group.value) {
            (0, "SECTION") => is_named_next = true,
            (2, name) if is_named_next => (is_within, is_named_next) = (name == "ENTITIES", false),
            (0, "ENDSEC") => is_within = false,
            (0, "EOF") => is_ended = true,
            (0, kind) if is_within => entities.push(Entity { kind, line, groups: Vec::new() }),
            _ if is_within => {
                if let Some(entity) = entities.last_mut() {
                    entity.groups.push(group);
                }
            }
            _ => {}
        }
    }
    if is_ended { Ok(entities) } else { Err(wrong(None, "ends before EOF", STRICT)) }
}

/// Corners of an entity; those of a POLYLINE are given by the `vertices`, the entities that follow it.
fn corners(entity: &Entity<'_>, vertices: &[Entity<'_>]) -> Result<Corners, Diagnostic> {
    // Bit 1: closed. Bit 128 (linetypes) does not affect the shape; curve fits, meshes and polylines in space do.
    let flags = entity.number(70)?.unwrap_or(0.0);
    let is_closed = flags.rem_euclid(2.0) == 1.0;
    let points: Vec<([f64; 2], f64)> = match entity.kind {
        "CIRCLE" => {
            let radius = entity.needed(40)?;
            return Ok(ellipse([entity.needed(10)?, entity.needed(20)?], [radius; 2]));
        }
        "POLYLINE" => {
            if ![0.0, 1.0, 128.0, 129.0].contains(&flags) {
                let reason = "is a fitted curve, a mesh or a polyline in space";
                return Err(wrong_at("group 70", flags.to_string(), wrong(entity.line, reason, EXPECTED)));
            }
            let point =
                |vertex: &Entity<'_>| Ok(([vertex.needed(10)?, vertex.needed(20)?], vertex.number(42)?.unwrap_or(0.0)));
            vertices.iter().map(point).collect::<Result<_, Diagnostic>>()?
        }
        "LWPOLYLINE" => {
            let mut points: Vec<([f64; 2], f64)> = Vec::new();
            for group in &entity.groups {
                match (group.code, points.last_mut()) {
                    (10, _) => points.push(([group.number()?, f64::NAN], 0.0)),
                    (20, Some((point, _))) => point[1] = group.number()?,
                    (42, Some((_, bulge))) => *bulge = group.number()?,
                    _ => {}
                }
            }
            points
        }
        kind => return Err(wrong_at("group 0", kind, wrong(entity.line, "is no closed outline", EXPECTED))),
    };
    let ends = points.first().zip(points.last()).map(|(first, last)| [first.0, last.0]);
    if !is_closed && ends.is_some_and(|[first, last]| first != last) {
        return Err(wrong(entity.line, format!("is a {} that is not closed", entity.kind), EXPECTED));
    }
    let mut out: Corners = points.first().map(|(first, _)| vec![*first]).unwrap_or_default();
    for (from, to) in points.iter().zip(points.iter().skip(1).chain(points.first().filter(|_| is_closed))) {
        push_bulge(&mut out, from.0, to.0, from.1);
    }
    Ok(out)
}
