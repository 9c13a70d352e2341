//! Tables: what is written is read again, bit for bit, in both formats; what cannot be read is named with its place.

use std::fs;
use std::path::PathBuf;

use phalanx::table::{Column, Format, Groups, Kind, RowWriter, Table, Value, read, read_csv, write, write_noted};
use proptest::prelude::*;

/// A file of its own, gone at the end.
struct Place(tempfile::TempDir);

impl Place {
    fn new() -> Self {
        Place(tempfile::tempdir().expect("a directory"))
    }

    fn file(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn holding(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.file(name);
        fs::write(&path, bytes).expect("a file");
        path
    }
}

fn columns() -> Vec<Column> {
    vec![
        Column::new("run", Kind::Integer),
        Column::new("mass_kg", Kind::Number),
        Column::new("form_closed", Kind::Flag),
        Column::new("reason", Kind::Text),
    ]
}

fn sample() -> Table {
    let row = |run: i64, mass: f64, closed: bool, reason: &str| {
        vec![Value::from(run), Value::from(mass), Value::from(closed), Value::from(reason)]
    };
    let mut rows = vec![
        row(1, 0.1 + 0.2, true, "completed, \"as\" wanted"),
        row(i64::MIN, -0.0, false, "two\nlines"),
        row(i64::MAX, f64::MIN_POSITIVE / 4.0, true, " τ11 "),
        row(0, f64::NAN, true, ","),
        row(4, f64::NEG_INFINITY, false, "µ"),
        row(5, 1.0, true, "x"),
    ];
    rows.push(vec![Value::Missing; 4]);
    Table::new(columns(), rows)
}

#[test]
fn both_formats_give_the_table_back() {
    let place = Place::new();
    for name in ["table.csv", "table.parquet", "TABLE.CSV"] {
        let path = place.file(name);
        write(&path, &sample()).expect(name);
        assert_eq!(read(&path).expect(name), sample(), "{name}");
        let first = fs::read(&path).expect(name);
        write(&path, &sample()).expect(name);
        assert_eq!(fs::read(&path).expect(name), first, "{name}: the same table gives the same bytes");
    }
    for name in ["none.csv", "none.parquet"] {
        let empty = Table::new(columns(), Vec::new());
        write(&place.file(name), &empty).expect(name);
        let back = read(&place.file(name)).expect(name);
        assert!(back.rows.is_empty());
        assert_eq!(back.columns.len(), 4);
    }
}

#[test]
fn more_rows_than_one_group_of_parquet_are_read_in_order() {
    let place = Place::new();
    let row = |run: i64| vec![Value::from((run % 3 > 0).then_some(run)), Value::from(run as f64 / 7.0)];
    let columns = vec![Column::new("run", Kind::Integer), Column::new("x", Kind::Number)];
    let table = Table::new(columns, (0..150_000).map(row).collect());
    let path = place.file("long.parquet");
    write(&path, &table).expect("written");
    assert_eq!(read(&path).expect("read"), table);
}

fn value(kind: Kind) -> BoxedStrategy<Value> {
    let there = match kind {
        Kind::Integer => any::<i64>().prop_map(Value::from).boxed(),
        Kind::Number => any::<u64>().prop_map(|bits| Value::from(f64::from_bits(bits))).boxed(),
        Kind::Flag => any::<bool>().prop_map(Value::from).boxed(),
        Kind::Text => "\\PC{1,12}".prop_map(Value::from).boxed(),
    };
    prop_oneof![4 => there, 1 => Just(Value::Missing)].boxed()
}

proptest! {
    #[test]
    fn any_table_is_read_as_it_was_written(
        rows in prop::collection::vec(
            (value(Kind::Integer), value(Kind::Number), value(Kind::Flag), value(Kind::Text)), 0..20)
    ) {
        let place = Place::new();
        let table = Table::new(columns(), rows.into_iter().map(|(a, b, c, d)| vec![a, b, c, d]).collect());
        write(&place.file("any.parquet"), &table).expect("written");
        prop_assert_eq!(&read(&place.file("any.parquet")).expect("read"), &table);
        // Random texts may look like numbers, which CSV cannot tell from them: the kinds are known here.
        write(&place.file("any.csv"), &table).expect("written");
        prop_assert_eq!(&read_csv(&place.file("any.csv"), &columns()).expect("read"), &table);
    }
}

#[test]
fn kinds_of_csv_columns_are_found() {
    let place = Place::new();
    let path = place.holding("kinds.csv", "\u{feff}a,b,c,d,e,f\n1,1,true,x,,inf\n2,2.5,False,3,,info\n".as_bytes());
    let table = read(&path).expect("a table");
    let kinds: Vec<Kind> = table.columns.iter().map(|column| column.kind).collect();
    assert_eq!(kinds, [Kind::Integer, Kind::Number, Kind::Flag, Kind::Text, Kind::Text, Kind::Text]);
    assert_eq!(table.numbers("a").expect("integers are numbers"), [Some(1.0), Some(2.0)]);
    assert_eq!(table.numbers("b").expect("numbers"), [Some(1.0), Some(2.5)]);
    assert_eq!(table.flags("c").expect("flags"), [Some(true), Some(false)]);
    assert_eq!(table.texts("d").expect("texts"), [Some("x"), Some("3")]);
    assert_eq!(table.numbers("e").expect("nothing is of any kind"), [None, None]);
}

#[test]
fn what_cannot_be_read_is_named_with_its_place() {
    let place = Place::new();
    let message = |name: &str, bytes: &[u8]| {
        let path = place.holding(name, bytes);
        let text = match read(&path) {
            Err(error) => error.to_string(),
            Ok(table) => table.numbers("mass_kg").expect_err("no such numbers").to_string(),
        };
        text.replace(&format!("{}/", place.0.path().display()), "")
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
        let found = message("x.csv", bytes);
        assert!(found.starts_with(expected), "{found}");
    }
    assert!(message("x.parquet", b"PAR1 or not").starts_with("x.parquet is no Parquet table"));
    assert!(message("x.txt", b"").contains("neither CSV nor Parquet"));
    let missing = read(&place.file("none.csv")).expect_err("there is none").to_string();
    assert!(missing.contains("there is no such file"), "{missing}");
}

#[test]
fn damaged_parquet_is_refused_without_panic() {
    let place = Place::new();
    let path = place.file("whole.parquet");
    write(&path, &sample()).expect("written");
    let whole = fs::read(&path).expect("read");
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x55;
        let damaged = place.holding("damaged.parquet", &bytes);
        // A flipped value may still be a value; only the refusal must be in words.
        if let Err(error) = read(&damaged) {
            assert!(error.to_string().contains("damaged.parquet"), "{error}");
        }
        let cut = place.holding("cut.parquet", &whole[..at]);
        assert!(read(&cut).is_err(), "cut at {at}");
    }
}

