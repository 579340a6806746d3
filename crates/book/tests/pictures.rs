//! Checks that every picture drawn by the book's commands has a title or caption, and that the pictures in chapters are
//! drawn by their commands.

use std::path::Path;

use crate::{book, files, keep, root, text};

/// Pictures of the book: chapter, file that the chapter's commands write, and name of the picture.
const SHOWN: [(&str, &str, &str); 5] = [
    ("tutorials/first-design.md", "out/first/target.svg", "target.svg"),
    ("tutorials/first-design.md", "out/first/pattern.svg", "pattern.svg"),
    ("tutorials/three-trials.md", "out/trials/trials.svg", "trials.svg"),
    ("how-to/measured-textures.md", "out/textured/map.svg", "surface-map.svg"),
    ("how-to/measured-textures.md", "out/textured/histogram.svg", "surface-histogram.svg"),
];

/// Compares the pictures in the chapter at `page` with the files that its commands wrote into `folder`.
pub fn compare_shown(page: &Path, folder: &Path) {
    let own = SHOWN.iter().filter(|(chapter, ..)| page.ends_with(chapter));
    own.for_each(|(_, written, shown)| keep(&book().join("pictures").join(shown), &text(&folder.join(written))))
}

/// Text between the first `start` and the next `end`, trimmed.
fn between<'a>(text: &'a str, start: &str, end: &str) -> Option<&'a str> {
    text.split_once(start)?.1.split_once(end).map(|(inside, _)| inside.trim())
}

/// Title of a drawing: its first bold text.
fn title(svg: &str) -> Option<&str> {
    between(svg.split_once("font-weight=\"bold\"")?.1, ">", "</text>")
}

/// Fault of the title of a drawing in the folder of a report with the title `page`; `None` if there is no fault.
fn untitled(svg: &str, page: Option<&str>) -> Option<&'static str> {
    let title = title(svg).unwrap_or_default();
    let is_name = |page: &str| page == title || page.strip_prefix(title).is_some_and(|rest| rest.starts_with(": "));
    if title.is_empty() {
        return Some("has no title");
    }
    page.is_some_and(is_name).then_some("has a title that is a name alone and does not say what is shown")
}

/// Number of figures of a page without a caption.
fn without_caption(page: &str) -> usize {
    let figures = page.split("<figure").skip(1).filter_map(|rest| rest.split("</figure>").next());
    figures.filter(|figure| between(figure, "<figcaption>", "</figcaption>").is_none_or(str::is_empty)).count()
}

/// Messages about the pictures below `folder` that have no title or no caption.
pub fn compare(folder: &Path) -> Vec<String> {
    let mut found = Vec::new();
    for path in files(folder, ".svg") {
        let page = path.with_file_name("report.html");
        let page = page.is_file().then(|| text(&page));
        let name = page.as_deref().and_then(|page| between(page, "<title>", "</title>"));
        found.extend(untitled(&text(&path), name).map(|wrong| format!("{} {wrong}", path.display())));
    }
    for path in files(folder, ".html") {
        let count = without_caption(&text(&path));
        if count > 0 {
            found.push(format!("{} has {count} figures without a caption", path.display()));
        }
    }
    found
}

#[test]
fn pictures_that_are_held_to_their_commands_stand_in_their_chapters() {
    for (chapter, _, shown) in SHOWN {
        assert!(text(&book().join(chapter)).contains(&format!("src=\"../pictures/{shown}\"")), "{chapter}: {shown}");
    }
}

/// The picture equals the one kept with its table, which takes two minutes of runs to draw.
#[test]
fn the_work_precision_diagram_is_the_kept_one() {
    let kept = text(&root().join("tests/accuracy/accuracy.svg"));
    assert_eq!(text(&book().join("pictures/accuracy.svg")), kept);
    assert!(text(&book().join("evidence/speed.md")).contains("src=\"../pictures/accuracy.svg\""));
}

#[test]
fn a_picture_that_does_not_say_what_it_shows_is_told() {
    let svg = |title: &str| format!("<svg><text font-size=\"3\" font-weight=\"bold\">\n{title}\n</text></svg>");
    assert_eq!(untitled(&svg("a: friction"), Some("a")), None);
    assert_eq!(untitled(&svg("a: friction"), None), None);
    assert!(untitled(&svg("a"), Some("a")).is_some() && untitled(&svg("a"), Some("a: trials")).is_some());
    assert!(untitled(&svg(""), None).is_some() && untitled("<svg><text>a</text></svg>", None).is_some());
    let page = "<figure><figcaption>a</figcaption></figure><figure><svg/></figure><figure><figcaption> </figcaption>";
    assert_eq!(without_caption(page), 2);
}
