//! Tables as Parquet: optional columns of INT64, DOUBLE, BOOLEAN or UTF-8 BYTE_ARRAY, compressed with zstd.

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
use crate::files::{ChecksumWriter, checksum};
use crate::limits::MAX_TABLE_BYTES;

/// Maximum rows per group; a reader needs one group in memory at a time.
const MAX_GROUP_ROWS: usize = 1 << 16;

/// Metadata key of the checksum: number of leading bytes of the file, and their CRC.
const CHECKSUM_KEY: &str = "phalanx.checksum";

/// Writes the table as Parquet. The same table gives the same bytes.
pub(super) fn write(out: &mut (dyn Write + Send), table: &Table, metadata: &[(String, String)]) -> io::Result<()> {
    let mut rows = Rows::new(out, &table.columns)?;
    table
        .rows
        .chunks(MAX_GROUP_ROWS)
        .try_for_each(|rows_of_group| rows.group(rows_of_group))
        .map_err(io::Error::other)?;
    rows.finish(metadata)
}

/// Writer of a Parquet file group by group, with one group in memory.
pub(super) struct Rows<'a> {
    writer: SerializedFileWriter<ChecksumWriter<'a>>,
    columns: Vec<Column>,
    /// Rows of the incomplete group.
    pending: Vec<Vec<Value>>,
}

impl<'a> Rows<'a> {
    pub fn new(out: &'a mut (dyn Write + Send), columns: &[Column]) -> io::Result<Self> {
        let properties = WriterProperties::builder().set_compression(Compression::ZSTD(Default::default())).build();
        let writer = schema(columns)
            .and_then(|schema| SerializedFileWriter::new(ChecksumWriter::new(out), schema, Arc::new(properties)));
        Ok(Rows { writer: writer.map_err(io::Error::other)?, columns: columns.to_vec(), pending: Vec::new() })
    }

    pub fn add(&mut self, row: Vec<Value>) -> io::Result<()> {
        self.pending.push(row);
        if self.pending.len() < MAX_GROUP_ROWS {
            return Ok(());
        }
        let rows = std::mem::take(&mut self.pending);
        self.group(&rows).map_err(io::Error::other)
    }

    /// Writes the remaining rows, the metadata and, if there is metadata, a checksum of everything before it.
    pub fn finish(mut self, metadata: &[(String, String)]) -> io::Result<()> {
        let rows = std::mem::take(&mut self.pending);
        if !rows.is_empty() {
            self.group(&rows).map_err(io::Error::other)?;
        }
        for (name, text) in metadata {
            self.writer.append_key_value_metadata(KeyValue::new(name.clone(), text.clone()));
        }
        if !metadata.is_empty() {
            self.writer.flush()?;
            let output = self.writer.inner();
            let encoded_checksum = format!("{}:{:08x}", output.bytes(), output.crc());
            self.writer.append_key_value_metadata(KeyValue::new(CHECKSUM_KEY.to_string(), encoded_checksum));
        }
        self.writer.close().map(drop).map_err(io::Error::other)
    }

