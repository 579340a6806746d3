//! Exported files read back, with readers written from the formats' descriptions.

use std::collections::BTreeMap;
use std::io::{self, Write};

use slipgrid_base::statistics::extremes;
use slipgrid_model::pattern::{Pattern, Planform, Texture};

use crate::export::gcode::read as read_gcode;
use crate::export::layout::every_kind;
use crate::export::stream::text;
use crate::export::*;

const HEADING: Heading = Heading { name: "a \"test\" (1)", version: "0.0.0", notes: &["synthetic surface"] };

const OUTLINES: [Outline; 3] = [
    Outline::Disc { diameter_m: 4e-3 },
    Outline::Rectangle { length_m: 3e-3, width_m: 2e-3 },
    Outline::Ring { outer_diameter_m: 4e-3, inner_diameter_m: 1.3e-3 },
];

fn laser() -> Laser {
    Laser {
        spot_um: Some(23.0),
        hatch_um: Some(20.0),
        speed_mm_s: Some(10.0),
        repetition_hz: Some(1e3),
        depth_per_burst_um: Some(0.4),
        ..Laser::default()
    }
}

/// Layouts of every kind of texture on every outline, complete and cut.
fn layouts() -> Vec<Layout> {
    let mut all = Vec::new();
    for texture in every_kind() {
        let pattern = Pattern::new(texture, 131.2347e-6, 369.9999e-6, 5.2e-6).unwrap();
        for outline in OUTLINES {
            all.extend([Layout::new(pattern, outline).unwrap(), Layout::clipped(pattern, outline).unwrap()]);
        }
    }
    all
}

#[test]
fn plots_read_back_to_the_same_paths_within_a_quarter_of_a_nanometre() {
    let marking = Marking::new(&laser()).unwrap();
    for layout in layouts() {
        let hatch = marking.on(&layout);
        let plot = text(|to| hpgl(&layout, Some(&marking), &HEADING, to));
        assert!(plot.is_ascii() && plot.starts_with("CO \"slipgrid 0.0.0: a 'test' (1)\";"));
        // Each path with its pen.
        let (mut pen, mut paths) = (0, Vec::new());
        for command in plot.split(";\n").flat_map(|line| line.split(';')) {
            let values = |text: &str| -> Vec<f64> {
                text.split(',').filter_map(|value| value.parse::<f64>().ok()).map(|units| units * 25e-6).collect()
            };
            match command.get(..2) {
                Some("SP") => pen = command[2..].parse().unwrap(),
                Some("PU") => paths.push((pen, values(&command[2..]))),
                Some("PD") => paths.last_mut().unwrap().1.extend(values(&command[2..])),
                _ => {}
            }
        }
        let of_pen = |wanted: u32| paths.iter().filter(move |(pen, path)| *pen == wanted && !path.is_empty());
        let boundaries: Vec<Boundary> = layout.iter().flat_map(|cavity| cavity.boundaries()).collect();
        assert_eq!(of_pen(2).count(), boundaries.len());
        for ((_, path), boundary) in of_pen(2).zip(&boundaries) {
            let mut corners = boundary.polygon_m();
            corners.push(corners[0]);
            let expected = corners.concat();
            assert_eq!(path.len(), expected.len());
            assert!(path.iter().zip(expected).all(|(read, laid)| (read - laid).abs() < 0.26e-9));
        }
        let lines: Vec<Line> = layout.iter().flat_map(|cavity| hatch.lines(&cavity)).collect();
        assert_eq!(of_pen(3).count(), lines.len());
        for ((_, path), line) in of_pen(3).zip(lines) {
            assert!(path.iter().zip(line.concat()).all(|(read, laid)| (read - laid).abs() < 0.26e-9));
        }
        assert_eq!(of_pen(1).count(), if layout.outline().name() == "ring" { 2 } else { 1 });
    }
}

