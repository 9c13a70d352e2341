//! Tables as Parquet: one optional column each of INT64, DOUBLE, BOOLEAN or UTF-8 BYTE_ARRAY, compressed with zstd.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::{ColumnChunkMetaData, KeyValue};
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnDescriptor, Type, TypePtr};

use super::{Column, Kind, Origin, Table, TableError, Value};
use crate::files::{Summed, checksum};
use crate::limits::LARGEST_TABLE_BYTES;

/// Rows of one group: a reader needs one group in memory at a time.
const GROUP: usize = 1 << 16;

/// Where a file with notes says how many of its first bytes are summed up, and what they come to.
const CHECKSUM: &str = "phalanx.checksum";

/// Writes the table as Parquet. The same table gives the same bytes.
pub(super) fn write(out: &mut (dyn Write + Send), table: &Table, notes: &[(String, String)]) -> io::Result<()> {
    let mut rows = Rows::new(out, &table.columns)?;
    table.rows.chunks(GROUP).try_for_each(|of| rows.group(of)).map_err(io::Error::other)?;
    rows.finish(notes)
}

/// A Parquet file that is written group by group: no more than one is in memory.
pub(super) struct Rows<'a> {
    writer: SerializedFileWriter<Summed<'a>>,
    columns: Vec<Column>,
    /// Rows of the group that is not full yet.
    pending: Vec<Vec<Value>>,
}

impl<'a> Rows<'a> {
    pub fn new(out: &'a mut (dyn Write + Send), columns: &[Column]) -> io::Result<Self> {
        let properties = WriterProperties::builder().set_compression(Compression::ZSTD(Default::default())).build();
        let writer = schema(columns)
            .and_then(|schema| SerializedFileWriter::new(Summed::new(out), schema, Arc::new(properties)));
        Ok(Rows { writer: writer.map_err(io::Error::other)?, columns: columns.to_vec(), pending: Vec::new() })
    }

    pub fn add(&mut self, row: Vec<Value>) -> io::Result<()> {
        self.pending.push(row);
        if self.pending.len() < GROUP {
            return Ok(());
        }
        let rows = std::mem::take(&mut self.pending);
        self.group(&rows).map_err(io::Error::other)
    }

    /// Writes what is left, the notes and, if there are any, a checksum of all that stands before them.
    pub fn finish(mut self, notes: &[(String, String)]) -> io::Result<()> {
        let rows = std::mem::take(&mut self.pending);
        if !rows.is_empty() {
            self.group(&rows).map_err(io::Error::other)?;
        }
        for (name, text) in notes {
            self.writer.append_key_value_metadata(KeyValue::new(name.clone(), text.clone()));
        }
        if !notes.is_empty() {
            self.writer.flush()?;
            let so_far = self.writer.inner();
            let sum = format!("{}:{:08x}", so_far.bytes(), so_far.crc());
            self.writer.append_key_value_metadata(KeyValue::new(CHECKSUM.to_string(), sum));
        }
        self.writer.close().map(drop).map_err(io::Error::other)
    }

    fn group(&mut self, rows: &[Vec<Value>]) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for (index, column) in self.columns.iter().enumerate() {
            let values = rows.iter().map(|row| &row[index]);
            match column.kind {
                Kind::Integer => put::<Int64Type>(&mut group, values, |value| match value {
                    Value::Integer(value) => Some(*value),
                    _ => None,
                })?,
                Kind::Number => put::<DoubleType>(&mut group, values, |value| match value {
                    Value::Number(value) => Some(*value),
                    _ => None,
                })?,
                Kind::Flag => put::<BoolType>(&mut group, values, |value| match value {
                    Value::Flag(value) => Some(*value),
                    _ => None,
                })?,
                Kind::Text => put::<ByteArrayType>(&mut group, values, |value| match value {
                    Value::Text(text) => Some(ByteArray::from(text.as_str())),
                    _ => None,
                })?,
            }
        }
        group.close().map(drop)
    }
}

