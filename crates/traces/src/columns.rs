//! Columns of a tribometer export: the meaning of a title, and its unit.

use crate::cells::unquoted;
pub use crate::channels::Channel;

/// A unit that a column's quantity does not have.
#[derive(Clone, Debug, PartialEq)]
pub struct UnknownUnit {
    /// The column, as the file writes it.
    pub name: String,
    /// The quantity of the column.
    pub channel: Channel,
    /// The unit, as the file writes it.
    unit: String,
}

impl UnknownUnit {
    /// What is wrong, and what would be accepted.
    #[must_use]
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

/// Which of several columns of one channel is used: the first kind that there is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Priority {
    /// Its title is given in `columns`.
    Own,
    /// Its title is one of [`Channel::names`].
    Primary,
    /// Its title is one of [`Channel::secondary_names`].
    Secondary,
}

/// A column that is used.
#[derive(Clone, Debug, PartialEq)]
pub struct Column {
    /// What it holds.
    pub channel: Channel,
    pub(crate) priority: Priority,
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
        if self.channel == Channel::Speed
            && let Some(factor) = Channel::Revolutions.factor(unit)
        {
            self.channel = Channel::Revolutions;
            return Some(factor);
        }
        self.channel.factor(unit)
    }
}

/// The unit stands in brackets, behind a slash, or behind an underscore.
const UNIT_MARKS: [char; 5] = ['[', '(', '{', '/', '_'];

/// The title that says that no column holds a channel.
pub const NO_COLUMN: &str = "none";

/// Titles of one's own for what columns hold, beside those that are known.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Titles(Vec<Title>);

/// A title of one's own.
#[derive(Clone, Debug, PartialEq)]
struct Title {
    channel: Channel,
    /// Letters of the whole title, its unit among them.
    whole: String,
    /// Letters of the title without the unit in brackets or behind a slash.
    letters: String,
    factor: f64,
    /// Which of several columns with this title, from 1.
    number: Option<usize>,
}

impl Titles {
    /// Takes `title` for columns of `channel`, which no other title means from now on. Its unit, written as in an export, is that of columns
    /// which name none; without it the first of [`Channel::unit_words`]. `#2` at its end means the second column with this title, and
    /// [`NO_COLUMN`] alone that no column holds the channel.
    ///
    /// # Errors
    /// [`UnknownUnit`] in its brackets.
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
        let priority = Priority::Own;
        let mut column = Column { channel, priority, name: written.to_owned(), factor: channel.usual_factor() };
        column.set_unit(unit)?;
        let mut letters_of_name = letters(name);
        // A suffix is the unit where it is one, as in `load_kg` or `time/ms`; the title is then sought as a whole, too.
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

    /// Whether columns of a channel have a title of one's own.
    #[must_use]
    pub fn has_own(&self, channel: Channel) -> bool {
        self.0.iter().any(|title| title.channel == channel)
    }

    /// Whether a column of `channel` is named by its own title.
    pub(crate) fn expects(&self, channel: Channel) -> bool {
        self.0.iter().any(|title| title.channel == channel && !title.whole.is_empty())
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
            self.0.iter().filter(|title| title.channel == channel).map(|title| &title.whole[..]).collect();
        let own: Vec<&str> = own.into_iter().map(|title| if title.is_empty() { NO_COLUMN } else { title }).collect();
        if own.is_empty() {
            channel.names()[..channel.names().len().min(3)].join(", ") + ", ..."
        } else {
            format!("{}, as `columns` says", own.join(", "))
        }
    }

    /// The meaning of a name: its channel, the factor of the unit that it has where none stands beside it, and its priority.
    fn meaning(&self, name: &str) -> Option<(Channel, f64, Priority)> {
        let letters = letters(name);
        if letters.is_empty() {
            return None;
        }
        let own = |title: &&Title| title.whole == letters || title.letters == letters;
        if let Some(own) = self.0.iter().find(own) {
            return Some((own.channel, own.factor, Priority::Own));
        }
        let is_in = |names: &[&str]| names.contains(&&letters[..]);
        let known = |channel: Channel| match channel {
            channel if is_in(channel.names()) => Some((channel, Priority::Primary)),
            channel if is_in(channel.secondary_names()) => Some((channel, Priority::Secondary)),
            _ => None,
        };
        let (known, priority) = Channel::ALL.into_iter().find_map(known)?;
        (!self.has_own(known)).then(|| (known, known.usual_factor(), priority))
    }

    /// Which of several columns with an own title of `channel` is meant, from 1.
    fn number(&self, channel: Channel) -> Option<usize> {
        self.0.iter().find(|title| title.channel == channel)?.number
    }
}

/// The meaning of each name of a header; `None` where it is not used. A column that a trace does not need is not used if its unit is unknown.
///
/// # Errors
/// [`UnknownUnit`] of a column that is needed and whose unit is not known.
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
            column.priority != Priority::Own || titles.number(column.channel).is_none_or(|number| number == *count)
        }))
    };
    cells.iter().map(of_cell).collect()
}

/// How many columns of kinds that a trace needs a header names, known or unknown in their units.
pub(crate) fn needed_columns(cells: &[&str], titles: &Titles) -> usize {
    let is_needed = |cell: &str| match column(cell, titles) {
        Ok(found) => found.is_some_and(|column| column.channel.is_needed()),
        Err(unknown) => unknown.channel.is_needed(),
    };
    cells.iter().filter(|cell| is_needed(cell)).count()
}

fn column(cell: &str, titles: &Titles) -> Result<Option<Column>, UnknownUnit> {
    let written = unquoted(cell);
    // The whole as a name comes first: `normal_force` has no unit.
    if let Some((channel, factor, priority)) = titles.meaning(written) {
        return Ok(Some(Column { channel, priority, name: written.to_owned(), factor }));
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
    unknown.map_or(Ok(None), Err)
}

/// Whether a title that is not known has the unit of a force, so that it may be the normal force.
pub(crate) fn may_be_force(title: &str) -> bool {
    let Some(at) = title.rfind(UNIT_MARKS) else { return false };
    let unit = unit_letters(&title[at + 1..]);
    !unit.is_empty() && Channel::NormalForce.factor(&unit).is_some()
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