#[test]
fn programs_read_back_to_the_lines_of_every_pass() {
    let laser = laser();
    let marking = Marking::new(&laser).unwrap();
    for layout in layouts() {
        let hatch = marking.on(&layout);
        // 13 bursts; a pass over an infinite hatch gives (pi/4) 23^2/(10 20) = 2.08.
        let passes = Removal::new(&layout, &laser).unwrap().passes;
        assert!((5..=7).contains(&passes), "{passes}");
        let program = text(|to| gcode(&layout, &GcodePlan::new(&laser, passes).unwrap(), &HEADING, to));
        assert!(program.starts_with("(slipgrid 0.0.0: a \"test\" [1])\n"), "{program}");
        assert!(program.contains("\nG1 F600\n") && program.ends_with("M5\nG0 X0 Y0\nM2\n"));
        let expected: Vec<Line> = layout
            .iter()
            .flat_map(|cavity| (0..passes).flat_map(|_| hatch.lines(&cavity)).collect::<Vec<_>>())
            .collect();
        let read = read_gcode(&program);
        assert_eq!(read.len(), expected.len());
        for (read, line) in read.iter().zip(&expected) {
            assert!(read.concat().iter().zip(line.concat()).all(|(read, laid)| (read - laid).abs() < 0.6e-9));
        }
    }
    let refused = GcodePlan::new(&Laser { speed_mm_s: None, ..laser }, 1).unwrap_err().to_string();
    assert!(refused.contains("laser.speed_mm_s"));
}

#[test]
fn tables_of_corners_and_lines_read_back() {
    let marking = Marking::new(&laser()).unwrap();
    let rows = |text: &str| -> Vec<Vec<f64>> {
        text.lines().skip(1).map(|line| line.split(',').map(|field| field.parse().unwrap()).collect()).collect()
    };
    for layout in layouts() {
        let hatch = marking.on(&layout);
        let corners = rows(&text(|to| corners_csv(&layout, to)));
        let expected = layout.iter().enumerate().flat_map(|(index, cavity)| {
            let parts = cavity.boundaries();
            let corners = parts.iter().enumerate().flat_map(|(part, boundary)| {
                boundary.polygon_m().into_iter().map(move |corner| (part, corner)).collect::<Vec<_>>()
            });
            corners.map(move |(part, corner)| (index, part, corner)).collect::<Vec<_>>()
        });
        let expected: Vec<_> = expected.collect();
        assert_eq!(corners.len(), expected.len());
        for (row, (index, part, [x, y])) in corners.iter().zip(expected) {
            assert_eq!((row[0], row[1]), ((index + 1) as f64, (part + 1) as f64));
            assert!((row[3] - x * 1e3).abs() < 0.6e-6 && (row[4] - y * 1e3).abs() < 0.6e-6);
        }
        let lines = rows(&text(|to| hatch_csv(&layout, &marking, to)));
        let expected: Vec<Line> = layout.iter().flat_map(|cavity| hatch.lines(&cavity)).collect();
        assert_eq!(lines.len(), expected.len());
        for (row, line) in lines.iter().zip(expected) {
            assert!(row[2..].iter().zip(line.concat()).all(|(read, laid)| (read - laid * 1e3).abs() < 0.6e-6));
        }
    }
}

