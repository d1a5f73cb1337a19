//! Folders of networks and checkpoints that a kill or a full disk interrupts, and files that were cut.

use crate::common::*;
use sinew_gnn::*;
use std::fs;

#[test]
fn a_failed_write_leaves_the_folder_as_it_was() {
    let (_, data) = plane_data();
    let config = small_config(&data, 2);
    let device = &devices()[0];
    let [first, second] =
        [untrained(&data, &config, 1, device), briefly_trained(&data, &config, device)];
    let predicted =
        |surrogate: &Surrogate| surrogate.predict(&data.geometries[0], &[vec![0.8, 1.3]]).unwrap();
    assert_ne!(predicted(&first), predicted(&second));

    let folder = tempfile::tempdir().unwrap();
    let (place, previous) = (folder.path().join("network"), folder.path().join("network.previous"));
    let read = || predicted(&Surrogate::load(&place, device).unwrap());
    first.save(&place).unwrap();
    // Something is in the way of the folder that is to be replaced.
    fs::write(&previous, "").unwrap();
    assert!(matches!(second.save(&place), Err(Error::File { .. })));
    assert_eq!(read(), predicted(&first));
    fs::remove_file(&previous).unwrap();
    fs::rename(&place, &previous).unwrap(); // a kill between the renames
    assert_eq!(read(), predicted(&first));
    second.save(&place).unwrap();
    assert_eq!(read(), predicted(&second));
    assert!(!previous.exists());
}

/// Histories of both optimisers survive bit for bit in `training::a_resumed_run_continues_bit_for_bit`.
#[test]
fn a_checkpoint_whose_history_was_cut_is_refused() {
    let (_, data) = plane_data();
    let device = &devices()[0];
    let surrogate = untrained(&data, &small_config(&data, 2), 1, device);
    let objective = || data_fit(&surrogate);
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("checkpoint");
    let config = TrainingConfig {
        budget: TrainingBudget::Steps(2),
        evaluations: 1,
        ..TrainingConfig::default()
    };
    let mut trainer = Trainer::new(surrogate.clone(), data.clone(), objective(), config).unwrap();
    trainer.checkpoints = Some(place.clone());
    trainer.run(&mut ()).unwrap();
    let resumed = || Trainer::resume(&place, data.clone(), objective(), device);
    assert!(resumed().is_ok());

    let file = place.join("run.json");
    let mut run: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&file).unwrap()).unwrap();
    let moments = run["optimiser"]["moments"].as_object_mut().unwrap();
    // Three bytes, which are no number.
    moments.values_mut().next().unwrap()[0] = "AACA".into();
    fs::write(&file, run.to_string()).unwrap();
    assert!(matches!(resumed(), Err(Error::Format { .. })));
}