fn schema(columns: &[Column]) -> Result<TypePtr, ParquetError> {
    let field = |column: &Column| {
        let (physical, logical) = match column.kind {
            Kind::Integer => (Physical::INT64, None),
            Kind::Number => (Physical::DOUBLE, None),
            Kind::Flag => (Physical::BOOLEAN, None),
            Kind::Text => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        let field = Type::primitive_type_builder(&column.name, physical).with_logical_type(logical);
        field.with_repetition(Repetition::OPTIONAL).build().map(Arc::new)
    };
    let fields = columns.iter().map(field).collect::<Result<_, _>>()?;
    Ok(Arc::new(Type::group_type_builder("phalanx").with_fields(fields).build()?))
}

/// The next column of a group: level 1 where there is a value, 0 where it is missing.
fn put<'a, T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Summed<'_>>,
    values: impl Iterator<Item = &'a Value>,
    get: impl Fn(&Value) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let found: Vec<Option<T::T>> = values.map(get).collect();
    let levels: Vec<i16> = found.iter().map(|value| i16::from(value.is_some())).collect();
    let there: Vec<T::T> = found.into_iter().flatten().collect();
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("the schema has fewer columns than the table".to_string()));
    };
    column.typed::<T>().write_batch(&there, Some(&levels), None)?;
    column.close()
}

/// Reads a Parquet file of flat columns.
pub(super) fn read(path: &Path) -> Result<Table, TableError> {
    if fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > LARGEST_TABLE_BYTES) {
        let most = LARGEST_TABLE_BYTES >> 20;
        let reason = format!("it is larger than {most} MiB; take some of its rows, or of its columns");
        return Err(TableError::Read { file: path.display().to_string(), reason });
    }
    let mut groups = Groups::open(path)?;
    let columns = groups.columns.clone();
    let mut table =
        Table { columns, rows: Vec::new(), origin: Origin { file: groups.file.clone(), lines: Vec::new() } };
    while groups.append(&mut table.rows)? {}
    super::check(&table)?;
    Ok(table)
}

/// A Parquet file of flat columns that is read group by group, however large it is.
pub struct Groups {
    path: PathBuf,
    file: String,
    reader: SerializedFileReader<File>,
    columns: Vec<Column>,
    next: usize,
}

impl Groups {
    /// Opens a file and reads what it says of itself, none of its rows.
    ///
    /// # Errors
    /// The file cannot be read, or is no Parquet table of plain values.
    pub fn open(path: &Path) -> Result<Self, TableError> {
        let file = path.display().to_string();
        let unreadable = |reason: String| TableError::Read { file: file.clone(), reason };
        if path.is_dir() {
            return Err(unreadable("it is a directory; name a file in it".to_string()));
        }
        let opened = File::open(path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => unreadable("there is no such file; check the path".to_string()),
            _ => unreadable(error.to_string()),
        })?;
        let strange = |reason: String| TableError::Parquet { file: file.clone(), reason };
        let reader = SerializedFileReader::new(opened).map_err(|error| strange(error.to_string()))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let columns = schema.columns().iter().map(|column| described(column)).collect::<Result<_, _>>();
        let columns = columns.map_err(strange)?;
        Ok(Groups { path: path.to_path_buf(), file, reader, columns, next: 0 })
    }

    /// Its columns.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// How many rows it says it has.
    pub fn rows(&self) -> u64 {
        u64::try_from(self.reader.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// What is noted beside the rows, by name.
    pub fn note(&self, name: &str) -> Option<&str> {
        let notes = self.reader.metadata().file_metadata().key_value_metadata()?;
        notes.iter().find(|note| note.key == name)?.value.as_deref()
    }

    /// Whether the rows are those that were written, by the checksum of a file with notes; `false` without one.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn sound(&self) -> io::Result<bool> {
        let sum = self.note(CHECKSUM).and_then(|sum| sum.split_once(':'));
        let Some((bytes, crc)) = sum.and_then(|(bytes, crc)| Some((bytes.parse().ok()?, crc))) else {
            return Ok(false);
        };
        let (found, read) = checksum(&self.path, bytes)?;
        Ok(read == bytes && format!("{found:08x}") == crc)
    }

    /// The rows of the next group; `None` after the last one. A group of more rows than this program writes into one is refused.
    ///
    /// # Errors
    /// The file is damaged.
    pub fn next_group(&mut self) -> Result<Option<Vec<Vec<Value>>>, TableError> {
        let claimed = self.reader.metadata().row_groups().get(self.next).map_or(0, |group| group.num_rows());
        if claimed > GROUP as i64 {
            let reason = format!("it has {claimed} rows in one group, and this program writes {GROUP} at most");
            return Err(TableError::Parquet { file: self.file.clone(), reason });
        }
        let mut rows = Vec::new();
        Ok(self.append(&mut rows)?.then_some(rows))
    }

    /// Adds the rows of the next group; says whether there was one.
    fn append(&mut self, rows: &mut Vec<Vec<Value>>) -> Result<bool, TableError> {
        if self.next >= self.reader.num_row_groups() {
            return Ok(false);
        }
        let strange = |error: ParquetError| TableError::Parquet { file: self.file.clone(), reason: error.to_string() };
        append(&self.reader, self.next, self.columns.len(), rows).map_err(strange)?;
        self.next += 1;
        Ok(true)
    }
}

