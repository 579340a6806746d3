//! Report on an altitude map: parameters, cavities, pictures.

mod cavities;
mod files;
mod period;

pub use files::{FILES, Measured, files};
pub use period::{period_note, period_text};

use cavities::{Cavities, um};
use serde::{Serialize, Serializer};
use serde_json::json;
use slipgrid_base::monitor::Monitor;
use slipgrid_surface::topography::{HeightMap, MapError, PreparedMap, ShortWaves, SpectrumBin};

use slipgrid_base::units::tidy;
use slipgrid_design::results::{MadeBy, SCHEMA, SCREEN_WIDTH, Table, fixed, wrapped};
use slipgrid_io::formats::altitude_map::told;

/// Record that `surface --json` prints.
#[derive(Clone, Debug, Serialize)]
pub struct SurfaceReport {
    #[serde(flatten)]
    pub(crate) made_by: MadeBy,
    pub(crate) map: String,
    pub(crate) format: &'static str,
    /// The map file states that its surface is synthetic.
    pub(crate) synthetic_surface: bool,
    /// Points along y: number of lines in a file that stores one row per line.
    pub(crate) rows: usize,
    /// Points along x: number of values per line.
    pub(crate) columns: usize,
    /// Sides of a pixel along x and y.
    pub(crate) pixel_um: [f64; 2],
    pub(crate) missing_points: usize,
    pub(crate) model: Vec<String>,
    /// Warnings; each begins with its name.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub(crate) warnings: Vec<String>,
    #[serde(serialize_with = "by_key")]
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) filters: Filters,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) cavities: Option<Cavities>,
    /// Contribution of the shortest waves to the rms slope that the area law uses, with the map taken as one period;
    /// absent if it cannot be computed.
    #[serde(skip_serializing_if = "Option::is_none", serialize_with = "short_waves")]
    pub(crate) short_waves: Option<ShortWaves>,
    #[serde(serialize_with = "rings")]
    pub(crate) spectrum: Vec<SpectrumBin>,
}

/// F-operation and filters of ISO 25178-2 before the parameters are computed, and range of wavelengths in the map.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct Filters {
    /// Form that the F-operation removed: `mean`, `plane` or `second-order`.
    f_operation: &'static str,
    /// Nesting index of the S-filter; null, because no S-filter is applied.
    s_filter_um: Option<f64>,
    /// Nesting index of the L-filter; null, because no L-filter is applied.
    l_filter_um: Option<f64>,
    /// Shortest wavelength that the points resolve: two pixels of the longer side.
    shortest_wave_um: f64,
    /// Longest wavelength in the map: the longer side of the map.
    longest_wave_um: f64,
}

impl Filters {
    fn new(surface: &PreparedMap) -> Self {
        let map = &surface.map;
        let [dx_m, dy_m] = [map.dx_m(), map.dy_m()];
        Self {
            f_operation: surface.form.name(),
            s_filter_um: None,
            l_filter_um: None,
            shortest_wave_um: um(2.0 * dx_m.max(dy_m)),
            longest_wave_um: um((map.rows() as f64 * dx_m).max(map.cols() as f64 * dy_m)),
        }
    }

    /// States the F-operation, the filters and the range of wavelengths in one sentence.
    pub(crate) fn in_words(&self) -> String {
        let form = match self.f_operation {
            "plane" => "the least-squares plane",
            "second-order" => "the least-squares surface of second order",
            _ => "the mean alone",
        };
        format!(
            "F-operation: {form} removed; no S-filter and no L-filter applied: the parameters hold waves from {} um, two pixels, \
             to {} um, the longer side",
            self.shortest_wave_um, self.longest_wave_um
        )
    }
}

/// Serializes the shortest waves: upper limit of their wavelength (four pixels of the longer side), and their share of
/// the squared slope.
fn short_waves<S: Serializer>(short: &Option<ShortWaves>, serializer: S) -> Result<S::Ok, S::Error> {
    let record = |short: ShortWaves| json!({ "below_um": um(short.below_m), "slope_share": tidy(short.slope_share) });
    short.map(record).serialize(serializer)
}

