//! Meanings of GRBL error and alarm numbers.

use std::fmt;

/// What a number means and what to do about it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Meaning {
    /// What has happened, one sentence.
    pub what: &'static str,
    /// What to do about it, one sentence.
    pub remedy: &'static str,
}

impl fmt::Display for Meaning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {}", self.what, self.remedy)
    }
}

/// The meaning of `error:code`.
pub fn error(code: u16) -> Meaning {
    find(ERRORS, code, "This controller knows an error that this program does not.")
}

/// The meaning of `ALARM:code`.
pub fn alarm(code: u16) -> Meaning {
    find(ALARMS, code, "This controller knows an alarm that this program does not.")
}

/// Whether a reset cannot clear `ALARM:code` before a person has removed its cause: emergency stop,
/// closed switch, protection, self-test, motor driver, expander, memory.
pub fn needs_person(code: u16) -> bool {
    matches!(code, 10 | 12 | 13 | 16 | 17 | 20 | 21)
}

/// Whether the meaning of `error:code` is known.
pub fn knows_error(code: u16) -> bool {
    ERRORS.iter().any(|(number, ..)| *number == code)
}

/// Whether the meaning of `ALARM:code` is known.
pub fn knows_alarm(code: u16) -> bool {
    ALARMS.iter().any(|(number, ..)| *number == code)
}

type CodeText = (u16, &'static str, &'static str);

fn find(entries: &[CodeText], code: u16, unknown: &'static str) -> Meaning {
    let entry = entries.iter().find(|(number, ..)| *number == code);
    entry.map_or(Meaning { what: unknown, remedy: MANUAL }, |&(_, what, remedy)| Meaning {
        what,
        remedy,
    })
}

const MANUAL: &str = "Look it up in the manual of its firmware, then reset and home it.";
const LINE: &str = "The line was damaged on the way or another program sends too: check the cable, \
                    then reset and home.";
const PROGRAM: &str =
    "This program sends no such line, so check what else uses the port, then reset and home.";
const SETTING: &str = "Correct the setting with a terminal program, then connect again.";
const HOME: &str = "Reset and home it.";
const SWITCHES: &str = "Check the switches and their cables, then reset and home.";
const CLEAR: &str = "Remove the cause, then reset and home.";
const FILES: &str = "This program uses no files of the controller: check what else uses the port.";
const POWER: &str = "Switch the controller off and on; replace it if this happens again.";

