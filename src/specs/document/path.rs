//! The path of a key inside a document, such as `gp.sizes[2]`.

use std::fmt;

/// One step down into a document.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum Step {
    /// Into the value of this key.
    Key(String),
    /// Into this item of a list, counted from 0.
    Item(usize),
}

/// A path from the root of a document; empty at the root.
#[derive(Clone, Debug, Default, PartialEq, Eq, Hash)]
pub struct KeyPath(pub Vec<Step>);

impl KeyPath {
    /// The path written as `a.b[2].c`.
    ///
    /// # Errors
    /// With the offending part when it is not such a path.
    pub fn parse(text: &str) -> Result<KeyPath, String> {
        let mut steps = Vec::new();
        for part in text.split('.') {
            let (key, rest) = part.split_at(part.find('[').unwrap_or(part.len()));
            if key.is_empty() {
                return Err(format!("`{text}`"));
            }
            steps.push(Step::Key(key.to_owned()));
            for item in rest.split_inclusive(']').filter(|item| !item.is_empty()) {
                let digits = item.strip_prefix('[').and_then(|item| item.strip_suffix(']'));
                let index = digits
                    .and_then(|digits| digits.parse().ok())
                    .ok_or_else(|| format!("`{part}`"))?;
                steps.push(Step::Item(index));
            }
        }
        Ok(KeyPath(steps))
    }

    /// This path with one more key.
    #[must_use]
    pub fn key(&self, key: &str) -> KeyPath {
        self.with(Step::Key(key.to_owned()))
    }

    /// This path with one more list item.
    #[must_use]
    pub fn item(&self, index: usize) -> KeyPath {
        self.with(Step::Item(index))
    }

    /// The path of what holds this one; the root holds itself.
    #[must_use]
    pub fn parent(&self) -> KeyPath {
        KeyPath(self.0[..self.0.len().saturating_sub(1)].to_vec())
    }

    fn with(&self, step: Step) -> KeyPath {
        let mut steps = self.0.clone();
        steps.push(step);
        KeyPath(steps)
    }
}

impl From<&serde_path_to_error::Path> for KeyPath {
    fn from(path: &serde_path_to_error::Path) -> KeyPath {
        use serde_path_to_error::Segment;
        let step = |segment: &Segment| match segment {
            Segment::Seq { index } => Some(Step::Item(*index)),
            Segment::Map { key } | Segment::Enum { variant: key } => Some(Step::Key(key.clone())),
            Segment::Unknown => None,
        };
        KeyPath(path.iter().filter_map(step).collect())
    }
}

impl fmt::Display for KeyPath {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return out.write_str("(whole document)");
        }
        for (depth, step) in self.0.iter().enumerate() {
            match step {
                Step::Key(key) if depth == 0 => write!(out, "{key}")?,
                Step::Key(key) => write!(out, ".{key}")?,
                Step::Item(index) => write!(out, "[{index}]")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        for text in ["a", "a.b", "a.b[2].c", "sizes[0][1]"] {
            assert_eq!(KeyPath::parse(text).unwrap().to_string(), text);
        }
        for text in ["", ".a", "a..b", "a[x]", "a[1"] {
            assert!(KeyPath::parse(text).is_err(), "{text}");
        }
    }
}
