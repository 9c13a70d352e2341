//! Tables as Parquet: optional columns of INT64, DOUBLE, BOOLEAN or UTF-8 BYTE_ARRAY, compressed with zstd.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::Path;
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

use super::{Column, Kind, Table, TableError, Value};
use crate::limits::MAX_TABLE_BYTES;

/// Maximum rows per group; a reader needs one group in memory at a time.
const MAX_GROUP_ROWS: usize = 1 << 16;

type Output<'a> = &'a mut (dyn Write + Send);

/// Writer of a Parquet file. It keeps one group of rows in memory.
pub struct Writer<'a> {
    file: SerializedFileWriter<Output<'a>>,
    columns: Vec<Column>,
    /// Rows of the incomplete group.
    pending: Vec<Vec<Value>>,
}

impl<'a> Writer<'a> {
    pub(super) fn new(out: Output<'a>, columns: &[Column]) -> io::Result<Self> {
        let properties = WriterProperties::builder().set_compression(Compression::ZSTD(Default::default())).build();
        let file = schema(columns).and_then(|schema| SerializedFileWriter::new(out, schema, Arc::new(properties)));
        Ok(Writer { file: file.map_err(io::Error::other)?, columns: columns.to_vec(), pending: Vec::new() })
    }

    pub(super) fn add(&mut self, row: &[Value]) -> io::Result<()> {
        if row.len() != self.columns.len() {
            let message = format!("a row has {} values for {} columns", row.len(), self.columns.len());
            return Err(io::Error::new(io::ErrorKind::InvalidData, message));
        }
        self.pending.push(row.to_vec());
        if self.pending.len() < MAX_GROUP_ROWS { Ok(()) } else { self.write_group().map_err(io::Error::other) }
    }

