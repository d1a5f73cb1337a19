//! Stored emulators that were damaged, and answers that are no numbers.

use crate::support::{beam, small_network, steps};
use sinew_emulate::{Body, Emulator, TrainingOptions, read_simulations, simulate};
use sinew_energy::laws::NeoHookean;
use sinew_energy::{Load, Magnitude, Parameter, Scene, Support};
use sinew_gnn::Recipe;
use sinew_gnn::recipe::{DataDriven, Regression};
use std::path::{Path, PathBuf};

const THETAS: [[f64; 2]; 2] = [[9.0, 14.0], [15.0, 8.5]];

fn predicted(emulator: &Emulator<'_>) -> Vec<f64> {
    emulator.predict(&THETAS.map(Vec::from)).unwrap().displacement
}

/// Files of a folder and its folders.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}

/// Numbers below `end` that look random, the same every time (Knuth's linear congruence).
struct Dice(u64);

impl Dice {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % end.max(1)
    }
}

/// Writes a file as a new one: some file systems wait for the disk where a file is cut to nothing and written again.
fn write(path: &Path, bytes: &[u8]) {
    // It may be lost.
    let _ = std::fs::remove_file(path);
    std::fs::write(path, bytes).unwrap();
}

/// One damage of one kind: files with what they hold afterwards, none where they are lost.
fn damage(
    kind: usize,
    files: &[(PathBuf, Vec<u8>)],
    others: &[(PathBuf, Vec<u8>)],
    dice: &mut Dice,
) -> Vec<(usize, Option<Vec<u8>>)> {
    let (a, b) = (dice.below(files.len()), dice.below(files.len()));
    let mut bytes = files[a].1.clone();
    match kind {
        0 => {
            let at = dice.below(bytes.len());
            bytes[at] ^= 1 << dice.below(8);
            vec![(a, Some(bytes))]
        }
        1 => {
            bytes.truncate(dice.below(bytes.len()));
            vec![(a, Some(bytes))]
        }
        2 => vec![(a, Some(files[b].1.clone())), (b, Some(bytes))],
        3 => vec![(a, None)],
        // The same file of another emulator of the same body.
        4 => vec![(a, Some(others[a].1.clone()))],
        _ => {
            // A sector of zeros, as a disk that lost power leaves it.
            let from = dice.below(bytes.len());
            let to = (from + 512).min(bytes.len());
            bytes[from..to].fill(0);
            vec![(a, Some(bytes))]
        }
    }
}

/// Kinds of damage.
const KINDS: usize = 6;

/// Damages a stored emulator so often; how often it was refused.
fn refused(body: &Body, [recipe, other]: [&Recipe; 2], times: usize) -> usize {
    let folder = tempfile::tempdir().unwrap();
    let [own, other] = [(recipe, "own"), (other, "other")].map(|(recipe, name)| {
        let place = folder.path().join(name);
        let emulator = recipe.train(body, &TrainingOptions::default(), &mut ()).unwrap();
        emulator.save(&place).unwrap();
        let read = |path: PathBuf| (path.clone(), std::fs::read(path).unwrap());
        (
            predicted(&emulator),
            place.clone(),
            files(&place).into_iter().map(read).collect::<Vec<_>>(),
        )
    });
    let ((truth, place, files), others) = (own, other.2);
    assert_eq!(files.len(), others.len());
    let (mut dice, mut refused) = (Dice(7), 0);
    for time in 0..times {
        let damaged = damage(time % KINDS, &files, &others, &mut dice);
        for (file, bytes) in &damaged {
            match bytes {
                Some(bytes) => write(&files[*file].0, bytes),
                None => std::fs::remove_file(&files[*file].0).unwrap(),
            }
        }
        match sinew_gnn::load(&place, body) {
            // Damage that changes nothing, such as a file that is swapped with itself.
            Ok(emulator) => assert_eq!(predicted(&emulator), truth, "{time}: damaged unnoticed"),
            Err(error) => {
                refused += 1;
                let text = error.to_string();
                assert!(text.contains(&place.display().to_string()), "{text}");
            }
        }
        damaged.iter().for_each(|(file, _)| write(&files[*file].0, &files[*file].1));
    }
    refused
}

#[test]
fn five_thousand_damaged_emulators_predict_nothing_else() {
    let body = beam(1.0);
    let regression = |simulations| -> Recipe {
        Regression { simulations, most: simulations, target: 0.0 }.into()
    };
    let network = |count| -> Recipe {
        let base = DataDriven::default();
        let training = steps(&base.training, count);
        DataDriven { simulations: 6, network: small_network(), training, ..base }.into()
    };
    // With a Taylor expansion and without one.
    let found = [
        refused(&body, [&regression(4), &regression(5)], 1500),
        refused(&body, [&regression(16), &regression(17)], 1500),
        refused(&body, [&Recipe::Taylor, &Recipe::Taylor], 500),
        refused(&body, [&network(4), &network(6)], 1500),
    ];
    println!("{found:?} refused of 1500, 1500, 500 and 1500");
    // What is accepted are files swapped with themselves, or with the same file of an equal emulator.
    assert!(found.iter().sum::<usize>() > 4000, "{found:?}");
}

