//! The program as a person at a terminal meets it.

use std::io::Read;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// A bar that trains in a second.
pub(crate) const BAR: &str = r#"
law = "neo-hookean"
loads = [{ body_force = [0.0, 0.0, -9.8e-3] }]
supports = [{ clamped = "x_min" }]

[mesh]
box = { extent = [30.0, 6.0, 6.0], cells = [6, 2, 2] }

[parameters]
lambda = [8.0, 16.0]
mu = [8.0, 16.0]

[training]
recipe = "regression"
samples = 12
held_out = 4
"#;

fn sinew(folder: &Path, arguments: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
    command.current_dir(folder).args(arguments.split_whitespace()).output().unwrap()
}

/// Output of a command that must succeed.
pub(crate) fn done(folder: &Path, arguments: &str) -> String {
    let output = sinew(folder, arguments);
    let [out, err] =
        [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
    assert!(output.status.success(), "sinew {arguments}\n{out}{err}");
    out + &err
}

/// Exit code and standard error of a command that must fail.
pub(crate) fn refused(folder: &Path, arguments: &str) -> (i32, String) {
    let output = sinew(folder, arguments);
    assert!(!output.status.success(), "sinew {arguments} was to fail");
    let text = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(!text.contains('{') && !text.contains("Err("), "printed for debugging: {text}");
    (output.status.code().unwrap(), text)
}

pub(crate) fn bar() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("bar.toml"), BAR).unwrap();
    folder
}

#[test]
fn from_a_case_to_a_report() {
    let folder = bar();
    let folder = folder.path();
    let solved = done(folder, "solve bar.toml --theta lambda=12,mu=10");
    assert!(solved.contains("mu = 10 kPa, lambda = 12 kPa"), "{solved}");
    assert!(folder.join("out/bar/solve/0000.vtu").exists());

    done(folder, "sample bar.toml --count 5 --design sobol --solve");
    let table = std::fs::read_to_string(folder.join("out/bar/sample/thetas.csv")).unwrap();
    assert!(table.starts_with("mu [kPa],lambda [kPa]\n") && table.lines().count() == 6, "{table}");

    let early = refused(folder, "predict bar.toml");
    assert!(early.0 == 2 && early.1.contains("sinew train"), "{early:?}");
    let trained = done(folder, "train bar.toml");
    assert!(trained.contains("held-out cases"), "{trained}");
    let predicted = done(folder, "predict bar.toml --theta out/bar/sample/thetas.csv");
    assert_eq!(predicted.matches("estimated error").count(), 5, "{predicted}");
    let (mesh, _) =
        sinew_mesh::read_mesh::<4>(folder.join("out/bar/predict/regression/0004.vtu")).unwrap();
    assert_eq!(mesh.point_fields["displacement"].components, 3);

    let error = |told: &str| -> f64 {
        let after = told.split("estimated error ").nth(1).unwrap();
        after.split_whitespace().next().unwrap().parse().unwrap()
    };
    let [plain, refined] = ["", " --refine 4"].map(|more| {
        error(&done(folder, &format!("predict bar.toml --theta mu=10,lambda=12{more}")))
    });
    assert!(refined < 0.2 * plain, "{refined:e} for {plain:e}");

    let corrected = done(folder, "correct bar.toml --theta mu=10,lambda=12 --steps 2");
    assert!(corrected.contains("step 2: residual"), "{corrected}");
    let (mesh, _) =
        sinew_mesh::read_mesh::<4>(folder.join("out/bar/correct/regression/0000.vtu")).unwrap();
    let (solved, _) = sinew_mesh::read_mesh::<4>(folder.join("out/bar/solve/0000.vtu")).unwrap();
    let [found, truth] = [&mesh.point_fields["displacement"], &solved.point_fields["displacement"]];
    let pairs = found.to_f64().into_owned().into_iter().zip(truth.to_f64().into_owned());
    let apart = pairs.fold(0.0f64, |most, (a, b)| most.max((a - b).abs()));
    assert!(apart < 1e-9, "{apart:e} mm from the equilibrium after two steps");
    assert_eq!(mesh.point_fields["displacement_predicted"].components, 3);

    let evaluated = done(folder, "evaluate bar.toml --cases 6");
    assert!(evaluated.contains("2 Newton steps"), "{evaluated}");
    assert!(folder.join("out/bar/report.html").exists());
    std::fs::write(folder.join("bad.csv"), "mu,lambda\n9,ten\n").unwrap();
    let (code, told) = refused(folder, "predict bar.toml --theta bad.csv");
    assert!(code == 2 && told.contains("no row that can be computed"), "{told}");
    assert!(!folder.join("out/bar/predict/regression/cases.csv").exists(), "of an earlier run");
}