/// Serializes a spectrum, one record per ring of wave vectors.
fn rings<S: Serializer>(spectrum: &[SpectrumBin], serializer: S) -> Result<S::Ok, S::Error> {
    let ring = |bin: &SpectrumBin| {
        json!({
            "wavelength_um": um(std::f64::consts::TAU / bin.q_per_m),
            "q_per_um": tidy(bin.q_per_m * 1e-6),
            "psd_um4": tidy(bin.psd_m4 * 1e24),
            "waves": bin.waves,
        })
    };
    serializer.collect_seq(spectrum.iter().map(ring))
}

/// Parameter of ISO 25178-2, or the rms slope that contact theories use.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Parameter {
    /// Key in the record.
    key: &'static str,
    /// Symbol in the standard.
    pub(crate) symbol: &'static str,
    /// Value in `unit`; `None` for Sal and Str if the autocorrelation does not fall to 0.2 within half the map.
    value: Option<f64>,
    pub(crate) unit: &'static str,
}

impl Parameter {
    /// Formats the value with four significant digits, or as a dash if it is unknown.
    pub(crate) fn digits(&self) -> String {
        self.value.map_or_else(|| "-".to_owned(), significant)
    }
}

/// Serializes parameters as a map from key to value.
fn by_key<S: Serializer>(parameters: &[Parameter], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(parameters.iter().map(|parameter| (parameter.key, parameter.value)))
}

impl SurfaceReport {
    /// Computes the parameters of the map `of`, read from `path`, and assembles the report with the other results.
    ///
    /// # Errors
    /// [`MapError::Cancelled`] once `monitor` cancels.
    pub fn new(path: &std::path::Path, of: &Measured, monitor: &dyn Monitor) -> Result<Self, MapError> {
        let Measured { surface, cavities, curve, lengths, spectrum } = of;
        let map = &surface.map;
        let heights = map.height_parameters(monitor)?;
        monitor.heed()?;
        let core = curve.core();
        monitor.heed()?;
        let sdq = map.rms_slope_finite_difference();
        monitor.heed()?;
        let mut model = surface.notes.clone();
        if surface.period {
            model.push("the map is one whole period: its sides continue each other".to_owned());
        } else {
            model.push("the spectrum is that of the map faded out to a circle (Hann window)".to_owned());
        }
        if lengths.block > 1 {
            model.push(format!("Sal and Str are those of blocks of {} x {} pixels", lengths.block, lengths.block));
        }
        let sdr_pct = 100.0 * map.sdr(monitor)?;
        let parameters = [
            ("sa_um", "Sa", Some(um(heights.sa_m)), "um"),
            ("sq_um", "Sq", Some(um(heights.sq_m)), "um"),
            ("ssk", "Ssk", Some(tidy(heights.ssk)), ""),
            ("sku", "Sku", Some(tidy(heights.sku)), ""),
            ("sp_um", "Sp", Some(um(heights.sp_m)), "um"),
            ("sv_um", "Sv", Some(um(heights.sv_m)), "um"),
            ("sz_um", "Sz", Some(um(heights.sz_m)), "um"),
            ("sdq", "Sdq", Some(tidy(sdq)), ""),
            // By the spectrum, as used by the area law.
            ("rms_slope", "rms slope", Some(tidy(surface.rms_slope)), ""),
            ("sdr_pct", "Sdr", Some(tidy(sdr_pct)), "%"),
            ("sk_um", "Sk", Some(um(core.sk_m)), "um"),
            ("spk_um", "Spk", Some(um(core.spk_m)), "um"),
            ("svk_um", "Svk", Some(um(core.svk_m)), "um"),
            ("smr1_pct", "Smr1", Some(tidy(100.0 * core.smr1)), "%"),
            ("smr2_pct", "Smr2", Some(tidy(100.0 * core.smr2)), "%"),
            ("sal_um", "Sal", lengths.sal_m.map(um), "um"),
            ("str", "Str", lengths.str_ratio.map(tidy), ""),
        ];
        let parameters = parameters.map(|(key, symbol, value, unit)| Parameter { key, symbol, value, unit }).to_vec();
        let short_waves = match map.short_waves(monitor) {
            Err(MapError::Cancelled) => return Err(MapError::Cancelled),
            found => found.ok(),
        };
        Ok(Self {
            made_by: MadeBy::slipgrid(SCHEMA),
            map: path.display().to_string(),
            format: surface.format.name(),
            synthetic_surface: surface.synthetic,
            rows: map.cols(),
            columns: map.rows(),
            pixel_um: [um(map.dx_m()), um(map.dy_m())],
            missing_points: surface.filled.iter().filter(|missing| **missing).count(),
            model,
            warnings: surface.warnings.iter().map(told).collect(),
            parameters,
            filters: Filters::new(surface),
            cavities: cavities.clone().map(Cavities),
            short_waves,
            spectrum: spectrum.clone(),
        })
    }

