//! A report as HTML elements of a page.

use super::{Block, Cell, CellStyle, Figure, Table};
use crate::format::escape_markup;

/// Renders blocks in order; each heading starts a section.
pub(super) fn blocks(blocks: &[Block], title: &str) -> String {
    let (mut sections, mut tables, mut figures) = (0, 0, 0);
    let mut text = String::new();
    for block in blocks {
        text.push_str(&match block {
            Block::Heading(heading) => {
                let before = if sections > 0 { "</section>\n" } else { "" };
                sections += 1;
                format!("{before}<section id=\"s{}\"><h2>{}</h2>\n", sections - 1, escape_markup(heading))
            }
            Block::Lines(content) => content.lines().map(line).collect(),
            Block::Paragraph(content) => line(&content.trim().replace('\n', " ")),
            Block::Notes(notes) => {
                let items: String = notes.iter().map(|note| format!("<li>{}</li>\n", escape_markup(note))).collect();
                format!("<ul class=\"notes\">\n{items}</ul>\n")
            }
            Block::Table(item) => {
                tables += 1;
                table(item, title, tables)
            }
            Block::Figure(figure) => {
                figures += 1;
                figure_element(figure, figures)
            }
        });
    }
    if sections > 0 {
        text.push_str("</section>\n");
    }
    text
}

/// Renders a line of text; indentation is preserved.
fn line(line: &str) -> String {
    let class = if line.starts_with(' ') { " class=\"in\"" } else { "" };
    match line.trim() {
        "" => String::new(),
        content => format!("<p{class}>{}</p>\n", escape_markup(content)),
    }
}

/// Renders a table in a box that can be scrolled by keyboard; its accessible name is its caption, or else the title of
/// its context.
fn table(table: &Table, title: &str, number: usize) -> String {
    let columns = table.columns();
    let rows = table.split_header().1;
    let (caption, name) = match table.caption.as_str() {
        "" => (String::new(), format!("aria-label=\"{}, table {number}\"", escape_markup(title))),
        caption => (
            format!("<p class=\"caption\" id=\"t{number}\"><b>Table {number}.</b> {}</p>\n", escape_markup(caption)),
            format!("aria-labelledby=\"t{number}\""),
        ),
    };
    let heads = header(table, columns);
    let rows: String = rows.iter().map(|row| body_row(row, columns)).collect();
    format!(
        "{caption}<div class=\"grid\" tabindex=\"0\" role=\"region\" {name}><table>\n{heads}<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

/// Renders the header as one row. Prose columns are aligned left.
fn header(table: &Table, columns: usize) -> String {
    if table.split_header().0.is_empty() {
        return String::new();
    }
    let cell = |column: usize| {
        let class = if table.is_prose_column(column) { " class=\"words\"" } else { "" };
        match table.header_text(column) {
            text if text.is_empty() => "<td></td>".to_string(),
            text => format!("<th scope=\"col\"{class}>{}</th>", escape_markup(&text)),
        }
    };
    format!("<thead>\n<tr>{}</tr>\n</thead>\n", (0..columns).map(cell).collect::<String>())
}

fn body_row(row: &[Cell], columns: usize) -> String {
    if let ([heading], 2..) = (row, columns) {
        let heading = escape_markup(heading.text.trim());
        return format!("<tr><th scope=\"rowgroup\" colspan=\"{columns}\">{heading}</th></tr>\n");
    }
    let cells: String = row.iter().enumerate().map(cell).collect();
    // Fill up short rows.
    format!("<tr>{cells}{}</tr>\n", "<td></td>".repeat(columns.saturating_sub(row.len())))
}

fn cell((index, cell): (usize, &Cell)) -> String {
    let class = match cell.style {
        CellStyle::Plain if index == 0 && cell.text.starts_with(' ') => " class=\"in\"",
        CellStyle::Plain => "",
        CellStyle::Good => " class=\"good\"",
        CellStyle::Bad => " class=\"bad\"",
        CellStyle::Prose => " class=\"words\"",
    };
    let figure_attributes =
        |(key, value): &(String, f64)| format!(" data-figure=\"{}\" data-si=\"{value:e}\"", escape_markup(key));
    let figure = cell.figure.as_ref().map_or(String::new(), figure_attributes);
    let text = escape_markup(cell.text.trim());
    match index {
        0 => format!("<th scope=\"row\"{class}{figure}>{text}</th>"),
        _ => format!("<td{class}{figure}>{text}</td>"),
    }
}

fn figure_element(figure: &Figure, number: usize) -> String {
    let caption = escape_markup(&figure.caption);
    format!(
        "<figure><div class=\"sheet\" tabindex=\"0\" role=\"img\" aria-label=\"{caption}\">{}</div><figcaption><b>Figure \
         {number}.</b> {caption}</figcaption></figure>\n",
        figure.svg
    )
}

#[cfg(test)]
mod tests {
    use crate::format::numbers::row;
    use crate::format::report::{Report, table};

    #[test]
    fn renders_escaped_text_and_tables() {
        let mut report = Report::from("a < b\n  within\n\n");
        report.push(table(&[
            row(["", "x, µm", "y"]),
            row(["family <i>"]),
            row(["  one", "1", "2"]),
            row(["two", "3"]),
        ]));
        report.push(Report::paragraph("goes\non\n"));
        assert_eq!(
            report.html("a \"title\""),
            "<p>a &lt; b</p>\n<p class=\"in\">within</p>\n<div class=\"grid\" tabindex=\"0\" role=\"region\" aria-label=\"a \
             &quot;title&quot;, table 1\"><table>\n<thead>\n<tr><td></td><th scope=\"col\">x, µm</th><th \
             scope=\"col\">y</th></tr>\n</thead>\n<tbody>\n<tr><th scope=\"rowgroup\" colspan=\"3\">family \
             &lt;i&gt;</th></tr>\n<tr><th scope=\"row\" class=\"in\">one</th><td>1</td><td>2</td></tr>\n<tr><th \
             scope=\"row\">two</th><td>3</td><td></td></tr>\n</tbody>\n</table></div>\n<p>goes on</p>\n"
        );
    }
}
