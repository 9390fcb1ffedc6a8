//! The subset of G-code that the simulated controller accepts.

/// The words of a line, each letter at most once except G and M.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct GcodeWords {
    /// Target of each axis, as written.
    pub(crate) axes: [Option<f64>; 4],
    /// Feed.
    pub(crate) feed: Option<f64>,
    /// G words.
    pub(crate) commands: Vec<f64>,
}

/// Modal state, which persists from line to line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ModalState {
    pub(crate) rapid: bool,
    pub(crate) inches: bool,
    pub(crate) incremental: bool,
    pub(crate) inverse_time: bool,
    pub(crate) initial_level: bool,
    pub(crate) feed: f64,
}

impl Default for ModalState {
    fn default() -> Self {
        ModalState {
            rapid: true,
            inches: false,
            incremental: false,
            inverse_time: false,
            initial_level: true,
            feed: 0.0,
        }
    }
}

impl ModalState {
    /// Formatted as in answers to `$G`.
    pub(crate) fn text(&self) -> String {
        let motion = if self.rapid { 0 } else { 1 };
        let units = if self.inches { 20 } else { 21 };
        let distance = if self.incremental { 91 } else { 90 };
        let feed_mode = if self.inverse_time { 93 } else { 94 };
        let level = if self.initial_level { 98 } else { 99 };
        let feed = self.feed;
        format!(
            "[GC:G{motion} G54 G17 G{units} G{distance} G{feed_mode} G40 G49 G{level} G50 M5 M9 T0 \
             F{feed} S0.]"
        )
    }
}

/// Parses a line; on failure returns the error number.
pub(crate) fn words(line: &str) -> Result<GcodeWords, u16> {
    let text: Vec<u8> = line
        .bytes()
        .filter(|byte| !byte.is_ascii_whitespace())
        .map(|byte| byte.to_ascii_uppercase())
        .collect();
    let mut words = GcodeWords::default();
    let mut seen = Vec::new();
    let mut rest = text.as_slice();
    while let Some((&letter, after)) = rest.split_first() {
        if !letter.is_ascii_uppercase() {
            return Err(1);
        }
        let (value, after) = number(after).ok_or(2_u16)?;
        rest = after;
        if !matches!(letter, b'G' | b'M') {
            if seen.contains(&letter) {
                return Err(25);
            }
            seen.push(letter);
        }
        match letter {
            b'X' => words.axes[0] = Some(value),
            b'Y' => words.axes[1] = Some(value),
            b'Z' => words.axes[2] = Some(value),
            b'A' => words.axes[3] = Some(value),
            b'F' => words.feed = Some(value),
            b'G' => words.commands.push(value),
            b'L' | b'M' | b'N' | b'P' | b'S' | b'T' => {}
            _ => return Err(36),
        }
    }
    Ok(words)
}

/// The number at the beginning of `text` and what follows it.
fn number(text: &[u8]) -> Option<(f64, &[u8])> {
    let signed = usize::from(matches!(text.first(), Some(b'+' | b'-')));
    let digits = |from: usize| text[from..].iter().take_while(|byte| byte.is_ascii_digit()).count();
    let whole = signed + digits(signed);
    let end = if text.get(whole) == Some(&b'.') { whole + 1 + digits(whole + 1) } else { whole };
    let value = std::str::from_utf8(&text[..end]).ok()?.parse().ok()?;
    Some((value, &text[end..]))
}

/// Effect of a line.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum GcodeAction {
    /// Changes modes only, or dwells for no time.
    Nothing,
    /// Declares the present position to be this work position.
    Shift([Option<f64>; 4]),
    /// Moves to a work position, interpreted by the modes.
    Go([Option<f64>; 4]),
}

/// Applies the modes of a line; on failure returns the error number.
pub(crate) fn apply(words: &GcodeWords, modes: &mut ModalState) -> Result<GcodeAction, u16> {
    let mut next = *modes;
    let (mut shift, mut dwell) = (false, false);
    for &command in &words.commands {
        match (command * 10.0).round() as i64 {
            0 => next.rapid = true,
            10 => next.rapid = false,
            40 => dwell = true,
            200 => next.inches = true,
            210 => next.inches = false,
            900 => next.incremental = false,
            910 => next.incremental = true,
            920 => shift = true,
            930 => (next.inverse_time, next.feed) = (true, 0.0),
            940 => next.inverse_time = false,
            980 => next.initial_level = true,
            990 => next.initial_level = false,
            170 | 400 | 490 | 500 | 530 | 540 | 921 => {}
            _ => return Err(20),
        }
    }
    next.feed = match words.feed {
        Some(feed) if feed < 0.0 => return Err(4),
        Some(feed) => feed,
        None => next.feed,
    };
    let moves = words.axes.iter().any(Option::is_some) && !dwell;
    if moves
        && !shift
        && !next.rapid
        && (next.feed == 0.0 || (next.inverse_time && words.feed.is_none()))
    {
        return Err(22);
    }
    *modes = next;
    let scale = if next.inches { 25.4 } else { 1.0 };
    let axes = words.axes.map(|value| value.map(|value| value * scale));
    Ok(match (shift, moves) {
        (true, _) => GcodeAction::Shift(axes),
        (false, true) => GcodeAction::Go(axes),
        (false, false) => GcodeAction::Nothing,
    })
}
