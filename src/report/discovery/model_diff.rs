//! What was added to a model file: its lines beside those of the file as given.

/// A line of the new file.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum DiffLine<'a> {
    /// It stood there before.
    Kept(&'a str),
    /// It is new.
    Added(&'a str),
    /// It is gone.
    Removed(&'a str),
}

/// Files longer than this are compared by their ends alone.
const MAX_LINES: usize = 1000;

/// Both files as one list of lines, by their longest common subsequence.
pub(crate) fn compare<'a>(before: &'a str, after: &'a str) -> Vec<DiffLine<'a>> {
    let (old, new): (Vec<&str>, Vec<&str>) = (before.lines().collect(), after.lines().collect());
    let head = old.iter().zip(&new).take_while(|(a, b)| a == b).count();
    let room = old.len().min(new.len()) - head;
    let tail =
        old.iter().rev().zip(new.iter().rev()).take(room).take_while(|(a, b)| a == b).count();
    let (middle_old, middle_new) = (&old[head..old.len() - tail], &new[head..new.len() - tail]);
    let mut out: Vec<DiffLine> = new[..head].iter().map(|line| DiffLine::Kept(line)).collect();
    if middle_old.len() > MAX_LINES || middle_new.len() > MAX_LINES {
        out.extend(middle_old.iter().map(|line| DiffLine::Removed(line)));
        out.extend(middle_new.iter().map(|line| DiffLine::Added(line)));
    } else {
        out.extend(common(middle_old, middle_new));
    }
    out.extend(new[new.len() - tail..].iter().map(|line| DiffLine::Kept(line)));
    out
}

/// Longest common subsequence by dynamic programming.
fn common<'a>(old: &[&'a str], new: &[&'a str]) -> Vec<DiffLine<'a>> {
    // length[i][j]: of the longest common subsequence of old[i..] and new[j..].
    let mut length = vec![vec![0u32; new.len() + 1]; old.len() + 1];
    for i in (0..old.len()).rev() {
        for j in (0..new.len()).rev() {
            let skip = length[i + 1][j].max(length[i][j + 1]);
            length[i][j] = if old[i] == new[j] { length[i + 1][j + 1] + 1 } else { skip };
        }
    }
    let (mut i, mut j, mut out) = (0, 0, Vec::new());
    while i < old.len() || j < new.len() {
        if i < old.len() && j < new.len() && old[i] == new[j] {
            out.push(DiffLine::Kept(new[j]));
            (i, j) = (i + 1, j + 1);
        } else if j == new.len() || (i < old.len() && length[i + 1][j] >= length[i][j + 1]) {
            out.push(DiffLine::Removed(old[i]));
            i += 1;
        } else {
            out.push(DiffLine::Added(new[j]));
            j += 1;
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn added_lines_are_found_between_kept_ones() {
        let before = "robot:\n  a: 1\n  b: 2\neffects: []\n";
        let after = "robot:\n  a: 1\n  b: 3\neffects:\n- tip_load:\n    mass_kg: 0.02\n";
        let lines = compare(before, after);
        let added: Vec<&DiffLine> =
            lines.iter().filter(|line| matches!(line, DiffLine::Added(_))).collect();
        assert_eq!(added.len(), 4);
        assert_eq!(lines[0], DiffLine::Kept("robot:"));
        assert!(
            lines.contains(&DiffLine::Removed("  b: 2"))
                && lines.contains(&DiffLine::Added("  b: 3"))
        );
        // Without the removed lines it is the new file, without the added ones the old.
        let read = |skip: fn(&DiffLine) -> bool| {
            let text = lines.iter().filter(|line| !skip(line)).map(|line| match line {
                DiffLine::Kept(text) | DiffLine::Added(text) | DiffLine::Removed(text) => {
                    format!("{text}\n")
                }
            });
            text.collect::<String>()
        };
        assert_eq!(read(|line| matches!(line, DiffLine::Removed(_))), after);
        assert_eq!(read(|line| matches!(line, DiffLine::Added(_))), before);
    }

    #[test]
    fn same_and_empty_files_have_nothing_added() {
        assert!(compare("a\nb", "a\nb").iter().all(|line| matches!(line, DiffLine::Kept(_))));
        assert!(compare("", "").is_empty());
        assert_eq!(compare("", "a"), [DiffLine::Added("a")]);
        assert_eq!(compare("a\na", "a"), [DiffLine::Kept("a"), DiffLine::Removed("a")]);
    }
}
