//! Recognition of the columns of a tribometer export by titles and units.

use crate::cells::unquoted;
pub use crate::channels::Channel;

/// A unit that does not belong to the quantity of its column.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownUnit {
    /// Column name, as in the file.
    pub name: String,
    /// Quantity of the column.
    pub channel: Channel,
    /// Unit, as in the file.
    unit: String,
}

impl UnknownUnit {
    /// Returns the reason for the refusal, and the units that are accepted.
    pub fn words(&self) -> [String; 2] {
        let (unit, title) = (&self.unit, self.channel.title());
        let letters = unit_letters(unit);
        let is_known = Channel::ALL.iter().any(|channel| channel.factor(&letters).is_some());
        let reason = if is_known {
            format!("has the unit \"{unit}\", which is none of {title}")
        } else {
            format!("has the unit \"{unit}\", which is not known")
        };
        [reason, self.channel.unit_words().to_owned()]
    }
}

/// Priority of a column: of several columns of a channel, the first in this order is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Priority {
    /// Title given in `columns` of the table `[traces]`.
    Custom,
    /// Title listed in [`Channel::names`].
    Primary,
    /// Title listed in [`Channel::secondary_names`].
    Secondary,
}

/// A recognized column of a table.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// Quantity that the column holds.
    pub channel: Channel,
    pub(crate) priority: Priority,
    name: String,
    factor: f64,
}

impl Column {
    /// Column name, as in the file.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Converts a number of the column to SI units.
    pub fn to_si(&self, value: f64) -> f64 {
        value * self.factor
    }

    /// Sets the unit from a cell below the titles. An empty cell changes nothing.
    ///
    /// # Errors
    /// [`UnknownUnit`] if the unit does not belong to the quantity.
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
        // A speed in a unit of revolutions is the rotational speed of the axis.
        if self.channel == Channel::Speed
            && let Some(factor) = Channel::Revolutions.factor(unit)
        {
            self.channel = Channel::Revolutions;
            return Some(factor);
        }
        self.channel.factor(unit)
    }
}

/// Characters in front of a unit in a title: brackets, slash and underscore.
const UNIT_MARKS: [char; 5] = ['[', '(', '{', '/', '_'];

/// Custom title that declares a channel absent from the table.
pub const NO_COLUMN: &str = "none";

/// Custom titles of columns; channels without a custom title are recognized by the known titles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Titles(Vec<Title>);

#[derive(Clone, Debug, PartialEq)]
struct Title {
    channel: Channel,
    /// Whole title including the unit, reduced to lower-case letters and digits.
    whole: String,
    /// Title without a unit in brackets or after a slash, reduced to lower-case letters and digits.
    letters: String,
    factor: f64,
    /// Number, from 1, of the intended column among several columns with this title; `None` if any of them may be used.
    number: Option<usize>,
}

impl Titles {
    /// Adds `title` as the custom title of `channel`, whose known titles are then ignored. A unit in the title applies
    /// to columns without a unit; if neither has a unit, the first of [`Channel::unit_words`] is assumed. `#2` at the
    /// end means the second column with this title. [`NO_COLUMN`] says that no column holds the channel.
    ///
    /// # Errors
    /// [`UnknownUnit`] if the unit in brackets is not known.
    pub fn name(&mut self, channel: Channel, title: &str) -> Result<(), UnknownUnit> {
        let written = unquoted(title);
        if written.eq_ignore_ascii_case(NO_COLUMN) {
            self.0.push(Title { channel, whole: String::new(), letters: String::new(), factor: 1.0, number: None });
            return Ok(());
        }
        let numbered =
            written.rsplit_once('#').and_then(|(start, end)| Some((start.trim_end(), end.trim().parse().ok()?)));
        let (written, number) = numbered.map_or((written, None), |(start, number)| (start, Some(number)));
        let (name, unit) = written.find(['[', '(', '{']).map_or((written, ""), |at| written.split_at(at));
        let priority = Priority::Custom;
        let mut column = Column { channel, priority, name: written.to_owned(), factor: channel.usual_factor() };
        column.set_unit(unit)?;
        let mut letters_of_name = letters(name);
        // In `load_kg` or `time/ms` the suffix is a unit. The title as a whole is looked for as well.
        if unit.is_empty()
            && let Some((start, end)) = name.rsplit_once(['/', '_'])
            && column.set_unit(end).is_ok()
            && name.contains('/')
        {
            letters_of_name = letters(start);
        }
        let (channel, factor) = (column.channel, column.factor);
        self.0.push(Title { channel, whole: letters(written), letters: letters_of_name, factor, number });
        Ok(())
    }

    /// Whether `channel` has a custom title.
    pub fn has_title(&self, channel: Channel) -> bool {
        self.0.iter().any(|title| title.channel == channel)
    }

    /// Whether `channel` has a custom title other than [`NO_COLUMN`].
    pub(crate) fn expects(&self, channel: Channel) -> bool {
        self.0.iter().any(|title| title.channel == channel && !title.whole.is_empty())
    }

