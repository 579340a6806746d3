//! Tests of the page's server: the loop through its addresses, and attacks on them.

#![allow(clippy::unwrap_used, reason = "a test that unwraps in vain fails, as it should")]

mod attacks;
mod client;
mod files;
mod work;

use std::fs;
use std::path::{Path, PathBuf};

/// Folder of the repository.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").canonicalize().unwrap()
}

/// Copies the files of a folder of the repository.
fn copy(from: &str, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(root().join(from)).unwrap().map(Result::unwrap) {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.file_type().unwrap().is_dir() {
            copy(&format!("{from}/{name}"), &to.join(&name));
        } else {
            fs::copy(entry.path(), to.join(&name)).unwrap();
        }
    }
}

/// A design that is found in a second.
const DESIGN: &str = r#"# quick
name = "quick"
[material]
youngs_modulus_gpa = 0.38
density_g_cm3 = 0.9
friction = { static_mean = 0.30, dynamic_mean = 0.27, relative_std = 0.05 }
area_law = { pressure_mpa = [0.7, 2.6, 26.0], factor = [1.0, 0.8, 0.3] }
[target]
quantity = "ratio"
pressure_mpa = 2.6
value = 0.85  # what is asked for
tolerance = 0.1
[bounds]
width_um = [100, 200]
spacing_um = [200, 400]
depth_um = [5, 20]
[specimen]
shape = "disc"
diameter_mm = 2
[sample]
layer_um = 60
block_um = 10
"#;
