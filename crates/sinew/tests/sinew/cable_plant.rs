//! The plant's cable: every effect does what it says, alone, and can be left out.
#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use sinew::Error;
use sinew::transmission::Sliding;
use sinew::transmission::cable::{Cable, CableLaw, CableParameters, CablePath, EndMotion};
use sinew::twin::cable::{
    BraidCreep, Breakage, CablePlant, CablePlants, CableReading, DragHeat, Effects, Resolution,
    SheathCompliance, SlowFriction, Specimen, UnevenCurvature,
};

fn only(change: impl Fn(&mut Effects)) -> Specimen {
    let mut specimen = Specimen::ideal();
    change(&mut specimen.effects);
    specimen
}

fn plant(specimen: &Specimen) -> CablePlant {
    let mut plant = CablePlant::new(specimen, Resolution::default()).unwrap();
    plant.settle(100.0, Sliding::TowardMotor).unwrap();
    plant
}

fn both(speed: f64) -> EndMotion {
    EndMotion { motor: 1e-3 * speed, anchor: 1e-3 * speed }
}

/// Ends after sliding at a speed for some seconds.
fn slid(plant: &mut CablePlant, speed: f64, seconds: f64) -> CableReading {
    let mut reading = plant.step(1e-3, both(speed)).unwrap();
    for _ in 1..(seconds * 1e3) as usize {
        reading = plant.step(1e-3, both(speed)).unwrap();
    }
    reading
}

/// A working motion: strokes with reversals and a load that swings.
fn work(t: f64) -> EndMotion {
    let anchor = 1e-3 * 0.06 * (1.3 * t).sin();
    EndMotion { motor: anchor + 1e-3 * 0.02 * (2.1 * t).cos(), anchor }
}

#[test]
fn without_effects_the_plant_is_the_law() {
    let mut plant = CablePlant::new(&Specimen::ideal(), Resolution { cells: 12, substeps: 1 }).unwrap();
    let law = CableLaw::new(&CablePath::bench(), &CableParameters::bench(), 12).unwrap();
    let mut cable = Cable::new(law);
    plant.settle(70.0, Sliding::TowardMotor).unwrap();
    cable.settle(70.0, Sliding::TowardMotor).unwrap();
    for k in 0..3000 {
        let motion = work(f64::from(k) * 1e-3);
        let (a, b) = (plant.step(1e-3, motion).unwrap(), cable.step(1e-3, motion).unwrap());
        assert_eq!(a.tension_in.to_bits(), b.tension_in.to_bits());
        assert_eq!(a.tension_out.to_bits(), b.tension_out.to_bits());
    }
}

#[test]
fn the_default_resolution_is_fine_enough() {
    for seed in [0, 1] {
        let specimen = Specimen::draw(seed);
        let mut coarse = CablePlant::new(&specimen, Resolution::default()).unwrap();
        let mut fine = CablePlant::new(&specimen, Resolution { cells: 64, substeps: 8 }).unwrap();
        coarse.settle(100.0, Sliding::TowardMotor).unwrap();
        fine.settle(100.0, Sliding::TowardMotor).unwrap();
        let (mut near, mut far) = (0.0, 0.0);
        for k in 0..8000 {
            let motion = work(f64::from(k) * 1e-3);
            let (a, b) = (coarse.step(1e-3, motion).unwrap(), fine.step(1e-3, motion).unwrap());
            near += (a.tension_in - b.tension_in).powi(2) / 8000.0;
            far += (a.tension_out - b.tension_out).powi(2) / 8000.0;
        }
        assert!(near.sqrt() < 0.3 && far.sqrt() < 0.15, "{} N near, {} N far", near.sqrt(), far.sqrt());
    }
}

