//! Warnings of unusual values in a scene and its material, and of cavities. Nothing is refused, because a scene may be a
//! thought experiment.

use std::ops::Range;

use slipgrid_infer::calibrate::STATIC_OVER_DYNAMIC;
use slipgrid_model::material::Elastic;
use slipgrid_model::pattern::Rim;
use slipgrid_model::springblock::{Fidelity, RunOptions, Scene, max_run_speed_m_s};

use super::material::MaterialFile;
use super::pattern::PatternFile;
use super::scene::{DEFAULT_LAYER, LoadFile, SampleFile, SceneFile};
use super::target::ConditionRangeFile;
use super::values::{Number, Numbers, number_span};
use crate::formats::plausible::{
    CAVITY_DEPTH, CAVITY_WIDTH, DENSITY, FRICTION, GIVEN_PRESSURE, MODULUS, Plausible, RIM_HEIGHT, SPEED, STRAIN,
    exchanged_forces, share_of_one, stiff_for_its_density,
};
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{
    HUMIDITY_PCT, LENGTH_UM, MODULUS_GPA, PRESSURE_MPA, SPEED_MM_S, in_digits, significant, significant_to, tidy,
};

/// Warnings for the scene `file` of `document`, except for the material, whose Young's modulus is `modulus_gpa`.
pub fn of_scene(document: &Document, file: &SceneFile, modulus_gpa: f64) -> Vec<Diagnostic> {
    let mut told = Vec::new();
    let load = file.load.get_ref();
    told.extend(file.condition.as_ref().and_then(|at| {
        let humidity_pct = HUMIDITY_PCT.from_si(at.get_ref().humidity);
        of_share(document, &Spanned::new(document.value_span(&at.span(), "humidity_pct"), humidity_pct))
    }));
    told.extend(load.speed_mm_s.as_ref().and_then(|speed| number(document, SPEED, speed)));
    told.extend(of_pressures(document, &load.pressure_mpa, modulus_gpa));
    if let Some(pattern) = &file.pattern {
        let record = &pattern.get_ref().texture.record;
        // Invalid rims have been refused before.
        let rim = record.rim().ok().flatten().filter(Rim::stands);
        told.extend(of_rims(document, rim.as_ref(), &pattern.span(), file.sample.get_ref()));
    }
    told
}

/// Appends the probable intended unit of `pressure_mpa`, if any, to `expected`, the description of accepted pressures.
pub fn with_slip(expected: &str, pressure_mpa: f64) -> String {
    GIVEN_PRESSURE.slip(pressure_mpa).map_or_else(|| expected.to_owned(), |slip| format!("{expected}; {slip}"))
}

/// Warning of the first nominal pressure that strains a material of `modulus_gpa` more than solids bear, otherwise of
/// the first unusual pressure; `None` if all are usual.
pub fn of_pressures(document: &Document, pressures: &Spanned<Numbers>, modulus_gpa: f64) -> Option<Diagnostic> {
    let strained = |value: &Number| {
        let (pressure_mpa, modulus_mpa) = (*value.get_ref(), 1e3 * modulus_gpa);
        let strain = pressure_mpa / modulus_mpa;
        let usual = STRAIN.judge(strain).ok().flatten()?;
        let most_mpa = (STRAIN.usual[1] * modulus_mpa).min(GIVEN_PRESSURE.usual[1]);
        let slip = GIVEN_PRESSURE.within([GIVEN_PRESSURE.usual[0], most_mpa]).slip(pressure_mpa);
        let slip = slip.map_or_else(String::new, |slip| format!("; {slip}"));
        let [strain, modulus_mpa] = [significant(strain, 2), tidy(modulus_mpa)].map(in_digits);
        let reason = format!("MPa is {strain} of Young's modulus, {modulus_mpa} MPa: this {usual}{slip}");
        Some(document.refuse(value.span(), reason))
    };
    first(pressures, strained).or_else(|| first(pressures, |value| number(document, GIVEN_PRESSURE, value)))
}

/// Reason and accepted range for a speed that is too high for any run in time at this pressure; `None` for a lower
/// speed.
pub fn too_fast(elastic: &Elastic, pressure_pa: f64, speed_m_s: f64) -> Option<[String; 2]> {
    let most_m_s = max_run_speed_m_s(elastic, pressure_pa);
    (speed_m_s > most_m_s).then(|| {
        let reason = format!(
            "{} mm/s is too fast at {} MPa with E = {} GPa",
            tidy(SPEED_MM_S.from_si(speed_m_s)),
            significant(PRESSURE_MPA.from_si(pressure_pa), 3),
            tidy(MODULUS_GPA.from_si(elastic.youngs_modulus_pa()))
        );
        let most_mm_s = significant_to(SPEED_MM_S.from_si(most_m_s), 2, f64::floor);
        [reason, format!("speed_mm_s of at most {most_mm_s}, or higher pressures")]
    })
}

