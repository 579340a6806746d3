//! Other programs read the written files, if they are installed: ezdxf. `tests/browser` opens the pages.

use std::process::{Command, Stdio};

use crate::common::{Place, by_hand};

const AUDIT: &str = r#"
import sys
try:
    import ezdxf
except ImportError:
    sys.exit(77)
for path in sys.argv[1:]:
    drawing = ezdxf.readfile(path)
    audit = drawing.audit()
    assert drawing.dxfversion == "AC1009" and not audit.errors and not audit.fixes, (path, audit.errors, audit.fixes)
    layers = {entity.dxf.layer for entity in drawing.modelspace()}
    assert layers == {"OUTLINE", "CAVITIES", "SLIDING_DIRECTION", "ORIGIN"}, layers
    print(path, len(drawing.modelspace()))
"#;

#[test]
fn drawings_pass_an_independent_audit() {
    let place = Place::with(&[]);
    let mut files = Vec::new();
    let shapes = [
        r#""shape": "disc", "diameter_mm": 10.0"#,
        r#""shape": "rectangle", "length_mm": 9.96, "width_mm": 5.0, "cavities": "clipped""#,
        r#""shape": "ring", "outer_diameter_mm": 10.0, "inner_diameter_mm": 4.0, "cavities": "clipped""#,
    ];
    let planforms = [r#""planform": "groove", "angle_deg": 30.0"#, r#""planform": "disc", "arrangement": "staggered""#];
    for (number, (planform, shape)) in planforms.iter().flat_map(|p| shapes.map(|s| (*p, s))).enumerate() {
        place.write("result.json", by_hand(planform, r#""spot_um": 23.0"#, shape));
        place.succeed(&format!("export result.json --format dxf -o {number}"));
        files.push(place.path(&format!("{number}/pattern.dxf")).display().to_string());
    }
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".to_owned());
    let audit = Command::new(python).args(["-c", AUDIT]).args(&files).stdin(Stdio::null()).output();
    // 77: Python is here, ezdxf is not.
    let Some(audit) = audit.ok().filter(|audit| audit.status.code() != Some(77)) else { return };
    assert!(audit.status.success(), "{}", String::from_utf8_lossy(&audit.stderr));
    assert_eq!(String::from_utf8_lossy(&audit.stdout).lines().count(), files.len());
}