/// The line distances on the process sheet are those between the lines of `hatch.csv`.
#[test]
fn the_sheet_states_the_distances_that_lines_have() {
    let laser = laser();
    let marking = Marking::new(&laser).unwrap();
    let mut nearer = 0;
    for layout in layouts() {
        let input = ProcessInput { laser, tolerances: None, ..process::tests::input(None) };
        let work = ProcessSheet::new(&layout, input).unwrap().work;
        assert_eq!(work.line_distance_um, Some(20.0));
        let (least_um, greatest_um) = (work.least_line_distance_um.unwrap(), work.greatest_line_distance_um.unwrap());
        assert!(least_um <= greatest_um && greatest_um <= 20.0 + 1e-3);
        let csv = text(|to| hatch_csv(&layout, &marking, to));
        let mut cavities: BTreeMap<usize, Vec<[f64; 4]>> = BTreeMap::new();
        for row in csv.lines().skip(1) {
            let row: Vec<f64> = row.split(',').map(|field| field.parse().unwrap()).collect();
            cavities.entry(row[0] as usize).or_default().push([row[2], row[3], row[4], row[5]]);
        }
        let is_cut_in_parts = layout.iter().any(|cavity| cavity.boundaries().len() > 1);
        let mut apart_um = Vec::new();
        for lines in cavities.values() {
            // Across the longest line, whose direction is most accurate in the decimals of the file.
            let length_mm = |line: &[f64; 4]| (line[2] - line[0]).hypot(line[3] - line[1]);
            let longest = lines.iter().max_by(|a, b| length_mm(a).total_cmp(&length_mm(b))).unwrap();
            let [x0, y0, x1, y1] = *longest;
            let [dx, dy] = [(x1 - x0) / length_mm(longest), (y1 - y0) / length_mm(longest)];
            let middle_um = |line: &[f64; 4]| {
                let [x_mm, y_mm] = [f64::midpoint(line[0], line[2]) - x0, f64::midpoint(line[1], line[3]) - y0];
                1e3 * (y_mm * dx - x_mm * dy)
            };
            let mut offsets_um: Vec<f64> = lines.iter().map(middle_um).collect();
            offsets_um.sort_by(f64::total_cmp);
            apart_um.extend(offsets_um.windows(2).map(|pair| pair[1] - pair[0]).filter(|apart_um| *apart_um > 0.1));
        }
        if is_cut_in_parts {
            continue;
        }
        let [least_found_um, greatest_found_um] = extremes(apart_um.iter().copied());
        let what = format!("{:?}, {:?}", layout.pattern().texture(), layout.outline());
        assert!((least_found_um - least_um).abs() < 0.1, "{what}: {least_found_um} and {least_um} um");
        assert!((greatest_found_um - greatest_um).abs() < 0.1, "{what}: {greatest_found_um} and {greatest_um} um");
        nearer += usize::from(greatest_um < 19.9);
    }
    assert!(nearer > 5, "{nearer} layouts with nearer lines");
}

/// Heights, 0 to 1, of a 16-bit grey PNG, and its pixels per metre.
fn read_png(bytes: &[u8]) -> (u32, u32, Vec<f64>, u32) {
    let mut reader = png::Decoder::new(io::Cursor::new(bytes)).read_info().unwrap();
    let mut data = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut data).unwrap();
    assert_eq!((info.color_type, info.bit_depth), (png::ColorType::Grayscale, png::BitDepth::Sixteen));
    let heights = data.chunks_exact(2).map(|pair| f64::from(u16::from_be_bytes([pair[0], pair[1]])) / 65_535.0);
    (info.width, info.height, heights.collect(), reader.info().pixel_dims.unwrap().xppu)
}

