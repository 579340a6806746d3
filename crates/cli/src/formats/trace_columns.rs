//! Columns of a tribometer export: what a name means, and its unit.

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Time.
    Time,
    /// Torque about the axis.
    Torque,
    /// Friction force.
    FrictionForce,
    /// Normal force on the sample holder.
    NormalForce,
    /// Sliding speed.
    Speed,
    /// Revolutions per time.
    Revolutions,
    /// Relative humidity.
    Humidity,
    /// Number of the repeat.
    Repeat,
}

impl Channel {
    /// How many there are.
    pub const COUNT: usize = 8;

    /// A trace cannot be read without columns of this kind.
    #[must_use]
    pub const fn is_needed(self) -> bool {
        matches!(self, Self::Time | Self::Torque | Self::FrictionForce | Self::NormalForce)
    }

    /// Names of such a column, small letters and digits alone.
    const fn names(self) -> &'static [&'static str] {
        match self {
            Self::Time => &["time", "t", "timestamp", "elapsedtime", "testtime", "zeit", "temps", "tempo"],
            Self::Torque => &["torque", "tz", "mz", "frictiontorque", "moment", "drehmoment", "reibmoment", "coppia"],
            Self::FrictionForce => &[
                "frictionforce",
                "friction",
                "ff",
                "fx",
                "ft",
                "fr",
                "tangentialforce",
                "lateralforce",
                "reibkraft",
                "forcetangentielle",
            ],
            Self::NormalForce => {
                &["normalforce", "fz", "fn", "load", "normalload", "normalkraft", "forcenormale", "verticalforce"]
            }
            Self::Speed => &["speed", "velocity", "slidingspeed", "slidingvelocity", "v", "geschwindigkeit"],
            Self::Revolutions => {
                &["rpm", "revolutions", "rotationspeed", "rotationalspeed", "spindlespeed", "drehzahl"]
            }
            Self::Humidity => &["humidity", "rh", "relativehumidity", "luftfeuchte", "feuchte"],
            Self::Repeat => &["repeat", "repetition", "run", "test", "cycle", "wiederholung"],
        }
    }

    /// What it is called in messages.
    const fn title(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Torque => "torque",
            Self::FrictionForce => "friction force",
            Self::NormalForce => "normal force",
            Self::Speed => "speed",
            Self::Revolutions => "revolutions",
            Self::Humidity => "humidity",
            Self::Repeat => "number of the repeat",
        }
    }

    /// Its units, as people write them.
    const fn unit_words(self) -> &'static str {
        match self {
            Self::Time => "s, ms, min or h",
            Self::Torque => "N m, mN m, N cm or N mm",
            Self::FrictionForce | Self::NormalForce => "N, mN, kN, gf or kgf",
            Self::Speed => "mm/s, m/s, cm/s, um/s, m/min or rpm",
            Self::Revolutions => "rpm, 1/min, rev/min or 1/s",
            Self::Humidity => "%, %RH or pct",
            Self::Repeat => "a column without a unit",
        }
    }

    /// Units and what turns them into SI; the first is taken where none is given.
    const fn units(self) -> &'static [(&'static str, f64)] {
        const MINUTE: f64 = 60.0;
        const GRAM_FORCE: f64 = 9.806_65e-3;
        const FORCE: &[(&str, f64)] =
            &[("n", 1.0), ("mn", 1e-3), ("kn", 1e3), ("gf", GRAM_FORCE), ("kgf", 1e3 * GRAM_FORCE)];
        match self {
            Self::Time => &[("s", 1.0), ("sec", 1.0), ("seconds", 1.0), ("ms", 1e-3), ("min", MINUTE), ("h", 3600.0)],
            Self::Torque => &[("nm", 1.0), ("mnm", 1e-3), ("ncm", 1e-2), ("nmm", 1e-3)],
            Self::FrictionForce | Self::NormalForce => FORCE,
            Self::Speed => &[
                ("mms", 1e-3),
                ("ms", 1.0),
                ("cms", 1e-2),
                ("ums", 1e-6),
                ("rpm", 1.0 / MINUTE),
                ("mmin", 1.0 / MINUTE),
            ],
            Self::Revolutions => {
                &[("rpm", 1.0 / MINUTE), ("1min", 1.0 / MINUTE), ("revmin", 1.0 / MINUTE), ("1s", 1.0)]
            }
            Self::Humidity => &[("pct", 1e-2), ("%", 1e-2), ("rh", 1e-2), ("%rh", 1e-2), ("percent", 1e-2)],
            Self::Repeat => &[("", 1.0)],
        }
    }

    const ALL: [Self; Self::COUNT] = [
        Self::Time,
        Self::Torque,
        Self::FrictionForce,
        Self::NormalForce,
        Self::Speed,
        Self::Revolutions,
        Self::Humidity,
        Self::Repeat,
    ];
}

/// A unit that a column's quantity does not have.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownUnit {
    /// The column, as the file writes it.
    pub name: String,
    /// The unit, as the file writes it.
    unit: String,
    channel: Channel,
}

impl UnknownUnit {
    /// What is wrong, and what would be accepted.
    #[must_use]
    pub fn words(&self) -> [String; 2] {
        let (unit, title) = (&self.unit, self.channel.title());
        let letters = unit_letters(unit);
        let is_known = Channel::ALL.iter().any(|channel| channel.units().iter().any(|(name, _)| *name == letters));
        let reason = if is_known {
            format!("has the unit \"{unit}\", which is none of {title}")
        } else {
            format!("has the unit \"{unit}\", which is not known")
        };
        [reason, self.channel.unit_words().to_owned()]
    }
}