#[test]
fn parameters_outside_their_ranges_are_solved_with_a_warning() {
    let folder = bar();
    let told = done(folder.path(), "solve bar.toml --theta lambda=12,mu=20");
    assert!(told.contains("warning: mu = 20 kPa is outside its range from 8 to 16 kPa"), "{told}");
    let (code, told) = refused(folder.path(), "solve bar.toml --theta lambda=12,mu=-2");
    assert!(code == 2 && told.contains("mu"), "{told}");
}

#[test]
fn a_plan_for_many_sets_draws_none_of_them() {
    let folder = bar();
    let told = done(folder.path(), "plan bar.toml --count 10,1e8");
    assert!(told.contains("100000000 parameter sets") && told.contains("s expected"), "{told}");
}

#[test]
fn what_cannot_be_stored_is_not_trained_and_damage_can_be_replaced() {
    let folder = bar();
    let (_, told) = refused(folder.path(), "train bar.toml --target nan");
    assert!(told.contains("target of a regression is NaN"), "{told}");
    done(folder.path(), "train bar.toml");
    std::fs::write(folder.path().join("out/bar/regression/run.json"), "{").unwrap();
    let (_, told) = refused(folder.path(), "train bar.toml --resume");
    assert!(told.contains("begin the run again (--restart)"), "{told}");
    done(folder.path(), "train bar.toml --restart");
    // What is not ours stays, whatever its name.
    let other = folder.path().join("out/bar/other");
    std::fs::create_dir(&other).unwrap();
    std::fs::write(other.join("run.json"), "{\"version\": 4}").unwrap();
    let (_, told) = refused(folder.path(), "train bar.toml --name other");
    assert!(other.join("run.json").exists(), "{told}");
}

#[test]
fn a_run_is_replaced_only_with_restart_and_recipes_share_their_simulations() {
    let folder = bar();
    let folder = folder.path();
    let trained = done(folder, "train bar.toml --recipe dd --steps 20");
    assert!(trained.contains("kept: the network after step"), "{trained}");
    assert!(trained.contains("of 20, the best:"), "{trained}");
    let (_, told) = refused(folder, "train bar.toml --recipe dd --steps 30");
    for wanted in ["out/bar/dd", "--resume reads its emulator", "--restart replaces it", "--name"] {
        assert!(told.contains(wanted), "{told}");
    }
    let (_, told) = refused(folder, "train bar.toml --recipe dd --steps 30 --resume");
    assert!(told.contains("the options"), "{told}");
    let again = done(folder, "train bar.toml --recipe dd --steps 30 --restart");
    assert!(again.contains("of 30, the best:"), "{again}");
    // Solved once for all: the held-out cases, and the twelve that are learned from.
    let shared = || std::fs::read_dir(folder.join("out/bar/simulations")).unwrap().count();
    assert_eq!(shared(), 2);
    done(folder, "train bar.toml --recipe pi --steps 5");
    assert_eq!(shared(), 2);
    for taken in ["simulations", "predict"] {
        let (code, told) = refused(folder, &format!("train bar.toml --name {taken}"));
        assert!(code == 2 && told.contains("commands write into that folder"), "{told}");
    }
    let (code, told) = refused(folder, "train bar.toml --resume --restart");
    assert!(code == 2 && told.contains("--restart"), "{told}");
}

#[test]
fn a_bad_row_is_named() {
    let folder = bar();
    std::fs::write(folder.path().join("thetas.csv"), "lambda,mu\n9,9\n10,ten\n").unwrap();
    let (code, told) = refused(folder.path(), "solve bar.toml --theta thetas.csv");
    assert!(code == 2 && told.contains("thetas.csv, line 3"), "{told}");
    assert!(told.contains("`ten`") && told.contains("mu (from 8 to 16 kPa)"), "{told}");
}

