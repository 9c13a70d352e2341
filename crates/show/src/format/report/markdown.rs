//! Formats a report as Markdown.

use super::{Block, Cell, CellStyle, Figure, Report, Table};

pub(super) fn report(report: &Report) -> String {
    let mut text = if report.title.is_empty() { String::new() } else { format!("# {}\n", report.title) };
    let (mut tables, mut figures) = (0, 0);
    for block in &report.blocks {
        text.push('\n');
        match block {
            Block::Heading(heading) => text.push_str(&format!("## {heading}\n")),
            // Two trailing spaces preserve a line end in Markdown.
            Block::Lines(content) => text.push_str(&format!("{}\n", content.trim().replace('\n', "  \n"))),
            Block::Paragraph(content) => text.push_str(&format!("{}\n", content.trim())),
            Block::Notes(notes) => text.extend(notes.iter().flat_map(|note| ["- ", note.as_str(), "\n"])),
            Block::Table(item) => {
                tables += 1;
                text.push_str(&table(item, tables));
            }
            Block::Figure(figure) => {
                figures += 1;
                text.push_str(&picture(figure, figures));
            }
        }
    }
    text
}

fn table(table: &Table, number: usize) -> String {
    let escape_markup = |text: &str| text.trim().replace('|', "\\|").replace('\n', " ");
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let columns = table.columns();
    let mut text = match table.caption.as_str() {
        "" => String::new(),
        caption => format!("**Table {number}.** {caption}\n\n"),
    };
    text.push_str(&line((0..columns).map(|column| escape_markup(&table.header_text(column))).collect()));
    let rule = |column: usize| if column > 0 && !table.is_prose_column(column) { "---:" } else { "---" };
    text.push_str(&line((0..columns).map(|column| rule(column).to_string()).collect()));
    let cell_text = |cell: Option<&Cell>| match cell {
        Some(Cell { text, style: CellStyle::Bad, .. }) => format!("**{}**", escape_markup(text)),
        Some(Cell { text, .. }) => escape_markup(text),
        None => String::new(),
    };
    for row in table.split_header().1 {
        text.push_str(&line((0..columns).map(|column| cell_text(row.get(column))).collect()));
    }
    text
}

fn picture(figure: &Figure, number: usize) -> String {
    format!("![{}](figures/{})\n\n**Figure {number}.** {}\n", figure.file, figure.file, figure.caption)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::format::numbers::row;

    #[test]
    fn renders_every_kind_of_block() {
        let bad = vec![Cell::prose("a|b"), Cell { style: CellStyle::Bad, ..Cell::new("2") }];
        let mut all = Report::section("First").with_paragraph("goes on").with_notes(vec!["one".to_string()]);
        all = all.with_table("What.", &["", "x"], vec![bad]).with_figure("f.svg", "How.", "<svg>".to_string());
        all.title = "All".to_string();
        all.push("one\ntwo\n");
        all.push(Table::new(&[row(["", "x,"]), row(["", "mm"]), row(["whole"]), row(["  a", "1"])]).header_rows(2));
        assert_eq!(
            report(&all),
            "# All\n\n## First\n\ngoes on\n\n- one\n\n**Table 1.** What.\n\n|  | x |\n| --- | ---: |\n| a\\|b | **2** \
             |\n\n![f.svg](figures/f.svg)\n\n**Figure 1.** How.\n\none  \ntwo\n\n|  | x, mm |\n| --- | ---: |\n| whole |  |\n| a | 1 \
             |\n"
        );
    }
}
