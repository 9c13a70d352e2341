//! A report as Markdown, and as HTML elements of a page.

use std::mem::discriminant;

use super::{Block, Cell, CellStyle, Report, Table};
use crate::format::escape_markup;
use crate::scene::one_line;

/// Blocks with their numbers among the blocks of the same kind, from 1.
fn numbered(report: &Report) -> impl Iterator<Item = (usize, &Block)> {
    report.blocks.iter().enumerate().map(|(index, block)| {
        let before = report.blocks[..index].iter().filter(|other| discriminant(*other) == discriminant(block));
        (before.count() + 1, block)
    })
}

pub(super) fn markdown(report: &Report) -> String {
    let line = |text: &str| escape_markdown(&one_line(text));
    let mut text = if report.title.is_empty() { String::new() } else { format!("# {}\n", line(&report.title)) };
    for (number, block) in numbered(report) {
        text.push('\n');
        text.push_str(&match block {
            Block::Heading(heading) => format!("## {}\n", line(heading)),
            // Two trailing spaces preserve a line end in Markdown.
            Block::Lines(content) => format!("{}\n", escape_markdown(content.trim()).replace('\n', "  \n")),
            Block::Paragraph(content) => format!("{}\n", escape_markdown(content.trim())),
            Block::Notes(notes) => notes.iter().map(|note| format!("- {}\n", line(note))).collect(),
            Block::Table(table) => markdown_table(table, number),
            Block::Figure(figure) => {
                format!("![{0}](figures/{0})\n\n**Figure {number}.** {1}\n", figure.file, line(&figure.caption))
            }
        });
    }
    text
}

/// Escapes what Markdown reads as markup: HTML and entities, links, code, emphasis, and headings, quotes, lists and rules at
/// the beginning of a line.
fn escape_markdown(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for (index, line) in text.split('\n').enumerate() {
        if index > 0 {
            out.push('\n');
        }
        let content = line.trim_start();
        out.push_str(&line[..line.len() - content.len()]);
        let digits = content.len() - content.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (first, second) = (content[digits..].chars().next(), content[digits..].chars().nth(1));
        let is_separated = second.is_none_or(char::is_whitespace);
        let is_block = match first {
            Some('#' | '>' | '=' | '~') => digits == 0,
            // A sign before a number is none of these.
            Some('-' | '+') => digits == 0 && (is_separated || second == Some('-')),
            Some('.' | ')') => digits > 0 && is_separated,
            _ => false,
        };
        let mut before = ' ';
        let mut rest = content.chars().peekable();
        let mut position = 0;
        while let Some(c) = rest.next() {
            let next = rest.peek().copied().unwrap_or(' ');
            let is_special = match c {
                '\\' | '`' | '*' | '[' | '<' => true,
                '&' => next == '#' || next.is_ascii_alphabetic(),
                // Within a word it is a letter.
                '_' => !(before.is_alphanumeric() && next.is_alphanumeric()),
                _ => false,
            };
            if is_special || is_block && position == digits {
                out.push('\\');
            }
            out.push(c);
            before = c;
            position += 1;
        }
    }
    out
}

fn markdown_table(table: &Table, number: usize) -> String {
    let escape = |text: &str| escape_markdown(&one_line(text.trim())).replace('|', "\\|");
    let line = |cell: &dyn Fn(usize) -> String| {
        format!("| {} |\n", (0..table.columns()).map(cell).collect::<Vec<_>>().join(" | "))
    };
    let mut text = match table.caption.as_str() {
        "" => String::new(),
        caption => format!("**Table {number}.** {}\n\n", escape_markdown(&one_line(caption))),
    };
    text += &line(&|column| escape(&table.header_text(column)));
    text += &line(&|column| if column > 0 && !table.is_prose_column(column) { "---:" } else { "---" }.to_string());
    for row in table.split_header().1 {
        text += &line(&|column| match row.get(column) {
            Some(Cell { text, style: CellStyle::Bad, .. }) => format!("**{}**", escape(text)),
            Some(Cell { text, .. }) => escape(text),
            None => String::new(),
        });
    }
    text
}

/// Renders blocks in order; each heading starts a section. `title` names tables without a caption.
pub(super) fn html(report: &Report, title: &str) -> String {
    let mut text = String::new();
    let mut section_end = "";
    for (number, block) in numbered(report) {
        text.push_str(&match block {
            Block::Heading(heading) => {
                let end = std::mem::replace(&mut section_end, "</section>\n");
                format!("{end}<section id=\"s{}\"><h2>{}</h2>\n", number - 1, escape_markup(heading))
            }
            Block::Lines(content) => content.lines().map(html_line).collect(),
            Block::Paragraph(content) => html_line(&content.trim().replace('\n', " ")),
            Block::Notes(notes) => {
                let items: String = notes.iter().map(|note| format!("<li>{}</li>\n", escape_markup(note))).collect();
                format!("<ul class=\"notes\">\n{items}</ul>\n")
            }
            Block::Table(table) => html_table(table, title, number),
            Block::Figure(figure) => {
                let (caption, svg) = (escape_markup(&figure.caption), &figure.svg);
                format!(
                    "<figure><div class=\"sheet\" tabindex=\"0\" role=\"img\" aria-label=\"{caption}\">{svg}</div><figcaption><b>Figure \
                     {number}.</b> {caption}</figcaption></figure>\n"
                )
            }
        });
    }
    text + section_end
}

/// Renders a line of text; indentation is preserved.
fn html_line(line: &str) -> String {
    let class = if line.starts_with(' ') { " class=\"in\"" } else { "" };
    match line.trim() {
        "" => String::new(),
        content => format!("<p{class}>{}</p>\n", escape_markup(content)),
    }
}

