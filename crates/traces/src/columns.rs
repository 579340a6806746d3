//! Columns of a tribometer export: what a name means, and its unit.

use crate::cells::unquoted;

/// What a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Time.
    Time,
    /// Torque about the axis.
    Torque,
    /// Friction force.
    FrictionForce,
    /// Friction coefficient, as the instrument computed it; used where there is neither a torque nor a friction force.
    Coefficient,
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
    /// Position along the way of sliding, or the way itself; not used without a known unit.
    Position,
}

impl Channel {
    /// How many there are.
    pub const COUNT: usize = 10;

    /// A trace cannot be read without some of these columns.
    #[must_use]
    pub const fn is_needed(self) -> bool {
        matches!(self, Self::Time | Self::Torque | Self::FrictionForce | Self::Coefficient | Self::NormalForce)
    }

    /// Names of such a column, small letters and digits alone.
    #[must_use]
    pub const fn names(self) -> &'static [&'static str] {
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
            Self::Coefficient => &[
                "cof",
                "mu",
                "\u{3bc}",
                "frictioncoefficient",
                "coefficientoffriction",
                "coeffoffriction",
                "frictioncoeff",
                "reibungskoeffizient",
                "reibkoeffizient",
                "reibungszahl",
                "reibwert",
                "coefficientdefrottement",
            ],
            Self::NormalForce => {
                &["normalforce", "fz", "fn", "load", "normalload", "normalkraft", "forcenormale", "verticalforce"]
            }
            Self::Speed => &["speed", "velocity", "slidingspeed", "slidingvelocity", "v", "geschwindigkeit"],
            Self::Revolutions => {
                &["rpm", "revolutions", "rotationspeed", "rotationalspeed", "spindlespeed", "drehzahl"]
            }
            Self::Humidity => &["humidity", "rh", "relativehumidity", "luftfeuchte", "feuchte"],
            Self::Repeat => &["repeat", "repetition", "run", "test", "wiederholung"],
            Self::Position => &[
                "position",
                "pos",
                "x",
                "displacement",
                "stroke",
                "distance",
                "slidingdistance",
                "weg",
                "gleitweg",
                "hub",
                "deplacement",
            ],
        }
    }

    /// The key that gives a title of one's own for it.
    #[must_use]
    pub fn key(self) -> String {
        match self {
            Self::Repeat => "repeat".to_owned(),
            channel => channel.title().replace(' ', "_"),
        }
    }

    /// What it is called in messages.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Time => "time",
            Self::Torque => "torque",
            Self::FrictionForce => "friction force",
            Self::Coefficient => "friction coefficient",
            Self::NormalForce => "normal force",
            Self::Speed => "speed",
            Self::Revolutions => "revolutions",
            Self::Humidity => "humidity",
            Self::Repeat => "number of the repeat",
            Self::Position => "position",
        }
    }

    /// Its units, as people write them.
    #[must_use]
    pub const fn unit_words(self) -> &'static str {
        match self {
            Self::Time => "s, ms, us, min or h",
            Self::Torque => "N m, mN m, uN m, kN m, N cm, N mm, kgf m, kgf cm, gf cm, lbf in or lbf ft",
            Self::FrictionForce | Self::NormalForce => "N, mN, uN, kN, daN, gf, kgf, kp or lbf",
            Self::Speed => "mm/s, m/s, cm/s, um/s, mm/min, cm/min, m/min, um/min, km/h or those of revolutions",
            Self::Revolutions => "rpm, 1/min, r/min, rev/min, U/min, 1/s, rps, rev/s, Hz or rad/s",
            Self::Humidity => "%, %RH, %rF, pct or percent",
            Self::Position => "mm, m, cm, um or nm",
            Self::Coefficient | Self::Repeat => "a column without a unit",
        }
    }

    /// Units and what turns them into SI; the first is taken where none is given.
    const fn units(self) -> &'static [(&'static str, f64)] {
        const MINUTE: f64 = 60.0;
        const GRAM_FORCE: f64 = 9.806_65e-3;
        const POUND_FORCE: f64 = 4.448_221_615_260_5;
        const INCH: f64 = 25.4e-3;
        const FORCE: &[(&str, f64)] = &[
            ("n", 1.0),
            ("newton", 1.0),
            ("newtons", 1.0),
            ("mn", 1e-3),
            ("un", 1e-6),
            ("kn", 1e3),
            ("dan", 10.0),
            ("gf", GRAM_FORCE),
            ("kgf", 1e3 * GRAM_FORCE),
            ("kp", 1e3 * GRAM_FORCE),
            ("lbf", POUND_FORCE),
        ];
        match self {
            Self::Time => &[
                ("s", 1.0),
                ("sec", 1.0),
                ("secs", 1.0),
                ("second", 1.0),
                ("seconds", 1.0),
                ("ms", 1e-3),
                ("msec", 1e-3),
                ("milliseconds", 1e-3),
                ("us", 1e-6),
                ("min", MINUTE),
                ("mins", MINUTE),
                ("minutes", MINUTE),
                ("h", 3600.0),
                ("hr", 3600.0),
                ("hours", 3600.0),
            ],
            Self::Torque => &[
                ("nm", 1.0),
                ("mnm", 1e-3),
                ("unm", 1e-6),
                ("knm", 1e3),
                ("ncm", 1e-2),
                ("nmm", 1e-3),
                ("kgfm", 1e3 * GRAM_FORCE),
                ("kgfcm", 10.0 * GRAM_FORCE),
                ("gfcm", 1e-2 * GRAM_FORCE),
                ("lbfin", POUND_FORCE * INCH),
                ("inlbf", POUND_FORCE * INCH),
                ("lbfft", 12.0 * POUND_FORCE * INCH),
                ("ftlbf", 12.0 * POUND_FORCE * INCH),
            ],
            Self::FrictionForce | Self::NormalForce => FORCE,
            Self::Speed => &[
                ("mms", 1e-3),
                ("ms", 1.0),
                ("cms", 1e-2),
                ("ums", 1e-6),
                ("mmin", 1.0 / MINUTE),
                ("mmmin", 1e-3 / MINUTE),
                ("cmmin", 1e-2 / MINUTE),
                ("ummin", 1e-6 / MINUTE),
                ("kmh", 1.0 / 3.6),
            ],
            Self::Revolutions => &[
                ("rpm", 1.0 / MINUTE),
                ("1min", 1.0 / MINUTE),
                ("min1", 1.0 / MINUTE),
                ("rmin", 1.0 / MINUTE),
                ("umin", 1.0 / MINUTE),
                ("revmin", 1.0 / MINUTE),
                ("1s", 1.0),
                ("s1", 1.0),
                ("hz", 1.0),
                ("rps", 1.0),
                ("revs", 1.0),
                ("rads", 1.0 / std::f64::consts::TAU),
            ],
            Self::Humidity => &[
                ("pct", 1e-2),
                ("%", 1e-2),
                ("rh", 1e-2),
                ("%rh", 1e-2),
                ("rh%", 1e-2),
                ("%rf", 1e-2),
                ("pctrh", 1e-2),
                ("percent", 1e-2),
            ],
            Self::Coefficient => &[("", 1.0), ("1", 1.0)],
            Self::Repeat => &[("", 1.0)],
            Self::Position => &[("mm", 1e-3), ("m", 1.0), ("cm", 1e-2), ("um", 1e-6), ("nm", 1e-9)],
        }
    }

    /// What turns numbers without a unit into SI; of a position no number, as a title like `x` may be of anything.
    const fn usual_factor(self) -> f64 {
        if matches!(self, Self::Position) { f64::NAN } else { self.units()[0].1 }
    }

    /// All of them.
    pub const ALL: [Self; Self::COUNT] = [
        Self::Time,
        Self::Torque,
        Self::FrictionForce,
        Self::Coefficient,
        Self::NormalForce,
        Self::Speed,
        Self::Revolutions,
        Self::Humidity,
        Self::Repeat,
        Self::Position,
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
        let of = |channel: Channel| channel.units().iter().find(|(name, _)| *name == unit).map(|(_, factor)| *factor);
        // A speed in revolutions is of the axis.
        if self.channel == Channel::Speed
            && let Some(factor) = of(Channel::Revolutions)
        {
            self.channel = Channel::Revolutions;
            return Some(factor);
        }
        of(self.channel)
    }
}

