//! What a map must say, before any file is read.

use super::iso8601::zone_s;
use super::map::{
    BodyMap, ClockMap, CommandsMap, DriveMap, FrameRate, ImportMap, OffsetRange, TendonMeasure,
    TendonsMap, TextFormat, TimeMap, TrackingMap, TrialFilesMap,
};
use super::trial_files::{LogFiles, TRIAL};
use super::units::{CommandKind, TimeUnit};
use crate::base::{BadOption, PerTendon};
use crate::data::import::Axes;

/// The fault of a key below a path of the map.
type Fault = (String, BadOption);

fn fault(path: &str, key: &'static str, found: impl Into<String>, expected: &'static str) -> Fault {
    (path.to_owned(), BadOption { key, found: found.into(), expected })
}

/// Where the tables of an import come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceKind {
    /// Text files.
    Text {
        /// Their number.
        files: usize,
        /// Whether a folder was named.
        from_folder: bool,
    },
    /// A bag.
    Bag,
}

impl From<&LogFiles> for SourceKind {
    fn from(logs: &LogFiles) -> SourceKind {
        SourceKind::Text { files: logs.files.len(), from_folder: logs.from_folder }
    }
}

impl ImportMap {
    /// Checks everything that can be known without the data.
    ///
    /// # Errors
    /// The path and the key of the first fault.
    pub fn check(&self, source: SourceKind) -> Result<(), Fault> {
        self.text.check("text")?;
        let source = self.check_trial_files(source)?;
        self.commands.check(source)?;
        let Some(tracking) = &self.tracking else { return Ok(()) };
        tracking.check(source)?;
        let same_file = tracking.file_of(source) == self.commands.file;
        let is_text = matches!(source, SourceKind::Text { .. });
        if is_text && self.commands.time.is_none() && tracking.time.is_some() {
            let expected = "the times of the commands, because the tracking has times";
            return Err(fault("commands", "time", "no such key", expected));
        }
        if is_text && tracking.time.is_none() {
            let chosen = tracking.bodies().find(|(_, body)| !body.conditions.is_empty());
            if let Some((path, _)) = chosen {
                let expected = "`tracking.time` in addition: selected rows need times";
                return Err(fault(&path, "where", "this key", expected));
            }
            if !same_file {
                let expected = "the column of times, because the commands are in another file";
                return Err(fault("tracking", "time", "no such key", expected));
            }
            if tracking.clock != ClockMap::Same {
                let expected = "`time` in addition, or the same clock for rows that contain both";
                return Err(fault("tracking", "clock", "an offset", expected));
            }
        }
        Ok(())
    }

    /// Checks the names of files of one trial; returns the source of each trial.
    fn check_trial_files(&self, source: SourceKind) -> Result<SourceKind, Fault> {
        const PATH: &str = "trial_files";
        let Some(names) = &self.trial_files else {
            if let SourceKind::Text { from_folder: true, .. } = source {
                let expected = "the names of its files, such as `{commands: \"run_{trial}.csv\"}`";
                return Err(fault("", PATH, "no such key for a folder", expected));
            }
            return Ok(source);
        };
        if source == SourceKind::Bag {
            return Err(fault("", PATH, "this key", "no such key: a bag is one file"));
        }
        names.check()?;
        let CommandsMap { file, trial, trial_gap_s, .. } = &self.commands;
        if *file != 1 || self.tracking.as_ref().is_some_and(|tracking| tracking.file.is_some()) {
            let path = if *file == 1 { "tracking" } else { "commands" };
            return Err(fault(path, "file", "`file` and `trial_files`", "one of the two"));
        }
        if trial.is_some() || trial_gap_s.is_some() {
            let key = if trial.is_some() { "trial" } else { "trial_gap_s" };
            return Err(fault(
                "commands",
                key,
                format!("`{key}` and `trial_files`"),
                "one of the two",
            ));
        }
        match (&names.tracking, &self.tracking) {
            (Some(_), None) => Err(fault(
                "",
                "tracking",
                "no such key",
                "the columns of the files `trial_files.tracking`",
            )),
            (tracking_names, _) => Ok(SourceKind::Text {
                files: 1 + usize::from(tracking_names.is_some()),
                from_folder: false,
            }),
        }
    }
}

impl TrialFilesMap {
    fn check(&self) -> Result<(), Fault> {
        const PATH: &str = "trial_files";
        for (key, name) in
            [("commands", Some(&self.commands)), ("tracking", self.tracking.as_ref())]
        {
            let Some(name) = name else { continue };
            if name.matches(TRIAL).count() != 1 || name.contains(['/', '\\']) {
                let expected = "the name of a file without its folder, with {trial} once, such as \
                                `run_{trial}.csv`";
                return Err(fault(PATH, key, format!("`{name}`"), expected));
            }
        }
        if self.tracking.as_ref() == Some(&self.commands) {
            let expected = "another name, or no such key if each file contains both";
            return Err(fault(
                PATH,
                "tracking",
                format!("`{}`, as for the commands", self.commands),
                expected,
            ));
        }
        Ok(())
    }
}

