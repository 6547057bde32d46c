//! One page of HTML that needs nothing else: no script, and no request to anywhere.

use std::fmt::Write;

use super::figure::{FigureError, Table, escaped};
use super::source::Section;
use super::{Drawing, Versions};

/// What the page may load: nothing. Its style is in it.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; base-uri 'none'; \
                      form-action 'none'";
const STYLE: &str = include_str!("style.css");

/// The whole page, a section for each.
pub fn html(sections: &[Section]) -> Result<String, FigureError> {
    let title = match sections {
        [one] => format!("{} (bumper)", one.heading),
        _ => "bumper: report".to_owned(),
    };
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n\
         <title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <header>\n<h1>{title}</h1>\n{contents}</header>\n<main>\n",
        title = escaped(&title),
        contents = contents(sections),
    );
    for (index, section) in sections.iter().enumerate() {
        page += &section_html(index + 1, section)?;
    }
    let version = Versions::this().bumper;
    page += &format!("</main>\n<footer>Written by bumper {version}.</footer>\n</body>\n</html>\n");
    Ok(page)
}

fn contents(sections: &[Section]) -> String {
    if sections.len() < 2 {
        return String::new();
    }
    let mut list = String::from("<nav aria-label=\"Contents\">\n<ol>\n");
    for (index, section) in sections.iter().enumerate() {
        let (heading, origin) = (escaped(&section.heading), origin(section));
        let _ = writeln!(
            list,
            "<li><a href=\"#s{}\">{heading}</a> <span class=\"origin\">{origin}</span></li>",
            index + 1
        );
    }
    list + "</ol>\n</nav>\n"
}

fn origin(section: &Section) -> String {
    escaped(&section.origin.display().to_string())
}

fn section_html(number: usize, section: &Section) -> Result<String, FigureError> {
    let (heading, origin) = (escaped(&section.heading), origin(section));
    let mut html = format!(
        "<section id=\"s{number}\">\n<h2>{heading}</h2>\n<p class=\"origin\">{origin}</p>\n"
    );
    html += &made_by(&section.made_by);
    html += &notes(&section.notes);
    for drawing in &section.drawings {
        html += &figure_html(number, drawing)?;
    }
    for table in &section.tables {
        html += &format!("<div class=\"table\">{}</div>\n", table_html(table));
    }
    let json = embedded(&section.json);
    let _ = write!(
        html,
        "<p class=\"raw\">All figures as JSON are in the source of this page, in \
         <code>#s{number}-json</code>.</p>\n\
         <script type=\"application/json\" id=\"s{number}-json\">{json}</script>\n</section>\n"
    );
    Ok(html)
}

fn made_by(facts: &[[String; 2]]) -> String {
    let entry = |[name, value]: &[String; 2]| {
        format!("<div><dt>{}</dt><dd>{}</dd></div>\n", escaped(name), escaped(value))
    };
    format!("<dl>\n{}</dl>\n", facts.iter().map(entry).collect::<String>())
}

fn notes(notes: &[String]) -> String {
    let item = |note: &String| format!("<li>{}</li>\n", escaped(note));
    match notes {
        [] => String::new(),
        notes => format!("<ul>\n{}</ul>\n", notes.iter().map(item).collect::<String>()),
    }
}

fn figure_html(section: usize, drawing: &Drawing) -> Result<String, FigureError> {
    let (name, svg) = (drawing.name(), drawing.to_inline_svg()?);
    let table = table_html(&drawing.numbers());
    Ok(format!(
        "<figure id=\"s{section}-{name}\">\n{svg}<div class=\"table\">{table}</div>\n</figure>\n"
    ))
}

fn table_html(table: &Table) -> String {
    let row = |cells: &[String], tag: &str| {
        let cell = |text: &String| format!("<{tag}>{}</{tag}>", escaped(text));
        format!("<tr>{}</tr>\n", cells.iter().map(cell).collect::<String>())
    };
    let caption = match table.title.as_str() {
        "" => String::new(),
        title => format!("<caption>{}</caption>\n", escaped(title)),
    };
    let head = match table.columns.iter().any(|column| !column.is_empty()) {
        true => format!("<thead>\n{}</thead>\n", row(&table.columns, "th")),
        false => String::new(),
    };
    let rows: String = table.rows.iter().map(|cells| row(cells, "td")).collect();
    format!("<table>\n{caption}{head}<tbody>\n{rows}</tbody>\n</table>")
}

/// JSON has `<` in strings only, where it may be written like this; then nothing in it can end the
/// element or open a comment.
fn embedded(json: &str) -> String {
    json.replace('<', "\\u003c")
}

#[cfg(test)]
mod tests;
