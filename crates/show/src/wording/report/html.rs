//! A report as elements of a page.

use super::{Cell, Figure, Part, Table, Text, Tone};
use crate::wording::escaped;

/// Parts in order; those below a heading are a section.
pub(super) fn parts(parts: &[Part], title: &str) -> String {
    let (mut sections, mut tables, mut figures) = (0, 0, 0);
    let mut text = String::new();
    for part in parts {
        text.push_str(&match part {
            Part::Heading(heading) => {
                let before = if sections > 0 { "</section>\n" } else { "" };
                sections += 1;
                format!("{before}<section id=\"s{}\"><h2>{}</h2>\n", sections - 1, escaped(heading))
            }
            Part::Words(words) => words.lines().map(line).collect(),
            Part::Paragraph(words) => line(&words.trim().replace('\n', " ")),
            Part::Notes(notes) => {
                let items: String = notes.iter().map(|note| format!("<li>{}</li>\n", escaped(note))).collect();
                format!("<ul class=\"notes\">\n{items}</ul>\n")
            }
            Part::Table(of) => {
                tables += 1;
                table(of, title, tables)
            }
            Part::Figure(figure) => {
                figures += 1;
                picture(figure, figures)
            }
            Part::Text(Text { id, title, text }) => format!(
                "<div class=\"text\" id=\"{}\" tabindex=\"-1\"><h3>{}</h3><pre>{}</pre></div>\n",
                escaped(id),
                escaped(title),
                escaped(text)
            ),
        });
    }
    if sections > 0 {
        text.push_str("</section>\n");
    }
    text
}

/// A line of words; one that stands in does so on the page.
fn line(line: &str) -> String {
    let class = if line.starts_with(' ') { " class=\"in\"" } else { "" };
    match line.trim() {
        "" => String::new(),
        words => format!("<p{class}>{}</p>\n", escaped(words)),
    }
}

/// A table in a box that scrolls by itself, by keyboard too; what it is called is its caption, or the title of what it is in.
fn table(table: &Table, title: &str, number: usize) -> String {
    let columns = table.columns();
    let (heads, rows) = table.parted();
    let (caption, name) = match table.caption.as_str() {
        "" => (String::new(), format!("aria-label=\"{}, table {number}\"", escaped(title))),
        caption => (
            format!("<p class=\"caption\" id=\"t{number}\"><b>Table {number}.</b> {}</p>\n", escaped(caption)),
            format!("aria-labelledby=\"t{number}\""),
        ),
    };
    let heads = head(table, heads, columns);
    let rows: String = rows.iter().map(|row| body(row, columns)).collect();
    format!(
        "{caption}<div class=\"grid\" tabindex=\"0\" role=\"region\" {name}><table>\n{heads}<tbody>\n{rows}</tbody>{}</table></div>\n",
        gap(table)
    )
}

/// Between elements of a table without a caption.
fn gap(table: &Table) -> &'static str {
    if table.caption.is_empty() { "\n" } else { "" }
}

/// One row, for a head of several lines is one where there is room. Words and their head begin at the left.
fn head(table: &Table, rows: &[Vec<Cell>], columns: usize) -> String {
    if rows.is_empty() {
        return String::new();
    }
    let cell = |column: usize| {
        let lines = rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.text.trim());
        let class = if table.is_in_words(column) { " class=\"words\"" } else { "" };
        match lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ") {
            text if text.is_empty() && table.caption.is_empty() => "<td></td>".to_string(),
            text => format!("<th scope=\"col\"{class}>{}</th>", escaped(&text)),
        }
    };
    let gap = gap(table);
    format!("<thead>{gap}<tr>{}</tr>{gap}</thead>\n", (0..columns).map(cell).collect::<String>())
}

fn body(row: &[Cell], columns: usize) -> String {
    if let ([heading], 2..) = (row, columns) {
        let heading = escaped(heading.text.trim());
        return format!("<tr><th scope=\"rowgroup\" colspan=\"{columns}\">{heading}</th></tr>\n");
    }
    let cells: String = row.iter().enumerate().map(cell).collect();
    // A short row lacks some.
    format!("<tr>{cells}{}</tr>\n", "<td></td>".repeat(columns.saturating_sub(row.len())))
}

fn cell((index, cell): (usize, &Cell)) -> String {
    let class = match cell.tone {
        Tone::Plain if index == 0 && cell.text.starts_with(' ') => " class=\"in\"",
        Tone::Plain => "",
        Tone::Good => " class=\"good\"",
        Tone::Bad => " class=\"bad\"",
        Tone::Words => " class=\"words\"",
    };
    let shown = |(key, value): &(String, f64)| format!(" data-figure=\"{}\" data-si=\"{value:e}\"", escaped(key));
    let figure = cell.figure.as_ref().map_or(String::new(), shown);
    let text = escaped(cell.text.trim());
    let text = match &cell.link {
        Some(id) => format!("<a href=\"#{}\">{text}</a>", escaped(id)),
        None => text,
    };
    match index {
        0 => format!("<th scope=\"row\"{class}{figure}>{text}</th>"),
        _ => format!("<td{class}{figure}>{text}</td>"),
    }
}

fn picture(figure: &Figure, number: usize) -> String {
    let caption = escaped(&figure.caption);
    format!(
        "<figure><div class=\"sheet\" tabindex=\"0\" role=\"img\" aria-label=\"{caption}\">{}</div><figcaption><b>Figure \
         {number}.</b> {caption}</figcaption></figure>\n",
        figure.svg
    )
}

#[cfg(test)]
mod tests {
    use crate::wording::figures::row;
    use crate::wording::report::{Report, table};

    #[test]
    fn words_and_tables_are_elements_and_nothing_in_them_is_markup() {
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
