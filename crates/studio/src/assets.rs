//! Files of the page: text, styles and scripts, which are compiled into the program.

use axum::extract::Path;
use axum::http::StatusCode;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};

use crate::error::Refused;

macro_rules! assets {
    ($($name:literal),* $(,)?) => {
        [$(($name, include_bytes!(concat!("../assets/", $name)).as_slice())),*]
    };
}

/// Name and content of every file of the page.
const ASSETS: &[(&str, &[u8])] = &assets![
    "api.js",
    "app.js",
    "design.js",
    "explorer.js",
    "files.js",
    "form.js",
    "index.html",
    "intake.js",
    "jobs.js",
    "material.js",
    "plot.js",
    "start.js",
    "studio.css",
    "target.js",
    "targetplot.js",
    "traceview.js",
    "trial.js",
    "trials.js",
    "ui.js",
    "vendor/codemirror.LICENSE",
    "vendor/codemirror.js",
    "vendor/uPlot.LICENSE",
    "vendor/uPlot.esm.js",
    "vendor/uPlot.min.css",
];

/// Answers with the page itself.
pub async fn page() -> Result<Response, Refused> {
    found("index.html")
}

/// Answers with a file of the page.
pub async fn asset(Path(name): Path<String>) -> Result<Response, Refused> {
    found(&name)
}

fn found(name: &str) -> Result<Response, Refused> {
    let known = ASSETS.iter().find(|(known, _)| *known == name);
    let (_, bytes) = known.ok_or_else(|| Refused(StatusCode::NOT_FOUND, format!("there is no {name:?}")))?;
    let content_type = match name.rsplit_once('.').map_or("", |(_, extension)| extension) {
        "html" => "text/html; charset=utf-8",
        "css" => "text/css; charset=utf-8",
        "js" => "text/javascript; charset=utf-8",
        _ => "text/plain; charset=utf-8",
    };
    // Another version of the program may answer at the next start.
    Ok(([(CONTENT_TYPE, content_type), (CACHE_CONTROL, "no-cache")], *bytes).into_response())
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::path::Path;

    use super::*;

    #[test]
    fn every_file_of_the_page_is_served() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
        let names = |below: &str| {
            let entries = fs::read_dir(folder.join(below)).unwrap().map(Result::unwrap);
            let files = entries.filter(|entry| entry.file_type().unwrap().is_file());
            files.map(|entry| format!("{below}{}", entry.file_name().to_string_lossy())).collect::<Vec<_>>()
        };
        let mut found = [names(""), names("vendor/")].concat();
        found.sort();
        assert_eq!(found, ASSETS.iter().map(|(name, _)| (*name).to_owned()).collect::<Vec<_>>());
    }
}
