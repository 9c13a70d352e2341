//! A report as Markdown.

use super::{Cell, Figure, Part, Report, Table, Tone};

pub(super) fn report(report: &Report) -> String {
    let mut text = if report.title.is_empty() { String::new() } else { format!("# {}\n", report.title) };
    let (mut tables, mut figures) = (0, 0);
    for part in &report.parts {
        text.push('\n');
        match part {
            Part::Heading(heading) => text.push_str(&format!("## {heading}\n")),
            // A line that ends where it ends does so by two spaces.
            Part::Words(words) => text.push_str(&format!("{}\n", words.trim().replace('\n', "  \n"))),
            Part::Paragraph(words) => text.push_str(&format!("{}\n", words.trim())),
            Part::Notes(notes) => text.extend(notes.iter().flat_map(|note| ["- ", note.as_str(), "\n"])),
            Part::Table(of) => {
                tables += 1;
                text.push_str(&table(of, tables));
            }
            Part::Figure(figure) => {
                figures += 1;
                text.push_str(&picture(figure, figures));
            }
            Part::Text(of) => text.push_str(&format!("**{}**\n\n```\n{}\n```\n", of.title, of.text.trim_end())),
        }
    }
    text
}

fn table(table: &Table, number: usize) -> String {
    let escaped = |text: &str| text.trim().replace('|', "\\|").replace('\n', " ");
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let (heads, rows) = table.parted();
    let columns = table.columns();
    let mut text = match table.caption.as_str() {
        "" => String::new(),
        caption => format!("**Table {number}.** {caption}\n\n"),
    };
    let head = |column: usize| {
        let lines = heads.iter().filter_map(|row| row.get(column)).map(|cell| escaped(&cell.text));
        lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join(" ")
    };
    text.push_str(&line((0..columns).map(head).collect()));
    let rule = |column: usize| if column > 0 && !table.is_in_words(column) { "---:" } else { "---" };
    text.push_str(&line((0..columns).map(|column| rule(column).to_string()).collect()));
    let shown = |cell: Option<&Cell>| match cell {
        Some(Cell { text, tone: Tone::Bad, .. }) => format!("**{}**", escaped(text)),
        Some(Cell { text, .. }) => escaped(text),
        None => String::new(),
    };
    for row in rows {
        text.push_str(&line((0..columns).map(|column| shown(row.get(column))).collect()));
    }
    text
}

fn picture(figure: &Figure, number: usize) -> String {
    format!("![{}](figures/{})\n\n**Figure {number}.** {}\n", figure.file, figure.file, figure.caption)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wording::figures::row;

    #[test]
    fn every_part_has_a_form() {
        let bad = vec![Cell::words("a|b"), Cell { tone: Tone::Bad, ..Cell::new("2") }];
        let mut all = Report::section("First").words("goes on").notes(vec!["one".to_string()]);
        all = all.table("What.", &["", "x"], vec![bad]).figure("f.svg", "How.", "<svg>".to_string());
        all.title = "All".to_string();
        all.push("one\ntwo\n");
        all.push(Table::new(&[row(["", "x,"]), row(["", "mm"]), row(["whole"]), row(["  a", "1"])]).heads(2));
        assert_eq!(
            report(&all.text("id", "A text", "a = 1\n".to_string())),
            "# All\n\n## First\n\ngoes on\n\n- one\n\n**Table 1.** What.\n\n|  | x |\n| --- | ---: |\n| a\\|b | **2** \
             |\n\n![f.svg](figures/f.svg)\n\n**Figure 1.** How.\n\none  \ntwo\n\n|  | x, mm |\n| --- | ---: |\n| whole |  |\n| a | 1 \
             |\n\n**A text**\n\n```\na = 1\n```\n"
        );
    }
}
