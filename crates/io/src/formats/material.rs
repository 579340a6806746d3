//! Material tables: inline in a scene or design, or in a separate file, with the same keys.

use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use slipgrid_infer::calibrate::area_law::table_warnings;
use slipgrid_infer::calibrate::uncertainty::MaterialUncertainty;
use slipgrid_model::material::{AreaLaw, Elastic, Material, Provenance};

use super::file_kind::FileKind;
use super::friction::{FlatFrictionTable, FrictionFile, read_flat_friction, read_friction};
use super::learned::LearnedFile;
use super::made_from::MadeFrom;
use super::unusual;
use super::values::{Number, NumberList, PathOr, column, increasing, number_list};
use crate::formats::source::Entry;
use crate::formats::{Diagnostic, Document, Spanned};
use slipgrid_base::units::{
    DENSITY_G_CM3, FACTOR, FACTOR_STD, FRACTION, LENGTH_UM, MODULUS_GPA, MODULUS_STD_GPA, POISSON, PRESSURE_MPA, SLOPE,
    significant_to, tidy,
};
use slipgrid_design::KnownMaterial;
use slipgrid_design::results::VERSION;

/// A material in the form of its file.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MaterialFile {
    /// The material's name.
    pub name: Option<String>,
    /// Publication or laboratory that the values come from.
    pub source: Option<String>,
    /// Version of the file's schema; 1 when absent.
    pub schema: Option<Spanned<u32>>,
    /// Version of the program that wrote the file.
    pub slipgrid_version: Option<String>,
    /// The surface behind the area law is synthetic, not measured; false when absent.
    pub synthetic_surface: Option<bool>,
    /// Provenance of the values.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub notes: Vec<String>,
    /// Warnings of doubtful results that depend on the material; each begins with the name of the warning.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub warnings: Vec<String>,
    /// Young's modulus.
    pub youngs_modulus_gpa: Number,
    /// Standard deviation of Young's modulus.
    pub youngs_modulus_std_gpa: Option<Number>,
    /// Density.
    pub density_g_cm3: Number,
    /// Contact pressure at which rims flatten permanently; without the key, rims are elastic.
    pub yield_pressure_mpa: Option<Number>,
    /// Local friction coefficients, those of the contact blocks.
    pub friction: Spanned<FrictionFile>,
    /// Area law; without this table, friction is proportional to load (Amontons-Coulomb).
    pub area_law: Option<Spanned<AreaLawFile>>,
    /// Dynamic friction of flat samples as measured, per condition. If this friction contradicts the area law, the data
    /// do not show whether local friction follows the local or the nominal pressure.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub flat_friction: Vec<Spanned<FlatFrictionTable>>,
    /// Discrepancy between measured and modelled friction ratios, learned from trials; applies to any texture.
    pub learned: Option<Spanned<LearnedFile>>,
    /// The calibration from which the file was made.
    pub made_from: Option<MadeFrom>,
}

/// An area law in the form of a file.
#[derive(Clone, Debug, Default, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AreaLawFile {
    /// Source of the law: `map`, `persson`, `fit`, or `measured` for flat friction itself.
    pub origin: Option<String>,
    /// Rms slope of the surface for which the law was computed.
    pub rms_slope: Option<Number>,
    /// Arithmetic mean height Sa of the map.
    pub sa_um: Option<Number>,
    /// Pixel size of the map along the sliding direction.
    pub pixel_um: Option<Number>,
    /// Pixel size of the map across the sliding direction; as along the sliding direction when absent.
    pub pixel_y_um: Option<Number>,
    /// Poisson's ratio of the contact computation.
    pub poisson_ratio: Option<Number>,
    /// Pressures at which the law is tabulated.
    pub pressure_mpa: NumberList,
    /// Area factors f, one per pressure: real contact area over the area that proportionality to pressure would give.
    pub factor: NumberList,
    /// Standard errors of the factors, from the scatter between windows of the map.
    pub factor_std: Option<NumberList>,
    /// Real over nominal contact area, one per pressure, from which the factors were computed.
    pub area_fraction: Option<NumberList>,
}

impl MaterialFile {
    /// Creates the file form of a material from elasticity, friction and provenance; all other keys stay absent.
    pub(crate) fn new(elastic: &Elastic, provenance: &Provenance, friction: FrictionFile) -> Self {
        let named = |text: &String| Some(text.clone()).filter(|text| !text.is_empty());
        Self {
            name: named(&provenance.name),
            source: named(&provenance.source),
            slipgrid_version: Some(VERSION.to_owned()),
            synthetic_surface: Some(provenance.synthetic_surface),
            notes: provenance.notes.clone(),
            warnings: provenance.warnings.clone(),
            youngs_modulus_gpa: MODULUS_GPA.from_si(elastic.youngs_modulus_pa()).into(),
            density_g_cm3: DENSITY_G_CM3.from_si(elastic.density_kg_m3()).into(),
            yield_pressure_mpa: elastic.yield_pressure_pa().map(|pa| PRESSURE_MPA.from_si(pa).into()),
            friction: friction.into(),
            ..Self::default()
        }
    }
}