#[test]
fn a_file_that_was_added_or_lost_is_named() {
    let (body, folder) = (beam(1.0), tempfile::tempdir().unwrap());
    let options = TrainingOptions::default();
    let of = |simulations| -> Recipe {
        Regression { simulations, most: simulations, target: 0.0 }.into()
    };
    let [about_taylor, plain] = [(4, "taylor"), (16, "plain")].map(|(simulations, name)| {
        let place = folder.path().join(name);
        of(simulations).train(&body, &options, &mut ()).unwrap().save(&place).unwrap();
        place
    });
    let told = |place: &Path| sinew_gnn::load(place, &body).err().unwrap().to_string();
    // A plain regression with another one's expansion would predict both together.
    let taylor = plain.join("regression/taylor.json");
    assert!(!taylor.exists());
    std::fs::copy(about_taylor.join("regression/taylor.json"), &taylor).unwrap();
    assert!(told(&plain).contains("taylor.json was not stored with the other files"));
    std::fs::remove_file(&taylor).unwrap();
    sinew_gnn::load(&plain, &body).unwrap();
    std::fs::remove_file(plain.join("checksums.json")).unwrap();
    assert!(told(&plain).contains("checksums.json is missing"));
    std::fs::remove_file(about_taylor.join("regression/taylor.json")).unwrap();
    assert!(told(&about_taylor).contains("taylor.json is missing"));
}

#[test]
fn simulations_that_were_damaged_are_refused() {
    let (body, folder) = (beam(1.0), tempfile::tempdir().unwrap());
    let thetas: Vec<Vec<f64>> = [[9.0, 9.0], [-5.0, 9.0], [10.0, 9.0]].map(Vec::from).into();
    let stored = simulate(&body, &thetas, "test", Some(folder.path()), &mut ()).unwrap();
    let files: Vec<_> = files(folder.path())
        .into_iter()
        .map(|path| (path.clone(), std::fs::read(path).unwrap()))
        .collect();
    let mut dice = Dice(11);
    let mut refused = 0;
    for time in 0..600 {
        // Tables may be longer than what counts: a killed run has written more.
        let damaged = damage([0, 1, 2, 3, 5][time % 5], &files, &files, &mut dice);
        for (file, bytes) in &damaged {
            match bytes {
                Some(bytes) => write(&files[*file].0, bytes),
                None => std::fs::remove_file(&files[*file].0).unwrap(),
            }
        }
        match read_simulations(&body, folder.path()) {
            Ok(found) => assert_eq!(found, stored, "{time}: damaged unnoticed"),
            Err(_) => refused += 1,
        }
        damaged.iter().for_each(|(file, _)| write(&files[*file].0, &files[*file].1));
    }
    println!("{refused} of 600 refused");
    let mut bytes = files[0].1.clone();
    assert!(files[0].0.ends_with("displacement.npy"));
    *bytes.last_mut().unwrap() ^= 1;
    write(&files[0].0, &bytes);
    let told = read_simulations(&body, folder.path()).unwrap_err().to_string();
    assert!(told.contains("displacement.npy was changed after it was stored"), "{told}");
}

#[test]
fn answers_that_are_no_numbers_name_their_parameter() {
    let scene = Scene::new(sinew_mesh::box_tetrahedra([40.0, 8.0, 8.0], [6, 2, 2]), NeoHookean)
        .parameter(Parameter::log("mu", "kPa", 8.0..=16.0))
        .parameter(Parameter::log("lambda", "kPa", 8.0..=16.0))
        .parameter(Parameter::linear("p", "kPa", 0.0..=0.2))
        .load(Load::ThesisPressure { facets: "z_max".into(), magnitude: Magnitude::Theta(2) })
        .support(Support::clamped("x_min"));
    let body = scene.lower().unwrap();
    let emulator = Emulator::taylor(&body, 1).unwrap();
    let told =
        emulator.predict(&[vec![9.0, 9.0, 0.1], vec![9.0, 9.0, 1e300]]).unwrap_err().to_string();
    assert!(
        told.contains("p = 1e300 kPa is far outside its range from 0 kPa to 0.2 kPa"),
        "{told}"
    );
    assert!(told.contains("mu = 9 kPa, lambda = 9 kPa"), "{told}");
}

#[test]
fn a_body_without_free_parameters_is_refused_in_words() {
    let body = beam(1.0).with_known(&[("mu", 10.0), ("lambda", 12.0)]).unwrap();
    let recipes: [Recipe; 3] =
        [Recipe::Taylor, Regression::default().into(), DataDriven::default().into()];
    let trained = recipes
        .map(|recipe| recipe.train(&body, &TrainingOptions::default(), &mut ()).err().unwrap());
    let taylor = Emulator::taylor(&body, 1).err().unwrap();
    let told = trained.into_iter().chain([taylor]).map(|error| error.to_string());
    for told in told {
        assert!(told.contains("no free parameters") && told.contains("mu = 10"), "{told}");
    }
}