#[test]
fn mistakes_in_a_case_file_are_named_with_their_line() {
    let folder = bar();
    let told = |from: &str, to: &str| {
        assert!(BAR.contains(from));
        std::fs::write(folder.path().join("wrong.toml"), BAR.replace(from, to)).unwrap();
        let (code, text) = refused(folder.path(), "solve wrong.toml");
        assert_eq!(code, 2, "{text}");
        text
    };
    let text = told("mu = [8.0, 16.0]", "mu = [16.0, 8.0]");
    assert!(
        text.contains("wrong.toml, line 11, parameters.mu") && text.contains("[8, 16]"),
        "{text}"
    );
    let text = told("clamped = \"x_min\"", "clamped = \"x_mim\"");
    assert!(text.contains("line 4") && text.contains("did you mean `x_min`?"), "{text}");
    let text = told("mesh]\nbox", "mesh]\nbxo");
    assert!(text.contains("line 7") && text.contains("did you mean `box`?"), "{text}");
    let (code, text) = refused(folder.path(), "solve OnceClampdBeam");
    assert!(code == 2 && text.contains("did you mean `OnceClampedBeam`?"), "{text}");
}

#[test]
fn help_teaches_and_scenes_can_be_copied() {
    let folder = tempfile::tempdir().unwrap();
    for command in
        ["", "solve ", "sample ", "train ", "predict ", "correct ", "evaluate ", "mesh ventricle "]
    {
        let help = done(folder.path(), &format!("{command}--help"));
        assert!(
            ["sinew new", "Example: sinew", "Examples: sinew"].iter().any(|e| help.contains(e)),
            "{help}"
        );
    }
    let listed = done(folder.path(), "scenes");
    for scene in sinew::scenes::SCENES {
        assert!(listed.contains(scene.name));
    }
    let (code, told) = refused(folder.path(), "solve LeftVentricle");
    assert!(code == 2 && told.contains("--mesh FILE"), "{told}");
}

/// Numbers of a table of cases, row by row.
pub(crate) fn table(path: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(path).unwrap();
    // The last three columns are words.
    let rows = text.lines().skip(1).map(|row| row.trim_end_matches(",,,").split(','));
    rows.flatten().map(|x| x.parse::<f64>().unwrap()).collect()
}

#[test]
fn a_signal_stores_what_is_solved_and_the_same_command_goes_on() {
    let folder = bar();
    let folder = folder.path();
    // Ten times the time of the other tests' solves.
    let case = BAR.replace("[6, 2, 2]", "[16, 4, 4]");
    std::fs::write(folder.join("bar.toml"), case).unwrap();
    let line = "sample bar.toml --count 60 --design sobol --solve --out stopped --shard 1/2";
    let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
    command.current_dir(folder).args(line.split_whitespace()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // The options of a campaign are written when its samples are drawn, right before the first solve.
    while !folder.join("stopped/sample/thetas.csv").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(100));
    let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(kill.unwrap().success());
    let mut told = String::new();
    child.stderr.take().unwrap().read_to_string(&mut told).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(3), "{told}");
    assert!(told.contains("the same command goes on"), "{told}");
    let shard = folder.join("stopped/sample/shards/00001-of-00002");
    let rows = std::fs::metadata(shard.join("under-way/theta.npy")).unwrap().len();
    // More than the head of the table, which is 128 bytes.
    assert!(rows > 128 && !shard.join("done.json").exists());
    let told = done(folder, "merge bar.toml --out stopped --status");
    assert!(told.contains("0 of 2 shards done") && told.contains("2/2: nothing"), "{told}");
    assert!(told.contains("of 30 samples tried, 0 without equilibrium, stored "), "{told}");
    done(folder, line);
    assert!(!shard.join("under-way").exists());
    for shard in ["--out stopped --shard 2/2", "--out whole --shard 1/2", "--out whole --shard 2/2"]
    {
        done(folder, &format!("sample bar.toml --count 60 --design sobol --solve {shard}"));
    }
    let [stopped, whole] = ["stopped", "whole"].map(|run| {
        done(folder, &format!("merge bar.toml --out {run}"));
        table(&folder.join(run).join("sample/cases.csv"))
    });
    assert_eq!(stopped.len(), whole.len());
    for (a, b) in stopped.iter().zip(&whole) {
        assert!((a - b).abs() <= 1e-10 * b.abs(), "{a} for {b}");
    }
}

