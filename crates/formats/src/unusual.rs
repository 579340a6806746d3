//! What is unusual in a scene and its material: told, not refused, because a scene may be a thought experiment.

use slipgrid_pattern::Rim;
use toml::Spanned;

use super::condition_ranges::ConditionRangeFile;
use super::document::Document;
use super::file_kind::FileKind;
use super::material::MaterialFile;
use super::pattern::TextureFile;
use super::rim::read_rim;
use super::scene::{DEFAULT_LAYER, SampleFile, SceneFile};
use super::values::{Number, Numbers, PathOr};
use crate::diagnostic::Diagnostic;
use crate::plausible::{DENSITY, FRICTION, GIVEN_PRESSURE, MODULUS, Plausible, SPEED, exchanged_forces, share_of_one};
use slipgrid_units::LENGTH_UM;

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
    told.extend(file.condition.as_ref().and_then(|at| of_share(document, &at.get_ref().humidity_pct)));
    told.extend(load.speed_mm_s.as_ref().and_then(|speed| number(document, SPEED, speed)));
    told.extend(numbers(document, GIVEN_PRESSURE, &load.pressure_mpa));
    if let Some(pattern) = &file.pattern {
        let texture = pattern.get_ref().texture();
        // What is no rim has been refused before.
        let rim = read_rim(document, &texture).ok().flatten().filter(Rim::stands);
        told.extend(of_rims(document, rim.as_ref(), &texture, file.sample.get_ref()));
    }
    told
}

/// Rims narrower than two blocks, of which blocks hold no more than the mean.
#[must_use]
pub fn of_rims(document: &Document, rim: Option<&Rim>, file: &TextureFile, sample: &SampleFile) -> Option<Diagnostic> {
    let (rim, width) = (rim?, file.rim_width_um.as_ref()?);
    let block_m = sample.block_um.as_ref().map_or(DEFAULT_LAYER.block_m, |um| LENGTH_UM.to_si(*um.get_ref()));
    let [block_um, smaller_um] = [block_m, rim.block_m(block_m)].map(|length_m| LENGTH_UM.from_si(length_m));
    (smaller_um < block_um).then(|| {
        let reason = format!(
            "is narrower than two blocks of {block_um} um: they hold no more than the mean height of a rim, and friction moves with its \
             crest"
        );
        document.refuse(width.span(), reason).expected(format!("block_um = {smaller_um} or less in [sample]"))
    })
}

/// Humidities that are likely shares of 1, the first of each of the `conditions` of a design.
pub fn of_shares<'c>(
    document: &Document,
    conditions: impl Iterator<Item = &'c Spanned<ConditionRangeFile>>,
) -> Vec<Diagnostic> {
    conditions.filter_map(|of| first(of.get_ref().humidity(), |value| of_share(document, value))).collect()
}

fn of_share(document: &Document, humidity: &Number) -> Option<Diagnostic> {
    let reason = share_of_one(*humidity.get_ref())?;
    Some(document.refuse(humidity.span(), format!("is {reason}")))
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
    told.extend(high_friction(document, file));
    told.extend(file.made_from.as_ref().and_then(|made| made.changed(document)));
    told
}

/// The first dynamic coefficient, where nearly all are so high that friction force and normal force are likely exchanged.
fn high_friction(document: &Document, file: &MaterialFile) -> Option<Diagnostic> {
    let friction = file.friction.get_ref();
    let each = friction.conditions.iter().map(|table| &table.get_ref().dynamic_mean);
    let all: Vec<&Spanned<Numbers>> = each.chain(friction.dynamic_mean.as_ref()).collect();
    let values = |of: &Spanned<Numbers>| match of.get_ref() {
        Numbers::One(value) => vec![*value],
        Numbers::Each(each) => each.iter().map(|value| *value.get_ref()).collect(),
    };
    let means: Vec<f64> = all.iter().flat_map(|of| values(of)).collect();
    Some(document.refuse(all.first()?.span(), exchanged_forces(&means)?))
}

