//! Exponents of monomials.

/// Exponents of all monomials of some variables up to a total degree, the constant first.
///
/// ```
/// let of_degree_two = sinew_num::monomials(2, 2);
/// assert_eq!(of_degree_two, [[0, 0], [1, 0], [0, 1], [2, 0], [1, 1], [0, 2]]);
/// ```
pub fn monomials(variables: usize, degree: usize) -> Vec<Vec<i32>> {
    let mut found = vec![vec![0; variables]];
    let mut start = 0;
    for _ in 0..degree {
        let end = found.len();
        for at in start..end {
            // Raising only from the last variable used on makes each monomial once.
            let last = found[at].iter().rposition(|&e| e > 0).unwrap_or(0);
            for variable in last..variables {
                let mut next = found[at].clone();
                next[variable] += 1;
                found.push(next);
            }
        }
        start = end;
    }
    found
}