#[test]
fn a_campaign_in_shards_is_that_of_one_process() {
    let folder = bar();
    let folder = folder.path();
    let count = "--count 11 --design sobol --solve";
    done(folder, &format!("sample bar.toml {count} --out whole"));
    let (code, told) = refused(folder, "merge bar.toml --out parts");
    assert!(code == 2 && told.contains("sinew sample"), "{told}");
    // Processes of their own, at the same time, but for one.
    let shards: Vec<_> = [1, 3, 4]
        .map(|index| {
            let line = format!("sample bar.toml {count} --out parts --shard {index}/4");
            let mut command = Command::new(env!("CARGO_BIN_EXE_sinew"));
            command.current_dir(folder).args(line.split_whitespace()).spawn().unwrap()
        })
        .into();
    shards.into_iter().for_each(|mut shard| assert!(shard.wait().unwrap().success()));
    let (_, told) = refused(folder, "merge bar.toml --out parts");
    assert!(told.contains("lacks the shards 2/4"), "{told}");
    let told = done(folder, "merge bar.toml --out parts --status");
    let expected =
        "3 of 4 shards done, 0 samples without equilibrium in them\n2/4: nothing stored yet\n";
    assert!(told.contains(expected), "{told}");
    // What was solved is kept.
    let fields = folder.join("parts/sample/shards/00003-of-00004/displacement.npy");
    let before = std::fs::metadata(&fields).unwrap().modified().unwrap();
    for index in [2, 3] {
        done(folder, &format!("sample bar.toml {count} --out parts --shard {index}/4"));
    }
    assert_eq!(std::fs::metadata(&fields).unwrap().modified().unwrap(), before);
    let file = |name: &str| std::fs::read(folder.join(name)).unwrap();
    let mut merged = Vec::new();
    for _ in 0..2 {
        let told = done(folder, "merge bar.toml --out parts");
        assert!(told.contains("11 of 11 samples solved"), "{told}");
        merged.push(file("parts/sample/cases.csv"));
    }
    assert_eq!(merged[0], merged[1]);
    // A sweep goes from neighbour to neighbour, of which a shard has others: the same to the solver's rounding.
    let [parts, whole] =
        ["parts", "whole"].map(|run| table(&folder.join(run).join("sample/cases.csv")));
    assert_eq!(parts.len(), whole.len());
    // Reactions across the load cancel to rounding errors of forces of some kPa mm².
    for (a, b) in parts.iter().zip(&whole) {
        assert!((a - b).abs() <= 1e-10 * b.abs().max(1e-3), "{a} for {b}");
    }
    // Another campaign does not mix with it, and damage is noticed.
    let (_, told) = refused(folder, "sample bar.toml --count 12 --solve --out parts --shard 1/4");
    assert!(
        told.contains("another campaign (11 samples in 4 shards, design sobol, seed 1)"),
        "{told}"
    );
    let mut bytes = file("parts/sample/shards/00003-of-00004/displacement.npy");
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&fields, bytes).unwrap();
    let (_, told) = refused(folder, "merge bar.toml --out parts");
    assert!(told.contains("3/4 (displacement.npy changed since it was solved)"), "{told}");
    assert_eq!(String::from_utf8(file("parts/sample/thetas.csv")).unwrap().lines().count(), 12);
    // A damaged shard is solved again, not sealed as it is.
    done(folder, &format!("sample bar.toml {count} --out parts --shard 3/4"));
    done(folder, "merge bar.toml --out parts");
    assert_eq!(file("parts/sample/cases.csv"), merged[0]);
    let (code, told) = refused(folder, "sample bar.toml --count 8 --script slurm --shards 9999");
    assert!(code == 2 && told.contains("9999 shards of 8 samples"), "{told}");
    let (code, told) = refused(folder, "sample bar.toml --solve --shard 5/4");
    assert!(code == 2 && told.contains("INDEX/COUNT"), "{told}");
}