impl AreaLawFile {
    /// Converts `law` to its file form, with factors rounded by `digits`; keys about the origin of the law stay absent.
    pub(crate) fn new(law: &AreaLaw, digits: fn(f64) -> f64) -> Self {
        let rounded = |values: &[f64]| number_list(values.iter().map(|&value| digits(value)));
        Self {
            pressure_mpa: number_list(law.pressures_pa().iter().map(|&p| PRESSURE_MPA.from_si(p))),
            factor: rounded(law.factors()),
            factor_std: law.factor_std().map(rounded),
            ..Self::default()
        }
    }
}

/// Resolves `path`, which `key` names relative to the folder of `document`.
///
/// # Errors
/// [`Diagnostic`] at the key if the file does not exist.
pub fn existing<T>(document: &Document, key: &Spanned<T>, path: &str) -> Result<std::path::PathBuf, Diagnostic> {
    let path = document.resolve(path);
    let reason = match document.source().entry(&path) {
        Ok(Entry::File) => return Ok(path),
        Ok(_) => "is not a file".to_owned(),
        Err(error) => format!("cannot be read: {error}"),
    };
    let refused = document.refuse(key.span(), format!("({}) {reason}", path.display()));
    Err(refused.expected("the path of a file, relative to this one"))
}

/// Reads the material and its uncertainty from `file` in `document`; `place` is the span of the whole table.
///
/// # Errors
/// [`Diagnostic`] for any refused input.
pub fn read_known(
    document: &Document,
    file: &MaterialFile,
    place: &Range<usize>,
) -> Result<(Material, MaterialUncertainty), Diagnostic> {
    document.check_schema(file.schema.as_ref())?;
    let youngs_modulus_pa = document.number(&file.youngs_modulus_gpa, MODULUS_GPA)?;
    let modulus_std_pa = document.optional(file.youngs_modulus_std_gpa.as_ref(), MODULUS_STD_GPA)?;
    check_modulus_std(document, *file.youngs_modulus_gpa.get_ref(), file.youngs_modulus_std_gpa.as_ref())?;
    let density_kg_m3 = document.number(&file.density_g_cm3, DENSITY_G_CM3)?;
    let yield_pressure_pa = document.optional(file.yield_pressure_mpa.as_ref(), PRESSURE_MPA)?;
    let elastic = Elastic::new(youngs_modulus_pa, density_kg_m3)
        .and_then(|elastic| elastic.with_yield_pressure_pa(yield_pressure_pa))
        .map_err(|error| document.refuse(place.clone(), error.to_string()))?;
    let (friction, of_friction) = read_friction(document, &file.friction)?;
    let area_law = file.area_law.as_ref().map(|law| read_area_law(document, law)).transpose()?;
    let origin = file.area_law.as_ref().and_then(|law| law.get_ref().origin.as_deref());
    let uncertainty = MaterialUncertainty {
        modulus_relative_std: modulus_std_pa.map(|std_pa| std_pa / youngs_modulus_pa),
        law_is_fitted: origin == Some("fit"),
        law_is_measured: origin == Some("measured"),
        flat_friction: read_flat_friction(document, &file.flat_friction)?,
        learned: file.learned.as_ref().map(|table| LearnedFile::read(document, table)).transpose()?,
        ..of_friction
    };
    let mut warnings = file.warnings.clone();
    // Warnings that the file states about its law are not repeated.
    let named = |warning: &str| warning.split(':').next().map(str::to_owned);
    let told = |warning: &String| file.warnings.iter().any(|known| named(known) == named(warning));
    // A measured law may rise with pressure, because it does not describe contact area.
    let laws = area_law.iter().filter(|_| !uncertainty.law_is_measured);
    warnings.extend(laws.flat_map(table_warnings).filter(|warning| !told(warning)));
    let provenance = Provenance {
        name: file.name.clone().unwrap_or_default(),
        source: file.source.clone().unwrap_or_default(),
        synthetic_surface: file.synthetic_surface.unwrap_or(false),
        notes: file.notes.clone(),
        warnings,
    };
    Ok((Material { elastic, friction, area_law, provenance }, uncertainty))
}

