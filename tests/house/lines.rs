//! Size of the program: lines of code by crate, without tests, comments and blank lines.

use crate::rooms::{code, root, sources};

/// Upper limits of the lines of code of each crate. A crate that grows beyond its limit raises the limit in the same
/// change, with the reason; a crate that shrinks lowers it.
const LIMITS: [(&str, usize); 15] = [
    ("base", 1_670),
    ("model", 14_675),
    ("surface", 10_165),
    ("traces", 3_140),
    ("laser", 4_565),
    ("infer", 5_745),
    ("design", 7_055),
    ("io", 9_465),
    ("report", 7_180),
    ("validate", 2_740),
    ("slipgrid", 100),
    ("studio", 1_531),
    ("cli", 2_525),
    ("book", 556),
    ("python", 1_470),
];

/// Lines of code of the crate `room` outside tests.
fn lines(room: &str) -> usize {
    let folder = root().join("crates").join(room);
    let mut files = sources(&folder);
    files.retain(|file| !file.strip_prefix(&folder).unwrap().to_string_lossy().contains("test"));
    let of = |file: &std::path::PathBuf| {
        let text = std::fs::read_to_string(file).unwrap();
        code(&text).into_iter().filter(|(_, line)| !line.trim().is_empty()).count()
    };
    files.iter().map(of).sum()
}

#[test]
fn crates_keep_their_size() {
    let counted = LIMITS.map(|(room, most)| (room, lines(room), most));
    counted.iter().for_each(|(room, lines, most)| println!("{lines:>6} of {most:>6} {room}"));
    println!("{:>6} in all", counted.iter().map(|(_, lines, _)| lines).sum::<usize>());
    for (room, lines, most) in counted {
        assert!(lines <= most, "{room}: {lines} lines, at most {most}");
        assert!(lines + 300 > most, "{room}: {lines} lines, lower the limit of {most}");
    }
}