/// A column that is used.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// What it holds.
    pub channel: Channel,
    name: String,
    factor: f64,
}

impl Column {
    /// Its name, as the file writes it.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// A number of the column in SI units; the sign of a zero or of a conversion is not its concern.
    #[must_use]
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.factor
    }

    /// Takes a unit from a line below the names; nothing where the cell is empty.
    ///
    /// # Errors
    /// The unit, where it is not known.
    pub fn set_unit(&mut self, cell: &str) -> Result<(), UnknownUnit> {
        let unit = unit_letters(cell);
        if unit.is_empty() {
            return Ok(());
        }
        self.factor = self.factor_of(&unit).ok_or_else(|| UnknownUnit {
            name: self.name.clone(),
            unit: cell.trim().trim_matches(['[', ']', '(', ')', '{', '}', '"']).trim().to_owned(),
            channel: self.channel,
        })?;
        Ok(())
    }

    fn factor_of(&mut self, unit: &str) -> Option<f64> {
        // A speed in revolutions is of the axis.
        if self.channel == Channel::Speed && matches!(unit, "rpm" | "1min") {
            self.channel = Channel::Revolutions;
        }
        self.channel.units().iter().find(|(name, _)| *name == unit).map(|(_, factor)| *factor)
    }
}

/// What each name of a header means; `None` where it is not used.
///
/// # Errors
/// [`UnknownUnit`] of a column that is used and whose unit is not known.
pub fn columns(cells: &[&str]) -> Result<Vec<Option<Column>>, UnknownUnit> {
    cells.iter().map(|cell| column(cell)).collect()
}

fn column(cell: &str) -> Result<Option<Column>, UnknownUnit> {
    let written = cell.trim_matches('"').trim();
    // The whole as a name comes first: `normal_force` has no unit.
    if let Some(channel) = channel(written) {
        return Ok(Some(Column { channel, name: written.to_owned(), factor: channel.units()[0].1 }));
    }
    // The unit stands in brackets, behind a slash, or behind an underscore.
    let mut unknown = None;
    for (at, _) in written.char_indices().filter(|(_, letter)| matches!(letter, '[' | '(' | '{' | '/' | '_')) {
        let Some(channel) = channel(&written[..at]) else { continue };
        let mut column = Column { channel, name: written.to_owned(), factor: channel.units()[0].1 };
        match column.set_unit(&written[at + 1..]) {
            Ok(()) => return Ok(Some(column)),
            Err(unit) => unknown = Some(unit),
        }
    }
    unknown.map_or(Ok(None), Err)
}

fn channel(name: &str) -> Option<Channel> {
    let bare: String = name.chars().filter(char::is_ascii_alphanumeric).map(|c| c.to_ascii_lowercase()).collect();
    Channel::ALL.into_iter().find(|channel| channel.names().contains(&bare.as_str()))
}

/// A unit without brackets, dots, spaces and signs: `[N·m]` is `nm`, `mm/s` is `mms`.
fn unit_letters(cell: &str) -> String {
    let kept = cell.chars().filter(|c| c.is_alphanumeric() || *c == '%');
    kept.map(|c| if matches!(c, 'µ' | 'μ') { 'u' } else { c.to_ascii_lowercase() }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_units_of_several_houses() {
        for (written, channel, factor) in [
            ("time_s", Channel::Time, 1.0),
            ("Time [ms]", Channel::Time, 1e-3),
            ("Elapsed time (min)", Channel::Time, 60.0),
            ("Tz", Channel::Torque, 1.0),
            ("Tz (N·m)", Channel::Torque, 1.0),
            ("Torque/mNm", Channel::Torque, 1e-3),
            ("torque_nmm", Channel::Torque, 1e-3),
            ("\"Drehmoment [N cm]\"", Channel::Torque, 1e-2),
            ("friction_force_n", Channel::FrictionForce, 1.0),
            ("Fx(mN)", Channel::FrictionForce, 1e-3),
            ("normal_force", Channel::NormalForce, 1.0),
            ("Fz [kN]", Channel::NormalForce, 1e3),
            ("speed_mm_s", Channel::Speed, 1e-3),
            ("Sliding speed (m/s)", Channel::Speed, 1.0),
            ("speed [rpm]", Channel::Revolutions, 1.0 / 60.0),
            ("RH [%]", Channel::Humidity, 1e-2),
            ("humidity_pct", Channel::Humidity, 1e-2),
            ("run", Channel::Repeat, 1.0),
        ] {
            let found = column(written).unwrap().unwrap_or_else(|| panic!("{written}"));
            assert_eq!((found.channel, found.factor), (channel, factor), "{written}");
        }
        for other in ["COF", "Temperature [C]", "Z-position (mm)", ""] {
            assert_eq!(column(other), Ok(None), "{other}");
        }
        for (written, reason, expected) in [
            ("Fz [psi]", "has the unit \"psi\", which is not known", "N, mN, kN, gf or kgf"),
            ("Tz (N)", "has the unit \"N\", which is none of torque", "N m, mN m, N cm or N mm"),
            ("Fz [N m]", "has the unit \"N m\", which is none of normal force", "N, mN, kN, gf or kgf"),
        ] {
            let unknown = column(written).unwrap_err();
            assert_eq!((unknown.name.as_str(), unknown.words()), (written, [reason, expected].map(String::from)));
        }
    }
}