fn described(column: &ColumnDescriptor) -> Result<Column, String> {
    let name = column.path().string();
    if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
        return Err(format!("column `{name}` holds lists or groups; a table here has one plain value a cell"));
    }
    let text =
        column.converted_type() == ConvertedType::UTF8 || column.logical_type_ref() == Some(&LogicalType::String);
    let plain = matches!(
        column.converted_type(),
        ConvertedType::NONE
            | ConvertedType::INT_8
            | ConvertedType::INT_16
            | ConvertedType::INT_32
            | ConvertedType::INT_64
    );
    let kind = match column.physical_type() {
        Physical::INT32 | Physical::INT64 if plain => Kind::Integer,
        Physical::FLOAT | Physical::DOUBLE => Kind::Number,
        Physical::BOOLEAN => Kind::Flag,
        Physical::BYTE_ARRAY if text => Kind::Text,
        other => {
            return Err(format!(
                "column `{name}` is of type {other}; a table here has whole numbers, numbers, flags and texts: leave the \
                 column out, or convert it"
            ));
        }
    };
    Ok(Column { name, kind })
}

/// Adds the rows of one group.
fn append(
    reader: &SerializedFileReader<File>,
    index: usize,
    columns: usize,
    rows: &mut Vec<Vec<Value>>,
) -> Result<(), ParquetError> {
    let group = reader.get_row_group(index)?;
    let count = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
    let from = rows.len();
    rows.extend((0..count).map(|_| Vec::with_capacity(columns)));
    for at in 0..columns {
        sound(group.metadata().column(at))?;
        let rows = &mut rows[from..];
        match group.get_column_reader(at)? {
            ColumnReader::Int32ColumnReader(column) => take(column, rows, |value| Ok(Value::Integer(value.into())))?,
            ColumnReader::Int64ColumnReader(column) => take(column, rows, |value| Ok(Value::Integer(value)))?,
            ColumnReader::FloatColumnReader(column) => take(column, rows, |value| Ok(Value::Number(value.into())))?,
            ColumnReader::DoubleColumnReader(column) => take(column, rows, |value| Ok(Value::Number(value)))?,
            ColumnReader::BoolColumnReader(column) => take(column, rows, |value| Ok(Value::Flag(value)))?,
            ColumnReader::ByteArrayColumnReader(column) => {
                take(column, rows, |value| Ok(Value::Text(value.as_utf8()?.to_string())))?;
            }
            _ => return Err(ParquetError::General(format!("column {} is of an unknown type", at + 1))),
        }
    }
    Ok(())
}

/// Whether a column says where it is. The library takes that for granted, and panics where it is not so.
fn sound(column: &ColumnChunkMetaData) -> Result<(), ParquetError> {
    let dictionary = column.dictionary_page_offset().unwrap_or(0);
    match [column.data_page_offset(), dictionary, column.compressed_size()].iter().all(|at| *at >= 0) {
        true => Ok(()),
        false => Err(ParquetError::General("the file is damaged: a column begins before the file does".to_string())),
    }
}

/// Puts the values of one column of a group at the end of its rows.
fn take<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    rows: &mut [Vec<Value>],
    make: impl Fn(T::T) -> Result<Value, ParquetError>,
) -> Result<(), ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let (found, ..) = column.read_records(rows.len(), Some(&mut levels), None, &mut values)?;
    if found != rows.len() {
        return Err(ParquetError::General(format!("a column has {found} values for {} rows", rows.len())));
    }
    let required = levels.is_empty();
    let mut values = values.into_iter();
    for (index, row) in rows.iter_mut().enumerate() {
        let there = required || levels.get(index).is_some_and(|level| *level > 0);
        row.push(match there.then(|| values.next()).flatten() {
            Some(value) => make(value)?,
            None => Value::Missing,
        });
    }
    Ok(())
}