#[test]
fn uneven_curvature_affects_reversals_and_not_steady_sliding() {
    let uneven = only(|e| e.curvature = Some(UnevenCurvature { parts: vec![3.0, 1.0, 0.1] }));
    let (mut a, mut b) = (plant(&Specimen::ideal()), plant(&uneven));
    let (even, bent) = (slid(&mut a, 0.05, 2.0), slid(&mut b, 0.05, 2.0));
    let ratio = |r: CableReading| r.tension_in / (r.tension_out - 15.5);
    assert!((ratio(even) / ratio(bent) - 1.0).abs() < 0.01);
    let back = EndMotion { motor: -2e-4, anchor: 0.0 };
    for _ in 0..60 {
        a.step(1e-3, back).unwrap();
        b.step(1e-3, back).unwrap();
    }
    let (even, bent) = (a.step(1e-3, back).unwrap(), b.step(1e-3, back).unwrap());
    assert!((even.tension_in - bent.tension_in).abs() > 2.0, "{even:?} {bent:?}");
}

#[test]
fn a_soft_wall_makes_the_cable_longer_under_the_same_tension() {
    let soft = only(|e| e.sheath = Some(SheathCompliance::default()));
    let stretch = |specimen: &Specimen| slid(&mut plant(specimen), 0.02, 0.1).stretch;
    let (hard, soft) = (stretch(&Specimen::ideal()), stretch(&soft));
    assert!(soft > 1.03 * hard && soft < 1.1 * hard, "{hard} {soft}");
}

#[test]
fn friction_warms_the_sheath_and_lowers_the_drag_until_it_cools() {
    let warm = only(|e| e.heat = Some(DragHeat::default()));
    let (mut plant, mut cold) = (plant(&warm), plant(&Specimen::ideal()));
    // Back and forth, so that the stretch stays and the work goes into friction.
    for k in 0..60_000 {
        let motion = both(0.15 * (f64::from(k) * 5e-3).sin());
        plant.step(1e-3, motion).unwrap();
        cold.step(1e-3, motion).unwrap();
    }
    let (hot, reference) = (slid(&mut plant, 0.12, 1.0), slid(&mut cold, 0.12, 1.0));
    assert!(hot.warming > 2.0 && hot.warming < 30.0, "{} K", hot.warming);
    let loss = |r: CableReading| r.tension_in / (r.tension_out - 15.5);
    assert!(loss(hot) < loss(reference) - 0.02, "{} and {}", loss(hot), loss(reference));
    let rested = slid(&mut plant, 0.0, 200.0);
    assert!(rested.warming < 0.02 * hot.warming && reference.warming == 0.0);
}

#[test]
fn a_braid_under_load_loses_tension_slowly_and_no_more_than_its_share() {
    let creeping = only(|e| e.creep = Some(BraidCreep::default()));
    let (mut a, mut b) = (plant(&creeping), plant(&Specimen::ideal()));
    let (at_once, held) = (slid(&mut a, 0.0, 1.0), slid(&mut b, 0.0, 120.0));
    let later = slid(&mut a, 0.0, 119.0);
    assert!(later.tension_in < at_once.tension_in - 1.0);
    let fraction = later.stretch / held.stretch;
    assert!((0.95..0.99).contains(&fraction), "{fraction}");
}

#[test]
fn friction_is_higher_at_creeping_speed() {
    let slow = only(|e| {
        e.slow = Some(SlowFriction::default());
    });
    let loss = |specimen: &Specimen, speed: f64| {
        let reading = slid(&mut plant(specimen), speed, 6.0);
        (reading.tension_in / (reading.tension_out - 15.5)).ln()
    };
    let ideal = Specimen::ideal();
    assert!(loss(&slow, 0.001) > loss(&ideal, 0.001) + 0.02);
    assert!((loss(&slow, 0.1) - loss(&ideal, 0.1)).abs() < 0.003);
}

