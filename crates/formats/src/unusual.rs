//! What is unusual in a scene and its material: told, not refused, because a scene may be a thought experiment.

use toml::Spanned;

use super::document::Document;
use super::file_kind::FileKind;
use super::material::MaterialFile;
use super::scene::SceneFile;
use super::values::{Number, Numbers, PathOr};
use crate::diagnostic::Diagnostic;
use crate::plausible::{DENSITY, FRICTION, MODULUS, PRESSURE, Plausible, SPEED};

/// What is unusual in the scene `file` of `document`, its material included; numbers of nil have a meaning of their own.
#[must_use]
pub fn of_scene(document: &Document, file: &SceneFile) -> Vec<Diagnostic> {
    let mut told = match file.material.get_ref() {
        PathOr::Table(table) => of_material(document, table),
        PathOr::Path(path) => {
            // What cannot be read has been refused before.
            let named = Document::read(document.source(), &document.resolve(path), FileKind::Material).ok();
            named.and_then(|named| Some(of_material(&named, &named.parse::<MaterialFile>().ok()?))).unwrap_or_default()
        }
    };
    let load = file.load.get_ref();
    told.extend(load.speed_mm_s.as_ref().and_then(|speed| number(document, SPEED, speed)));
    told.extend(numbers(document, PRESSURE, &load.pressure_mpa));
    told
}

/// What is unusual in a material.
#[must_use]
pub fn of_material(document: &Document, file: &MaterialFile) -> Vec<Diagnostic> {
    let bulk = [(MODULUS, &file.youngs_modulus_gpa), (DENSITY, &file.density_g_cm3)];
    let mut told: Vec<Diagnostic> =
        bulk.into_iter().filter_map(|(quantity, value)| number(document, quantity, value)).collect();
    let friction = file.friction.get_ref();
    let pairs = friction.conditions.iter().map(|table| {
        let table = table.get_ref();
        (Some(&table.static_mean), Some(&table.dynamic_mean))
    });
    let pairs = pairs.chain([(friction.static_mean.as_ref(), friction.dynamic_mean.as_ref())]);
    for mean in pairs.flat_map(|(at_rest, sliding)| [at_rest, sliding]).flatten() {
        told.extend(numbers(document, FRICTION, mean));
    }
    told
}

fn number(document: &Document, quantity: Plausible, value: &Number) -> Option<Diagnostic> {
    let written = *value.get_ref();
    (written != 0.0).then(|| quantity.tell(written, || document.refuse(value.span(), ""))).flatten()
}

/// The first of `values` that is unusual: a list is told once.
fn numbers(document: &Document, quantity: Plausible, values: &Spanned<Numbers>) -> Option<Diagnostic> {
    match values.get_ref() {
        Numbers::One(value) => number(document, quantity, &Spanned::new(values.span(), *value)),
        Numbers::Each(each) => each.iter().find_map(|value| number(document, quantity, value)),
    }
}