/// The unit stands in brackets, behind a slash, or behind an underscore.
const UNIT_MARKS: [char; 5] = ['[', '(', '{', '/', '_'];

/// Titles of one's own for what columns hold, beside those that are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Titles(Vec<Title>);

/// A title, its letters alone, with the factor of its unit.
#[derive(Clone, Debug, PartialEq)]
struct Title {
    channel: Channel,
    letters: String,
    factor: f64,
}

impl Titles {
    /// Takes `title` for columns of `channel`, which no other title means from now on. The unit in its brackets is that of columns which
    /// name none; without it the first of [`Channel::unit_words`].
    ///
    /// # Errors
    /// [`UnknownUnit`] in its brackets.
    pub fn name(&mut self, channel: Channel, title: &str) -> Result<(), UnknownUnit> {
        let written = unquoted(title);
        let (name, unit) = written.find(['[', '(', '{']).map_or((written, ""), |at| written.split_at(at));
        let mut column = Column { channel, name: written.to_owned(), factor: channel.usual_factor() };
        column.set_unit(unit)?;
        self.0.push(Title { channel: column.channel, letters: letters(name), factor: column.factor });
        Ok(())
    }

    /// Whether columns of a channel have a title of one's own.
    #[must_use]
    pub fn has_own(&self, channel: Channel) -> bool {
        self.0.iter().any(|title| title.channel == channel)
    }

