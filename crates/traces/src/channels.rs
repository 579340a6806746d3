//! Quantities of export columns: one table of titles and units for all instruments.

/// Quantity that a column holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// Time.
    Time,
    /// Torque about the axis.
    Torque,
    /// Friction force.
    FrictionForce,
    /// Friction coefficient as computed by the instrument; next to a torque or friction force it is only used as a
    /// check.
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
    /// Number of the step of the test.
    Step,
    /// Position along the sliding path, or sliding distance; ignored if its unit is not known.
    Position,
}

/// The titles and units of a channel.
struct ChannelData {
    title: &'static str,
    /// Titles, reduced to lower-case letters and digits.
    names: &'static [&'static str],
    /// Titles that count only if no column has one of `names`: set points, and the distance next to the position.
    secondary: &'static [&'static str],
    /// Units with their factors to SI; the first is assumed where no unit is given.
    units: &'static [(&'static str, f64)],
    /// List of the units for messages.
    unit_words: &'static str,
}

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
    ("g", GRAM_FORCE),
    ("gram", GRAM_FORCE),
    ("grams", GRAM_FORCE),
    ("kgf", 1e3 * GRAM_FORCE),
    ("kg", 1e3 * GRAM_FORCE),
    ("kp", 1e3 * GRAM_FORCE),
    ("lbf", POUND_FORCE),
];
const FORCE_WORDS: &str = "N, mN, uN, kN, daN, gf or g, kgf or kg, kp or lbf";

