//! Damage to files: flipped bits, wrong numbers, lost and copied pieces.

use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;

#[derive(Clone, Debug)]
enum Damage {
    Flip(Index, u8),
    Overwrite(Index, Vec<u8>),
    Truncate(Index),
    Remove(Index, usize),
    /// Copies a piece from one place to another.
    Splice(Index, Index, usize),
    /// Replaces a run of digits by another number.
    Number(Index, String),
}

fn damage() -> impl Strategy<Value = Damage> {
    let extremes = prop_oneof![
        Just(i64::MAX.to_be_bytes().to_vec()),
        Just(i64::MAX.to_le_bytes().to_vec()),
        Just(vec![0xff; 8]),
        Just(vec![0; 8]),
        Just(vec![0x7f, 0xff, 0xff, 0xff]),
        vec(any::<u8>(), 1..9),
    ];
    let number = prop_oneof![
        Just("0".to_string()),
        Just("-1".to_string()),
        Just("nan".to_string()),
        Just("inf".to_string()),
        Just("1e400".to_string()),
        Just("4294967295".to_string()),
        Just("9223372036854775807".to_string()),
        Just("18446744073709551615".to_string()),
        Just("99999999999999999999999999".to_string()),
        any::<i32>().prop_map(|n| n.to_string()),
        (0u8..40).prop_map(|n| n.to_string()),
    ];
    let at = any::<Index>;
    prop_oneof![
        (at(), any::<u8>()).prop_map(|(at, bits)| Damage::Flip(at, bits)),
        (at(), extremes).prop_map(|(at, bytes)| Damage::Overwrite(at, bytes)),
        at().prop_map(Damage::Truncate),
        (at(), 1usize..40).prop_map(|(at, length)| Damage::Remove(at, length)),
        (at(), at(), 1usize..200).prop_map(|(from, to, length)| Damage::Splice(from, to, length)),
        (at(), number.clone()).prop_map(|(at, number)| Damage::Number(at, number)),
        (at(), number).prop_map(|(at, number)| Damage::Number(at, number)),
    ]
}

fn apply(bytes: &mut Vec<u8>, damage: &Damage) {
    if bytes.is_empty() {
        return;
    }
    let length = bytes.len();
    match damage {
        Damage::Flip(at, bits) => bytes[at.index(length)] ^= bits,
        Damage::Overwrite(at, new) => {
            let at = at.index(length);
            bytes[at..].iter_mut().zip(new).for_each(|(byte, &new)| *byte = new);
        }
        Damage::Truncate(at) => bytes.truncate(at.index(length)),
        Damage::Remove(at, count) => {
            let at = at.index(length);
            bytes.drain(at..(at + count).min(length));
        }
        Damage::Splice(from, to, count) => {
            let from = from.index(length);
            let piece = bytes[from..(from + count).min(length)].to_vec();
            let to = to.index(length);
            bytes.splice(to..to, piece);
        }
        Damage::Number(at, number) => {
            let at = at.index(length);
            let is_digit = |byte: &u8| byte.is_ascii_digit();
            let Some(start) = bytes[at..].iter().position(is_digit).map(|n| at + n) else { return };
            let digits = bytes[start..].iter().take_while(|byte| is_digit(byte)).count();
            bytes.splice(start..start + digits, number.bytes());
        }
    }
}

/// A file, damaged in one to four places.
pub(crate) fn damaged(files: Vec<Vec<u8>>) -> impl Strategy<Value = Vec<u8>> {
    (any::<Index>(), vec(damage(), 1..5)).prop_map(move |(file, damages)| {
        let mut bytes = files[file.index(files.len())].clone();
        damages.iter().for_each(|damage| apply(&mut bytes, damage));
        bytes
    })
}
