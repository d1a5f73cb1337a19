//! Patient files: what they are read as, and what is refused in words.

use sinew::PatientFile;
use sinew_calibrate::{Forward, Solves, check_identifiability};

/// A small ventricle with three volumes and strains of four segments.
pub(crate) const PATIENT: &str = r#"
law = { name = "holzapfel-ogden", bulk_modulus = 25.0 }
loads = [{ pressure = "p", facets = "endo" }]
supports = [{ clamped = "base" }]
parameters = { a = [0.1, 0.4], b = 2.0, a_f = [1.5, 5.0], b_f = 2.1, p = { range = [0.0, 40.0], unit = "mmHg", sampling = "linear" } }

[mesh]
ellipsoid = { short = [20.0, 30.0], long = [52.0, 62.0], base = 15.0, cells = [2, 8, 4] }

[fibres.rule]
endocardium = "endo"
epicardium = "epi"
base = "base"
angles = [60.0, -60.0]

[phases.image]
p = "8 mmHg"
[phases.low]
p = "3 mmHg"
[phases.high]
p = "16 mmHg"

[[data]]
volume = "endo"
phase = "low"
value = 44.0
unit = "mL"
sd = "3 %"

[[data]]
volume = "endo"
phase = "high"
value = 72.0
unit = "mL"
sd = 2.0

[[data]]
strain = "circumferential"
phase = "high"
values = [0.05, 0.06, 0.05, 0.06]
sd = 0.02

[calibration]
wall = { endocardium = "endo", epicardium = "epi", base = "base", septum = [-1.0, 0.0, 0.0] }
segments = "1x4"
"#;

fn refused(from: &str, to: &str) -> String {
    assert!(PATIENT.contains(from), "{from}");
    let text = PATIENT.replace(from, to);
    let file = PatientFile::parse(&text, "patient.toml");
    file.and_then(|file| file.prepare()).expect_err(to).to_string()
}

#[test]
fn units_phases_and_segments_are_read() {
    let prepared = PatientFile::parse(PATIENT, "patient.toml").unwrap().prepare().unwrap();
    let problem = &prepared.problem;
    assert_eq!(
        problem.unknowns.iter().map(|u| u.head()).collect::<Vec<_>>(),
        ["a [kPa]", "a_f [kPa]"]
    );
    assert_eq!((problem.data.len(), prepared.segments.as_ref().unwrap().names().len()), (6, 4));
    // 16 mmHg in kPa, 44 mL in mm³ and 3 % as a share.
    assert!((prepared.phases["high"]["p"] - 2.133158).abs() < 1e-6);
    let low = problem.data.iter().find(|d| d.name == "volume of endo at low").unwrap();
    assert_eq!((low.value, low.deviation, low.is_share), (44_000.0, 0.03, true));
    assert!((low.error() - 0.03 * 44.0 * 1e3).abs() < 1e-9);
    let name = |&at: &usize| prepared.observables[at].to_string();
    let reported: Vec<_> = prepared.reported.iter().map(name).collect();
    let expected = ["rest", "high", "low"].map(|state| format!("volume of endo at {state}"));
    assert_eq!(reported, expected);
    // Pressures of another unit are beyond their range; no pressure is none.
    assert!(prepared.warnings().is_empty());
    let kilopascals = PATIENT.replace("16 mmHg", "16 kPa");
    let prepared = PatientFile::parse(&kilopascals, "patient.toml").unwrap().prepare().unwrap();
    let [told] = &prepared.warnings()[..] else { panic!("one phase") };
    assert!(
        told.starts_with("phase high: p = 120.0") && told.contains("outside its range"),
        "{told}"
    );
}

