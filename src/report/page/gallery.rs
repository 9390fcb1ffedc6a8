//! Published pictures on a page: one with its caption, or all of them in groups.

use std::path::{Path, PathBuf};

use super::document::picture;

/// Groups of the gallery: a heading, and how the paths of its pictures below `plots/` begin.
const GROUPS: [(&str, &[&str]); 8] = [
    ("The paper", &["table1", "fig5", "fig6", "fig8", "claims", "no_gap/"]),
    (
        "Controllers and data",
        &["controllers", "perfect_model/", "data_efficiency", "gp_intervals/"],
    ),
    ("Robots that change", &["repair"]),
    ("A population of robots", &["population"]),
    ("Sweeps", &["sweep_"]),
    ("Discovery", &["discovery"]),
    ("Real robots", &["real/"]),
    ("Other programs, and clusters", &["peers", "scaling"]),
];
/// Pictures that have a page of their own, and the heading of what no group names.
const ELSEWHERE: &str = "effects/";
const OTHERS: &str = "Others";

/// A picture with its caption, where it has one; else with its name for words.
pub fn captioned_picture(path: &str, stem: &str, caption: Option<&str>) -> String {
    let Some(caption) = caption.map(str::trim).filter(|caption| !caption.is_empty()) else {
        return picture(path, stem);
    };
    // A reader that cannot see the picture hears the first sentence, and then the caption.
    let first = caption.split_once(". ").map_or(caption, |(first, _)| first).trim_end_matches('.');
    format!("{}\n\n*{caption}*", picture(path, first))
}

/// All pictures with captions below `plots`, in groups; `relative` is the folder as the page names
/// it.
///
/// # Errors
/// The folder or caption that cannot be read.
pub fn gallery(plots: &Path, relative: &str) -> std::io::Result<String> {
    let mut stems = Vec::new();
    collect(plots, Path::new(""), &mut stems)?;
    stems.retain(|stem| !stem.starts_with(ELSEWHERE));
    let group = |stem: &str| {
        GROUPS.iter().position(|(_, starts)| starts.iter().any(|start| stem.starts_with(start)))
    };
    let rank = |stem: &str| {
        let group = group(stem).unwrap_or(GROUPS.len());
        let starts = GROUPS.get(group).map_or(&[][..], |(_, starts)| starts);
        (group, starts.iter().position(|start| stem.starts_with(start)))
    };
    stems.sort_by_key(|stem| (rank(stem), stem.clone()));
    let mut text = String::new();
    let mut before = None;
    for stem in &stems {
        let heading = group(stem).map_or(OTHERS, |group| GROUPS[group].0);
        if before != Some(heading) {
            text += &format!("## {heading}\n\n");
            before = Some(heading);
        }
        let caption = std::fs::read_to_string(plots.join(format!("{stem}.md")))?;
        let path = format!("{relative}/{stem}");
        let shown = captioned_picture(&format!("{path}.png"), stem, Some(&caption));
        let column = format!("{stem}_column.svg");
        let column = if plots.join(&column).is_file() {
            format!(", [SVG for a column of 85 mm]({relative}/{column})")
        } else {
            String::new()
        };
        text += &format!("### `{stem}`\n\n{shown}\n\n[SVG]({path}.svg){column}\n\n");
    }
    Ok(text)
}

/// The paths below `plots`, without their ends, of the PNGs that have a caption.
fn collect(plots: &Path, below: &Path, stems: &mut Vec<String>) -> std::io::Result<()> {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(plots.join(below))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<_, _>>()?;
    entries.sort();
    for path in entries {
        let name = below.join(path.file_name().unwrap_or_default());
        if path.is_dir() {
            collect(plots, &name, stems)?;
        } else if path.extension().is_some_and(|end| end == "png")
            && path.with_extension("md").is_file()
        {
            stems.push(name.with_extension("").to_string_lossy().replace('\\', "/"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_stand_in_groups_with_their_captions() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, text: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        for stem in ["sweep_a/sweep", "fig6", "mine"] {
            put(&format!("{stem}.png"), "");
            put(&format!("{stem}.md"), "One thing. And another.\n");
        }
        put("fig6_column.png", "");
        let page = gallery(folder.path(), "../plots").unwrap();
        let order = ["## The paper", "### `fig6`", "## Sweeps", "## Others", "### `mine`"];
        let places: Vec<usize> = order.iter().map(|words| page.find(words).unwrap()).collect();
        assert!(places.is_sorted(), "{page}");
        assert!(page.contains("![One thing](../plots/fig6.png)\n\n*One thing. And another.*"));
        assert!(!page.contains("`fig6_column`"));
    }
}