/// Warning of a speed of `scene` that is too high for its run in time, unless the scene has more than the default
/// damping, which suppresses waves; otherwise `None`.
pub fn of_speed(document: &Document, load: &LoadFile, scene: &Scene) -> Option<Diagnostic> {
    let runs = scene.run.fidelity != Fidelity::Steady && scene.run.damping <= RunOptions::default().damping;
    let loaded = scene.loads.iter().map(|load| load.pressure_pa).filter(|pressure_pa| *pressure_pa > 0.0);
    let lightest_pa = loaded.filter(|_| runs).reduce(f64::min)?;
    let [reason, expected] = too_fast(&scene.elastic, lightest_pa, scene.speed_m_s)?;
    let place = load.speed_mm_s.as_ref().map_or(load.pressure_mpa.span(), Spanned::span);
    let told = document.refuse(place, format!("{reason}: the run ends as sliding_waves"));
    Some(Diagnostic { value: None, ..told }.expected(expected))
}

/// Warning of rims of the pattern in `table` that are higher than usual after laser cutting, or narrower than two
/// blocks, which then resolve only the mean height of a rim; `None` for other rims.
pub fn of_rims(
    document: &Document,
    rim: Option<&Rim>,
    table: &Range<usize>,
    sample: &SampleFile,
) -> Option<Diagnostic> {
    let rim = rim?;
    let height_um = LENGTH_UM.from_si(rim.heights_m().iter().map(|[_, height_m]| *height_m).fold(0.0, f64::max));
    let place = |key| document.refuse(document.value_span(table, key), "");
    let key = if rim.heights_m().len() > 1 { "rim_heights_um" } else { "rim_height_um" };
    if let Some(told) = RIM_HEIGHT.tell(height_um, || place(key)) {
        return Some(told);
    }
    let block_m = sample.block_um.as_ref().map_or(DEFAULT_LAYER.block_m, |um| LENGTH_UM.to_si(*um.get_ref()));
    let [block_um, smaller_um] = [block_m, rim.block_m(block_m)].map(|length_m| LENGTH_UM.from_si(length_m));
    (smaller_um < block_um).then(|| {
        let reason = format!(
            "is narrower than two blocks of {block_um} um: they hold no more than the mean height of a rim, and friction moves with its \
             crest"
        );
        document.refuse(document.value_span(table, "rim_width_um"), reason).expected(format!("block_um = {smaller_um} or less in [sample]"))
    })
}

/// Warnings of humidities that are probably fractions of 1, one for each of the `conditions` of a design that has any.
pub fn of_shares<'c>(
    document: &Document,
    conditions: impl Iterator<Item = &'c Spanned<ConditionRangeFile>>,
) -> Vec<Diagnostic> {
    conditions.filter_map(|of| first(&of.get_ref().humidity_pct, |value| of_share(document, value))).collect()
}

fn of_share(document: &Document, humidity: &Number) -> Option<Diagnostic> {
    let reason = share_of_one(*humidity.get_ref())?;
    Some(document.refuse(humidity.span(), format!("is {reason}")))
}

/// Warnings for a material. Values of zero give no warning, because zero has a meaning of its own.
pub fn of_material(document: &Document, file: &MaterialFile) -> Vec<Diagnostic> {
    let bulk = [(MODULUS, &file.youngs_modulus_gpa), (DENSITY, &file.density_g_cm3)];
    let mut told: Vec<Diagnostic> =
        bulk.into_iter().filter_map(|(quantity, value)| number(document, quantity, value)).collect();
    let stiff = stiff_for_its_density(*file.youngs_modulus_gpa.get_ref(), *file.density_g_cm3.get_ref());
    told.extend(stiff.map(|reason| document.refuse(file.youngs_modulus_gpa.span(), reason)));
    let friction = file.friction.get_ref();
    let tables = friction.conditions.iter().map(|table| (&table.get_ref().static_mean, &table.get_ref().dynamic_mean));
    let pairs: Vec<_> = tables.chain(friction.static_mean.as_ref().zip(friction.dynamic_mean.as_ref())).collect();
    let means = pairs.iter().flat_map(|(at_rest, sliding)| [at_rest, sliding]);
    told.extend(means.filter_map(|mean| first(mean, |value| number(document, FRICTION, value))));
    told.extend(pairs.iter().filter_map(|(at_rest, sliding)| of_static(document, at_rest, sliding)));
    let sliding: Vec<&Spanned<Numbers>> = pairs.iter().map(|(_, sliding)| *sliding).collect();
    told.extend(high_friction(document, &sliding));
    told.extend(file.made_from.as_ref().and_then(|made| made.changed(document)));
    told
}

