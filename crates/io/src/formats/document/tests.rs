//! Tests of the contents of TOML refusals.

use super::explain::replace_word;
use super::*;

#[derive(serde::Deserialize, Debug)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "only refused documents are looked at")]
struct Outer {
    inner: Inner,
    others: Option<Vec<Inner>>,
    side: Option<Side>,
}

#[derive(serde::Deserialize, Debug)]
#[serde(rename_all = "lowercase")]
enum Side {
    Left,
    Right,
}

#[derive(serde::Deserialize, Debug)]
#[serde(deny_unknown_fields)]
#[expect(dead_code, reason = "only refused documents are looked at")]
struct Inner {
    width_um: Spanned<f64>,
    count: Option<u64>,
}

fn refused(text: &str) -> String {
    Document::new("a.toml", text).parse::<Outer>().unwrap_err().to_string()
}

#[test]
fn a_decimal_comma_is_named() {
    let document = Document::new("a.toml", "[material]\nyoungs_modulus_gpa = 2,7   # measured\n");
    let refused = document.parse::<toml::Table>().unwrap_err().to_string();
    assert_eq!(refused, "a.toml:2: 2,7 has a decimal comma; expected a decimal point: 2.7");
}

#[test]
fn refusals_name_line_and_key() {
    for (text, message) in [
        (
            "[inner]\nwidth_um = 1.0\nwidht_um = 2",
            "a.toml:3: inner.widht_um: is not a known key; expected one of width_um, count (did you mean `width_um`?)",
        ),
        (
            "\n[inner]\n",
            "a.toml:2: inner.width_um: is missing; expected a number from 0.000001 up to 10000000 um, such as width_um = 130.0",
        ),
        ("# nothing\n", "a.toml: holds no keys; expected a file with the key inner"),
        ("inner = { width_um = \"wide\" }", "a.toml:1: inner.width_um: \"wide\" has the wrong type; expected a number"),
        (
            "[[inner]]\nwidth_um = 1.0",
            "a.toml:1: inner: stands in double brackets, as one of a list; expected one table, [inner]",
        ),
        // A list could otherwise supply the fields of a structure in order.
        ("inner = [1.5, 3]", "a.toml:1: inner: [1.5, 3] has the wrong type; expected a table"),
        ("inner = []", "a.toml:1: inner: has the wrong type; expected a table"),
        (
            "inner = { width_um = 1 }\nothers = [[2.5, 3]]",
            "a.toml:2: others: [2.5, 3] has the wrong type; expected a table",
        ),
        ("inner = 3", "a.toml:1: inner: 3 has the wrong type; expected a table"),
        (
            "[inner]\nwidth_um = 1\ncount = -3",
            "a.toml:3: inner.count: -3 is out of range; expected a whole number not below zero",
        ),
        // A name is not the key of an empty table.
        ("side = { left = {} }", "a.toml:1: side: has the wrong type; expected \"left\" or \"right\""),
        ("side = 3", "a.toml:1: side: 3 has the wrong type; expected \"left\" or \"right\""),
        (
            "side = \"lft\"",
            "a.toml:1: side: \"lft\" is not known; expected \"left\" or \"right\" (did you mean `left`?)",
        ),
        // A name with the marks that messages are quoted by.
        ("side = \"a`b`c\"", "a.toml:1: side: \"a`b`c\" is not known; expected \"left\" or \"right\""),
        ("\"a`b\" = 1", "a.toml:1: a`b: is not a known key; expected one of inner, others, side"),
    ] {
        assert_eq!(refused(text), message);
    }
    assert!(refused("[inner]\nwidth_um = = 2").starts_with("a.toml:2: "));
}

#[test]
fn a_missing_table_and_an_empty_file_are_said_with_what_writes_one() {
    #[derive(serde::Deserialize, Debug)]
    #[expect(dead_code, reason = "only refused documents are looked at")]
    struct File {
        target: toml::Table,
    }
    let refused =
        |text: &str| Document::new("a.toml", text).as_kind(FileKind::Design).parse::<File>().unwrap_err().to_string();
    assert_eq!(
        refused("[bounds]\n"),
        "a.toml:1: target: is missing; expected a table [target] with quantity, pressure_mpa, and value with tolerance, as \
         `slipgrid new design` writes one"
    );
    for empty in ["", " \n", "# no more than a comment\n"] {
        assert_eq!(
            refused(empty),
            "a.toml: holds no keys; expected a design file, with [target] and [bounds], such as `slipgrid new design` writes"
        );
    }
}

#[test]
fn what_occurs_twice_is_named_where_it_occurs_again() {
    for (text, says) in [
        (
            "[inner]\nwidth_um = 2\n\nwidth_um = 3",
            "a.toml:4: width_um: occurs a second time; expected one line with this key in its table",
        ),
        (
            "[inner]\nwidth_um = 2\n[other]\nwidth_um = 1\n[inner]\ncount = 3",
            "a.toml:5: inner: occurs a second time; expected one table with all of its keys, or a list of tables, [[NAME]]",
        ),
        ("inner = { width_um = 2, width_um = 3 }", "a.toml:1: width_um: occurs a second time"),
    ] {
        assert!(refused(text).starts_with(says), "{}", refused(text));
    }
}

#[test]
fn a_missing_condition_comes_with_what_is_accepted_and_an_example() {
    let document = Document::new("a.toml", "[load]\n");
    for (key, says) in [
        ("speed_mm_s", "a number above 0 up to 100000 mm/s, such as speed_mm_s = 5.0"),
        ("humidity_pct", "a number from 0 up to 100 %, such as humidity_pct = 50.0"),
    ] {
        assert_eq!(document.missing(0..6, key).expected.as_deref(), Some(says));
    }
}

#[test]
fn words_are_replaced_whole() {
    assert_eq!(replace_word("a map of bitmaps, map", "map", "table"), "a table of bitmaps, table");
}

#[test]
fn paths_are_named_without_detours_unless_a_link_is_on_the_way() {
    let folder = tempfile::tempdir().unwrap();
    let at = |path: &str| folder.path().join(path);
    for own in ["designs", "calibration", "far/designs"] {
        std::fs::create_dir_all(at(own)).unwrap();
    }
    let resolved = |document: &str, relative: &str| {
        Document::within(&crate::disk::disk(), at(document), String::new()).resolve(relative)
    };
    // As text: paths are equal if their parts are.
    let is = |path: PathBuf, own: &str| assert_eq!(path.as_os_str(), at(own).as_os_str());
    is(resolved("designs/a.toml", "../calibration/missing.toml"), "calibration/missing.toml");
    is(resolved("designs/a.toml", "b/../c.toml"), "designs/b/../c.toml");
    is(resolved("far/designs/a.toml", "../../m.toml"), "m.toml");
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(at("far/designs"), at("link")).unwrap();
        is(resolved("link/a.toml", "../calibration/c.toml"), "link/../calibration/c.toml");
        is(resolved("link/a.toml", "c.toml"), "link/c.toml");
    }
}
