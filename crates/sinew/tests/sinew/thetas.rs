//! Mistakes in values of parameters and their messages: file, line or option, number, unit, and what to do.

use crate::newcomer::{Faults, PLATE};
use sinew::{Case, parse_theta, read_rows, read_thetas};
use std::path::Path;

#[test]
fn mistakes_in_theta_are_told_with_parameter_range_unit_and_remedy() {
    let mut faults = Faults::default();
    let parameters = Case::parse(PLATE, "plate.toml").unwrap().body().unwrap().parameters.clone();
    let attempts: [(&str, &[&str]); 12] = [
        ("mu=9,lambda=9", &["p (from 1 to 4 mmHg) is missing", "mu,lambda,p"]),
        ("mu=9,lamda=9,p=2", &["`lamda`", "did you mean `lambda`?"]),
        ("mu=9,mu=9,lambda=9,p=2", &["`mu` is there twice", "keep one"]),
        ("mu=9,lambda=9,p=8bar", &["`8bar`", "units of stress: kPa, mmHg"]),
        ("mu=9,lambda=9,p=8mPa", &["`8mPa`", "mega", "did you mean `MPa`?"]),
        ("mu=9,lambda=9,p=nan", &["`nan` is not a finite number", "p (from 1 to 4 mmHg)"]),
        ("mu=9,lambda=9,p=1e999", &["`1e999` is not a finite number", "p (from 1 to 4 mmHg)"]),
        ("mu=9,lambda=9,p=", &["no value for p (from 1 to 4 mmHg)"]),
        ("mu=9,lambda,p=2", &["`lambda` is not a name=value pair", "mu=75"]),
        ("mu=9;lambda=9;p=2", &["holds two pairs", "commas"]),
        ("mu=9 p=2,lambda=9", &["`mu=9 p=2` holds two pairs", "commas"]),
        ("=9,mu=9,lambda=9,p=2", &["`` is not a parameter", "mu, lambda, p"]),
    ];
    for (text, words) in attempts {
        let told = parse_theta(text, &parameters).unwrap_err().to_string();
        assert!(told.contains("--theta"), "{told}");
        faults.judge(&told, text, words);
    }
    // What is meant is understood.
    let theta = |text: &str| parse_theta(text, &parameters).unwrap();
    assert_eq!(theta("mu=9,lambda=9,p=2"), theta("p=2mmhg, lambda=9000 pa, mu=9 KPA"));
}

#[test]
fn mistakes_in_tables_are_told_with_file_line_and_remedy() {
    let mut faults = Faults::default();
    let parameters = Case::parse(PLATE, "plate.toml").unwrap().body().unwrap().parameters.clone();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("thetas.csv");
    let attempts: [(&[u8], &[&str]); 20] = [
        (b",mu,lambda,p\n0,9,9,2\n", &["line 1", "leave the first column out", "index=False"]),
        (b"case,mu,lambda,p\n0,9,9,2\n", &["line 1", "`case`", "leave the first column out"]),
        (b"", &["line 1", "empty", "mu,lambda,p"]),
        (b"mu,lambda,p\n", &["line 1", "add a row"]),
        (b"9,9,2\n", &["line 1", "`9` is not a parameter", "mu, lambda, p"]),
        (b"mu,lambda,pressure\n9,9,2\n", &["line 1", "`pressure`", "mu, lambda, p"]),
        (b"sep=,\nmu,lambda,p\n9,9,2\n", &["line 1", "`sep=`", "alone in the first line"]),
        (b"mu (kPa),lambda,p\n9,9,2\n", &["line 1", "`mu (kPa)`", "as in `p [mmHg]`"]),
        (b"mu,lambda\n9,9\n", &["line 1", "p (from 1 to 4 mmHg) is missing"]),
        (b"mu,mu,lambda,p\n9,9,9,2\n", &["line 1", "`mu` is there twice", "keep one"]),
        (b"mu,lambda,p [bar]\n9,9,2\n", &["line 1", "column `p`", "`bar`", "kPa, mmHg"]),
        (b"mu;lambda;p\n9;9;2\n", &["line 1", "separate columns by commas"]),
        (b"mu,lambda,p\n9,9\n", &["line 2", "2 values for the 3 columns mu, lambda, p"]),
        (b"mu,lambda,p\n9,9,2,1\n", &["line 2", "4 values for the 3 columns"]),
        (b"mu,lambda,p\n9,9,2\n9,ten,2\n", &["line 3", "`ten`", "lambda (from 8 to 16 kPa)"]),
        (b"mu,lambda,p\n9,9,NaN\n", &["line 2", "`NaN`", "p (from 1 to 4 mmHg)"]),
        (b"mu,lambda,p\n9,,2\n", &["line 2", "no value for lambda (from 8 to 16 kPa)"]),
        (b"mu,lambda,p\n9,9,2bar\n", &["line 2", "`2bar`", "kPa, mmHg"]),
        (b"mu,lambda,p\n\"9,0\",9,2\n", &["line 2", "`9,0`", "decimals with a point"]),
        (b"\xff\xfe\x00mu", &["thetas.csv", "CSV table"]),
    ];
    for (text, words) in attempts {
        std::fs::write(&path, text).unwrap();
        let told = read_thetas(&path, &parameters).unwrap_err().to_string();
        assert!(told.contains("thetas.csv"), "{told}");
        faults.judge(&told, &String::from_utf8_lossy(text), words);
    }
    // Tables of other programs: a mark before a comment, comments in another encoding, names behind a #.
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let names: Vec<&str> = parameters.iter().map(|p| p.name.as_str()).collect();
    let (names, row) = (names.join(","), vec!["9"; parameters.len()].join(","));
    let read = |text: &[u8]| {
        std::fs::write(&path, text).unwrap();
        read_thetas(&path, &parameters)
    };
    let expected = read(format!("{names}\n{row}\n").as_bytes()).unwrap();
    for text in [
        format!("\u{feff}# exported\n{names}\n{row}\n").into_bytes(),
        [b"# M\xfcnster\n", format!("{names}\n{row}\n").as_bytes()].concat(),
        format!("# numbers of 2026\n# {names}\n{row}\n").into_bytes(),
        format!("# {names}\n{names}\n{row}\n").into_bytes(),
    ] {
        assert_eq!(read(&text).unwrap(), expected, "{}", String::from_utf8_lossy(&text));
    }
    // Names in Latin-1 are what they were.
    let told = read(
        format!("m\u{fc},{names}\n9,{row}\n")
            .chars()
            .map(|c| c as u8)
            .collect::<Vec<_>>()
            .as_slice(),
    );
    assert!(told.unwrap_err().to_string().contains("`m\u{fc}`"));
    assert!(read(format!("# other\n{row}\n").as_bytes()).is_err());
    let told = read_rows(Path::new("none.csv"), &parameters).unwrap_err().to_string();
    faults.judge(&told, "no file", &["none.csv", "CSV table", "mu=8,lambda=8,p=1"]);
    // A bare number is in the unit of its column, or of its parameter.
    std::fs::write(&path, "mu,lambda,p\n9,9,2\n").unwrap();
    let own = read_thetas(&path, &parameters).unwrap();
    std::fs::write(&path, "p [mmhg],lambda [Pa],mu\n2,9000,9\n").unwrap();
    assert_eq!(read_thetas(&path, &parameters).unwrap(), own);
    assert_eq!(own[0][2], 2.0 * 0.133_322_387_415);
}