#[test]
fn a_cable_breaks_once_reports_the_time_and_stays_broken() {
    let mut plant = plant(&only(|e| e.breakage = Some(Breakage::default())));
    let pull = EndMotion { motor: 3e-4, anchor: 0.0 };
    let mut steps = 0;
    let broken = loop {
        let reading = plant.step(1e-3, pull).unwrap();
        steps += 1;
        assert!(reading.tension_in <= 800.0);
        if let Some(broken) = reading.broken {
            assert_eq!((reading.tension_in, reading.tension_out), (0.0, 0.0));
            break broken;
        }
    };
    assert!((broken.time_s - f64::from(steps) * 1e-3).abs() < 1e-9 && broken.tension > 800.0);
    let back = plant.step(1e-3, EndMotion { motor: -0.05, anchor: 0.0 }).unwrap();
    assert_eq!((back.broken, back.tension_in.to_bits()), (Some(broken), 0.0_f64.to_bits()));
}

#[test]
fn parallel_cables_equal_single_cables_to_the_bit() {
    let specimens: Vec<Specimen> = (0..11).map(Specimen::draw).collect();
    let resolution = Resolution { cells: 16, substeps: 2 };
    let mut many = CablePlants::new(&specimens, resolution).unwrap();
    let mut ones: Vec<_> = specimens.iter().map(|s| CablePlant::new(s, resolution).unwrap()).collect();
    for (k, one) in ones.iter_mut().enumerate() {
        one.settle(60.0 + k as f64, Sliding::TowardMotor).unwrap();
        many.settle(k, 60.0 + k as f64, Sliding::TowardMotor).unwrap();
    }
    let mut readings = vec![CableReading::default(); 11];
    for k in 0..2000 {
        let motions: Vec<_> = (0..11).map(|m| work(f64::from(k) * 1e-3 + f64::from(m))).collect();
        many.step(1e-3, &motions, &mut readings).unwrap();
        for ((one, motion), reading) in ones.iter_mut().zip(&motions).zip(&readings) {
            assert_eq!(one.step(1e-3, *motion).unwrap(), *reading);
        }
    }
    assert!(many.tensions(10).unwrap().eq(ones[10].tensions()) && many.tensions(11).is_err());
}

#[test]
fn parameters_outside_their_domain_are_refused_by_name() {
    let refused = |change: fn(&mut Specimen), name: &str| {
        let mut specimen = Specimen::bench();
        change(&mut specimen);
        let error = CablePlant::new(&specimen, Resolution::default()).unwrap_err();
        assert!(error.to_string().contains(name), "{error}");
    };
    refused(|s| s.effects.creep = Some(BraidCreep { fraction: -0.1, time: 1.0 }), "creep.fraction");
    refused(|s| s.effects.creep = Some(BraidCreep { fraction: 0.1, time: 0.0 }), "creep.time");
    refused(|s| s.effects.heat = Some(DragHeat { capacity: 0.0, ..DragHeat::default() }), "heat.capacity");
    refused(
        |s| s.effects.heat = Some(DragHeat { softening: f64::NAN, ..DragHeat::default() }),
        "heat.softening",
    );
    refused(|s| s.effects.breakage = Some(Breakage { tension: 0.0 }), "breakage.tension");
    refused(|s| s.effects.sheath = Some(SheathCompliance { compliance: -1.0 }), "sheath_compliance");
    refused(|s| s.effects.curvature = Some(UnevenCurvature { parts: vec![0.0] }), "curvature");
    refused(|s| s.parameters.friction = f64::NAN, "friction");
    let none = Resolution { cells: 24, substeps: 0 };
    assert!(matches!(
        CablePlant::new(&Specimen::bench(), none),
        Err(Error::OutOfDomain { name: "substeps", .. })
    ));
    let mut plant = plant(&Specimen::bench());
    assert!(plant.step(1e-3, EndMotion { motor: f64::NAN, anchor: 0.0 }).is_err());
    assert!(plant.step(1.0, EndMotion::default()).is_err());
    assert!(plant.step(1e-3, EndMotion::default()).is_ok());
    assert!(CablePlants::new(&[], Resolution::default()).is_err());
}
