//! Tables as text: Markdown and LaTeX.

/// A table of text, the first row its header.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MarkdownTable {
    /// Column names.
    pub header: Vec<String>,
    /// Rows of as many cells.
    pub rows: Vec<Vec<String>>,
}

impl MarkdownTable {
    /// A table; ` | ` stands between the names of its columns.
    pub fn new(header: &str, rows: impl Iterator<Item = Vec<String>>) -> MarkdownTable {
        MarkdownTable {
            header: header.split(" | ").map(str::to_owned).collect(),
            rows: rows.collect(),
        }
    }

    /// The table in GitHub's Markdown: columns of numbers are aligned right, except the first
    /// column.
    pub fn markdown(&self) -> String {
        let line = |cells: &[String]| {
            let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
            format!("| {} |\n", cells.join(" | "))
        };
        let numeric = |column: usize| {
            let cells = self.rows.iter().map(|row| row[column].as_str());
            column > 0 && cells.into_iter().all(is_numeric)
        };
        let rules: Vec<String> = (0..self.header.len())
            .map(|column| if numeric(column) { "---:" } else { "---" }.to_owned())
            .collect();
        let rows: String = self.rows.iter().map(|row| line(row)).collect();
        format!("{}{}{rows}", line(&self.header), line(&rules))
    }
}

/// Numbers, with or without brackets, and symbols for a missing number.
fn is_numeric(cell: &str) -> bool {
    matches!(cell, "" | "N/A" | "–")
        || cell.starts_with(|first: char| first.is_ascii_digit() || "−-+[".contains(first))
}

/// Text with LaTeX's special characters escaped.
pub fn latex(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\\' => out.push_str("\\textbackslash{}"),
            '&' | '%' | '$' | '#' | '_' | '{' | '}' => {
                out.push('\\');
                out.push(letter);
            }
            '’' => out.push('\''),
            '–' => out.push_str("--"),
            '~' => out.push_str("\\textasciitilde{}"),
            '^' => out.push_str("\\textasciicircum{}"),
            other => out.push(other),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn markdown_aligns_numbers_and_escapes_bars() {
        let rows = [["a|b", "0.010(0.004)", "yes"], ["c", "N/A", "no"]]
            .map(|row| row.map(str::to_owned).to_vec());
        let grid = MarkdownTable::new("name | error (m) | verdict", rows.into_iter());
        let lines = "| name | error (m) | verdict |\n| --- | ---: | --- |\n| a\\|b | 0.010(0.004) \
                     | yes |\n| c | N/A | no |\n";
        assert_eq!(grid.markdown(), lines);
    }

    #[test]
    fn latex_is_escaped() {
        assert_eq!(latex("50 % of a_b & {c}’s"), "50 \\% of a\\_b \\& \\{c\\}'s");
    }
}
