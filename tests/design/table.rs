//! Tables: bit-exact round trips in both formats, and error messages with locations.

use std::fs;

use phalanx::table::{
    Column, Format, Kind, RowGroups, RowWriter, Table, Value, read, read_csv, write, write_over_own,
    write_with_metadata,
};
use proptest::prelude::*;

use crate::support::cli::{directory as test_directory, write_bytes};

fn columns() -> Vec<Column> {
    let kinds =
        [("run", Kind::Integer), ("mass_kg", Kind::Number), ("form_closed", Kind::Flag), ("reason", Kind::Text)];
    kinds.map(|(name, kind)| Column::new(name, kind)).to_vec()
}

fn sample() -> Table {
    let rows = [
        (1, 0.1 + 0.2, true, "completed, \"as\" wanted"),
        (i64::MIN, -0.0, false, "two\nlines"),
        (i64::MAX, f64::MIN_POSITIVE / 4.0, true, " τ11 "),
        (0, f64::NAN, true, ","),
        (4, f64::NEG_INFINITY, false, "µ"),
        (5, 1.0, true, "x"),
    ];
    let rows = rows.map(|(run, mass, closed, reason)| {
        vec![Value::from(run), Value::from(mass), Value::from(closed), Value::from(reason)]
    });
    Table::new(columns(), rows.into_iter().chain([vec![Value::Missing; 4]]).collect())
}

#[test]
fn both_formats_round_trip() {
    let directory = test_directory("table_both_formats_round_trip");
    for name in ["table.csv", "table.parquet", "TABLE.CSV"] {
        let path = directory.join(name);
        for table in [sample(), Table::new(columns(), Vec::new())] {
            let write = || write(&path, &table).map(|()| fs::read(&path).expect(name)).expect(name);
            assert_eq!(write(), write(), "{name}: output is reproducible");
            let reread = read(&path).expect(name);
            // A CSV column without values has no kind.
            assert!(reread == table || reread.rows.is_empty() && reread.columns.len() == 4, "{name}");
        }
    }
}

#[test]
fn a_file_of_another_program_is_not_replaced() {
    let directory = test_directory("table_own");
    let few = Table::new(columns()[2..].to_vec(), vec![vec![Value::from(true), Value::Missing]]);
    for (name, foreign) in [("table.csv", "name,age\nAda,36\n"), ("table.parquet", "PAR1 of another program")] {
        let path = directory.join(name);
        fs::write(&path, foreign).expect("written");
        let error = write_over_own(&path, &few).expect_err("refused").to_string();
        assert!(error.contains("not a table written by phalanx") && error.contains(name), "{error}");
        assert_eq!(fs::read_to_string(&path).expect("text"), foreign);
        fs::remove_file(&path).expect("removed");
        // A table of phalanx and one with the same columns are replaced.
        for _ in 0..2 {
            write_over_own(&path, &few).expect("written");
        }
        write(&path, &sample()).expect("written");
        assert_eq!(write_over_own(&path, &few).is_ok(), name == "table.parquet", "run,mass_kg is no head of phalanx");
    }
}

fn value(kind: Kind) -> BoxedStrategy<Value> {
    let present = match kind {
        Kind::Integer => any::<i64>().prop_map(Value::from).boxed(),
        Kind::Number => any::<u64>().prop_map(|bits| Value::from(f64::from_bits(bits))).boxed(),
        Kind::Flag => any::<bool>().prop_map(Value::from).boxed(),
        Kind::Text => "\\PC{1,12}".prop_map(Value::from).boxed(),
    };
    prop_oneof![4 => present, 1 => Just(Value::Missing)].boxed()
}

proptest! {
    #[test]
    fn any_table_round_trips(
        rows in prop::collection::vec(
            (value(Kind::Integer), value(Kind::Number), value(Kind::Flag), value(Kind::Text)), 0..20)
    ) {
        let directory = test_directory("table_any_table_round_trips");
        let table = Table::new(columns(), rows.into_iter().map(|(a, b, c, d)| vec![a, b, c, d]).collect());
        write(&directory.join("any.parquet"), &table).expect("written");
        prop_assert_eq!(&read(&directory.join("any.parquet")).expect("read"), &table);
        // Random texts may look like numbers, which CSV cannot distinguish; the kinds are therefore given.
        write(&directory.join("any.csv"), &table).expect("written");
        prop_assert_eq!(&read_csv(&directory.join("any.csv"), &columns()).expect("read"), &table);
    }
}

#[test]
fn kinds_of_csv_columns_are_detected() {
    let directory = test_directory("table_kinds_of_csv_columns_are_detected");
    let text = "\u{feff}a,b,c,d,e,f\n1,1,true,x,,inf\n2,2.5,False,3,,info\n";
    let table = read(&write_bytes(&directory, "kinds.csv", text.as_bytes())).expect("a table");
    let kinds: Vec<Kind> = table.columns.iter().map(|column| column.kind).collect();
    assert_eq!(kinds, [Kind::Integer, Kind::Number, Kind::Flag, Kind::Text, Kind::Text, Kind::Text]);
    // Integers are numbers, and missing values match any kind.
    let expected = [("a", [Some(1.0), Some(2.0)]), ("b", [Some(1.0), Some(2.5)]), ("e", [None, None])];
    expected.into_iter().for_each(|(name, values)| assert_eq!(table.numbers(name).expect(name), values));
    assert_eq!(table.flags("c").expect("flags"), [Some(true), Some(false)]);
    assert_eq!(table.texts("d").expect("texts"), [Some("x"), Some("3")]);
}