#[test]
fn mistakes_are_refused_with_their_place() {
    let says = |from: &str, to: &str, expected: &[&str]| {
        let error = refused(from, to);
        expected.iter().for_each(|words| assert!(error.contains(words), "{words}: {error}"));
    };
    says("value = 72.0", "value = nan", &["data.1.value", "is NaN"]);
    // It would be read as a change, and is the volume itself.
    let from = "value = 72.0\nfrom = \"low\"";
    says("value = 72.0", from, &["data.1.from", "a volume does not read it"]);
    says("unit = \"mL\"\nsd = 2.0", "sd = 2.0", &["data.1.unit", "the unit is missing", "mL"]);
    says(
        "unit = \"mL\"\nsd = 2.0",
        "unit = \"mmHg\"\nsd = 2.0",
        &["`mmHg` is not a unit of volume"],
    );
    says("p = \"16 mmHg\"", "p = 16.0", &["phases.high.p", "the unit is missing", "16 mmHg"]);
    says("p = \"16 mmHg\"", "p = \"16 bar\"", &["`bar` is not a unit of stress"]);
    says(
        "p = \"16 mmHg\"",
        "q = \"16 mmHg\"",
        &["stresses that have a range in the case file, and `q` is not one of them", "a, a_f, p"],
    );
    // A number without a unit is no stress.
    let free = PATIENT.replace("b = 2.0,", "b = [1.0, 4.0],");
    let free = free.replace("p = \"16 mmHg\"", "p = \"16 mmHg\"\nb = \"2 kPa\"");
    let told = PatientFile::parse(&free, "p.toml").and_then(|file| file.prepare()).expect_err("b");
    assert!(told.to_string().contains("and `b` is not one of them"), "{told}");
    says("[phases.high]", "[phases.low]", &["`low` is there twice"]);
    says(
        "phase = \"high\"\nvalue = ",
        "phase = \"hihg\"\nvalue = ",
        &["no phase `hihg`", "`high`?"],
    );
    let unknown = refused("phase = \"high\"\nvalue = ", "phase = \"systole\"\nvalue = ");
    assert!(
        unknown.trim().ends_with("no phase `systole`; phases: high, image, low, rest"),
        "{unknown}"
    );
    says(
        "volume = \"endo\"\nphase = \"low\"",
        "volume = \"lv\"\nphase = \"low\"",
        &["no cavity `lv`", "endo"],
    );
    says("values = [0.05, 0.06, 0.05, 0.06]", "values = [0.05]", &["1 values for 4 segments"]);
    says("values = [0.05, 0.06, 0.05, 0.06]", "segment = 9\nvalue = 0.1", &["no segment `9`"]);
    says(
        "values = [0.05, 0.06, 0.05, 0.06]",
        "segment = 18\nvalue = 0.1",
        &["no segment `18`; segments: 1"],
    );
    says("segments = \"1x4\"", "segments = \"aha\"", &["`aha` is not a division"]);
    says(", septum = [-1.0, 0.0, 0.0]", "", &["septum"]);
    says("sd = 2.0", "sd = 0.0", &["standard deviation is 0"]);
    says("sd = 0.02", "sd = \"2 %\"", &["a share is for volumes"]);
    says(
        "phase = \"high\"\nvalue = ",
        "phase = \"low\"\nvalue = ",
        &["line 30, data.1", "`volume of endo at low` is given in line 23 already"],
    );
    for (setting, advice) in [
        ("pressure_common = 5", "write 0.05 for 5 %"),
        ("pressure_each = 1.5", "write 0.015 for 1.5 %"),
        ("priors.a = { median = 0.2, sd = 30 }", "write 0.3 for 30 %"),
    ] {
        let key = setting.split_once(" = ").unwrap().0;
        says("[calibration]", &format!("[calibration]\n{setting}"), &[key, advice]);
    }
    says(
        "a = [0.1, 0.4]",
        "a = { range = [0.0, 0.4], sampling = \"linear\" }",
        &["parameters.a", "positive"],
    );
    let four = "strain = \"circumferential\"\npoint = [1.0, 2.0, 3.0, 4.0]";
    says("strain = \"circumferential\"", four, &["data.2.point", "4 values where 3 belong"]);
    says("[-1.0, 0.0, 0.0]", "[-1.0, 0.0, 0.0, 0.0]", &["wall.septum", "4 values where 3 belong"]);
    says(
        "segments = \"1x4\"",
        "segments = \"1x4\"\ninfer_noise = [\"strains\"]",
        &["kind `strains`", "`strain`?"],
    );
    says("segments = \"1x4\"", "segments = \"1x4\"\nsede = 3", &["`seed`?"]);
    says("[phases.image]\np = \"8 mmHg\"", "", &["the loads of the image are missing"]);
}