/// Titles and units in the order of [`Channel`].
const CHANNELS: [ChannelData; Channel::COUNT] = [
    ChannelData {
        title: "time",
        names: &["time", "t", "elapsedtime", "testtime", "zeit", "temps", "tempo", "czas", "tiempo"],
        secondary: &["steptime", "timestamp"],
        units: &[
            ("s", 1.0),
            ("secs", 1.0),
            ("second", 1.0),
            ("seconds", 1.0),
            ("ms", 1e-3),
            ("milliseconds", 1e-3),
            ("us", 1e-6),
            ("min", MINUTE),
            ("mins", MINUTE),
            ("minutes", MINUTE),
            ("h", 3600.0),
            ("hr", 3600.0),
            ("hours", 3600.0),
        ],
        unit_words: "s, ms, us, min or h",
    },
    ChannelData {
        title: "torque",
        names: &["torque", "tz", "mz", "frictiontorque", "moment", "drehmoment", "reibmoment", "coppia", "daqtz"],
        secondary: &[],
        units: &[
            ("nm", 1.0),
            ("mnm", 1e-3),
            ("unm", 1e-6),
            ("knm", 1e3),
            ("ncm", 1e-2),
            ("nmm", 1e-3),
            ("kgfm", 1e3 * GRAM_FORCE),
            ("kgm", 1e3 * GRAM_FORCE),
            ("kgfcm", 10.0 * GRAM_FORCE),
            ("kgcm", 10.0 * GRAM_FORCE),
            ("gfcm", 1e-2 * GRAM_FORCE),
            ("gcm", 1e-2 * GRAM_FORCE),
            ("lbfin", POUND_FORCE * INCH),
            ("inlbf", POUND_FORCE * INCH),
            ("lbfft", 12.0 * POUND_FORCE * INCH),
            ("ftlbf", 12.0 * POUND_FORCE * INCH),
        ],
        unit_words: "N m, mN m, uN m, kN m, N cm, N mm, kgf m, kgf cm, gf cm, lbf in or lbf ft",
    },
    ChannelData {
        title: "friction force",
        names: &[
            "frictionforce",
            "friction",
            "ff",
            "fx",
            "ft",
            "fr",
            "tangentialforce",
            "lateralforce",
            "tractionforce",
            "daqfx",
            "daqff",
            "reibkraft",
            "forcetangentielle",
            "si\u{142}atarcia",
        ],
        secondary: &[],
        units: FORCE,
        unit_words: FORCE_WORDS,
    },
    ChannelData {
        title: "friction coefficient",
        names: &[
            "cof",
            "mu",
            "\u{3bc}",
            "frictioncoefficient",
            "coefficientoffriction",
            "coeffoffriction",
            "frictioncoeff",
            "tractioncoeff",
            "tractioncoefficient",
            "daqcof",
            "reibungskoeffizient",
            "reibkoeffizient",
            "reibungszahl",
            "reibwert",
            "coefficientdefrottement",
        ],
        secondary: &[],
        // Rtec gives in brackets the force that was divided.
        units: &[("", 1.0), ("1", 1.0), ("fx", 1.0), ("ff", 1.0)],
        unit_words: "a column without a unit",
    },
    ChannelData {
        title: "normal force",
        names: &[
            "normalforce",
            "fz",
            "fn",
            "load",
            "normalload",
            "ballload",
            "pinload",
            "daqfz",
            "normalkraft",
            "forcenormale",
            "verticalforce",
        ],
        secondary: &["nominalload", "nominalforce", "setload", "setforce", "targetload", "targetforce", "sollkraft"],
        units: FORCE,
        unit_words: FORCE_WORDS,
    },
    ChannelData {
        title: "speed",
        names: &["speed", "velocity", "slidingspeed", "slidingvelocity", "linearvelocity", "v", "geschwindigkeit"],
        secondary: &[],
        units: &[
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
        unit_words: "mm/s, m/s, cm/s, um/s, mm/min, cm/min, m/min, um/min, km/h or those of revolutions",
    },
    ChannelData {
        title: "revolutions",
        names: &[
            "rpm",
            "revolutions",
            "rotationspeed",
            "rotationalspeed",
            "rotaryvelocity",
            "spindlespeed",
            "drehzahl",
        ],
        secondary: &[],
        units: &[
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
        unit_words: "rpm, 1/min, r/min, rev/min, U/min, 1/s, rps, rev/s, Hz or rad/s",
    },
    ChannelData {
        title: "humidity",
        names: &["humidity", "rh", "relativehumidity", "luftfeuchte", "feuchte"],
        secondary: &[],
        units: &[
            ("pct", 1e-2),
            ("%", 1e-2),
            ("rh", 1e-2),
            ("%rh", 1e-2),
            ("rh%", 1e-2),
            ("%rf", 1e-2),
            ("pctrh", 1e-2),
            ("percent", 1e-2),
        ],
        unit_words: "%, %RH, %rF, pct or percent",
    },
    ChannelData {
        title: "number of the repeat",
        names: &["repeat", "repetition", "run", "test", "wiederholung"],
        secondary: &[],
        units: &[("", 1.0)],
        unit_words: "a column without a unit",
    },
    ChannelData {
        title: "number of the step",
        names: &["step", "stepno", "stepnumber", "recipestep", "sequenceid", "schritt"],
        secondary: &[],
        units: &[("", 1.0)],
        unit_words: "a column without a unit",
    },
    ChannelData {
        title: "position",
        names: &["position", "pos", "x", "displacement", "linearposition", "stroke", "hub", "deplacement"],
        secondary: &["distance", "slidingdistance", "weg", "gleitweg"],
        units: &[("mm", 1e-3), ("m", 1.0), ("cm", 1e-2), ("um", 1e-6), ("nm", 1e-9)],
        unit_words: "mm, m, cm, um or nm",
    },
];

impl Channel {
    /// Number of channels.
    pub const COUNT: usize = 11;

    /// All channels.
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
        Self::Step,
        Self::Position,
    ];

    /// Channels that can give friction; messages propose the first.
    pub(crate) const FRICTION: [Self; 3] = [Self::FrictionForce, Self::Torque, Self::Coefficient];

    const fn data(self) -> &'static ChannelData {
        &CHANNELS[self as usize]
    }

    /// Whether a trace can need this column: time, friction and normal force.
    #[must_use]
    pub const fn is_needed(self) -> bool {
        matches!(self, Self::Time | Self::Torque | Self::FrictionForce | Self::Coefficient | Self::NormalForce)
    }

    /// Titles of such a column, reduced to lower-case letters and digits.
    #[must_use]
    pub const fn names(self) -> &'static [&'static str] {
        self.data().names
    }

    /// Titles that are used where no column has one of [`Channel::names`], for example set points.
    #[must_use]
    pub const fn secondary_names(self) -> &'static [&'static str] {
        self.data().secondary
    }

    /// The key in `columns` that gives this channel a custom title.
    #[must_use]
    pub fn key(self) -> String {
        match self {
            Self::Repeat => "repeat".to_owned(),
            Self::Step => "step".to_owned(),
            channel => channel.title().replace(' ', "_"),
        }
    }

    /// Name of the channel in messages.
    #[must_use]
    pub const fn title(self) -> &'static str {
        self.data().title
    }

    /// Units of the channel, as messages list them.
    #[must_use]
    pub const fn unit_words(self) -> &'static str {
        self.data().unit_words
    }

    /// Units with their factors to SI; the first is assumed where no unit is given.
    pub(crate) const fn units(self) -> &'static [(&'static str, f64)] {
        self.data().units
    }

    /// Factor from `unit`, reduced to its letters, to SI.
    pub(crate) fn factor(self, unit: &str) -> Option<f64> {
        // `mm/sec` means `mm/s`.
        let short = unit.strip_suffix("sec").map(|start| format!("{start}s"));
        let unit = short.as_deref().unwrap_or(unit);
        self.units().iter().find(|(name, _)| *name == unit).map(|(_, factor)| *factor)
    }

    /// Factor for numbers without a unit. NaN for a position, because a title such as `x` may mean any quantity.
    pub(crate) const fn usual_factor(self) -> f64 {
        if matches!(self, Self::Position) { f64::NAN } else { self.units()[0].1 }
    }
}
