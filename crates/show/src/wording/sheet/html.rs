//! Words and tables as elements of a page.

use super::{Part, Table};
use crate::wording::escaped;

pub(super) fn parts(parts: &[Part], title: &str) -> String {
    let mut tables = 0;
    let one = |part: &Part| match part {
        Part::Words(words) => words.lines().map(line).collect(),
        Part::Paragraph(words) => line(&words.trim().replace('\n', " ")),
        Part::Table(of) => {
            tables += 1;
            table(of, &format!("{title}, table {tables}"))
        }
    };
    parts.iter().map(one).collect()
}

/// A line of words; one that stands in does so on the page.
fn line(line: &str) -> String {
    let class = if line.starts_with(' ') { " class=\"in\"" } else { "" };
    match line.trim() {
        "" => String::new(),
        words => format!("<p{class}>{}</p>\n", escaped(words)),
    }
}

/// A table in a box that scrolls by itself, by keyboard too.
fn table(table: &Table, title: &str) -> String {
    let columns = table.rows.iter().map(Vec::len).max().unwrap_or(0);
    let (heads, rows) = table.rows.split_at(table.heads.min(table.rows.len()));
    let heads = head(heads, columns);
    let rows: String = rows.iter().map(|row| body(row, columns)).collect();
    format!(
        "<div class=\"grid\" tabindex=\"0\" role=\"region\" aria-label=\"{}\"><table>\n{heads}<tbody>\n{rows}</tbody>\n</table></div>\n",
        escaped(title)
    )
}

/// One row, for a head of several lines is one where there is room.
fn head(rows: &[Vec<String>], columns: usize) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let cell = |column: usize| {
        let lines =
            rows.iter().filter_map(|row| row.get(column)).map(|line| line.trim()).filter(|line| !line.is_empty());
        match lines.collect::<Vec<_>>().join(" ") {
            text if text.is_empty() => "<td></td>".to_string(),
            text => format!("<th scope=\"col\">{}</th>", escaped(&text)),
        }
    };
    format!("<thead>\n<tr>{}</tr>\n</thead>\n", (0..columns).map(cell).collect::<String>())
}

fn body(row: &[String], columns: usize) -> String {
    if let ([heading], 2..) = (row, columns) {
        return format!("<tr><th scope=\"rowgroup\" colspan=\"{columns}\">{}</th></tr>\n", escaped(heading.trim()));
    }
    let cell = |(index, cell): (usize, &String)| {
        let text = escaped(cell.trim());
        match index {
            0 if cell.starts_with(' ') => format!("<th scope=\"row\" class=\"in\">{text}</th>"),
            0 => format!("<th scope=\"row\">{text}</th>"),
            _ => format!("<td>{text}</td>"),
        }
    };
    format!("<tr>{}{}</tr>\n", row.iter().enumerate().map(cell).collect::<String>(), rest(row, columns))
}

/// Cells that a short row lacks.
fn rest(row: &[String], columns: usize) -> String {
    "<td></td>".repeat(columns.saturating_sub(row.len()))
}

#[cfg(test)]
mod tests {
    use crate::wording::figures::row;
    use crate::wording::sheet::{Sheet, table};

    #[test]
    fn words_and_tables_are_elements_and_nothing_in_them_is_markup() {
        let mut sheet = Sheet::from("a < b\n  within\n\n");
        sheet.push(table(&[row(["", "x, µm", "y"]), row(["family <i>"]), row(["  one", "1", "2"]), row(["two", "3"])]));
        sheet.push(Sheet::paragraph("goes\non\n"));
        assert_eq!(
            sheet.html("a \"title\""),
            "<p>a &lt; b</p>\n<p class=\"in\">within</p>\n<div class=\"grid\" tabindex=\"0\" role=\"region\" aria-label=\"a \
             &quot;title&quot;, table 1\"><table>\n<thead>\n<tr><td></td><th scope=\"col\">x, µm</th><th \
             scope=\"col\">y</th></tr>\n</thead>\n<tbody>\n<tr><th scope=\"rowgroup\" colspan=\"3\">family \
             &lt;i&gt;</th></tr>\n<tr><th scope=\"row\" class=\"in\">one</th><td>1</td><td>2</td></tr>\n<tr><th \
             scope=\"row\">two</th><td>3</td><td></td></tr>\n</tbody>\n</table></div>\n<p>goes on</p>\n"
        );
    }
}