impl TimeMap {
    fn check(&self, path: &str, source: SourceKind) -> Result<(), Fault> {
        let ways = [self.column.is_some(), !self.sum.is_empty()];
        match (ways, &self.rate_hz) {
            ([true, true], _) => {
                return Err(fault(path, "sum", "`column` and `sum`", "one of the two"));
            }
            ([_, true], Some(_)) => {
                return Err(fault(path, "sum", "`rate_hz` and `sum`", "one of the two"));
            }
            ([false, false], None) => {
                let expected = "the column of times, or `sum`, or `rate_hz`";
                return Err(fault(path, "column", "no such key", expected));
            }
            _ => {}
        }
        self.check_frames(path, source)?;
        if let Some(part) = self.sum.iter().find(|part| part.unit == TimeUnit::Iso8601) {
            let expected = "times that can be added; a date must be in one column";
            return Err(fault(path, "sum", format!("{} as a date", part.column), expected));
        }
        match &self.zone {
            Some(zone) if self.unit != TimeUnit::Iso8601 => Err(fault(
                path,
                "zone",
                format!("`{zone}`"),
                "`unit: iso8601` in addition: numbers have no zone",
            )),
            Some(zone) if zone_s(zone).is_none() => Err(fault(
                path,
                "zone",
                format!("`{zone}`"),
                "`Z`, or hours and minutes ahead of UTC such as `+01:00`",
            )),
            _ => Ok(()),
        }
    }

    fn check_frames(&self, path: &str, source: SourceKind) -> Result<(), Fault> {
        match self.rate_hz {
            Some(_) if source == SourceKind::Bag && self.first_frame.is_none() => {
                let expected = "the number of the frame at time 0, which differs between topics";
                Err(fault(path, "first_frame", "no such key", expected))
            }
            Some(FrameRate::Hz(rate_hz)) if !(rate_hz.is_finite() && rate_hz > 0.0) => {
                Err(fault(path, "rate_hz", rate_hz.to_string(), "a frame rate in Hz, above 0"))
            }
            Some(_) if self.unit != TimeUnit::S => {
                let expected = "no such key together with `rate_hz`, which numbers the frames";
                Err(fault(path, "unit", "this key", expected))
            }
            None if self.first_frame.is_some() => {
                Err(fault(path, "first_frame", "this key", "`rate_hz` in addition"))
            }
            _ => Ok(()),
        }
    }
}

impl TextFormat {
    fn check(&self, path: &str) -> Result<(), Fault> {
        if self.delimiter.chars().count() != 1 {
            return Err(fault(path, "delimiter", format!("`{}`", self.delimiter), "one character"));
        }
        if !matches!(self.decimal.as_str(), "." | ",") {
            return Err(fault(path, "decimal", format!("`{}`", self.decimal), "`.` or `,`"));
        }
        if self.decimal == self.delimiter {
            return Err(fault(
                path,
                "decimal",
                format!("`{}`", self.decimal),
                "another character than the delimiter",
            ));
        }
        for (key, mark) in [("comment", &self.comment), ("block", &self.block)] {
            if let Some(mark) = mark.as_ref().filter(|mark| mark.trim().is_empty()) {
                return Err(fault(path, key, format!("`{mark}`"), "a character or word"));
            }
        }
        if self.header_lines == 0 {
            let expected = "lines of the header, 1 or more (`header: false` where there is none)";
            return Err(fault(path, "header_lines", "0", expected));
        }
        Ok(())
    }
}

/// A file of the command line, or a topic, but not both.
fn check_source(
    path: &str,
    source: SourceKind,
    file: usize,
    topics: &[&str],
    needs_topic: bool,
) -> Result<(), Fault> {
    match source {
        SourceKind::Text { files, .. } => {
            if !(1..=files).contains(&file) {
                let found = format!("{file}, and {files} on the command line");
                return Err(fault(
                    path,
                    "file",
                    found,
                    "the number of a file on the command line, from 1",
                ));
            }
            match topics.first() {
                Some(topic) => Err(fault(
                    path,
                    "topic",
                    format!("`{topic}`"),
                    "no topic: text files have none",
                )),
                None => Ok(()),
            }
        }
        SourceKind::Bag if needs_topic && topics.is_empty() => {
            Err(fault(path, "topic", "no such key", "the topic's name"))
        }
        SourceKind::Bag => Ok(()),
    }
}