const ERRORS: &[CodeText] = &[
    (1, "A word of the line does not begin with a letter.", LINE),
    (2, "A number is missing or badly written.", LINE),
    (3, "The controller does not know this `$` command.", PROGRAM),
    (4, "A value is negative that must not be.", PROGRAM),
    (5, "Homing is switched off.", "Set $22=13 with a terminal program, then connect again."),
    (6, "The step pulse is too short.", SETTING),
    (
        7,
        "The stored settings could not be read and were replaced by defaults.",
        "Set the controller up again.",
    ),
    (
        8,
        "This command is only taken while the controller is idle.",
        "Wait until it stands, then try again.",
    ),
    (9, "G-code is locked while the controller is in alarm.", HOME),
    (10, "Soft limits need homing to be on.", "Set $22=13 before $20=1."),
    (11, "The line is too long.", LINE),
    (12, "The setting asks for more steps per second than the controller can give.", SETTING),
    (13, "The safety door is open.", CLEAR),
    (14, "The start-up line or build information is too long to be stored.", SETTING),
    (15, "The jog would leave the travel.", PROGRAM),
    (16, "The jog command is not complete or has words that do not belong there.", PROGRAM),
    (17, "Laser mode needs a spindle output with variable speed.", SETTING),
    (18, "The controller was reset while it worked on the line.", HOME),
    (19, "A value must be above 0.", PROGRAM),
    (20, "The controller does not know this G or M command.", PROGRAM),
    (21, "Two commands of the line exclude each other.", LINE),
    (22, "The move has no feed.", LINE),
    (23, "A command needs a whole number.", LINE),
    (24, "Two commands of the line both claim the axis words.", LINE),
    (25, "A word occurs twice in the line.", LINE),
    (26, "The command needs axis words and has none.", LINE),
    (27, "The line number is out of range.", PROGRAM),
    (28, "A command lacks a value that it needs.", LINE),
    (29, "There is no such work coordinate system.", PROGRAM),
    (30, "G53 goes with G0 and G1 only.", PROGRAM),
    (31, "There are axis words without a command that uses them.", LINE),
    (32, "An arc has no axis word in its plane.", PROGRAM),
    (33, "The target is not valid.", LINE),
    (34, "The radius of an arc does not fit its ends.", PROGRAM),
    (35, "An arc lacks its centre.", PROGRAM),
    (
        36,
        "Words are left over that no command uses; maybe an axis is missing in the firmware.",
        LINE,
    ),
    (37, "The tool length offset does not go with the configured axis.", PROGRAM),
    (38, "The tool number is higher than the controller supports.", PROGRAM),
    (39, "A value is out of range.", LINE),
    (40, "A tool change is waiting to be confirmed.", PROGRAM),
    (41, "The spindle does not run and the move needs it.", PROGRAM),
    (42, "The plane does not go with the command.", PROGRAM),
    (
        43,
        "The feed is higher than the controller allows.",
        "Lower max_speed_mm_min, or raise $110 to $113.",
    ),
    (44, "The spindle speed is out of range.", PROGRAM),
    (45, "A limit switch is closed, so that motion stays locked.", SWITCHES),
    (46, "The controller wants to be homed first.", HOME),
    (47, "The tool is not defined.", PROGRAM),
    (48, "Two values of the line contradict each other.", LINE),
    (49, "The power-on self-test has failed.", POWER),
    (50, "The emergency stop is pressed.", "Release it when it is safe, then reset and home."),
    (
        51,
        "A motor driver reports a fault.",
        "Check motors, drivers and their supply, then reset and home.",
    ),
    (52, "The value is out of the range of this setting.", SETTING),
    (53, "The setting does not exist in this firmware or is switched off.", SETTING),
    (54, "The retract position lies below the drilling depth.", PROGRAM),
    (
        55,
        "The homing settings contradict each other.",
        "Check $22, $23 and $44 to $47, then connect again.",
    ),
    (56, "The work coordinate system is locked.", PROGRAM),
    (57, "A program ends or begins where it must not.", FILES),
    (58, "The port of the controller that the command names cannot be used.", PROGRAM),
    (60, "The memory card could not be mounted.", FILES),
    (61, "A file could not be opened for reading.", FILES),
    (62, "A folder could not be opened.", FILES),
    (63, "There is no such folder.", FILES),
    (64, "The file is empty.", FILES),
    (65, "There is no such file.", FILES),
    (66, "The file could not be deleted or renamed.", FILES),
    (67, "The memory card is read-only.", FILES),
    (70, "Bluetooth could not be started.", POWER),
    (71, "An expression has an unknown operation.", PROGRAM),
    (72, "An expression divides by 0.", PROGRAM),
    (73, "A function of an expression got a value out of its range.", PROGRAM),
    (74, "A function of an expression got a value that it does not take.", PROGRAM),
    (75, "An expression is badly written.", PROGRAM),
    (76, "The result of an expression is no number.", PROGRAM),
    (
        77,
        "The controller asks for a password.",
        "Switch its password protection off, then connect again.",
    ),
    (
        78,
        "This user may not do that.",
        "Switch the controller's password protection off, then connect again.",
    ),
    (
        79,
        "The controller takes this only after a reset, since something serious has happened.",
        HOME,
    ),
];

const ALARMS: &[CodeText] = &[
    (1, "A limit switch was hit and the position is probably lost.", SWITCHES),
    (
        2,
        "A move would have left the travel; the position is kept.",
        "Check $130 to $133 and travel_m, reset and home.",
    ),
    (3, "It was reset while it moved and steps may be lost.", HOME),
    (4, "The probe was not in the state it should have had before the cycle.", PROGRAM),
    (5, "The probe touched nothing within its travel.", PROGRAM),
    (6, "Homing was interrupted by a reset.", HOME),
    (7, "Homing was interrupted because the safety door opened.", CLEAR),
    (
        8,
        "A limit switch stayed closed when homing backed away from it.",
        "Check that switch and $27, reset and home.",
    ),
    (9, "Homing found no switch: it is not connected, stuck open or too far away.", SWITCHES),
    (10, "The emergency stop is pressed.", "Release it when it is safe, then reset and home."),
    (11, "The axes are not homed, and nothing else is taken before that.", "Home them."),
    (12, "A limit switch is closed.", "Move the axis off its switch by hand, then reset and home."),
    (13, "The probe protection has triggered.", CLEAR),
    (14, "The spindle did not reach its speed.", PROGRAM),
    (15, "Homing found no second switch of an axis with two motors.", SWITCHES),
    (16, "The power-on self-test has failed.", POWER),
    (
        17,
        "A motor driver reports a fault.",
        "Check motors, drivers and their supply, then reset and home.",
    ),
    (18, "Homing has failed.", SWITCHES),
    (
        19,
        "A Modbus device does not answer.",
        "Check the Modbus devices of the controller, then reset and home.",
    ),
    (20, "The input and output expander does not answer.", POWER),
    (21, "The memory of the settings has failed.", POWER),
];