#[test]
fn height_maps_hold_the_area_and_the_volume_of_the_cavities() {
    for (place, layout) in layouts().into_iter().enumerate() {
        // On each outline, one of the whole and the clipped cavities has vertical walls, the other inclined ones.
        let taper_deg = Some(60.0).filter(|_| (place + place / 2) % 2 == 0);
        let laser = Laser { wall_taper_deg: taper_deg, ..laser() };
        let map = HeightMap::new(&layout, &laser, Some(4.0)).unwrap();
        let mut bytes = Vec::new();
        height_map(&layout, &map, &HEADING, &mut bytes).unwrap();
        let (columns, rows, heights, per_metre) = read_png(&bytes);
        assert_eq!(([columns, rows], per_metre), (map.size, 250_000));
        let removed = heights.iter().map(|height| 1.0 - height).sum::<f64>() * 16e-12;
        // With vertical walls it is the area, otherwise the volume over the depth. Edges of round and turned cavities
        // are sampled randomly, those along the raster's axes are off by at most one pixel.
        let expected = match taper_deg {
            None => layout.cavity_area_m2(),
            Some(_) => {
                let inset_m = laser.floor_inset_m(5.2e-6);
                let area = |cavity: &Cavity, share: f64| cavity.inset(share * inset_m).unwrap().area_m2();
                layout.iter().map(|c| (c.area_m2() + 4.0 * area(&c, 0.5) + area(&c, 1.0)) / 6.0).sum()
            }
        };
        assert!((removed / expected - 1.0).abs() < 0.035, "{layout:?}: {removed:e} for {expected:e}");
    }
    // A millimetre with known squares: lattice points at -0.25, 0 and 0.25 mm, y up.
    let pattern = Pattern::new(Planform::Square, 100e-6, 150e-6, 5e-6).unwrap();
    let layout = Layout::new(pattern, Outline::Rectangle { length_m: 0.6e-3, width_m: 0.3e-3 }).unwrap();
    let mut bytes = Vec::new();
    let map = HeightMap::new(&layout, &Laser::default(), Some(10.0)).unwrap();
    height_map(&layout, &map, &HEADING, &mut bytes).unwrap();
    let (columns, rows, heights, _) = read_png(&bytes);
    assert_eq!((columns, rows), (60, 30));
    for (place, height) in heights.iter().enumerate() {
        let (column, row) = (place % 60, place / 60);
        let inside = [0, 25, 50].iter().any(|start| (*start..start + 10).contains(&column)) && (10..20).contains(&row);
        assert_eq!(*height, if inside { 0.0 } else { 1.0 }, "{column} {row}");
    }
    let refused = HeightMap::new(&layout, &Laser::default(), Some(1e-3)).unwrap_err().to_string();
    assert!(refused.contains("32768"), "{refused}");
    // A pixel as wide as a cavity shows each, a wider one may miss some.
    assert!(HeightMap::new(&layout, &Laser::default(), Some(100.0)).is_ok());
    for pixel_um in [101.0, 20_000.0] {
        let refused = HeightMap::new(&layout, &Laser::default(), Some(pixel_um)).unwrap_err().to_string();
        assert!(refused.contains(&format!("pixels of {pixel_um} um")) && refused.contains("to 100 um"), "{refused}");
    }
}

/// Triangles of a binary STL, in millimetres.
fn read_stl(bytes: &[u8]) -> Vec<[[f64; 3]; 4]> {
    let count = u32::from_le_bytes(bytes[80..84].try_into().unwrap()) as usize;
    assert_eq!(bytes.len(), 84 + 50 * count);
    let number = |at: usize| f64::from(f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap()));
    let row = |start: usize| [number(start), number(start + 4), number(start + 8)];
    (0..count).map(|k| [0, 12, 24, 36].map(|offset| row(84 + 50 * k + offset))).collect()
}