/// Warning about the first static coefficient whose ratio to the dynamic coefficient lies outside the range that
/// calibrations find; `None` if there is none. Blocks slide one after another, so the peak of a specimen is lower than
/// that of its blocks: a peak of twice dynamic friction, the highest accepted in tables of measurements, needs blocks
/// whose static coefficient is three times the dynamic coefficient.
fn of_static(document: &Document, at_rest: &Spanned<Numbers>, sliding: &Spanned<Numbers>) -> Option<Diagnostic> {
    let [least, most] = STATIC_OVER_DYNAMIC;
    let (at_rest_values, sliding) = (at_rest.get_ref().written(), sliding.get_ref().written());
    let mut pairs = at_rest_values.iter().zip(sliding.iter().cycle()).enumerate();
    let is_found =
        |mean: f64, dynamic: f64| mean <= 0.0 || dynamic <= 0.0 || (least..=most).contains(&(mean / dynamic));
    let (place, (mean, dynamic)) = pairs.find(|(_, (mean, dynamic))| !is_found(**mean, **dynamic))?;
    let reason = format!(
        "is {} times the dynamic coefficient beside it, {}, which no calibration finds: friction at rest is hardly below that of sliding, \
         and with more than {most} times of it no specimen slides at once",
        in_digits(significant(mean / dynamic, 3)),
        in_digits(*dynamic),
    );
    let of = |times: f64| in_digits(tidy(times * dynamic));
    let expected = format!("{} to {}, {least} to {most} times dynamic_mean", of(least), of(most));
    Some(document.refuse(number_span(at_rest, place), reason).expected(expected))
}

/// Warning at the first of the dynamic coefficients `sliding`, if nearly all are so high that friction force and normal
/// force are probably swapped; otherwise `None`.
fn high_friction(document: &Document, sliding: &[&Spanned<Numbers>]) -> Option<Diagnostic> {
    let means: Vec<f64> = sliding.iter().flat_map(|of| of.get_ref().written()).collect();
    Some(document.refuse(sliding.first()?.span(), exchanged_forces(&means)?))
}

/// Warning of an unusual `value` other than zero; `None` for a usual one.
fn number(document: &Document, quantity: Plausible, value: &Number) -> Option<Diagnostic> {
    let written = Some(*value.get_ref()).filter(|written| *written != 0.0)?;
    quantity.tell(written, || document.refuse(value.span(), ""))
}

/// Returns the first warning that `tell` gives for a number of `values`, so that a list gets at most one warning; `None`
/// if there is none.
fn first(values: &Spanned<Numbers>, tell: impl Fn(&Number) -> Option<Diagnostic>) -> Option<Diagnostic> {
    match values.get_ref() {
        Numbers::One(value) => tell(&Spanned::new(values.span(), *value)),
        Numbers::Each(each) => each.iter().find_map(tell),
    }
}