fn number(document: &Document, quantity: Plausible, value: &Number) -> Option<Diagnostic> {
    let written = *value.get_ref();
    (written != 0.0).then(|| quantity.tell(written, || document.refuse(value.span(), ""))).flatten()
}

/// What is unusual in the first of `values` that is: a list is told once.
fn numbers(document: &Document, quantity: Plausible, values: &Spanned<Numbers>) -> Option<Diagnostic> {
    first(values, |value| number(document, quantity, value))
}

/// What `tell` says of the first of `values` of which it says anything.
fn first(values: &Spanned<Numbers>, tell: impl Fn(&Number) -> Option<Diagnostic>) -> Option<Diagnostic> {
    match values.get_ref() {
        Numbers::One(value) => tell(&Spanned::new(values.span(), *value)),
        Numbers::Each(each) => each.iter().find_map(tell),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_humidity_of_1_and_below_is_asked_about_but_not_that_of_dry_air() {
        let told = |humidity: &str| -> Vec<String> {
            let document = Document::new("a.toml", format!("speed_mm_s = 5.0\nhumidity_pct = {humidity}"));
            let range: ConditionRangeFile = document.parse().unwrap();
            of_shares(&document, std::iter::once(&Spanned::new(0..0, range)))
                .iter()
                .map(Diagnostic::to_string)
                .collect()
        };
        let share = "is at most 1 %, and only dried gas has so little; as a share of 1, that would be";
        assert_eq!(told("0.2"), [format!("a.toml:2: humidity_pct: 0.2 {share} 20 %")]);
        assert_eq!(told("[0.45, 45.0]"), [format!("a.toml:2: humidity_pct: 0.45 {share} 45 %")]);
        for usual in ["0", "1.5", "45.0", "[20, 80]"] {
            assert_eq!(told(usual), [""; 0], "{usual}");
        }
    }

    #[test]
    fn coefficients_of_a_material_that_are_all_above_1_are_asked_about() {
        let told = |dynamic: &str| -> Vec<String> {
            let text = format!("youngs_modulus_gpa = 0.4\ndensity_g_cm3 = 0.9\n[friction]\n{dynamic}");
            let document = Document::new("m.toml", text);
            of_material(&document, &document.parse().unwrap()).iter().map(Diagnostic::to_string).collect()
        };
        let said = told("static_mean = 2.8\ndynamic_mean = 2.5");
        assert!(said.len() == 1 && said[0].starts_with("m.toml:5: friction.dynamic_mean: 2.5 is unusual"), "{said:?}");
        assert!(said[0].contains("in each other's place, friction would be 0.4"), "{said:?}");
        assert_eq!(told("static_mean = 0.3\ndynamic_mean = 0.25"), [""; 0]);
    }

    #[test]
    fn rims_narrower_than_two_blocks_are_told_with_the_block_size_that_would_do() {
        let told = |pattern: &str, sample: &str| {
            let document = Document::new("a.toml", format!("{pattern}\nrim_profile = \"flat\""));
            let file: TextureFile = document.parse().unwrap();
            let sample: SampleFile = toml::from_str(sample).unwrap();
            let rim = read_rim(&document, &file).unwrap().filter(Rim::stands);
            of_rims(&document, rim.as_ref(), &file, &sample).map(|told| told.to_string())
        };
        let rim = |height: f64, width: f64| format!("rim_height_um = {height}\nrim_width_um = {width}");
        for (width, sample, block) in
            [(10.0, "", "5"), (12.0, "", "5"), (6.0, "", "2.5"), (7.5, "block_um = 7.5", "3.75")]
        {
            let said = told(&rim(0.1, width), sample).unwrap();
            assert!(
                said.starts_with("a.toml:2: rim_width_um: ") && said.contains("narrower than two blocks"),
                "{said}"
            );
            assert!(said.ends_with(&format!("expected block_um = {block} or less in [sample]")), "{said}");
        }
        for (height, width, sample) in [(0.1, 20.0, ""), (0.1, 10.0, "block_um = 5"), (0.0, 1.0, "")] {
            assert_eq!(told(&rim(height, width), sample), None, "{width}");
        }
    }
}
