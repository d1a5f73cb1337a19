//! Parallel loops.

use rayon::ThreadPoolBuilder;
use sinew_num::{in_parallel, in_tasks, try_in_parallel};
use std::sync::Mutex;

#[test]
fn values_stand_in_the_order_of_their_parts_on_any_number_of_threads() {
    let squares: Vec<usize> = (0..1000).map(|x| x * x).collect();
    for threads in [1, 2, 7] {
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            assert_eq!(in_parallel(0..1000, |x| x * x), squares);
            for grain in [1, 64, 999, 1000, 5000] {
                assert_eq!(in_tasks(1000, grain, |x| x * x), squares, "tasks of {grain}");
            }
        });
    }
    assert!(in_tasks(0, 8, |x| x).is_empty() && in_parallel([], |x: u8| x).is_empty());
}

#[test]
fn no_part_begins_after_an_error() {
    let pool = ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    let begun = Mutex::new(Vec::new());
    let ended = pool.install(|| {
        try_in_parallel(0..100, |part| {
            begun.lock().unwrap().push(part);
            if part < 3 { Ok(part) } else { Err(part) }
        })
    });
    assert_eq!(ended, Err(3));
    assert_eq!(begun.into_inner().unwrap(), [0, 1, 2, 3]);
    assert_eq!(try_in_parallel(0..3, Ok::<_, ()>), Ok(vec![0, 1, 2]));
}

#[test]
fn a_panic_reaches_the_caller() {
    let panics = || in_parallel(0..10, |part| assert!(part != 5, "part {part}"));
    let caught = std::panic::catch_unwind(panics).unwrap_err();
    assert!(caught.downcast_ref::<String>().is_some_and(|text| text.contains("part 5")));
}