/// Warns of lengths in the `table` that no cut cavity has.
pub fn of_cavity(document: &Document, table: &Spanned<PatternFile>) -> Vec<Diagnostic> {
    let file = table.get_ref();
    let length = file.texture.record.length_um;
    let length = length.map(|length| Spanned::new(document.value_span(&table.span(), "length_um"), length));
    let lengths = [
        (CAVITY_WIDTH, Some(&file.width_um)),
        (CAVITY_WIDTH, Some(&file.spacing_um)),
        (CAVITY_WIDTH, length.as_ref()),
        (CAVITY_DEPTH, Some(&file.depth_um)),
    ];
    lengths.into_iter().filter_map(|(quantity, length)| number(document, quantity, length?)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::pattern::TextureFile;

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
    fn static_friction_that_no_calibration_finds_is_told_of() {
        let told = |friction: &str| -> Vec<String> {
            let text = format!("youngs_modulus_gpa = 0.4\ndensity_g_cm3 = 0.9\n[friction]\n{friction}");
            let document = Document::new("m.toml", text);
            of_material(&document, &document.parse().unwrap()).iter().map(Diagnostic::to_string).collect()
        };
        let said = told("static_mean = 3.0\ndynamic_mean = 0.27");
        assert!(
            said.len() == 1 && said[0].starts_with("m.toml:4: friction.static_mean: 3.0 is 11.1 times"),
            "{said:?}"
        );
        assert!(said[0].contains("expected 0.243 to 0.945"), "{said:?}");
        let said = told("pressure_mpa = [1.0, 2.0]\nstatic_mean = [0.3, 0.2]\ndynamic_mean = [0.27, 0.27]");
        assert!(
            said.len() == 1 && said[0].contains("0.2 is 0.741 times the dynamic coefficient beside it, 0.27"),
            "{said:?}"
        );
        let table = "[[friction.conditions]]\nspeed_mm_s = 1.0\nhumidity_pct = 30.0\npressure_mpa = [1.0]\nstatic_mean = [0.1]\n\
                     dynamic_mean = [0.2]";
        assert!(told(table)[0].starts_with("m.toml:8: friction.conditions.static_mean: 0.1"), "{:?}", told(table));
        // A measured peak of twice dynamic friction needs three times at the blocks.
        assert_eq!(told("static_mean = 0.81\ndynamic_mean = 0.27"), [""; 0]);
    }

    #[test]
    fn nominal_pressures_that_strain_a_solid_too_much_are_told_of() {
        let told = |pressures: &str| {
            let document = Document::new("d.toml", format!("pressure_mpa = {pressures}"));
            let file: std::collections::HashMap<String, Spanned<Numbers>> = document.parse().unwrap();
            of_pressures(&document, &file["pressure_mpa"], 0.8).map(|told| told.to_string())
        };
        let said = told("[1.0, 390.0]").unwrap();
        assert!(said.starts_with("d.toml:1: pressure_mpa: 390.0 MPa is 0.49 of Young's modulus, 800 MPa"), "{said}");
        assert!(
            said.contains("mostly lie from 0 to 0.05") && said.contains("in kPa, that would be 0.39 MPa"),
            "{said}"
        );
        assert_eq!(told("[1.0, 39.0]"), None);
    }

    #[test]
    fn rims_narrower_than_two_blocks_are_told_with_the_block_size_that_would_do() {
        let told = |pattern: &str, sample: &str| {
            let document = Document::new("a.toml", format!("{pattern}\nrim_profile = \"flat\""));
            let file: TextureFile = document.parse().unwrap();
            let sample: SampleFile = toml::from_str(sample).unwrap();
            let rim = file.record.rim().unwrap().filter(Rim::stands);
            of_rims(&document, rim.as_ref(), &(0..0), &sample).map(|told| told.to_string())
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
        let said = told(&rim(300.0, 20.0), "").unwrap();
        assert!(
            said.starts_with("a.toml:1: rim_height_um: 300") && said.ends_with("in nm, that would be 0.3 um"),
            "{said}"
        );
        for (height, width, sample) in [(0.1, 20.0, ""), (0.1, 10.0, "block_um = 5"), (0.0, 1.0, "")] {
            assert_eq!(told(&rim(height, width), sample), None, "{width}");
        }
    }

    fn said(text: &str) -> Vec<String> {
        let document = Document::new("c.toml", text);
        of_cavity(&document, &document.parse().unwrap()).iter().map(ToString::to_string).collect()
    }

    #[test]
    fn millimetres_in_place_of_micrometres_are_asked_about() {
        let said = said("width_um = 0.08\nspacing_um = 0.16\ndepth_um = 0.001\n");
        assert_eq!(said.len(), 3, "{said:?}");
        assert!(
            said[0].starts_with("c.toml:1: width_um: 0.08 is unusual")
                && said[0].ends_with("in mm, that would be 80 um")
        );
        assert!(said[1].ends_with("in mm, that would be 160 um"), "{said:?}");
        assert!(said[2].starts_with("c.toml:3: depth_um: 0.001") && said[2].ends_with("in mm, that would be 1 um"));
    }

    #[test]
    fn lengths_that_are_cut_are_not_told() {
        for text in [
            "width_um = 130.0\nspacing_um = 372.0\ndepth_um = 5.2\n",
            "width_um = 5.0\nspacing_um = 10.0\ndepth_um = 0.5\nlength_um = 8000.0\n",
        ] {
            assert_eq!(said(text), [""; 0]);
        }
    }
}