#[test]
fn read_errors_name_the_location() {
    let directory = test_directory("table_read_errors_name_the_location");
    let message = |name: &str, bytes: &[u8]| {
        let path = write_bytes(&directory, name, bytes);
        let text = match read(&path) {
            Err(error) => error.to_string(),
            Ok(table) => table.numbers("mass_kg").expect_err("no such numbers").to_string(),
        };
        text.replace(&format!("{}/", directory.display()), "")
    };
    for (bytes, expected) in [
        (&b"run,mass_kg\n1,2.5\n2,heavy\n"[..], "x.csv:3, column 2 (`mass_kg`): \"heavy\" is not a number"),
        (b"run,mass_kg\n1,2,3\n", "x.csv:2: 3 values in 2 columns"),
        (b"run,mass_kg\n1,\xff\n", "x.csv:2: column 2 is not UTF-8"),
        (b"run;mass_kg\n1;2\n", "x.csv:1: columns are not separated by commas"),
        (b"run,run\n", "x.csv has two columns `run`"),
        (b"run,,x\n", "x.csv:1: column 2 has no name"),
        (b"", "x.csv:1: the file is empty"),
        (b"run,mas_kg\n", "x.csv has no column `mass_kg` (did you mean `mas_kg`?); its columns: run, mas_kg"),
    ] {
        let actual = message("x.csv", bytes);
        assert!(actual.starts_with(expected), "{actual}");
    }
    assert!(message("x.parquet", b"PAR1 or not").starts_with("x.parquet is not a readable Parquet table"));
    assert!(message("x.txt", b"").contains("neither CSV nor Parquet"));
    let missing = read(&directory.join("none.csv")).expect_err("no file").to_string();
    assert!(missing.contains("there is no such file"), "{missing}");
}

#[test]
fn damaged_parquet_is_rejected_without_panic() {
    let directory = test_directory("table_damaged_parquet_is_rejected_without_panic");
    let path = directory.join("whole.parquet");
    let contents = write(&path, &sample()).map(|()| fs::read(&path).expect("read")).expect("written");
    for offset in 0..contents.len() {
        let mut bytes = contents.clone();
        bytes[offset] ^= 0x55;
        let damaged = write_bytes(&directory, "damaged.parquet", &bytes);
        // A changed byte may still give a valid value; if not, the error names the file.
        if let Err(error) = read(&damaged) {
            assert!(error.to_string().contains("damaged.parquet"), "{error}");
        }
        let truncated = write_bytes(&directory, "cut.parquet", &contents[..offset]);
        assert!(read(&truncated).is_err(), "cut at {offset}");
    }
}

#[test]
fn invalid_tables_do_not_replace_existing_files() {
    let directory = test_directory("table_invalid_tables_do_not_replace_existing_files");
    for name in ["old.csv", "old.parquet"] {
        let path = directory.join(name);
        write(&path, &sample()).expect("written");
        let mut invalid = sample();
        invalid.rows[1][0] = Value::from("one");
        let error = write(&path, &invalid).expect_err("a text among integers").to_string();
        assert!(error.starts_with("row 2, column 1 (`run`): \"one\" is not a whole number"), "{error}");
        invalid.rows[1].pop();
        assert!(write(&path, &invalid).is_err());
        assert_eq!(read(&path).expect("the existing file"), sample());
    }
    let error = write(&directory.join("no/such/place.csv"), &sample()).expect_err("no directory").to_string();
    assert!(error.starts_with("cannot write"), "{error}");
}

/// Uses more rows than a row group, with all kinds and missing values.
#[test]
fn row_writer_and_row_groups_match_whole_tables() {
    let row = |run: i64| {
        let with_gaps = |value: Value| if run % 7 == 0 { Value::Missing } else { value };
        vec![
            Value::Integer(run),
            with_gaps(Value::Number(run as f64 / 3.0)),
            with_gaps(Value::Flag(run % 2 == 0)),
            with_gaps(Value::from(format!("at {} ms, \"so\"", run % 1000))),
        ]
    };
    let table = Table::new(columns(), (1..=150_000).map(row).collect());
    let directory = test_directory("table_row_writer_and_row_groups_match_whole_tables");
    for (name, format) in [("rows.csv", Format::Csv), ("rows.parquet", Format::Parquet)] {
        write(&directory.join(name), &table).expect("written");
        let mut bytes = Vec::new();
        let mut writer = RowWriter::new(&mut bytes, format, &columns()).expect("written to memory");
        table.rows.iter().try_for_each(|row| writer.add(row)).expect("written to memory");
        writer.finish(&[]).expect("written to memory");
        assert!(bytes == fs::read(directory.join(name)).expect("readable"), "{name}");
        let mut writer = RowWriter::new(&mut bytes, format, &columns()).expect("written to memory");
        assert!(writer.add(&[Value::Integer(1)]).is_err(), "a row with the wrong number of columns");
    }
    let groups = RowGroups::open(&directory.join("rows.parquet")).expect("a table");
    assert_eq!((groups.columns(), groups.row_count()), (&columns()[..], 150_000));
    let groups: Vec<Vec<Vec<Value>>> = groups.collect::<Result<_, _>>().expect("valid groups");
    assert!(groups.iter().all(|rows| rows.len() <= 1 << 16) && groups.concat() == table.rows);

    let with_metadata = directory.join("metadata.parquet");
    write_with_metadata(&with_metadata, &sample(), &[("whose".to_string(), "mine".to_string())]).expect("written");
    let groups = RowGroups::open(&with_metadata).expect("a table");
    assert_eq!((groups.metadata_value("whose"), groups.metadata_value("else")), (Some("mine"), None));
    assert_eq!(read(&with_metadata).expect("a table"), sample());
}
