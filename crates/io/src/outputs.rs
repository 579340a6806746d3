//! Files of one result, in memory.

use std::io::{self, Write};
use std::sync::Arc;

use serde::Serialize;
use slipgrid_design::results::{NoJsonForm, json_and_timings};

/// Writes a file's bytes; every call writes identical bytes.
pub type Writer = Arc<dyn Fn(&mut dyn Write) -> io::Result<()> + Send + Sync>;

/// Content of an output file.
#[derive(Clone)]
pub enum Content {
    /// Bytes in memory.
    Bytes(Vec<u8>),
    /// Bytes generated during writing, for files too large for memory.
    Stream(Writer),
}

impl Content {
    /// Writes the content to `to`.
    ///
    /// # Errors
    /// The error of writing to `to`.
    pub fn write(&self, to: &mut dyn Write) -> io::Result<()> {
        match self {
            Self::Bytes(bytes) => to.write_all(bytes),
            Self::Stream(write) => write(to),
        }
    }
}

/// Files of one result: names and contents.
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
    /// Adds the file `name` with the content `bytes`.
    pub fn add(&mut self, name: impl Into<String>, bytes: impl Into<Vec<u8>>) {
        self.files.push((name.into(), Content::Bytes(bytes.into())));
    }

    /// Adds `record` as result.json without the wall times, and the wall times as timings.json.
    ///
    /// # Errors
    /// [`NoJsonForm`] if a value has no JSON form.
    pub fn add_record(&mut self, record: &impl Serialize) -> Result<(), NoJsonForm> {
        let [result, timings] = json_and_timings(record)?;
        self.add("result.json", result);
        self.add("timings.json", timings);
        Ok(())
    }

    /// Adds all files of `others` with `prefix` before each name; the prefix `next-1/` puts the files into a folder.
    pub fn add_below(&mut self, prefix: &str, others: &Self) {
        self.files.extend(others.files.iter().map(|(name, content)| (format!("{prefix}{name}"), content.clone())));
    }

    /// Adds a file that `write` generates piece by piece during writing.
    pub fn add_stream(
        &mut self,
        name: impl Into<String>,
        write: impl Fn(&mut dyn Write) -> io::Result<()> + Send + Sync + 'static,
    ) {
        self.files.push((name.into(), Content::Stream(Arc::new(write))));
    }

    /// The file `name` as text; `None` if it does not exist or is not text.
    pub fn text(&self, name: &str) -> Option<String> {
        let (_, content) = self.files.iter().find(|(other, _)| other == name)?;
        let mut bytes = Vec::new();
        content.write(&mut bytes).ok()?;
        String::from_utf8(bytes).ok()
    }

    /// Names of the files, in order of addition.
    pub fn names(&self) -> Vec<&str> {
        self.files.iter().map(|(name, _)| name.as_str()).collect()
    }

    /// Names and contents of the files, in order of addition.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &Content)> {
        self.files.iter().map(|(name, content)| (name.as_str(), content))
    }
}