    fn group(&mut self, rows: &[Vec<Value>]) -> Result<(), ParquetError> {
        let mut group = self.writer.next_row_group()?;
        for (index, column) in self.columns.iter().enumerate() {
            let values = rows.iter().map(|row| &row[index]);
            match column.kind {
                Kind::Integer => write_column::<Int64Type>(&mut group, values, |value| match value {
                    Value::Integer(value) => Some(*value),
                    _ => None,
                })?,
                Kind::Number => write_column::<DoubleType>(&mut group, values, |value| match value {
                    Value::Number(value) => Some(*value),
                    _ => None,
                })?,
                Kind::Flag => write_column::<BoolType>(&mut group, values, |value| match value {
                    Value::Flag(value) => Some(*value),
                    _ => None,
                })?,
                Kind::Text => write_column::<ByteArrayType>(&mut group, values, |value| match value {
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

/// Writes the next column of a group: definition level 1 for a value, 0 for a missing one.
fn write_column<'a, T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, ChecksumWriter<'_>>,
    values: impl Iterator<Item = &'a Value>,
    get: impl Fn(&Value) -> Option<T::T>,
) -> Result<(), ParquetError> {
    let found: Vec<Option<T::T>> = values.map(get).collect();
    let levels: Vec<i16> = found.iter().map(|value| i16::from(value.is_some())).collect();
    let present: Vec<T::T> = found.into_iter().flatten().collect();
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("the schema has fewer columns than the table".to_string()));
    };
    column.typed::<T>().write_batch(&present, Some(&levels), None)?;
    column.close()
}

/// Reads a Parquet file of flat columns.
pub(super) fn read(path: &Path) -> Result<Table, TableError> {
    if fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > MAX_TABLE_BYTES) {
        let most = MAX_TABLE_BYTES >> 20;
        let reason = format!("it is larger than {most} MiB; select fewer rows or columns");
        return Err(TableError::Read { file: path.display().to_string(), reason });
    }
    let mut groups = RowGroupReader::open(path)?;
    let columns = groups.columns.clone();
    let mut table =
        Table { columns, rows: Vec::new(), origin: Origin { file: groups.file.clone(), lines: Vec::new() } };
    while groups.append_group(&mut table.rows)? {}
    super::check(&table)?;
    Ok(table)
}

/// Reader of a Parquet file with flat columns, group by group, for files of any size.
pub struct RowGroupReader {
    path: PathBuf,
    file: String,
    reader: SerializedFileReader<File>,
    columns: Vec<Column>,
    next: usize,
}

impl RowGroupReader {
    /// Opens a file and reads its metadata, but no rows.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, or is not a Parquet table of plain values.
    pub fn open(path: &Path) -> Result<Self, TableError> {
        let file = path.display().to_string();
        let read_error = |reason: String| TableError::Read { file: file.clone(), reason };
        if path.is_dir() {
            return Err(read_error("it is a directory; name a file in it".to_string()));
        }
        let opened = File::open(path).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => read_error("there is no such file; check the path".to_string()),
            _ => read_error(error.to_string()),
        })?;
        let invalid = |reason: String| TableError::Parquet { file: file.clone(), reason };
        let reader = SerializedFileReader::new(opened).map_err(|error| invalid(error.to_string()))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let columns = schema.columns().iter().map(|column| convert_column(column)).collect::<Result<_, _>>();
        let columns = columns.map_err(invalid)?;
        Ok(RowGroupReader { path: path.to_path_buf(), file, reader, columns, next: 0 })
    }

    /// Columns of the file.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of rows according to the metadata.
    pub fn row_count(&self) -> u64 {
        u64::try_from(self.reader.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// Value of a metadata key.
    pub fn metadata_value(&self, name: &str) -> Option<&str> {
        let metadata = self.reader.metadata().file_metadata().key_value_metadata()?;
        metadata.iter().find(|entry| entry.key == name)?.value.as_deref()
    }

    /// Whether the checksum matches the rows; `false` for a file without checksum.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read.
    pub fn is_intact(&self) -> io::Result<bool> {
        let encoded_checksum =
            self.metadata_value(CHECKSUM_KEY).and_then(|encoded_checksum| encoded_checksum.split_once(':'));
        let Some((bytes, crc)) = encoded_checksum.and_then(|(bytes, crc)| Some((bytes.parse().ok()?, crc))) else {
            return Ok(false);
        };
        let (found, read) = checksum(&self.path, bytes)?;
        Ok(read == bytes && format!("{found:08x}") == crc)
    }

    /// Reads the rows of the next group; `None` after the last one.
    ///
    /// # Errors
    /// Returns an error if the file is damaged, or the group has more rows than this program writes.
    pub fn next_group(&mut self) -> Result<Option<Vec<Vec<Value>>>, TableError> {
        let claimed = self.reader.metadata().row_groups().get(self.next).map_or(0, |group| group.num_rows());
        if claimed > MAX_GROUP_ROWS as i64 {
            let reason = format!("it has {claimed} rows in one group, but at most {MAX_GROUP_ROWS} are allowed");
            return Err(TableError::Parquet { file: self.file.clone(), reason });
        }
        let mut rows = Vec::new();
        Ok(self.append_group(&mut rows)?.then_some(rows))
    }

    /// Appends the rows of the next group; returns `false` after the last one.
    fn append_group(&mut self, rows: &mut Vec<Vec<Value>>) -> Result<bool, TableError> {
        if self.next >= self.reader.num_row_groups() {
            return Ok(false);
        }
        let invalid = |error: ParquetError| TableError::Parquet { file: self.file.clone(), reason: error.to_string() };
        append_group(&self.reader, self.next, self.columns.len(), rows).map_err(invalid)?;
        self.next += 1;
        Ok(true)
    }
}

fn convert_column(column: &ColumnDescriptor) -> Result<Column, String> {
    let name = column.path().string();
    if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
        return Err(format!("column `{name}` contains lists or groups; only one plain value per cell is supported"));
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
                "column `{name}` is of type {other}; only whole numbers, numbers, flags and texts are supported: remove or \
                 convert the column"
            ));
        }
    };
    Ok(Column { name, kind })
}

