//! Random numbers.

use sinew_num::SplitMix64;

/// Numbers of the seed 1234567: <https://rosettacode.org/wiki/Pseudo-random_numbers/Splitmix64>.
#[test]
fn bits_are_those_of_other_programs() {
    let mut random = SplitMix64(1_234_567);
    let expected =
        [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
    assert_eq!([0; 3].map(|_| random.bits()), expected);
}