#[test]
fn samples_are_not_written_beside_solutions_of_others() {
    let folder = bar();
    let folder = folder.path();
    done(folder, "sample bar.toml --count 3 --design sobol --solve");
    let kept = ["thetas.csv", "cases.csv", "theta.npy"];
    let read = || kept.map(|name| std::fs::read(folder.join("out/bar/sample").join(name)).unwrap());
    let before = read();
    for other in ["--seed 2", "--seed 2 --solve", "--count 4 --design sobol", "--solve --shard 1/2"]
    {
        let (code, told) = refused(folder, &format!("sample bar.toml {other}"));
        let named = "out/bar/sample holds solutions of other parameter sets; choose another --out";
        assert!(code == 2 && told.contains(named), "{other}: {told}");
        assert!(!folder.join("out/bar/sample/campaign.json").exists());
    }
    assert_eq!(read(), before);
    // The same samples, and solves that go on from them.
    done(folder, "sample bar.toml --count 3 --design sobol");
    assert_eq!(read(), before);
    done(folder, "sample bar.toml --count 4 --design sobol --solve");
    assert!(read().iter().zip(&before).all(|(grown, before)| grown.len() > before.len()));
}

#[test]
fn trainings_begin_from_what_there_is() {
    let folder = bar();
    let folder = folder.path();
    done(folder, "sample bar.toml --count 11 --solve");
    let train =
        |more: &str| format!("train bar.toml --steps 5 --simulations out/bar/sample {more}");
    let told = done(folder, &train("--recipe dd"));
    assert!(told.contains("11 simulations"), "{told}");
    // Each number says which of the held-out cases' errors it is.
    let told = done(
        folder,
        "train bar.toml --recipe regression --simulations out/bar/sample --target 1e-15",
    );
    for words in ["11 simulations", "the displacements median", "the root mean square error over"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    // From another run of the same recipe only, and not from one that it would replace.
    let (_, told) = refused(folder, "train bar.toml --steps 5 --recipe pi --from out/bar/dd");
    assert!(told.contains("it is of the recipe `dd`, not `pi`"), "{told}");
    let (_, told) = refused(folder, &train("--recipe dd --from out/bar/dd"));
    assert!(told.contains("which the new run replaces"), "{told}");
    assert!(folder.join("out/bar/dd/emulator").exists());
    done(folder, &train("--recipe dd --from out/bar/dd --name again"));
    let (_, told) = refused(
        folder,
        &train("--recipe regression --from out/bar/dd --name none").replace("--steps 5 ", ""),
    );
    assert!(told.contains("trains no network"), "{told}");
    // What would not be learned from, and where nobody would look for it.
    let (code, told) = refused(folder, &train("--recipe pi"));
    assert!(code == 2 && told.contains("`pi` learns from no simulations"), "{told}");
    let (code, told) = refused(folder, &train("--recipe dd --name ../elsewhere"));
    assert!(code == 2 && told.contains("../elsewhere"), "{told}");
}

/// A scheduler that runs what it is given at once, all tasks of an array, and notes its options.
#[cfg(unix)]
const BSUB: &str = r#"#!/bin/sh
echo "$@" >> options
cat > job
case "$2" in
  *\[1-3\]) for LSB_JOBINDEX in 1 2 3; do export LSB_JOBINDEX; sh job >&2 || exit; done ;;
  *) sh job >&2 || exit ;;
esac
echo "Job <4711> is submitted to default queue <normal>."
"#;

#[test]
#[cfg(unix)]
fn a_campaign_on_lsf_is_an_array_and_a_merge_that_waits_for_it() {
    use std::os::unix::fs::PermissionsExt;
    let folder = bar();
    let folder = folder.path();
    std::fs::write(folder.join("bsub"), BSUB).unwrap();
    std::fs::set_permissions(folder.join("bsub"), PermissionsExt::from_mode(0o755)).unwrap();
    done(folder, "sample bar.toml --count 7 --script lsf --shards 3");
    let own = Path::new(env!("CARGO_BIN_EXE_sinew")).parent().unwrap();
    let path = format!("{}:{}:{}", folder.display(), own.display(), std::env::var("PATH").unwrap());
    let mut command = Command::new("sh");
    command.current_dir(folder).args(["out/bar/sample/lsf.sh", "-W", "240"]).env("PATH", path);
    let output = command.output().unwrap();
    let told = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && told.contains("7 of 7 samples solved"), "{told}");
    let options = std::fs::read_to_string(folder.join("options")).unwrap();
    let [array, merge] = &options.lines().collect::<Vec<_>>()[..] else { panic!("{options}") };
    assert!(array.contains("-Q 3 -wa TERM -wt 1 -W 240"), "{array}");
    assert!(merge.contains("-w done(4711) -W 240"), "{merge}");
}
