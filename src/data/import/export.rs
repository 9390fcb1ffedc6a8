//! What a motion capture system exported: rigid bodies and single markers over time.

use std::path::PathBuf;

use crate::data::DataError;
use crate::data::error::listed;
use crate::data::recording::Pose;

/// A rigid body or a single marker over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Its name in the export.
    pub name: String,
    /// Whether its orientation was tracked; a single marker has none.
    pub has_orientation: bool,
    /// Pose of its pivot for each frame, in the export's frame, unturned without orientation;
    /// `None` where it was not tracked.
    pub poses: Vec<Option<Pose>>,
}

/// The rigid bodies and markers of an export.
#[derive(Clone, Debug, PartialEq)]
pub struct Export {
    /// The file.
    pub file: PathBuf,
    /// Time of each frame in the export, seconds, increasing.
    pub time_s: Vec<f64>,
    /// Rigid bodies, in the order of the file.
    pub bodies: Vec<Body>,
    /// Single markers, in the order of the file.
    pub markers: Vec<Body>,
    /// Number of frames according to the header.
    pub promised_frames: Option<usize>,
    /// Rigid bodies whose orientation the file writes in a way that it does not tell.
    pub unread_orientations: Vec<String>,
    /// Where the names stand.
    pub(super) names_place: String,
}

impl Export {
    /// Frames at these times, for bodies that come from elsewhere.
    pub(crate) fn of_times(file: PathBuf, time_s: Vec<f64>) -> Export {
        Export {
            file,
            time_s,
            bodies: Vec::new(),
            markers: Vec::new(),
            promised_frames: None,
            unread_orientations: Vec::new(),
            names_place: "line 1".to_owned(),
        }
    }

    /// The rigid body with exactly this name, or else the marker.
    ///
    /// # Errors
    /// [`DataError::Line`] lists all of them when none or several have it.
    pub fn body(&self, name: &str) -> Result<&Body, DataError> {
        let has_name = |body: &Body| body.name == name;
        let kind = if self.bodies.iter().any(has_name) { &self.bodies } else { &self.markers };
        only(kind, &has_name).ok_or_else(|| self.unclear(format!("one called `{name}`")))
    }

    /// The rigid body called `word`, or else the only one whose name begins so, ignoring case; or
    /// else such a marker.
    ///
    /// # Errors
    /// As [`Export::body`].
    pub fn body_like(&self, word: &str) -> Result<&Body, DataError> {
        let begins = |body: &Body| body.name.to_lowercase().starts_with(&word.to_lowercase());
        let kind = if self.bodies.iter().any(begins) { &self.bodies } else { &self.markers };
        if kind.iter().any(|body| body.name == word) {
            return self.body(word);
        }
        let expected = || format!("one called `{word}`, or a single one whose name begins with it");
        only(kind, &begins).ok_or_else(|| self.unclear(expected()))
    }

    fn unclear(&self, expected: String) -> DataError {
        let listed = |bodies: &[Body], what: &str| {
            let names = listed(bodies.iter().map(|body| format!("`{}`", body.name)));
            (!names.is_empty()).then(|| format!("the {what} {names}"))
        };
        let lists = [listed(&self.bodies, "rigid bodies"), listed(&self.markers, "markers")];
        let found = lists.into_iter().flatten().collect::<Vec<String>>().join(" and ");
        let (file, place) = (self.file.clone(), self.names_place.clone());
        DataError::Line { file, place, found, expected }
    }
}

/// The only one that `fits`.
fn only<'a>(bodies: &'a [Body], fits: &dyn Fn(&Body) -> bool) -> Option<&'a Body> {
    let fitting: Vec<&Body> = bodies.iter().filter(|body| fits(body)).collect();
    if let [body] = fitting[..] { Some(body) } else { None }
}
