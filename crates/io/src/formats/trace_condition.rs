//! Conditions of traces: the sample, its load and speed, and the files of its repeats.

use std::path::PathBuf;

/// The surface of a specimen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfaceKind {
    /// Flat.
    Flat,
    /// Patterned.
    Patterned,
}

impl SurfaceKind {
    /// All kinds of surface.
    pub const ALL: [Self; 2] = [Self::Flat, Self::Patterned];

    /// Name used in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Flat => "flat",
            Self::Patterned => "patterned",
        }
    }
}

/// Trial of a calibration to which traces belong.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OfTrial {
    /// Number in the file, counted from 1.
    pub number: usize,
    /// Name of the trial.
    pub name: String,
}

/// An export, and the step in it that belongs to a condition.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Export {
    /// The file.
    pub path: PathBuf,
    /// Step to read, by the instrument's number; `None` for the whole file.
    pub step: Option<u32>,
}

impl Export {
    /// The whole file at `path`.
    #[must_use]
    pub const fn whole(path: PathBuf) -> Self {
        Self { path, step: None }
    }

    /// The name of the file.
    pub(crate) fn name(&self) -> String {
        self.path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
    }
}

/// Traces of one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct TraceCondition {
    /// Flat or patterned.
    pub surface: SurfaceKind,
    /// Trial that was measured, if any.
    pub trial: Option<OfTrial>,
    /// Nominal normal force on one specimen, in newtons.
    pub force_n: f64,
    /// Sliding speed, in m/s.
    pub speed_m_s: f64,
    /// Relative humidity, 0 to 1.
    pub humidity: f64,
    /// Averaging window, in seconds since the first row.
    pub window_s: [f64; 2],
    /// Fraction in the middle of every stroke that is averaged, if the sample slides back and forth.
    pub stroke_share: Option<f64>,
    /// Span before touchdown whose mean forces are subtracted as the zero of the sensors, in seconds since the first
    /// row.
    pub zero_s: Option<[f64; 2]>,
    /// Place in the order of all runs, if given.
    pub order: Option<f64>,
    /// Exports, in the order of their names.
    pub files: Vec<Export>,
    /// Exports that `exclude` left out.
    pub excluded: Vec<PathBuf>,
}

impl TraceCondition {
    /// Whether `other` is a repeat: equal condition, sample and options.
    #[must_use]
    pub fn is_repeated_by(&self, other: &Self) -> bool {
        let Self { files, excluded, order, .. } = other.clone();
        Self { files, excluded, order, ..self.clone() } == *other
    }

    /// Describes the sample: `flat sample`, or the name of a trial.
    #[must_use]
    pub fn sample(&self) -> String {
        self.trial
            .as_ref()
            .map_or_else(|| format!("{} sample", self.surface.name()), |trial| format!("trial \"{}\"", trial.name))
    }
}
