//! Files of one result, in memory.

use std::io::{self, Write};
use std::sync::Arc;

use serde::Serialize;
use slipgrid_results::{NoJsonForm, json_and_timings};

/// Writes a file's bytes, the same at every call.
pub type Writer = Arc<dyn Fn(&mut dyn Write) -> io::Result<()> + Send + Sync>;

/// What a file holds.
#[derive(Clone)]
pub enum Content {
    /// As it is.
    Bytes(Vec<u8>),
    /// Made when it is written: files that would fill the memory.
    Stream(Writer),
}

impl Content {
    /// Writes it to `to`.
    ///
    /// # Errors
    /// What writing to `to` said.
    pub fn write(&self, to: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Bytes(bytes) => to.write_all(bytes),
            Self::Stream(write) => write(to),
        }
    }
}

/// Files of one result: names and what they hold.
#[derive(Clone, Default)]
pub struct Outputs {
    files: Vec<(String, Content)>,
}

impl std::fmt::Debug for Outputs {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_list().entries(self.names()).finish()
    }
}

impl Outputs {
    /// Adds a file.
    pub fn add(&mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.files.push((name.into(), Content::Bytes(bytes.into())));
    }

    /// Adds `record` as result.json, and its times as timings.json.
    ///
    /// # Errors
    /// [`NoJsonForm`] if a value has none.
    pub fn add_record(&mut self, record: &impl Serialize) -> Result<(), NoJsonForm> {
        let [result, timings] = json_and_timings(record)?;
        self.add("result.json", result);
        self.add("timings.json", timings);
        Ok(())
    }

    /// Adds all of `others`, each with `prefix` before its name: `next-1/` puts them below a folder.
    pub fn add_below(&mut self, prefix: &str, others: &Self) {
        self.files.extend(others.files.iter().map(|(name, content)| (format!("{prefix}{name}"), content.clone())));
    }

    /// Adds a file that `write` makes, piece by piece, when it is written.
    pub fn add_stream(
        &mut self,
        name: impl Into<String>,
        write: impl Fn(&mut dyn Write) -> io::Result<()> + Send + Sync + 'static,
    ) {
        self.files.push((name.into(), Content::Stream(Arc::new(write))));
    }

    /// The file `name` as text; `None` where there is none, or none that is text.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<String> {
        let (_, content) = self.files.iter().find(|(other, _)| other == name)?;
        let mut bytes = Vec::new();
        content.write(&mut bytes).ok()?;
        String::from_utf8(bytes).ok()
    }

    /// Names of the files, in the order in which they were added.
    #[must_use]
    pub fn names(&self) -> Vec<&str> {
        self.files.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Names of the files with what they hold, in the order in which they were added.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Content)> {
        self.files.iter().map(|(name, content)| (name.as_str(), content))
    }
}
