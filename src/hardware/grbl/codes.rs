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
    find(ERRORS, code, "This program does not know this error of the controller.")
}

/// The meaning of `ALARM:code`.
pub fn alarm(code: u16) -> Meaning {
    find(ALARMS, code, "This program does not know this alarm of the controller.")
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
const LINE: &str = "The line was damaged in transmission, or another program also sends: check the \
                    cable, then reset and home.";
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
        "The controller accepts this command only in the state Idle.",
        "Wait until the axes have stopped, then try again.",
    ),
    (9, "G-code is locked while the controller is in alarm.", HOME),
    (10, "Soft limits require homing to be enabled.", "Set $22=13 before $20=1."),
    (11, "The line is too long.", LINE),
    (12, "The setting requires more steps per second than the controller can generate.", SETTING),
    (13, "The safety door is open.", CLEAR),
    (14, "The start-up line or build information is too long to store.", SETTING),
    (15, "The jog would leave the travel.", PROGRAM),
    (16, "The jog command is incomplete or has invalid words.", PROGRAM),
    (17, "Laser mode needs a spindle output with variable speed.", SETTING),
    (18, "The controller was reset while it executed the line.", HOME),
    (19, "A value must be above 0.", PROGRAM),
    (20, "The controller does not know this G or M command.", PROGRAM),
    (21, "Two commands of the line exclude each other.", LINE),
    (22, "The move has no feed.", LINE),
    (23, "A command requires a whole number.", LINE),
    (24, "Two commands of the line both use the axis words.", LINE),
    (25, "A word occurs twice in the line.", LINE),
    (26, "The command needs axis words and has none.", LINE),
    (27, "The line number is out of range.", PROGRAM),
    (28, "A required value of a command is missing.", LINE),
    (29, "This work coordinate system does not exist.", PROGRAM),
    (30, "G53 requires G0 or G1.", PROGRAM),
    (31, "The line has axis words without a command that uses them.", LINE),
    (32, "An arc has no axis word in its plane.", PROGRAM),
    (33, "The target is not valid.", LINE),
    (34, "The radius of an arc does not fit its ends.", PROGRAM),
    (35, "An arc lacks its centre.", PROGRAM),
    (36, "The line has words that no command uses; the firmware may lack an axis.", LINE),
    (37, "The tool length offset does not apply to the configured axis.", PROGRAM),
    (38, "The tool number is higher than the controller supports.", PROGRAM),
    (39, "A value is out of range.", LINE),
    (40, "A tool change is waiting to be confirmed.", PROGRAM),
    (41, "The move requires a running spindle.", PROGRAM),
    (42, "The plane is not valid for the command.", PROGRAM),
    (
        43,
        "The feed is higher than the controller allows.",
        "Lower max_speed_mm_min, or raise $110 to $113.",
    ),
    (44, "The spindle speed is out of range.", PROGRAM),
    (45, "A limit switch is closed; motion is locked.", SWITCHES),
    (46, "The controller requires homing first.", HOME),
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
    (57, "A program ends or begins at an invalid place.", FILES),
    (58, "The port of the controller that the command names cannot be used.", PROGRAM),
    (60, "The memory card could not be mounted.", FILES),
    (61, "A file could not be opened for reading.", FILES),
    (62, "A folder could not be opened.", FILES),
    (63, "This folder does not exist.", FILES),
    (64, "The file is empty.", FILES),
    (65, "This file does not exist.", FILES),
    (66, "The file could not be deleted or renamed.", FILES),
    (67, "The memory card is read-only.", FILES),
    (70, "Bluetooth could not be started.", POWER),
    (71, "An expression has an unknown operation.", PROGRAM),
    (72, "An expression divides by 0.", PROGRAM),
    (73, "A function of an expression has an argument out of range.", PROGRAM),
    (74, "A function of an expression has an invalid argument.", PROGRAM),
    (75, "An expression is badly written.", PROGRAM),
    (76, "The result of an expression is not a number.", PROGRAM),
    (
        77,
        "The controller requires a password.",
        "Disable its password protection, then connect again.",
    ),
    (
        78,
        "This user lacks the permission for the command.",
        "Disable the controller's password protection, then connect again.",
    ),
    (79, "After a critical event the controller accepts this only after a reset.", HOME),
];

const ALARMS: &[CodeText] = &[
    (1, "A limit switch was hit and the position is probably lost.", SWITCHES),
    (
        2,
        "A move would have left the travel; the position is kept.",
        "Check $130 to $133 and travel_m, reset and home.",
    ),
    (3, "The controller was reset during a motion; steps may be lost.", HOME),
    (4, "The probe was not in the state it should have had before the cycle.", PROGRAM),
    (5, "The probe found no contact within its travel.", PROGRAM),
    (6, "Homing was interrupted by a reset.", HOME),
    (7, "Homing was interrupted because the safety door opened.", CLEAR),
    (
        8,
        "A limit switch stayed closed when homing retracted from it.",
        "Check that switch and $27, reset and home.",
    ),
    (9, "Homing found no switch: it is not connected, stuck open or too far away.", SWITCHES),
    (10, "The emergency stop is pressed.", "Release it when it is safe, then reset and home."),
    (
        11,
        "The axes are not homed, and the controller accepts no other command before homing.",
        "Home them.",
    ),
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
