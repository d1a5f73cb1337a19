//! Arrays of NumPy: both orders of bytes and of indices, and errors with their place.

use sinew_mesh::{FieldValues, parse_npy, to_npy};

fn npy(header: &str, data: &[u8]) -> Vec<u8> {
    let length = (header.len() as u16).to_le_bytes();
    [&b"\x93NUMPY"[..], &[1, 0], &length, header.as_bytes(), data].concat()
}

#[test]
fn fortran_order_is_transposed() {
    let header = "{'descr': '|u1', 'fortran_order': True, 'shape': (2, 3), }\n";
    let array = parse_npy("a.npy", &npy(header, &[1, 4, 2, 5, 3, 6])).unwrap();
    assert_eq!(array.values, FieldValues::Integer(vec![1, 2, 3, 4, 5, 6]));
}

#[test]
fn a_scalar_and_a_vector() {
    let array = parse_npy("a.npy", &to_npy(&[], &[2.5])).unwrap();
    assert_eq!((array.shape, array.values), (vec![], FieldValues::Float(vec![2.5])));
    let bytes = to_npy(&[3], &[1.0, -0.0, f64::INFINITY]);
    assert_eq!(bytes.len() % 64, 3 * 8);
    assert_eq!(parse_npy("a.npy", &bytes).unwrap().shape, [3]);
}

#[test]
fn errors_say_where_and_why() {
    let message = |header: &str| parse_npy("a.npy", &npy(header, &[0; 8])).unwrap_err().to_string();
    let big =
        message("{'descr': '<f8', 'fortran_order': False, 'shape': (99999999999, 9999999999)}");
    assert!(big.contains("numbers of the array: only"), "{big}");
    let object = message("{'descr': '|O', 'fortran_order': False, 'shape': (1,)}");
    assert!(object.contains("float64"), "{object}");
    let cut = message("{'descr': '<f8', 'fortran_order': False, 'shape': (2,)}");
    assert!(cut.contains("only 8 of 16 bytes"), "{cut}");
    assert!(message("{'descr': '<f8', 'shape': (1,)}").contains("fortran_order"));
}

#[test]
fn numbers_of_both_byte_orders() {
    let values = |descr: &str, data: &[u8], count: usize| {
        let header =
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({count},), }}\n");
        parse_npy("a.npy", &npy(&header, data)).map(|array| array.values)
    };
    let of = |descr: &str, data: &[u8], count: usize| values(descr, data, count).unwrap();
    assert_eq!(of("<i2", &[1, 0, 255, 255], 2), FieldValues::Integer(vec![1, -1]));
    assert_eq!(of(">u2", &[1, 0, 255, 255], 2), FieldValues::Integer(vec![256, 65535]));
    assert_eq!(of(">f4", &1.5f32.to_be_bytes(), 1), FieldValues::Float(vec![1.5]));
    // The second of two numbers is beyond the largest with a sign; it begins eight bytes behind the header.
    let bytes = [1u64.to_le_bytes(), u64::MAX.to_le_bytes()].concat();
    let error = values("<u8", &bytes, 2).unwrap_err().to_string();
    let header = npy("{'descr': '<u8', 'fortran_order': False, 'shape': (2,), }\n", &[]).len();
    let place = format!("a.npy, byte {}: expected an integer below 2^63", header + 8);
    assert!(error.starts_with(&place), "{error}");
}