    /// Candidate names within a title: the whole title, and the text before each bracket, slash or underscore; reduced
    /// to lower-case letters and digits.
    pub fn letters_of(title: &str) -> Vec<String> {
        let written = unquoted(title);
        let cuts = written.char_indices().filter(|(_, letter)| UNIT_MARKS.contains(letter)).map(|(at, _)| at);
        cuts.chain([written.len()]).map(|at| letters(&written[..at])).collect()
    }

    /// Lists the titles of a channel for messages.
    pub fn list(&self, channel: Channel) -> String {
        let own: Vec<&str> =
            self.0.iter().filter(|title| title.channel == channel).map(|title| &title.whole[..]).collect();
        let own: Vec<&str> = own.into_iter().map(|title| if title.is_empty() { NO_COLUMN } else { title }).collect();
        if own.is_empty() {
            channel.names().take(3).collect::<Vec<_>>().join(", ") + ", ..."
        } else {
            format!("{}, as `columns` says", own.join(", "))
        }
    }

    /// Recognizes a name: returns its channel, the factor of its default unit to SI, and its priority; `None` if it is
    /// unknown.
    fn meaning(&self, name: &str) -> Option<(Channel, f64, Priority)> {
        let letters = letters(name);
        if letters.is_empty() {
            return None;
        }
        let own = |title: &&Title| title.whole == letters || title.letters == letters;
        if let Some(own) = self.0.iter().find(own) {
            return Some((own.channel, own.factor, Priority::Custom));
        }
        let is_in = |mut names: std::str::SplitWhitespace<'_>| names.any(|name| name == letters);
        let known = |channel: Channel| match channel {
            channel if is_in(channel.names()) => Some((channel, Priority::Primary)),
            channel if is_in(channel.secondary_names()) => Some((channel, Priority::Secondary)),
            _ => None,
        };
        let (known, priority) = Channel::ALL.into_iter().find_map(known)?;
        (!self.has_title(known)).then(|| (known, known.usual_factor(), priority))
    }

    /// Number, from 1, of the intended column among several columns with the custom title of `channel`; `None` if any
    /// of them may be used.
    fn number(&self, channel: Channel) -> Option<usize> {
        self.0.iter().find(|title| title.channel == channel)?.number
    }
}

/// Recognizes each title of a header; `None` for columns that are not used. An optional column with an unknown unit is
/// not used.
///
/// # Errors
/// [`UnknownUnit`] if a column that is needed has an unknown unit.
pub(crate) fn columns(cells: &[&str], titles: &Titles) -> Result<Vec<Option<Column>>, UnknownUnit> {
    let mut counts = [0; Channel::COUNT];
    let of_cell = |cell: &&str| {
        let column = match column(cell, titles) {
            Err(unknown) if !unknown.channel.is_needed() => None,
            found => found?,
        };
        Ok(column.filter(|column| {
            let count = &mut counts[column.channel as usize];
            *count += 1;
            column.priority != Priority::Custom || titles.number(column.channel).is_none_or(|number| number == *count)
        }))
    };
    cells.iter().map(of_cell).collect()
}

/// Counts the columns of a header that a trace may need, including those with unknown units.
pub(crate) fn needed_columns(cells: &[&str], titles: &Titles) -> usize {
    let is_needed = |cell: &str| match column(cell, titles) {
        Ok(found) => found.is_some_and(|column| column.channel.is_needed()),
        Err(unknown) => unknown.channel.is_needed(),
    };
    cells.iter().filter(|cell| is_needed(cell)).count()
}

fn column(cell: &str, titles: &Titles) -> Result<Option<Column>, UnknownUnit> {
    let written = unquoted(cell);
    let whole = titles.meaning(written);
    let whole = whole.map(|(channel, factor, priority)| Column { channel, priority, name: written.to_owned(), factor });
    // The whole title is tried first, because the suffix of `normal_force` is no unit; but `%` is one without letters.
    if whole.is_some() && !written.contains('%') {
        return Ok(whole);
    }
    let mut unknown = None;
    for (at, _) in written.char_indices().filter(|(_, letter)| UNIT_MARKS.contains(letter)) {
        let Some((channel, factor, priority)) = titles.meaning(&written[..at]) else { continue };
        let mut column = Column { channel, priority, name: written.to_owned(), factor };
        match column.set_unit(&written[at + 1..]) {
            Ok(()) => return Ok(Some(column)),
            Err(unit) => unknown = Some(unit),
        }
    }
    unknown.map_or(Ok(whole), Err)
}

/// Whether an unknown title has the unit of a force and might therefore be the normal force.
pub(crate) fn may_be_force(title: &str) -> bool {
    let Some(at) = title.rfind(UNIT_MARKS) else { return false };
    let unit = unit_letters(&title[at + 1..]);
    !unit.is_empty() && Channel::NormalForce.factor(&unit).is_some()
}

/// Reduces a title to lower-case letters and digits; the micro sign becomes the letter mu.
fn letters(name: &str) -> String {
    let plain = |letter: char| match letter {
        '\u{b5}' => '\u{3bc}',
        letter => letter,
    };
    name.chars().filter(|letter| letter.is_alphanumeric()).map(plain).flat_map(char::to_lowercase).collect()
}

/// Reduces a unit to its letters, digits and `%`: `[N·m]` becomes `nm`, `mm/s` becomes `mms`.
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