    /// What may be the name in a title: the whole, and what stands before a bracket, a slash or an underscore; letters and digits alone.
    #[must_use]
    pub fn letters_of(title: &str) -> Vec<String> {
        let written = unquoted(title);
        let cuts = written.char_indices().filter(|(_, letter)| UNIT_MARKS.contains(letter)).map(|(at, _)| at);
        cuts.chain([written.len()]).map(|at| letters(&written[..at])).collect()
    }

    /// The titles of a channel as messages list them.
    #[must_use]
    pub fn of(&self, channel: Channel) -> String {
        let own: Vec<&str> =
            self.0.iter().filter(|title| title.channel == channel).map(|title| &title.letters[..]).collect();
        if own.is_empty() {
            channel.names()[..channel.names().len().min(3)].join(", ") + ", ..."
        } else {
            format!("{}, as `columns` says", own.join(", "))
        }
    }

    /// What a name means, and the factor of the unit that it has where none stands beside it.
    fn meaning(&self, name: &str) -> Option<(Channel, f64)> {
        let letters = letters(name);
        if let Some(own) = self.0.iter().find(|title| title.letters == letters) {
            return Some((own.channel, own.factor));
        }
        let known = Channel::ALL.into_iter().find(|channel| channel.names().contains(&&letters[..]))?;
        (!self.has_own(known)).then(|| (known, known.usual_factor()))
    }
}

/// What each name of a header means; `None` where it is not used.
///
/// # Errors
/// [`UnknownUnit`] of a column that is used and whose unit is not known.
pub(crate) fn columns(cells: &[&str], titles: &Titles) -> Result<Vec<Option<Column>>, UnknownUnit> {
    cells.iter().map(|cell| column(cell, titles)).collect()
}

/// How many columns of kinds that a trace needs a header names, known or unknown in their units.
pub(crate) fn needed_columns(cells: &[&str], titles: &Titles) -> usize {
    let is_needed = |cell: &str| match column(cell, titles) {
        Ok(found) => found.is_some_and(|column| column.channel.is_needed()),
        Err(_) => true,
    };
    cells.iter().filter(|cell| is_needed(cell)).count()
}

fn column(cell: &str, titles: &Titles) -> Result<Option<Column>, UnknownUnit> {
    let written = unquoted(cell);
    // The whole as a name comes first: `normal_force` has no unit.
    if let Some((channel, factor)) = titles.meaning(written) {
        return Ok(Some(Column { channel, name: written.to_owned(), factor }));
    }
    let mut unknown = None;
    for (at, _) in written.char_indices().filter(|(_, letter)| UNIT_MARKS.contains(letter)) {
        let Some((channel, factor)) = titles.meaning(&written[..at]) else { continue };
        let mut column = Column { channel, name: written.to_owned(), factor };
        match column.set_unit(&written[at + 1..]) {
            Ok(()) => return Ok(Some(column)),
            // A position that cannot be read is not needed.
            Err(_) if channel == Channel::Position => {}
            Err(unit) => unknown = Some(unit),
        }
    }
    unknown.map_or(Ok(None), Err)
}

/// The letters and digits of a title, small; the letter mu, as such or as the micro sign, is a name of its own.
fn letters(name: &str) -> String {
    let plain = |letter: char| match letter {
        '\u{b5}' => '\u{3bc}',
        letter => letter,
    };
    name.chars().filter(|letter| letter.is_alphanumeric()).map(plain).flat_map(char::to_lowercase).collect()
}

/// A unit without brackets, dots, spaces and signs: `[N·m]` is `nm`, `mm/s` is `mms`.
fn unit_letters(cell: &str) -> String {
    let kept = cell.chars().filter(|c| c.is_alphanumeric() || *c == '%');
    let plain = |letter| match letter {
        'µ' | 'μ' => 'u',
        '¹' => '1',
        letter => letter.to_ascii_lowercase(),
    };
    kept.map(plain).collect()
}

#[cfg(test)]
#[path = "columns_tests.rs"]
mod tests;
