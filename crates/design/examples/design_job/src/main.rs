//! Runs the design job from a separate program: a task built in code, a run that another thread may cancel, a drawing for
//! the laser.

use std::error::Error;
use std::fs::File;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;

use slipgrid_design::export::{Heading, Outline, Specimen, dxf};
use slipgrid_design::material::{AreaLaw, Elastic, Friction, LocalFriction, Material, Provenance};
use slipgrid_design::optimize::{DesignSpace, Quantity, Target, TargetPoint};
use slipgrid_design::{DesignTask, NoCache, pattern::Planform, run, springblock::Layer};

fn main() -> Result<(), Box<dyn Error + Send + Sync>> {
    let friction = Friction::Single(LocalFriction::new(0.30, 0.27, 0.05)?);
    let area_law = Some(AreaLaw::new(vec![0.7e6, 2.6e6, 26e6], vec![1.0, 0.8, 0.3])?);
    let material = Material { elastic: Elastic::new(0.38e9, 900.0)?, friction, area_law, provenance: Provenance::default() };
    let target = Target::new(Quantity::Ratio, vec![TargetPoint { pressure_pa: 2.6e6, value: 0.9 }], 0.01)?;
    let space = DesignSpace::new(Planform::Groove, [100e-6, 300e-6], [200e-6, 600e-6], [5e-6, 30e-6])?;
    let specimen = Specimen { outline: Outline::Disc { diameter_m: 4e-3 }, is_clipped: false };
    let layer = Layer { length_m: 4e-3, height_m: 100e-6, block_m: 10e-6, thickness_m: None, holder: None };
    let task = DesignTask::new(material, target, space, specimen, layer);
    let button = AtomicBool::new(false);
    let found = thread::scope(|scope| {
        scope.spawn(|| button.store(std::env::args().any(|argument| argument == "--cancel"), Ordering::Relaxed));
        run(&task, &mut NoCache, &button)
    })?;
    println!("{}", found.report.summary());
    let heading = Heading { name: &task.name, version: &found.report.made_by.version, notes: &[] };
    dxf(&specimen.layout(found.pattern)?, &heading, &mut File::create("pattern.dxf")?)?;
    Ok(())
}