    /// Value of the parameter with the symbol `symbol`, in the unit of the parameter; `None` if unknown.
    pub(crate) fn parameter(&self, symbol: &str) -> Option<f64> {
        self.parameters.iter().find(|parameter| parameter.symbol == symbol)?.value
    }

    /// Formats the report as text.
    pub fn table(&self) -> String {
        let mut text = format!(
            "{}: {}, {}{} x {} pixels of {} x {} um\n",
            self.map,
            self.format,
            if self.synthetic_surface { "synthetic, " } else { "" },
            self.columns,
            self.rows,
            self.pixel_um[0],
            self.pixel_um[1],
        );
        text += &(crate::marked("-", &self.model) + &crate::marked("!", &self.warnings));
        // Two parameters a row, so that all fit on one screen.
        let cells = |of: &Parameter| [of.symbol.to_owned(), of.digits(), of.unit.to_owned()];
        let (left, right) = self.parameters.split_at(self.parameters.len().div_ceil(2));
        let mut table = Table::new(["parameter", "value", "", "parameter", "value"]);
        for (place, own) in left.iter().enumerate() {
            table.row(cells(own).into_iter().chain(right.get(place).into_iter().flat_map(cells)));
        }
        text += &format!("\n{table}");
        let mut explain = |words: &str| text += &(wrapped(&format!("  {words}"), SCREEN_WIDTH, "  ", 3) + "\n");
        explain(&self.filters.in_words());
        explain(
            "Sdq is by differences of neighbouring points; the rms slope is by the spectrum, of all waves that the map \
             resolves, and is the one that the area law takes",
        );
        if self.parameter("Str").is_none() {
            explain(
                "Str is not known: correlation does not fall to 0.2 in every direction within the map, as where a lay runs \
                 through it",
            );
        }
        if let Some(cavities) = &self.cavities {
            text += &cavities.table();
        }
        text
    }
}

/// Formats `value` with four significant digits.
fn significant(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    fixed(Some(value), (3 - value.abs().log10().floor() as i32).clamp(0, 12) as usize)
}

/// Formats the section along x through the pixels with the index `column` along y as CSV, one row per point, in
/// micrometres.
pub fn section_csv(map: &HeightMap, column: usize) -> String {
    let places: Vec<usize> = (0..map.rows()).collect();
    let mut table = Table::of(&places);
    table.numbers("x_um", |i| um(*i as f64 * map.dx_m()));
    table.numbers("height_um", |i| um(map.heights_m()[i * map.cols() + column]));
    table.table().csv()
}

/// Formats the power spectrum as CSV, one row per ring of wave vectors.
pub fn spectrum_csv(spectrum: &[SpectrumBin]) -> String {
    let mut table = Table::of(spectrum);
    table.numbers("q_per_um", |bin| tidy(bin.q_per_m * 1e-6));
    table.numbers("psd_um4", |bin| tidy(bin.psd_m4 * 1e24));
    table.numbers("waves", |bin| bin.waves);
    table.table().csv()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_digits_whatever_the_size() {
        for (value, text) in
            [(0.158_234, "0.1582"), (12.3456, "12.35"), (-0.80982, "-0.8098"), (0.0, "0"), (123_456.0, "123456")]
        {
            assert_eq!(significant(value), text);
        }
    }
}