#[test]
fn solids_are_closed_and_hold_the_cavities_volume() {
    for layout in layouts() {
        let mut bytes = Vec::new();
        check_stl(&layout, &laser()).unwrap();
        stl(&layout, &laser(), &HEADING, &mut bytes).unwrap();
        let triangles = read_stl(&bytes);
        // Every edge occurs once in each direction.
        let mut edges: Vec<[[u32; 3]; 2]> = Vec::new();
        let bits = |corner: [f64; 3]| corner.map(|value| (value as f32 + 0.0).to_bits());
        for [_, a, b, c] in &triangles {
            edges.extend([[*a, *b], [*b, *c], [*c, *a]].map(|edge| edge.map(bits)));
        }
        let mut back: Vec<[[u32; 3]; 2]> = edges.iter().map(|[from, to]| [*to, *from]).collect();
        edges.sort_unstable();
        back.sort_unstable();
        assert_eq!(edges, back);
        for [_, a, b, c] in &triangles {
            let [u, v] = [b, c].map(|to| [0, 1, 2].map(|axis| to[axis] - a[axis]));
            let normal = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
            // Corners are a nanometre apart, in single precision.
            assert!(normal.iter().any(|part| part.abs() > 1e-11), "{layout:?}: {a:?} {b:?} {c:?}");
        }
        // Divergence theorem: V = 1/6 sum a . (b x c); single precision on a specimen of 4 mm.
        let volume_mm3: f64 = triangles
            .iter()
            .map(|[_, a, b, c]| {
                let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]];
                (a[0] * cross[0] + a[1] * cross[1] + a[2] * cross[2]) / 6.0
            })
            .sum();
        let round = layout.pattern().planform() == Planform::Disc;
        // sin(x)/x for a polygon of 64 corners, x = 2 pi / 64
        let share = if round && !layout.specimen().is_clipped { 0.998_394 } else { 1.0 };
        let expected = layout.cavity_volume_m3() * 1e9 * share;
        let slack = if round { 2e-3 } else { 1e-4 };
        assert!((volume_mm3 / expected - 1.0).abs() < slack, "{layout:?}: {volume_mm3} for {expected}");
        let lies = |z: f64| z == 0.0 || (z + 5.2e-3).abs() < 1e-8;
        assert!(triangles.iter().flat_map(|[_, a, b, c]| [a, b, c]).all(|corner| lies(corner[2])));
    }
}

#[test]
fn leaning_walls_make_frustums_and_are_not_cut() {
    let pattern = Pattern::new(Planform::Square, 130e-6, 370e-6, 5.2e-6).unwrap();
    let laser = Laser { wall_taper_deg: Some(45.0), ..Laser::default() };
    let one = Layout::new(pattern, Outline::Rectangle { length_m: 0.2e-3, width_m: 0.2e-3 }).unwrap();
    let mut bytes = Vec::new();
    stl(&one, &laser, &HEADING, &mut bytes).unwrap();
    let low: Vec<f64> = read_stl(&bytes)
        .iter()
        .flat_map(|[_, a, b, c]| [*a, *b, *c])
        .filter(|p| p[2] < 0.0)
        .map(|p| p[0].abs())
        .collect();
    assert!(low.iter().all(|x| (x - 0.0598).abs() < 1e-6));
    let cut = Layout::clipped(pattern, Outline::Disc { diameter_m: 4e-3 }).unwrap();
    assert!(check_stl(&cut, &laser).unwrap_err().to_string().contains("that the rim cuts"));
    assert_eq!(check_stl(&cut, &Laser::default()), Ok(()));
    let steep = Laser { wall_taper_deg: Some(80.0), ..Laser::default() };
    let shallow = Pattern::new(Planform::Square, 50e-6, 370e-6, 5.2e-6).unwrap();
    assert!(steep.check(&shallow).unwrap_err().to_string().contains("wall_taper_deg"));
}

#[test]
fn a_pattern_finer_than_the_laser_is_refused_with_the_limit() {
    let pattern = Pattern::new(Planform::Square, 20e-6, 30e-6, 5e-6).unwrap();
    let refused = |laser: Laser| laser.check(&pattern).unwrap_err().to_string();
    assert_eq!(refused(laser()), "smallest extent of a cavity of 20 um is below spot_um, 23 um");
    let land = Laser { min_land_um: Some(40.0), ..Laser::default() };
    assert!(refused(land).starts_with("land between cavities of 30"));
    assert_eq!(Laser { spot_um: Some(20.0), min_land_um: Some(30.0), ..Laser::default() }.check(&pattern), Ok(()));
}

/// Counts bytes and the largest piece written.
#[derive(Default)]
struct Meter {
    bytes: usize,
    largest: usize,
}