/// Renders a table in a box that can be scrolled by keyboard; its accessible name is its caption, or else the title of
/// its context.
fn html_table(table: &Table, title: &str, number: usize) -> String {
    let (columns, (header, rows)) = (table.columns(), table.split_header());
    let (caption, name) = match table.caption.as_str() {
        "" => (String::new(), format!("aria-label=\"{}, table {number}\"", escape_markup(title))),
        caption => (
            format!("<p class=\"caption\" id=\"t{number}\"><b>Table {number}.</b> {}</p>\n", escape_markup(caption)),
            format!("aria-labelledby=\"t{number}\""),
        ),
    };
    // The header is one row. Prose columns are aligned left.
    let header_cell = |column: usize| {
        let class = if table.is_prose_column(column) { " class=\"words\"" } else { "" };
        match table.header_text(column) {
            text if text.is_empty() => "<td></td>".to_string(),
            text => format!("<th scope=\"col\"{class}>{}</th>", escape_markup(&text)),
        }
    };
    let header = match header {
        [] => String::new(),
        _ => format!("<thead>\n<tr>{}</tr>\n</thead>\n", (0..columns).map(header_cell).collect::<String>()),
    };
    let row = |row: &Vec<Cell>| match (row.as_slice(), columns) {
        ([heading], 2..) => {
            let heading = escape_markup(heading.text.trim());
            format!("<tr><th scope=\"rowgroup\" colspan=\"{columns}\">{heading}</th></tr>\n")
        }
        // Short rows are filled up.
        (cells, _) => {
            let filled = "<td></td>".repeat(columns.saturating_sub(row.len()));
            format!("<tr>{}{filled}</tr>\n", cells.iter().enumerate().map(html_cell).collect::<String>())
        }
    };
    let rows: String = rows.iter().map(row).collect();
    format!(
        "{caption}<div class=\"grid\" tabindex=\"0\" role=\"region\" {name}><table>\n{header}<tbody>\n{rows}</tbody>\n</table></div>\n"
    )
}

fn html_cell((index, cell): (usize, &Cell)) -> String {
    let class = match cell.style {
        CellStyle::Plain if index == 0 && cell.text.starts_with(' ') => " class=\"in\"",
        CellStyle::Plain => "",
        CellStyle::Good => " class=\"good\"",
        CellStyle::Bad => " class=\"bad\"",
        CellStyle::Prose => " class=\"words\"",
    };
    let figure = cell
        .figure
        .as_ref()
        .map_or(String::new(), |(key, value)| format!(" data-figure=\"{}\" data-si=\"{value:e}\"", escape_markup(key)));
    let text = escape_markup(cell.text.trim());
    match index {
        0 => format!("<th scope=\"row\"{class}{figure}>{text}</th>"),
        _ => format!("<td{class}{figure}>{text}</td>"),
    }
}

#[cfg(test)]
mod tests {
    use crate::format::numbers::row;
    use crate::format::report::{Cell, CellStyle, Report, Table, table};

    #[test]
    fn markdown_renders_every_kind_of_block() {
        let bad = vec![Cell::prose("a|b"), Cell { style: CellStyle::Bad, ..Cell::new("2") }];
        let mut all = Report::section("First").with_paragraph("goes on").with_notes(vec!["one".to_string()]);
        all = all.with_table("What.", &["", "x"], vec![bad]).with_figure("f.svg", "How.", "<svg>".to_string());
        all.title = "All".to_string();
        all.push("one\ntwo\n");
        all.push(Table::new(&[row(["", "x,"]), row(["", "mm"]), row(["whole"]), row(["  a", "1"])]).header_rows(2));
        assert_eq!(
            all.markdown(),
            "# All\n\n## First\n\ngoes on\n\n- one\n\n**Table 1.** What.\n\n|  | x |\n| --- | ---: |\n| a\\|b | **2** \
             |\n\n![f.svg](figures/f.svg)\n\n**Figure 1.** How.\n\none  \ntwo\n\n|  | x, mm |\n| --- | ---: |\n| whole |  |\n| a | 1 \
             |\n"
        );
    }

    /// Names in texts are no markup, and begin no lines.
    #[test]
    fn markdown_escapes_markup() {
        for (text, escaped) in [
            (
                "<b>*a*</b> [l](u) `c` &amp; & _e_ a_b \\",
                "\\<b>\\*a\\*\\</b> \\[l](u) \\`c\\` \\&amp; & \\_e\\_ a_b \\\\",
            ),
            ("# a", "\\# a"),
            ("- a", "\\- a"),
            ("-1 mm", "-1 mm"),
            ("---", "\\---"),
            ("===", "\\==="),
            ("12. a", "12\\. a"),
            ("12.5 mm", "12.5 mm"),
            ("> a", "\\> a"),
            ("a > b", "a > b"),
            ("~~~", "\\~~~"),
        ] {
            assert_eq!(super::escape_markdown(text), escaped);
            assert_eq!(super::escape_markdown(&format!("x\n  {text}")), format!("x\n  {escaped}"));
        }
        let mut report = Report::section("a\n# b").with_notes(vec!["a\nb".to_string()]);
        report = report.with_table("c\nd", &["e\nf"], vec![vec![Cell::new("g\nh")]]);
        report.title = "t\n# u".to_string();
        let text = report.markdown();
        assert_eq!(text.lines().filter(|line| ["# b", "b", "d", "f", "h", "# u"].contains(line)).count(), 0, "{text}");
        assert!(!report.to_string().lines().any(|line| ["# b", "b", "d", "f", "h"].contains(&line.trim())), "{report}");
    }

    #[test]
    fn html_renders_escaped_text_and_tables() {
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