impl CommandsMap {
    fn check(&self, source: SourceKind) -> Result<(), Fault> {
        const PATH: &str = "commands";
        let topics: Vec<&str> = self.topic.iter().map(String::as_str).collect();
        check_source(PATH, source, self.file, &topics, true)?;
        if let Some(text) = &self.text {
            text.check("commands.text")?;
        }
        if let Some(time) = &self.time {
            time.check("commands.time", source)?;
        }
        if let Some(gap_s) = self.trial_gap_s {
            if self.time.is_none() && source != SourceKind::Bag {
                return Err(fault(PATH, "time", "no such key", "times, to find the gaps"));
            }
            BadOption::unless_positive("trial_gap_s", gap_s)
                .map_err(|error| (PATH.to_owned(), error))?;
            if self.trial.is_some() {
                return Err(fault(
                    PATH,
                    "trial_gap_s",
                    format!("{gap_s}"),
                    "`trial` or `trial_gap_s`, not both",
                ));
            }
        }
        match (&self.tendons, self.drives.is_empty()) {
            (None, true) => {
                Err(fault(PATH, "tendons", "no such key", "the columns of tendons, or `drives`"))
            }
            (Some(_), false) => Err(fault(PATH, "drives", "tendons and drives", "one of the two")),
            (Some(tendons), true) => tendons.check(),
            (None, false) => self.drives.iter().try_for_each(|(name, drive)| drive.check(name)),
        }
    }
}