/// Reads the material and its uncertainty from the table or the file that a key of `document` gives. Also returns
/// warnings of unusual values.
///
/// # Errors
/// [`Diagnostic`] if a file cannot be read, or for any refused input.
pub fn read_referenced(
    document: &Document,
    material: &Spanned<PathOr<MaterialFile>>,
) -> Result<(KnownMaterial, Vec<Diagnostic>), Diagnostic> {
    let read = |document: &Document, file: &MaterialFile, place: &Range<usize>| {
        let (material, uncertainty) = read_known(document, file, place)?;
        Ok((KnownMaterial { material, uncertainty }, unusual::of_material(document, file)))
    };
    match material.get_ref() {
        PathOr::Table(table) => read(document, table, &material.span()),
        PathOr::Path(path) => {
            let named = Document::read(document.source(), &existing(document, material, path)?, FileKind::Material)?;
            read(&named, &named.parse()?, &(0..0))
        }
    }
}

/// Refuses a standard deviation of Young's modulus that is not below the modulus, because such a modulus determines
/// nothing.
pub(crate) fn check_modulus_std(document: &Document, modulus_gpa: f64, std: Option<&Number>) -> Result<(), Diagnostic> {
    let Some(std) = std.filter(|std| *std.get_ref() >= modulus_gpa) else { return Ok(()) };
    let reason = format!("leaves Young's modulus of {modulus_gpa} GPa open altogether");
    Err(document.refuse(std.span(), reason).expected("a standard deviation below the modulus, in GPa"))
}

/// Relative decrease of tabulated contact area between two pressures that is accepted, because tables may be rounded to
/// three digits.
const AREA_TOLERANCE: f64 = 5e-3;

fn read_area_law(document: &Document, file: &Spanned<AreaLawFile>) -> Result<AreaLaw, Diagnostic> {
    let law = file.get_ref();
    let pressure_pa = increasing(document, &law.pressure_mpa, PRESSURE_MPA)?;
    let count = pressure_pa.len();
    let factor = column(document, &law.factor, FACTOR, count, "pressure")?;
    // A scene would end with the status `no_friction`, and a design would have nothing to search.
    let nil = law.factor.get_ref().iter().find(|factor| *factor.get_ref() <= 0.0);
    if let Some(nil) = nil.filter(|_| document.is_meant_as(FileKind::Design)) {
        return Err(document
            .refuse(nil.span(), "leaves no contact and no friction, and nothing to compare a pattern with")
            .expected("a positive factor at every pressure"));
    }
    if law.origin.as_deref() != Some("measured") {
        refuse_falling_area(document, &law.factor, &pressure_pa, &factor)?;
    }
    for (about, quantity) in [
        (&law.rms_slope, SLOPE),
        (&law.sa_um, LENGTH_UM),
        (&law.pixel_um, LENGTH_UM),
        (&law.pixel_y_um, LENGTH_UM),
        (&law.poisson_ratio, POISSON),
    ] {
        document.optional(about.as_ref(), quantity)?;
    }
    if let Some(area_fraction) = &law.area_fraction {
        column(document, area_fraction, FRACTION, count, "pressure")?;
    }
    let factor_std = law.factor_std.as_ref().map(|list| column(document, list, FACTOR_STD, count, "pressure"));
    let factor_std = factor_std.transpose()?;
    let read = AreaLaw::new(pressure_pa, factor).and_then(|law| match factor_std {
        Some(factor_std) => law.with_factor_std(factor_std),
        None => Ok(law),
    });
    read.map_err(|error| document.refuse(file.span(), error.to_string()))
}

/// Refuses factors by which contact area, which is proportional to pressure times factor, decreases from one pressure
/// to the next.
fn refuse_falling_area(
    document: &Document,
    file: &NumberList,
    pressure_pa: &[f64],
    factor: &[f64],
) -> Result<(), Diagnostic> {
    let area: Vec<f64> = pressure_pa.iter().zip(factor).map(|(pressure_pa, factor)| pressure_pa * factor).collect();
    let falls = |pair: &[f64]| pair[1] < (1.0 - AREA_TOLERANCE) * pair[0];
    let Some(place) = area.windows(2).position(falls) else { return Ok(()) };
    let [from_mpa, to_mpa] = [place, place + 1].map(|place| tidy(PRESSURE_MPA.from_si(pressure_pa[place])));
    let least = significant_to(factor[place] * pressure_pa[place] / pressure_pa[place + 1], 3, f64::ceil);
    let reason = format!(
        "makes contact area fall to {:.2} times from {from_mpa} to {to_mpa} MPa; real contact area never falls with pressure",
        area[place + 1] / area[place]
    );
    let span = file.get_ref().get(place + 1).map_or(file.span(), Spanned::span);
    Err(document.refuse(span, reason).expected(format!("a factor of at least {least} at {to_mpa} MPa")))
}