/// Appends the rows of one group.
fn append_group(
    reader: &SerializedFileReader<File>,
    index: usize,
    columns: usize,
    rows: &mut Vec<Vec<Value>>,
) -> Result<(), ParquetError> {
    let group = reader.get_row_group(index)?;
    let count = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
    let from = rows.len();
    rows.extend((0..count).map(|_| Vec::with_capacity(columns)));
    for column_index in 0..columns {
        is_intact(group.metadata().column(column_index))?;
        let rows = &mut rows[from..];
        match group.get_column_reader(column_index)? {
            ColumnReader::Int32ColumnReader(column) => {
                append_column(column, rows, |value| Ok(Value::Integer(value.into())))?
            }
            ColumnReader::Int64ColumnReader(column) => append_column(column, rows, |value| Ok(Value::Integer(value)))?,
            ColumnReader::FloatColumnReader(column) => {
                append_column(column, rows, |value| Ok(Value::Number(value.into())))?
            }
            ColumnReader::DoubleColumnReader(column) => append_column(column, rows, |value| Ok(Value::Number(value)))?,
            ColumnReader::BoolColumnReader(column) => append_column(column, rows, |value| Ok(Value::Flag(value)))?,
            ColumnReader::ByteArrayColumnReader(column) => {
                append_column(column, rows, |value| Ok(Value::Text(value.as_utf8()?.to_string())))?;
            }
            _ => return Err(ParquetError::General(format!("column {} is of an unknown type", column_index + 1))),
        }
    }
    Ok(())
}

/// Checks the offsets and size of a column, because the library panics on negative ones.
fn is_intact(column: &ColumnChunkMetaData) -> Result<(), ParquetError> {
    let dictionary = column.dictionary_page_offset().unwrap_or(0);
    match [column.data_page_offset(), dictionary, column.compressed_size()].iter().all(|offset| *offset >= 0) {
        true => Ok(()),
        false => Err(ParquetError::General("the file is damaged: a column has a negative offset".to_string())),
    }
}

/// Appends the values of one column to the rows of a group.
fn append_column<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    rows: &mut [Vec<Value>],
    convert: impl Fn(T::T) -> Result<Value, ParquetError>,
) -> Result<(), ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let (found, ..) = column.read_records(rows.len(), Some(&mut levels), None, &mut values)?;
    if found != rows.len() {
        return Err(ParquetError::General(format!("a column has {found} values for {} rows", rows.len())));
    }
    let required = levels.is_empty();
    let mut values = values.into_iter();
    for (index, row) in rows.iter_mut().enumerate() {
        let present = required || levels.get(index).is_some_and(|level| *level > 0);
        row.push(match present.then(|| values.next()).flatten() {
            Some(value) => convert(value)?,
            None => Value::Missing,
        });
    }
    Ok(())
}