#[test]
fn a_table_that_is_none_leaves_the_older_file_alone() {
    let place = Place::new();
    for name in ["old.csv", "old.parquet"] {
        let path = place.file(name);
        write(&path, &sample()).expect("written");
        let mut wrong = sample();
        wrong.rows[1][0] = Value::from("one");
        let error = write(&path, &wrong).expect_err("a text among integers").to_string();
        assert!(error.starts_with("row 2, column 1 (`run`): \"one\" is not a whole number"), "{error}");
        wrong.rows[1].pop();
        assert!(write(&path, &wrong).is_err());
        assert_eq!(read(&path).expect("the old one"), sample());
    }
    let error = write(&place.file("no/such/place.csv"), &sample()).expect_err("nowhere").to_string();
    assert!(error.starts_with("cannot write"), "{error}");
}

/// More rows than a group has, with all kinds and gaps.
#[test]
fn rows_one_by_one_are_the_bytes_of_the_whole_table_and_come_back_by_groups() {
    let kinds = [("run", Kind::Integer), ("x_m", Kind::Number), ("good", Kind::Flag), ("reason", Kind::Text)];
    let columns = kinds.map(|(name, kind)| Column::new(name, kind)).to_vec();
    let row = |run: i64| {
        let gap = |value: Value| if run % 7 == 0 { Value::Missing } else { value };
        let reason = Value::from(format!("at {} ms, \"so\"", run % 1000));
        vec![Value::Integer(run), gap(Value::Number(run as f64 / 3.0)), gap(Value::Flag(run % 2 == 0)), gap(reason)]
    };
    let table = Table::new(columns.clone(), (1..=150_000).map(row).collect());
    let directory = crate::support::cli::directory("table_rows");
    for (name, format) in [("rows.csv", Format::Csv), ("rows.parquet", Format::Parquet)] {
        let path = directory.join(name);
        write(&path, &table).expect("written");
        let mut bytes = Vec::new();
        let mut writer = RowWriter::new(&mut bytes, format, &columns).expect("memory takes everything");
        (1..=150_000).try_for_each(|run| writer.add(row(run))).expect("memory takes everything");
        writer.finish().expect("memory takes everything");
        assert!(bytes == std::fs::read(&path).expect("there"), "{name}");
    }
    let mut bytes = Vec::new();
    let mut writer = RowWriter::new(&mut bytes, Format::Csv, &columns).expect("memory takes everything");
    assert!(writer.add(vec![Value::Integer(1)]).is_err(), "a row of another table");

    let mut groups = Groups::open(&directory.join("rows.parquet")).expect("a table");
    assert_eq!((groups.columns(), groups.rows()), (&columns[..], 150_000));
    assert!(!groups.sound().expect("readable"), "without notes there is no checksum");
    let (mut found, mut largest) = (Vec::new(), 0);
    while let Some(rows) = groups.next_group().expect("sound") {
        largest = largest.max(rows.len());
        found.extend(rows);
    }
    assert!(largest <= 1 << 16 && found == table.rows, "{largest}");

    // Notes and a checksum; whatever is changed of the rows is seen.
    let noted = directory.join("noted.parquet");
    let few = Table::new(columns, (1..=500).map(row).collect());
    write_noted(&noted, &few, &[("whose".to_string(), "mine".to_string())]).expect("written");
    let open = || Groups::open(&noted).expect("a table");
    assert_eq!((open().note("whose"), open().note("else")), (Some("mine"), None));
    assert!(open().sound().expect("readable"));
    assert_eq!(read(&noted).expect("a table"), few);
    let whole = std::fs::read(&noted).expect("there");
    for at in (4..whole.len() / 2).step_by(101) {
        let mut changed = whole.clone();
        changed[at] ^= 16;
        std::fs::write(&noted, changed).expect("written");
        assert!(!open().sound().expect("readable"), "byte {at}");
    }
}
