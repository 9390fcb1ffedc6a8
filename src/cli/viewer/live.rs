//! The talk of the live view with a page: sliders in, poses out, at sixty a second.

use std::net::TcpStream;
use std::time::{Duration, Instant};

use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Error, Message, WebSocket};

use super::live_robot::{LiveAnswer, LiveRobot, SliderState};
use super::server::ServedPage;
use spinebench::effects::Model;
use spinebench::report::scene::live_page;

/// From one pose to the next.
const TICK: Duration = Duration::from_nanos(16_666_667);
/// Longest step in which the robot moves as fast as the clock, s.
const MAX_STEP_S: f64 = 0.05;
/// Upper bound on a message of the page, bytes.
const MAX_MESSAGE: usize = 64 << 10;

/// The live view of a model.
pub(super) struct LiveModel {
    name: String,
    model: Model,
    page: String,
}

impl LiveModel {
    pub(super) fn new(name: &str, model: Model) -> LiveModel {
        let (_, view) = LiveRobot::new(name, &model);
        LiveModel { name: name.to_owned(), page: live_page(&view), model }
    }
}

impl ServedPage for LiveModel {
    fn page(&self) -> &str {
        &self.page
    }

    fn talk(&self, stream: TcpStream) {
        if stream.set_nonblocking(true).is_err() {
            return;
        }
        let config = WebSocketConfig::default()
            .max_message_size(Some(MAX_MESSAGE))
            .max_frame_size(Some(MAX_MESSAGE));
        let socket = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
        let (robot, _) = LiveRobot::new(&self.name, &self.model);
        // The page goes away: the socket ends with an error.
        let _ = converse(socket, robot);
    }
}

/// Until the page says something the robot waits: then it answers at every tick.
fn converse(mut socket: WebSocket<TcpStream>, mut robot: LiveRobot) -> Result<(), Error> {
    let mut asked = false;
    let mut before = Instant::now();
    loop {
        let tick = Instant::now();
        if let Some(state) = latest(&mut socket)? {
            asked = true;
            if let Some(answer) = robot.ask(state) {
                send(&mut socket, &answer)?;
            }
        }
        if asked {
            let passed_s = (tick - before).as_secs_f64();
            let step_s = passed_s.clamp(1e-3, MAX_STEP_S);
            before = tick;
            if let Some(answer) = robot.step(step_s) {
                let pace = (step_s / passed_s.max(1e-3)).min(1.0);
                send(&mut socket, &LiveAnswer { pace, ..answer })?;
            }
        }
        std::thread::sleep(TICK.saturating_sub(tick.elapsed()));
    }
}

/// The last of the messages that have come; none where none has.
fn latest(socket: &mut WebSocket<TcpStream>) -> Result<Option<SliderState>, Error> {
    let mut last: Option<SliderState> = None;
    loop {
        match socket.read() {
            Ok(Message::Text(text)) => {
                if let Ok(state) = serde_json::from_str::<SliderState>(&text) {
                    let restart = state.restart || last.is_some_and(|last| last.restart);
                    last = Some(SliderState { restart, ..state });
                }
            }
            Ok(_) => {}
            Err(Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => {
                return Ok(last);
            }
            Err(error) => return Err(error),
        }
    }
}

/// Sends an answer; a page that does not read yet gets it later.
fn send(socket: &mut WebSocket<TcpStream>, answer: &LiveAnswer) -> Result<(), Error> {
    let text = serde_json::to_string(answer).unwrap_or_default();
    match socket.send(Message::text(text)) {
        Err(Error::Io(error)) if error.kind() == std::io::ErrorKind::WouldBlock => Ok(()),
        sent => sent,
    }
}
