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
    /// Rotational speed.
    Revolutions,
    /// Relative humidity.
    Humidity,
    /// Number of the repeat.
    Repeat,
    /// Number of the step of the test.
    Step,
    /// Position along the sliding path, or sliding distance; ignored if the unit is not known.
    Position,
}

/// Titles and units of a channel.
struct ChannelData {
    title: &'static str,
    /// Titles, reduced to lower-case letters and digits and separated by spaces.
    names: &'static str,
    /// Titles that count only if no column has a title in `names`, for example titles of set points, separated by
    /// spaces.
    secondary: &'static str,
    /// Spellings of units, separated by spaces, with their factors to SI; the first unit is assumed where none is
    /// given.
    units: &'static [(&'static str, f64)],
    /// Accepted units, as listed in messages.
    unit_words: &'static str,
}

const MINUTE: f64 = 60.0;
const GRAM_FORCE: f64 = 9.806_65e-3;
const POUND_FORCE: f64 = 4.448_221_615_260_5;
const INCH: f64 = 25.4e-3;

const FORCE: &[(&str, f64)] = &[
    ("n newton newtons", 1.0),
    ("mn", 1e-3),
    ("un", 1e-6),
    ("kn", 1e3),
    ("dan", 10.0),
    ("gf g gram grams", GRAM_FORCE),
    ("kgf kg kp", 1e3 * GRAM_FORCE),
    ("lbf", POUND_FORCE),
];
const FORCE_WORDS: &str = "N, mN, uN, kN, daN, gf or g, kgf or kg, kp or lbf";