#[test]
fn phases_without_a_load_of_others_are_refused() {
    let says = |from: &str, to: &str| refused(from, to);
    let error = says("[phases.high]\np = \"16 mmHg\"", "[phases.high]");
    assert!(
        error.contains("phases.high: phase `high` lacks `p`, which phase `image` has"),
        "{error}"
    );
    // With an image at rest its own loads are zero, those of phases are not.
    let at_rest = "[calibration]\nimage_at_rest = true";
    let text = PATIENT.replace("[phases.image]\np = \"8 mmHg\"\n", "");
    let text = text.replace("[calibration]", at_rest);
    let read = |text: &str| PatientFile::parse(text, "patient.toml").unwrap().prepare();
    assert_eq!(read(&text).unwrap().phases["image"]["p"], 0.0);
    let lacking = text.replace("[phases.low]\np = \"3 mmHg\"", "[phases.low]");
    assert!(read(&lacking).unwrap_err().to_string().contains("phase `low` lacks `p`"));
}

#[test]
fn data_that_no_parameter_changes_are_refused() {
    let strain = "strain = \"circumferential\"\nphase = \"high\"";
    let zero = "data.2.phase: it is counted from the same state";
    for to in [
        "strain = \"circumferential\"\nfrom = \"high\"\nphase = \"high\"",
        "strain = \"circumferential\"\nphase = \"image\"",
        "strain = \"circumferential\"\nfrom = \"rest\"\nphase = \"rest\"",
    ] {
        let error = refused(strain, to);
        assert!(error.contains(zero), "{error}");
    }
    // Another name for the same loads, unless each pressure has an error of its own.
    let error = refused("p = \"16 mmHg\"", "p = \"8 mmHg\"");
    assert!(error.contains("data.1.phase: the volume in the image"), "{error}");
    let own = PATIENT.replace("p = \"16 mmHg\"", "p = \"8 mmHg\"") + "pressure_each = 0.05\n";
    assert!(PatientFile::parse(&own, "patient.toml").unwrap().prepare().is_ok());
    let error =
        refused("volume = \"endo\"\nphase = \"low\"", "volume = \"endo\"\nphase = \"image\"");
    assert!(error.contains("data.0.phase: the volume in the image is that of the mesh"), "{error}");
    let moved =
        "displacement = [0.0, 0.0, 1.0]\npoint = [25.0, 0.0, 0.0]\nvalue = 1.0\nunit = \"mm\"";
    let error = refused(
        "strain = \"circumferential\"\nphase = \"high\"\nvalues = [0.05, 0.06, 0.05, 0.06]",
        &format!("{moved}\nfrom = \"low\"\nphase = \"low\""),
    );
    assert!(error.contains(zero), "{error}");
}

#[test]
fn medians_in_another_unit_are_refused() {
    let setting =
        |line: &str| refused("segments = \"1x4\"", &format!("segments = \"1x4\"\n{line}"));
    let error = setting("priors.a = { median = 200.0, sd = 0.3 }");
    let words = "calibration.priors.a: the median 200 is outside of the range of `a`, 0.1 to 0.4 in the unit kPa";
    assert!(error.contains(words), "{error}");
    assert!(setting("priors.a_f = { median = 0.003, sd = 0.3 }").contains("0.003 is outside"));
    let inside = PATIENT.to_string() + "priors.a = { median = 0.4, sd = 0.3 }\n";
    assert!(PatientFile::parse(&inside, "patient.toml").unwrap().prepare().is_ok());
}