    /// Writes the remaining rows and the metadata.
    pub(super) fn finish(mut self, metadata: &[(String, String)]) -> io::Result<()> {
        if !self.pending.is_empty() {
            self.write_group().map_err(io::Error::other)?;
        }
        for (name, text) in metadata {
            self.file.append_key_value_metadata(KeyValue::new(name.clone(), text.clone()));
        }
        self.file.close().map(drop).map_err(io::Error::other)
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let rows = std::mem::take(&mut self.pending);
        let mut group = self.file.next_row_group()?;
        for (index, column) in self.columns.iter().enumerate() {
            let values = rows.iter().map(|row| &row[index]);
            match column.kind {
                Kind::Integer => write_column::<Int64Type>(&mut group, values.map(Value::as_integer))?,
                Kind::Number => write_column::<DoubleType>(&mut group, values.map(Value::as_number))?,
                Kind::Flag => write_column::<BoolType>(&mut group, values.map(Value::as_flag))?,
                Kind::Text => {
                    write_column::<ByteArrayType>(
                        &mut group,
                        values.map(|value| value.as_text().map(ByteArray::from)),
                    )?;
                }
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
fn write_column<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Output<'_>>,
    values: impl Iterator<Item = Option<T::T>>,
) -> Result<(), ParquetError> {
    let values: Vec<Option<T::T>> = values.collect();
    let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
    let present: Vec<T::T> = values.into_iter().flatten().collect();
    let Some(mut column) = group.next_column()? else {
        return Err(ParquetError::General("the schema has fewer columns than the table".to_string()));
    };
    column.typed::<T>().write_batch(&present, Some(&levels), None)?;
    column.close()
}

/// Reads a Parquet file of flat columns.
pub(super) fn read(path: &Path) -> Result<Table, TableError> {
    if fs::metadata(path).is_ok_and(|found| found.is_file() && found.len() > MAX_TABLE_BYTES) {
        return Err(TableError::too_large(path));
    }
    let groups = RowGroups::open(path)?;
    let mut table = Table::new(groups.columns.clone(), Vec::new());
    table.origin.file.clone_from(&groups.file);
    for rows in groups {
        table.rows.append(&mut rows?);
    }
    table.check()?;
    Ok(table)
}

/// Reader of a Parquet file with flat columns, group of rows by group of rows; files may be of any size.
pub struct RowGroups {
    file: String,
    reader: SerializedFileReader<File>,
    columns: Vec<Column>,
    next: usize,
}

impl RowGroups {
    /// Opens a file and reads its metadata, but no rows.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, or if it is not a Parquet table of plain values.
    pub fn open(path: &Path) -> Result<Self, TableError> {
        if path.is_dir() {
            return Err(TableError::unopened(path, &io::ErrorKind::IsADirectory.into()));
        }
        let opened = File::open(path).map_err(|error| TableError::unopened(path, &error))?;
        let file = path.display().to_string();
        let reader = SerializedFileReader::new(opened).map_err(|error| invalid(&file, error))?;
        let schema = reader.metadata().file_metadata().schema_descr();
        let columns = schema.columns().iter().map(|column| convert_column(column)).collect::<Result<_, _>>();
        let columns = columns.map_err(|reason| invalid(&file, reason))?;
        Ok(RowGroups { file, reader, columns, next: 0 })
    }

    /// Columns of the file.
    pub fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Number of rows according to the metadata.
    pub fn row_count(&self) -> u64 {
        u64::try_from(self.reader.metadata().file_metadata().num_rows()).unwrap_or(0)
    }

    /// Value of a metadata key; `None` if there is no such key.
    pub fn metadata_value(&self, name: &str) -> Option<&str> {
        let metadata = self.reader.metadata().file_metadata().key_value_metadata()?;
        metadata.iter().find(|entry| entry.key == name)?.value.as_deref()
    }
}

/// Rows of each group; an error if the file is damaged.
impl Iterator for RowGroups {
    type Item = Result<Vec<Vec<Value>>, TableError>;

    fn next(&mut self) -> Option<Self::Item> {
        if self.next >= self.reader.num_row_groups() {
            return None;
        }
        self.next += 1;
        let rows = read_group(&self.reader, self.next - 1, self.columns.len());
        Some(rows.map_err(|error| invalid(&self.file, error)))
    }
}

fn invalid(file: &str, reason: impl std::fmt::Display) -> TableError {
    TableError(format!("{file} is not a readable Parquet table: {reason}"))
}

fn convert_column(column: &ColumnDescriptor) -> Result<Column, String> {
    let name = column.path().string();
    if column.max_rep_level() > 0 || column.path().parts().len() > 1 {
        return Err(format!("column `{name}` contains lists or groups; only one plain value per cell is supported"));
    }
    let converted = column.converted_type();
    let is_text = converted == ConvertedType::UTF8 || column.logical_type_ref() == Some(&LogicalType::String);
    let is_plain = {
        use ConvertedType::{INT_8, INT_16, INT_32, INT_64, NONE};
        matches!(converted, NONE | INT_8 | INT_16 | INT_32 | INT_64)
    };
    let kind = match column.physical_type() {
        Physical::INT32 | Physical::INT64 if is_plain => Kind::Integer,
        Physical::FLOAT | Physical::DOUBLE => Kind::Number,
        Physical::BOOLEAN => Kind::Flag,
        Physical::BYTE_ARRAY if is_text => Kind::Text,
        other => {
            return Err(format!(
                "column `{name}` is of type {other}; only whole numbers, numbers, flags and texts are supported: remove or \
                 convert the column"
            ));
        }
    };
    Ok(Column { name, kind })
}

/// Reads the rows of one group.
fn read_group(
    reader: &SerializedFileReader<File>,
    index: usize,
    columns: usize,
) -> Result<Vec<Vec<Value>>, ParquetError> {
    let group = reader.get_row_group(index)?;
    let count = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
    let mut rows: Vec<Vec<Value>> = (0..count).map(|_| Vec::with_capacity(columns)).collect();
    for index in 0..columns {
        check_offsets(group.metadata().column(index))?;
        let rows = &mut rows[..];
        match group.get_column_reader(index)? {
            ColumnReader::Int32ColumnReader(column) => read_column(column, rows, |value| Ok(i64::from(value).into())),
            ColumnReader::Int64ColumnReader(column) => read_column(column, rows, |value| Ok(value.into())),
            ColumnReader::FloatColumnReader(column) => read_column(column, rows, |value| Ok(f64::from(value).into())),
            ColumnReader::DoubleColumnReader(column) => read_column(column, rows, |value| Ok(value.into())),
            ColumnReader::BoolColumnReader(column) => read_column(column, rows, |value| Ok(value.into())),
            ColumnReader::ByteArrayColumnReader(column) => {
                read_column(column, rows, |value| Ok(value.as_utf8()?.into()))
            }
            _ => Err(ParquetError::General(format!("column {} is of an unknown type", index + 1))),
        }?;
    }
    Ok(rows)
}

/// Checks the offsets and size of a column, because the library panics on negative ones.
fn check_offsets(column: &ColumnChunkMetaData) -> Result<(), ParquetError> {
    let dictionary = column.dictionary_page_offset().unwrap_or(0);
    match [column.data_page_offset(), dictionary, column.compressed_size()].iter().all(|offset| *offset >= 0) {
        true => Ok(()),
        false => Err(ParquetError::General("the file is damaged: a column has a negative offset".to_string())),
    }
}

/// Appends the values of one column to the rows of a group.
fn read_column<T: DataType>(
    mut column: ColumnReaderImpl<T>,
    rows: &mut [Vec<Value>],
    convert: impl Fn(T::T) -> Result<Value, ParquetError>,
) -> Result<(), ParquetError> {
    let (mut levels, mut values) = (Vec::new(), Vec::new());
    let (found, ..) = column.read_records(rows.len(), Some(&mut levels), None, &mut values)?;
    if found != rows.len() {
        return Err(ParquetError::General(format!("a column has {found} values for {} rows", rows.len())));
    }
    let is_required = levels.is_empty();
    let mut values = values.into_iter();
    for (index, row) in rows.iter_mut().enumerate() {
        let is_present = is_required || levels.get(index).is_some_and(|level| *level > 0);
        let value = is_present.then(|| values.next()).flatten();
        row.push(value.map_or(Ok(Value::Missing), &convert)?);
    }
    Ok(())
}