/// Letters, digits and _, as names of columns need.
fn is_plain(name: &str) -> bool {
    !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

impl TendonsMap {
    fn check(&self) -> Result<(), Fault> {
        const PATH: &str = "commands.tendons";
        let count = self.columns.len();
        if count == 0 {
            return Err(fault(PATH, "columns", "an empty list", "one column per tendon"));
        }
        let kind = self.unit.factor().0;
        match &self.scale {
            None if matches!(kind, CommandKind::Angle | CommandKind::Count) => {
                let expected =
                    "metres of tendon per radian or per count: one number, or one per tendon";
                return Err(fault(PATH, "scale", "no such key", expected));
            }
            Some(PerTendon::Each(scale)) if !(scale.len() == 1 || scale.len() == count) => {
                return Err(fault(
                    PATH,
                    "scale",
                    format!("{} numbers", scale.len()),
                    "one number, or one per tendon",
                ));
            }
            Some(scale) if scale.values().iter().any(|one| !one.is_finite() || *one == 0.0) => {
                return Err(fault(
                    PATH,
                    "scale",
                    format!("{:?}", scale.values()),
                    "finite numbers other than 0",
                ));
            }
            _ => {}
        }
        if kind == CommandKind::Tension && self.measure != TendonMeasure::Pulled {
            return Err(fault(PATH, "measure", "lengths in newtons", "`pulled` for tensions"));
        }
        let Some(home) = &self.home else { return Ok(()) };
        if self.zero.is_some() {
            return Err(fault(PATH, "home", "`zero` and `home`", "one of the two"));
        }
        if home.len() != count || home.iter().any(|number| !number.is_finite()) {
            return Err(fault(PATH, "home", format!("{home:?}"), "one finite number per tendon"));
        }
        Ok(())
    }
}

impl DriveMap {
    fn check(&self, name: &str) -> Result<(), Fault> {
        let path = format!("commands.drives.{name}");
        if !is_plain(name) {
            return Err(fault(
                "commands",
                "drives",
                format!("`{name}`"),
                "names of letters, digits and _",
            ));
        }
        match (self.unit.factor().0, self.scale) {
            (CommandKind::Tension, _) => {
                return Err(fault(
                    &path,
                    "unit",
                    self.unit.word(),
                    "a unit of length, of angle, or counts",
                ));
            }
            (CommandKind::Count, None) => {
                return Err(fault(&path, "scale", "no such key", "radians per count"));
            }
            (_, Some(scale)) if !scale.is_finite() || scale == 0.0 => {
                return Err(fault(
                    &path,
                    "scale",
                    format!("{scale}"),
                    "a finite number other than 0",
                ));
            }
            _ => {}
        }
        match self.home {
            Some(home) if !home.is_finite() => {
                Err(fault(&path, "home", format!("{home}"), "a finite number"))
            }
            _ => Ok(()),
        }
    }
}

impl TrackingMap {
    /// The file of this map among those of the command line.
    pub(crate) fn file_of(&self, source: SourceKind) -> usize {
        let last = if let SourceKind::Text { files, .. } = source { files } else { 1 };
        self.file.unwrap_or(last)
    }

    /// The recording's axes.
    pub(crate) fn to_axes(&self) -> Result<Axes, Fault> {
        Axes::of_hand(&self.axes, self.left_handed).map_err(|_| {
            let expected = "each axis once, such as `x=+y,y=-x,z=+z`; `left_handed: true` if the \
                            tracker's axes are";
            fault("tracking", "axes", format!("`{}`", self.axes), expected)
        })
    }

    /// All bodies with their paths in the map.
    fn bodies(&self) -> impl Iterator<Item = (String, &BodyMap)> {
        let points =
            self.points.iter().map(|(name, body)| (format!("tracking.points.{name}"), body));
        let base = self.base.iter().map(|body| ("tracking.base".to_owned(), body));
        std::iter::once(("tracking.tip".to_owned(), &self.tip)).chain(base).chain(points)
    }

    fn check_bodies(&self, source: SourceKind) -> Result<(), Fault> {
        const PATH: &str = "tracking";
        for (path, body) in self.bodies() {
            let topics: Vec<&str> =
                body.topic.iter().chain(&self.topic).map(String::as_str).collect();
            check_source(&path, source, self.file_of(source), &topics, true)?;
            if matches!(source, SourceKind::Text { .. }) && body.position.is_none() {
                return Err(fault(&path, "position", "no such key", "the columns of x, y and z"));
            }
            if body.angles.is_some() && body.orientation.is_some() {
                return Err(fault(&path, "angles", "`orientation` and `angles`", "one of the two"));
            }
            if body.angles.is_some() && self.euler.is_none() {
                let expected =
                    "what `angles` mean, such as `{order: zyx, rotation: intrinsic, unit: deg}`";
                return Err(fault(PATH, "euler", "no such key", expected));
            }
        }
        if self.euler.is_some() && self.bodies().all(|(_, body)| body.angles.is_none()) {
            return Err(fault(PATH, "euler", "this key", "`angles` of a body to which it applies"));
        }
        Ok(())
    }

    fn check(&self, source: SourceKind) -> Result<(), Fault> {
        const PATH: &str = "tracking";
        let topics: Vec<&str> = self.topic.iter().map(String::as_str).collect();
        check_source(PATH, source, self.file_of(source), &topics, false)?;
        if let Some(text) = &self.text {
            text.check("tracking.text")?;
        }
        if let Some(time) = &self.time {
            time.check("tracking.time", source)?;
        }
        self.to_axes()?;
        self.check_bodies(source)?;
        if let Some(name) = self.points.keys().find(|name| !is_plain(name)) {
            return Err(fault(
                PATH,
                "points",
                format!("`{name}`"),
                "names of letters, digits and _",
            ));
        }
        if !(self.max_gap_s.is_finite() && self.max_gap_s >= 0.0) {
            return Err(fault(PATH, "max_gap_s", self.max_gap_s.to_string(), "seconds, 0 or more"));
        }
        match self.origin {
            Some(_) if self.base.is_some() => {
                return Err(fault(PATH, "origin", "`base` and `origin`", "one of the two"));
            }
            Some(origin) if origin.iter().any(|x| !x.is_finite()) => {
                return Err(fault(PATH, "origin", format!("{origin:?}"), "three finite numbers"));
            }
            _ => {}
        }
        self.clock.check()
    }
}

impl ClockMap {
    fn check(&self) -> Result<(), Fault> {
        match *self {
            ClockMap::OffsetS(offset_s) if !offset_s.is_finite() => Err(fault(
                "tracking.clock",
                "offset_s",
                offset_s.to_string(),
                "seconds, a finite number",
            )),
            ClockMap::FirstRowAfterS(after_s) if !after_s.is_finite() => Err(fault(
                "tracking.clock",
                "first_row_after_s",
                after_s.to_string(),
                "seconds, a finite number",
            )),
            ClockMap::Estimate(OffsetRange { from_s, to_s, dead_time_s }) => {
                let path = "tracking.clock.estimate";
                for (key, limit_s) in [("from_s", from_s), ("to_s", to_s)] {
                    if let Some(limit_s) = limit_s.filter(|limit_s| !limit_s.is_finite()) {
                        return Err(fault(
                            path,
                            key,
                            limit_s.to_string(),
                            "seconds, a finite number",
                        ));
                    }
                }
                if !(dead_time_s.is_finite() && dead_time_s >= 0.0) {
                    return Err(fault(
                        path,
                        "dead_time_s",
                        dead_time_s.to_string(),
                        "seconds, 0 or more",
                    ));
                }
                match (from_s, to_s) {
                    (Some(from_s), Some(to_s)) if from_s >= to_s => Err(fault(
                        path,
                        "to_s",
                        format!("{from_s} to {to_s}"),
                        "a limit above `from_s`",
                    )),
                    _ => Ok(()),
                }
            }
            _ => Ok(()),
        }
    }
}