#[test]
fn settings_that_make_no_sense_are_refused_with_their_key() {
    let setting = |line: &str, expected: &[&str]| {
        let error = refused("segments = \"1x4\"", &format!("segments = \"1x4\"\n{line}"));
        expected.iter().for_each(|words| assert!(error.contains(words), "{words}: {error}"));
    };
    let prior = "calibration.priors.a: ";
    setting(
        "priors.a = { median = -0.2, sd = 0.3 }",
        &[prior, "the median is -0.2; give a positive"],
    );
    setting(
        "priors.a = { median = 0.2, sd = 0.0 }",
        &[prior, "standard deviation of the logarithm is 0"],
    );
    setting("pressure_common = -1.0", &["calibration.pressure_common: ", "logarithm is -1; give"]);
    setting("pressure_each = nan", &["calibration.pressure_each: ", "logarithm is NaN; give"]);
    for key in ["draws", "design", "checks", "rounds"] {
        setting(&format!("{key} = 0"), &[&format!("calibration.{key}: it is 0; give at least")]);
    }
    setting("degree = 9", &["calibration.degree: it is 9; give at least 1 and at most 4"]);
}

#[test]
fn pressures_in_kpa_that_were_meant_in_mmhg_are_seen_ahead() {
    // 3 and 16 kPa are 22 and 120 mmHg: the volumes cannot be those.
    let text = PATIENT.replace("p = \"3 mmHg\"", "p = \"3 kPa\"");
    let prepared = PatientFile::parse(&text, "patient.toml").unwrap().prepare().unwrap();
    let model = prepared.patient().unwrap();
    let mut solves = Solves::new(&model);
    let (mode, _) = check_identifiability(&prepared.problem, &mut solves).unwrap();
    let low = prepared.problem.data.iter().position(|d| d.name == "volume of endo at low").unwrap();
    assert!(mode.misfits[low] < -5.0, "{:?}", mode.misfits);
}

#[test]
fn factors_of_pressures_are_parameters() {
    let text = PATIENT.replace(
        "segments = \"1x4\"",
        "segments = \"1x4\"\npressure_common = 0.1\npressure_each = 0.05",
    );
    let prepared = PatientFile::parse(&text, "patient.toml").unwrap().prepare().unwrap();
    let names: Vec<_> = prepared.problem.unknowns.iter().map(|u| u.name.as_str()).collect();
    let own = ["high", "image", "low"].map(|phase| format!("pressure factor at {phase}"));
    assert_eq!(names[..3], ["a", "a_f", "pressure factor"]);
    assert_eq!(names[3..], own);
    // All stresses times a factor leave the displacements: the two other laws' parameters are known, so only nearly here.
    let model = prepared.patient().unwrap();
    let [plain, pressed] = [1.0, 1.1]
        .map(|factor| model.observe(&[0.2, 2.8, factor, 1.0, 1.0, 1.0], false).unwrap().values);
    assert!(pressed[1] > plain[1], "{pressed:?} {plain:?}");
    let curve = prepared.curve("endo", &[1.0]).unwrap();
    assert_eq!((curve.parameters(), prepared.curve_parameters()), (4, vec![0, 1, 2, 4]));
}

#[test]
fn the_patient_file_of_the_documentation_is_one() {
    let page = include_str!("../../../../docs/calibration.md");
    let blocks: Vec<&str> = page.split("```toml\n").skip(1).collect();
    assert_eq!(blocks.len(), 1);
    let text = blocks[0].split("```").next().unwrap();
    let prepared = PatientFile::parse(text, "docs").unwrap().prepare().unwrap();
    assert_eq!((prepared.problem.data.len(), prepared.problem.unknowns.len()), (2, 4));
}
