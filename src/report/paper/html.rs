//! A paper as one HTML file: styles, figures and one small script are in it, and its policy forbids everything else.

use super::{Block, Cell, Figure, Grid, Paper, Section, Text, Tone};
use crate::wording::escaped;

const STYLES: [&str; 3] = [
    include_str!("../../page/assets/theme.css"),
    include_str!("../../page/assets/pictures.css"),
    include_str!("paper.css"),
];
/// Light or dark, as the reader's system has it, and by a button.
const SCRIPT: &str = include_str!("paper.js");

/// The whole file. The same paper gives the same bytes.
pub fn paper_html(paper: &Paper) -> String {
    let title = escaped(&paper.title);
    let nonce = format!("{:08x}", crc32fast::hash(SCRIPT.as_bytes()));
    let (mut tables, mut figures) = (0, 0);
    let sections: String = paper.sections.iter().enumerate().map(|of| section(of, &mut tables, &mut figures)).collect();
    let contents: String = paper
        .sections
        .iter()
        .enumerate()
        .map(|(index, section)| format!("<li><a href=\"#s{index}\">{}</a></li>\n", escaped(&section.title)))
        .collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta http-equiv=\"Content-Security-Policy\" \
         content=\"default-src 'none'; script-src 'nonce-{nonce}'; style-src 'unsafe-inline'; img-src data:; base-uri 'none'; \
         form-action 'none'\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<meta \
         name=\"color-scheme\" content=\"light dark\">\n<meta name=\"generator\" content=\"phalanx\">\n<title>{title}</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>\n{}</style>\n</head>\n<body>\n<header><h1>{title}</h1><button \
         class=\"word\" id=\"theme\" type=\"button\" hidden>Light or dark</button></header>\n<nav aria-label=\"Sections\"><ol>\n\
         {contents}</ol></nav>\n<main>\n{sections}</main>\n<script nonce=\"{nonce}\">\n{SCRIPT}</script>\n</body>\n</html>\n",
        STYLES.concat()
    )
}

fn section((index, section): (usize, &Section), tables: &mut usize, figures: &mut usize) -> String {
    let mut text = format!("<section id=\"s{index}\"><h2>{}</h2>\n", escaped(&section.title));
    for block in &section.blocks {
        text.push_str(&match block {
            Block::Words(words) => format!("<p>{}</p>\n", escaped(words)),
            Block::Notes(notes) => {
                let items: String = notes.iter().map(|note| format!("<li>{}</li>\n", escaped(note))).collect();
                format!("<ul class=\"notes\">\n{items}</ul>\n")
            }
            Block::Table(grid) => {
                *tables += 1;
                table(grid, *tables)
            }
            Block::Figure(figure) => {
                *figures += 1;
                picture(figure, *figures)
            }
            Block::Text(Text { id, title, text }) => format!(
                "<div class=\"text\" id=\"{}\" tabindex=\"-1\"><h3>{}</h3><pre>{}</pre></div>\n",
                escaped(id),
                escaped(title),
                escaped(text)
            ),
        });
    }
    text.push_str("</section>\n");
    text
}

fn table(grid: &Grid, number: usize) -> String {
    // Words and their head begin at the left.
    let column = |(index, cell): (usize, &String)| {
        let words = grid.rows.iter().filter_map(|row| row.get(index)).any(|cell| cell.tone == Tone::Words);
        let class = if words { " class=\"words\"" } else { "" };
        format!("<th scope=\"col\"{class}>{}</th>", escaped(cell))
    };
    let head: String = grid.head.iter().enumerate().map(column).collect();
    let rows: String = grid.rows.iter().map(|row| line(row)).collect();
    format!(
        "<p class=\"caption\" id=\"t{number}\"><b>Table {number}.</b> {}</p>\n<div class=\"grid\" tabindex=\"0\" role=\"region\" \
         aria-labelledby=\"t{number}\"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n",
        escaped(&grid.caption)
    )
}

fn line(row: &[Cell]) -> String {
    let cell = |(index, cell): (usize, &Cell)| {
        let class = match cell.tone {
            Tone::Plain => "",
            Tone::Good => " class=\"good\"",
            Tone::Bad => " class=\"bad\"",
            Tone::Words => " class=\"words\"",
        };
        let figure = cell
            .figure
            .as_ref()
            .map_or(String::new(), |(key, value)| format!(" data-figure=\"{}\" data-si=\"{value:e}\"", escaped(key)));
        let text = match &cell.link {
            Some(id) => format!("<a href=\"#{}\">{}</a>", escaped(id), escaped(&cell.text)),
            None => escaped(&cell.text),
        };
        match index {
            0 => format!("<th scope=\"row\"{class}{figure}>{text}</th>"),
            _ => format!("<td{class}{figure}>{text}</td>"),
        }
    };
    format!("<tr>{}</tr>\n", row.iter().enumerate().map(cell).collect::<String>())
}

fn picture(figure: &Figure, number: usize) -> String {
    let caption = escaped(&figure.caption);
    format!(
        "<figure><div class=\"sheet\" tabindex=\"0\" role=\"img\" aria-label=\"{caption}\">{}</div><figcaption><b>Figure \
         {number}.</b> {caption}</figcaption></figure>\n",
        figure.svg
    )
}