impl Write for Meter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes += bytes.len();
        self.largest = self.largest.max(bytes.len());
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_hundred_thousand_cavities_are_handed_on_piece_by_piece() {
    let disc = Texture::new(Planform::Square);
    let pattern = Pattern::new(disc, 20e-6, 8e-6, 5e-6).unwrap();
    let layout = Layout::clipped(pattern, Outline::Disc { diameter_m: 10e-3 }).unwrap();
    assert!(layout.cavities() > 99_000);
    let laser = Laser { spot_um: Some(10.0), ..laser() };
    let laser = Laser { hatch_um: Some(10.0), ..laser };
    let marking = Marking::new(&laser).unwrap();
    let plan = GcodePlan::new(&laser, 1).unwrap();
    let map = HeightMap::new(&layout, &laser, Some(20.0)).unwrap();
    type Written<'a> = (&'a str, Box<dyn Fn(&mut dyn Write) -> io::Result<()> + 'a>);
    let writers: Vec<Written<'_>> = vec![
        ("dxf", Box::new(|to| dxf(&layout, &HEADING, to))),
        ("svg", Box::new(|to| svg(&layout, &HEADING, to))),
        ("plt", Box::new(|to| hpgl(&layout, Some(&marking), &HEADING, to))),
        ("gcode", Box::new(|to| gcode(&layout, &plan, &HEADING, to))),
        ("csv", Box::new(|to| csv(&layout, Some(2), to))),
        ("corners", Box::new(|to| corners_csv(&layout, to))),
        ("lines", Box::new(|to| hatch_csv(&layout, &marking, to))),
        ("stl", Box::new(|to| stl(&layout, &laser, &HEADING, to))),
        ("png", Box::new(|to| height_map(&layout, &map, &HEADING, to))),
    ];
    for (name, write) in writers {
        let mut meter = Meter::default();
        write(&mut meter).unwrap();
        assert!(meter.bytes > if name == "png" { 1_000 } else { 1_000_000 }, "{name}: {}", meter.bytes);
        assert!(meter.largest < 1 << 17, "{name}: {}", meter.largest);
    }
}

/// A floor of 2 um cannot be cut in passes of 3 um, whatever bursts would give.
#[test]
fn depths_are_whole_passes_or_whole_bursts() {
    // 20 um spots every 2 um on lines 10 um apart: (pi / 4) 20^2 / (2 x 10) = 15.7 bursts of 0.2 um.
    let hatched = Laser {
        spot_um: Some(20.0),
        repetition_hz: Some(50e3),
        speed_mm_s: Some(100.0),
        hatch_um: Some(10.0),
        depth_per_burst_um: Some(0.2),
        ..Laser::default()
    };
    assert!((hatched.infinite_pass_um().unwrap() - std::f64::consts::PI).abs() < 1e-12);
    let deep = |depth_um: f64| Pattern::new(Planform::Square, 110e-6, 170e-6, depth_um * 1e-6).unwrap();
    // Lines spread evenly over the width are nearer than 10 um.
    let step_um = hatched.depth_step_um(&deep(2.0)).unwrap();
    assert!((3.2..3.5).contains(&step_um), "{step_um}");
    let refused = hatched.check_depth(&deep(2.0)).unwrap_err().to_string();
    assert!(refused.contains("whole number of passes of 3."), "{refused}");
    assert_eq!(hatched.check_depth(&deep(2.0 * step_um)), Ok(()));
    assert_eq!(hatched.bursts(2e-6 * step_um), None, "bursts on a spot do not give the depth");
    // A mask exposes the whole cavity, and a spot that does not move stays for whole bursts.
    let mask = Laser { exposure: Some(Exposure::Mask), ..hatched };
    let still = Laser { speed_mm_s: None, ..hatched };
    for laser in [mask, still] {
        assert_eq!((laser.depth_step_um(&deep(2.0)), laser.bursts(2e-6)), (Some(0.2), Some(10)));
        assert_eq!(laser.check_depth(&deep(2.0)), Ok(()));
        assert!(laser.check_depth(&deep(2.1)).unwrap_err().to_string().contains("whole number of bursts of 0.2 um"));
    }
    assert_eq!(Laser::default().check_depth(&deep(2.1)), Ok(()));
}
