//! Whatever is called and whatever arrives: nothing panics and no move beyond the travel leaves.

use std::io;

use proptest::prelude::*;
use spinebench::hardware::clock::Clock;
use spinebench::hardware::grbl::parser::{LineReader, ReceivedLine, parse};
use spinebench::hardware::grbl::{Controller, MotionSettings};
use spinebench::hardware::serial::SerialLine;
use spinebench::simulators::{ControllerFault, ControllerOptions};

use super::bench::Bench;

#[derive(Clone, Debug)]
enum Call {
    Wait(f64),
    Move([f64; 4], f64),
    Home,
    Hold,
    Resume,
    Reset,
    Noise(Vec<u8>),
    Say(&'static str),
    Fault(ControllerFault),
    Repair,
}

const SAYINGS: &[&str] = &[
    "ok",
    "error:9",
    "ALARM:1",
    "GrblHAL 1.1f ['$' or '$HELP' for help]",
    "<Idle|MPos:0.000,0.000,0.000,0.000|Bf:100,1023|FS:0,0|H:1>",
    "<Idle|MPos:-500.000,9e9,0.000,0.000|Bf:100,1023|FS:0,0|H:1>",
    "<Run|MPos:30.000,30.000,30.000,30.000|Bf:100,1023|FS:0,0|WCO:0.000,0.000,0.000,0.000>",
    "<Hold:0|MPos:1.000,1.000,1.000,1.000|Bf:0,0>",
    "<Alarm|MPos:1.000,1.000,1.000,1.000>",
    "<Home|MPos:1.000,1.000,1.000,1.000>",
    "[MSG:Reset to continue]",
    "$20=0",
];

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![
        6 => 0.0..60.0_f64,
        2 => -1e-3..1e-3_f64,
        1 => 59.999..60.001_f64,
        1 => -1e3..1e3_f64,
        1 => any::<f64>(),
    ]
}

fn call() -> impl Strategy<Value = Call> {
    let feed = prop_oneof![8 => 1.0..3000.0_f64, 1 => -1.0..1e5_f64, 1 => any::<f64>()];
    let fault = prop_oneof![
        Just(ControllerFault::GarbledLine),
        Just(ControllerFault::Reboot),
        Just(ControllerFault::LostOk),
        Just(ControllerFault::DoubledOk),
        Just(ControllerFault::Silent),
        Just(ControllerFault::HardLimit(0)),
        Just(ControllerFault::StickyError(20)),
        Just(ControllerFault::WrongPosition(1, 70.0)),
    ];
    prop_oneof![
        8 => (0.0..0.5_f64).prop_map(Call::Wait),
        1 => (0.0..8.0_f64).prop_map(Call::Wait),
        8 => ([value(), value(), value(), value()], feed).prop_map(|(target, feed)| Call::Move(target, feed)),
        2 => Just(Call::Home),
        1 => Just(Call::Hold),
        1 => Just(Call::Resume),
        1 => Just(Call::Reset),
        1 => prop::collection::vec(any::<u8>(), 0..600).prop_map(Call::Noise),
        1 => prop::sample::select(SAYINGS).prop_map(Call::Say),
        1 => fault.prop_map(Call::Fault),
        1 => Just(Call::Repair),
    ]
}

fn make(call: Call, bench: &Bench, controller: &mut Controller) {
    let now_s = bench.now_s();
    match call {
        Call::Wait(duration_s) => _ = bench.run(controller, duration_s),
        Call::Move(target_mm, feed_mm_min) => _ = controller.move_to(target_mm, feed_mm_min, now_s),
        Call::Home => controller.start_homing(now_s),
        Call::Hold => controller.hold(now_s),
        Call::Resume => controller.resume(now_s),
        Call::Reset => controller.reset(now_s),
        Call::Noise(bytes) => bench.make_noise(&bytes),
        Call::Say(line) => bench.make_noise(format!("{line}\n").as_bytes()),
        Call::Fault(fault) => bench.inject(fault),
        Call::Repair => bench.clear_faults(),
    }
}

/// Every line is one of the few that the driver knows, and every move is within the travel.
fn only_known_lines(sent: &[u8]) -> Result<usize, TestCaseError> {
    prop_assert!(!sent.contains(&b'\r'));
    let mut moves = 0;
    for line in super::bench::lines(sent) {
        if ["$I", "$$", "$#", "$H", "G21 G90 G94 G54"].contains(&line.as_str()) {
            continue;
        }
        let words: Vec<&str> = line.split(' ').collect();
        prop_assert_eq!(words.len(), 6, "{}", line);
        prop_assert_eq!(words[0], "G1");
        for (word, letter) in words[1..].iter().zip(["X", "Y", "Z", "A", "F"]) {
            let value: f64 = word.strip_prefix(letter).unwrap().parse().unwrap();
            let most = if letter == "F" { 3000.0 } else { 60.0 };
            prop_assert!((0.0..=most).contains(&value) && !word.contains("-0"), "{}", line);
        }
        moves += 1;
    }
    Ok(moves)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(96) })]

    #[test]
    fn no_sequence_of_calls_and_bytes_gets_past_the_gate(
        homed in any::<bool>(),
        calls in prop::collection::vec(call(), 0..60),
    ) {
        let bench = Bench::new(ControllerOptions::default());
        let mut controller = if homed { bench.ready() } else { bench.open() };
        for call in calls {
            make(call, &bench, &mut controller);
            prop_assert!(controller.state().unacknowledged <= 1);
        }
        let moves = only_known_lines(&bench.sent())?;
        prop_assert_eq!(moves as u64, controller.state().moves);
    }

    #[test]
    fn opening_survives_any_answers(bytes in prop::collection::vec(any::<u8>(), 0..4000), text in "[ -~\n]{0,400}") {
        let mut answers = text.into_bytes();
        answers.extend(bytes);
        let clock = Bench::new(ControllerOptions::default());
        let babbler = Babbler { answers, next: 0 };
        prop_assert!(Controller::open(Box::new(babbler), &MotionSettings::default(), &clock).is_err());
    }

    #[test]
    fn any_line_is_read(line in "\\PC{0,80}", status in "<[A-Z][a-z]{2,4}(:[0-9])?(\\|[A-Za-z]{1,4}:[-0-9.,]{0,30}){0,6}>") {
        let _ = (parse(&line), parse(&status));
    }

    #[test]
    fn lines_are_cut_at_their_ends_however_they_arrive(text in prop::collection::vec("[ -~]{1,40}", 1..20)) {
        let mut reader = LineReader::default();
        let bytes = text.join("\r\n") + "\n";
        let pieces: Vec<ReceivedLine> = bytes.bytes().filter_map(|byte| reader.push(byte)).collect();
        let expected: Vec<ReceivedLine> = text.into_iter().map(ReceivedLine::Line).collect();
        prop_assert_eq!(pieces, expected);
    }
}

/// Says the same for ever, a little at a time.
struct Babbler {
    answers: Vec<u8>,
    next: usize,
}

impl SerialLine for Babbler {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = (self.next % 7).min(buffer.len()).min(self.answers.len());
        for place in &mut buffer[..count] {
            *place = self.answers[self.next % self.answers.len()];
            self.next += 1;
        }
        self.next += 1;
        Ok(count)
    }

    fn write(&mut self, _: &[u8]) -> io::Result<()> {
        Ok(())
    }
}