/// Titles and units in the order of [`Channel`].
const CHANNELS: [ChannelData; Channel::COUNT] = [
    ChannelData {
        title: "time",
        names: "time t elapsedtime testtime zeit temps tempo czas tiempo",
        secondary: "steptime timestamp",
        units: &[
            ("s secs second seconds", 1.0),
            ("ms milliseconds", 1e-3),
            ("us", 1e-6),
            ("min mins minutes", MINUTE),
            ("h hr hours", 3600.0),
        ],
        unit_words: "s, ms, us, min or h",
    },
    ChannelData {
        title: "torque",
        names: "torque tz mz frictiontorque moment drehmoment reibmoment coppia daqtz",
        secondary: "",
        units: &[
            ("nm", 1.0),
            ("mnm nmm", 1e-3),
            ("unm", 1e-6),
            ("knm", 1e3),
            ("ncm", 1e-2),
            ("kgfm kgm", 1e3 * GRAM_FORCE),
            ("kgfcm kgcm", 10.0 * GRAM_FORCE),
            ("gfcm gcm", 1e-2 * GRAM_FORCE),
            ("lbfin inlbf", POUND_FORCE * INCH),
            ("lbfft ftlbf", 12.0 * POUND_FORCE * INCH),
        ],
        unit_words: "N m, mN m, uN m, kN m, N cm, N mm, kgf m, kgf cm, gf cm, lbf in or lbf ft",
    },
    ChannelData {
        title: "friction force",
        names: "frictionforce friction ff fx ft fr tangentialforce lateralforce tractionforce daqfx daqff reibkraft \
            forcetangentielle si\u{142}atarcia",
        secondary: "",
        units: FORCE,
        unit_words: FORCE_WORDS,
    },
    ChannelData {
        title: "friction coefficient",
        names: "cof mu \u{3bc} frictioncoefficient coefficientoffriction coeffoffriction frictioncoeff \
            tractioncoeff tractioncoefficient daqcof reibungskoeffizient reibkoeffizient reibungszahl reibwert \
            coefficientdefrottement",
        secondary: "",
        // Rtec instruments write the divided force in place of the unit.
        units: &[(" 1 fx ff", 1.0), ("% pct percent", 1e-2)],
        unit_words: "1, %, pct or percent",
    },
    ChannelData {
        title: "normal force",
        names: "normalforce fz fn load normalload ballload pinload daqfz normalkraft forcenormale verticalforce",
        secondary: "nominalload nominalforce setload setforce targetload targetforce sollkraft",
        units: FORCE,
        unit_words: FORCE_WORDS,
    },
    ChannelData {
        title: "speed",
        names: "speed velocity slidingspeed slidingvelocity linearvelocity v geschwindigkeit",
        secondary: "",
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
        names: "rpm revolutions rotationspeed rotationalspeed rotaryvelocity spindlespeed drehzahl",
        secondary: "",
        units: &[
            ("rpm 1min min1 rmin umin revmin", 1.0 / MINUTE),
            ("1s s1 hz rps revs", 1.0),
            ("rads", 1.0 / std::f64::consts::TAU),
        ],
        unit_words: "rpm, 1/min, r/min, rev/min, U/min, 1/s, rps, rev/s, Hz or rad/s",
    },
    ChannelData {
        title: "humidity",
        names: "humidity rh relativehumidity luftfeuchte feuchte",
        secondary: "",
        units: &[("pct % rh %rh rh% %rf pctrh percent", 1e-2)],
        unit_words: "%, %RH, %rF, pct or percent",
    },
    ChannelData {
        title: "number of the repeat",
        names: "repeat repetition run test wiederholung",
        secondary: "",
        units: &[("", 1.0)],
        unit_words: "a column without a unit",
    },
    ChannelData {
        title: "number of the step",
        names: "step stepno stepnumber recipestep sequenceid schritt",
        secondary: "",
        units: &[("", 1.0)],
        unit_words: "a column without a unit",
    },
    ChannelData {
        title: "position",
        names: "position pos x displacement linearposition stroke hub deplacement",
        secondary: "distance slidingdistance weg gleitweg",
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

    /// Channels from which friction can be computed; messages propose the first.
    pub(crate) const FRICTION: [Self; 3] = [Self::FrictionForce, Self::Torque, Self::Coefficient];

    const fn data(self) -> &'static ChannelData {
        &CHANNELS[self as usize]
    }

    /// Whether a trace can need this channel: true for time, the friction channels and the normal force.
    pub const fn is_needed(self) -> bool {
        matches!(self, Self::Time | Self::Torque | Self::FrictionForce | Self::Coefficient | Self::NormalForce)
    }

    /// Known titles of columns that hold this channel, reduced to lower-case letters and digits.
    pub fn names(self) -> std::str::SplitWhitespace<'static> {
        self.data().names.split_whitespace()
    }

    /// Titles that count only if no column has a title of [`Channel::names`], for example those of set points.
    pub fn secondary_names(self) -> std::str::SplitWhitespace<'static> {
        self.data().secondary.split_whitespace()
    }

    /// Key in `columns` of a `[traces]` table that gives this channel a custom title.
    pub fn key(self) -> String {
        self.title().trim_start_matches("number of the ").replace(' ', "_")
    }

    /// Name of the channel in messages.
    pub const fn title(self) -> &'static str {
        self.data().title
    }

    /// Units of the channel, as listed in messages.
    pub const fn unit_words(self) -> &'static str {
        self.data().unit_words
    }

    /// Spellings of units, separated by spaces, with their factors to SI; the first unit is assumed where none is
    /// given.
    pub(crate) const fn units(self) -> &'static [(&'static str, f64)] {
        self.data().units
    }

    /// Factor from `unit`, spelled without marks and spaces, to the SI unit; `None` if the unit is unknown. Humidity
    /// becomes a fraction, and rotational speed revolutions per second.
    pub(crate) fn factor(self, unit: &str) -> Option<f64> {
        // `mm/sec` means `mm/s`.
        let short = unit.strip_suffix("sec").map(|start| format!("{start}s"));
        let unit = short.as_deref().unwrap_or(unit);
        self.units().iter().find(|(names, _)| names.split(' ').any(|name| name == unit)).map(|(_, factor)| *factor)
    }

    /// Factor to the SI unit for numbers without a unit. NaN for a position, because a title such as `x` may mean any
    /// quantity.
    pub(crate) const fn usual_factor(self) -> f64 {
        if matches!(self, Self::Position) { f64::NAN } else { self.units()[0].1 }
    }
}
