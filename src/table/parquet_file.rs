//! Tables as Parquet: one optional column each of INT64, DOUBLE, BOOLEAN or UTF-8 BYTE_ARRAY, compressed with zstd.

use std::fs::File;
use std::io::{self, Write};
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{Compression, ConvertedType, LogicalType, Repetition, Type as Physical};
use parquet::column::reader::{ColumnReader, ColumnReaderImpl};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::properties::WriterProperties;
use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{ColumnDescriptor, Type, TypePtr};

use super::{Column, Kind, Origin, Table, TableError, Value};
use crate::limits::LARGEST_TABLE_BYTES;

/// Rows of one group: a reader needs one group in memory at a time.
const GROUP: usize = 1 << 16;

/// Writes the table as Parquet. The same table gives the same bytes.
pub(super) fn write(out: &mut dyn Write, table: &Table) -> io::Result<()> {
    // The format's writer wants to own what it writes to, and to send it elsewhere: the bytes of a table fit in memory.
    let bytes = bytes(table).map_err(io::Error::other)?;
    out.write_all(&bytes)
}

fn bytes(table: &Table) -> Result<Vec<u8>, ParquetError> {
    let properties = WriterProperties::builder().set_compression(Compression::ZSTD(Default::default())).build();
    let mut writer = SerializedFileWriter::new(Vec::new(), schema(table)?, Arc::new(properties))?;
    for rows in table.rows.chunks(GROUP) {
        let mut group = writer.next_row_group()?;
        for (index, column) in table.columns.iter().enumerate() {
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
        group.close()?;
    }
    writer.into_inner()
}

fn schema(table: &Table) -> Result<TypePtr, ParquetError> {
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
    let fields = table.columns.iter().map(field).collect::<Result<_, _>>()?;
    Ok(Arc::new(Type::group_type_builder("phalanx").with_fields(fields).build()?))
}

/// The next column of a group: level 1 where there is a value, 0 where it is missing.
fn put<'a, T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
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
    let file = path.display().to_string();
    let unreadable = |reason: String| TableError::Read { file: file.clone(), reason };
    if path.is_dir() {
        return Err(unreadable("it is a directory; name a file in it".to_string()));
    }
    let opened = File::open(path).map_err(|error| match error.kind() {
        io::ErrorKind::NotFound => unreadable("there is no such file; check the path".to_string()),
        _ => unreadable(error.to_string()),
    })?;
    let most = LARGEST_TABLE_BYTES >> 20;
    if opened.metadata().is_ok_and(|found| found.len() > LARGEST_TABLE_BYTES) {
        return Err(unreadable(format!("it is larger than {most} MiB; take some of its rows, or of its columns")));
    }
    let strange = |reason: String| TableError::Parquet { file: file.clone(), reason };
    let reader = SerializedFileReader::new(opened).map_err(|error| strange(error.to_string()))?;
    let schema = reader.metadata().file_metadata().schema_descr();
    let columns = schema.columns().iter().map(|column| described(column)).collect::<Result<_, _>>().map_err(strange)?;
    let mut table = Table { columns, rows: Vec::new(), origin: Origin { file: file.clone(), lines: Vec::new() } };
    append(&reader, &mut table).map_err(|error| strange(error.to_string()))?;
    super::check(&table)?;
    Ok(table)
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

fn append(reader: &SerializedFileReader<File>, table: &mut Table) -> Result<(), ParquetError> {
    for index in 0..reader.num_row_groups() {
        let group = reader.get_row_group(index)?;
        let count = usize::try_from(group.metadata().num_rows()).unwrap_or(0);
        let from = table.rows.len();
        table.rows.extend((0..count).map(|_| Vec::with_capacity(table.columns.len())));
        for at in 0..table.columns.len() {
            sound(group.metadata().column(at))?;
            let rows = &mut table.rows[from..];
            match group.get_column_reader(at)? {
                ColumnReader::Int32ColumnReader(column) => {
                    take(column, rows, |value| Ok(Value::Integer(value.into())))?
                }
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
