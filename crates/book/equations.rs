//! Preprocessor of mdBook: turns the equations of the chapters into MathML, so that pages need no script.

use std::process::ExitCode;

use serde_json::Value;
use slipgrid_book::equations::convert;

/// Converts every chapter of `book`, and of the parts in it.
fn convert_all(book: &mut Value) -> Result<(), String> {
    if let Some(content) = book.get_mut("content")
        && let Some(text) = content.as_str()
    {
        *content = convert(text)?.into();
    }
    match book {
        Value::Object(parts) => parts.values_mut().try_for_each(convert_all),
        Value::Array(parts) => parts.iter_mut().try_for_each(convert_all),
        _ => Ok(()),
    }
}

fn run() -> Result<(), Box<dyn std::error::Error>> {
    // mdBook asks first whether the pages of a renderer are supported.
    if std::env::args().nth(1).is_some_and(|question| question == "supports") {
        return Ok(());
    }
    let [_context, mut book]: [Value; 2] = serde_json::from_reader(std::io::stdin().lock())?;
    convert_all(&mut book)?;
    Ok(serde_json::to_writer(std::io::stdout().lock(), &book)?)
}

fn main() -> ExitCode {
    run().map_or_else(
        |error| {
            let _ = std::io::Write::write_fmt(&mut std::io::stderr(), format_args!("equations: {error}\n"));
            ExitCode::FAILURE
        },
        |()| ExitCode::SUCCESS,
    )
}
