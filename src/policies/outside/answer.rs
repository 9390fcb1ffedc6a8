//! Answers for a policy in lines of JSON: the other end of `process.rs`, for networks that this
//! program evaluates in a process of its own.

use std::io::{BufRead, Write};

use serde_json::{Value, json};

use super::OutsidePolicy;
use super::controller::{OutsideDecider, OutsideView};
use super::onnx_policy::OnnxDecider;

/// Answers each line of `requests` with a line of `answers`, until the requests end.
///
/// # Errors
/// A file that cannot be read, or a connection that breaks.
pub fn answer_requests(
    policy: &OutsidePolicy,
    requests: impl BufRead,
    mut answers: impl Write,
) -> std::io::Result<()> {
    let content = std::fs::read(policy.file())?;
    let mut decider = None;
    for line in requests.lines() {
        let request: Value = serde_json::from_str(&line?)?;
        let answer = answered(policy, &content, &mut decider, &request);
        let words = |message| json!({ "error": { "kind": "failed", "message": message } });
        writeln!(answers, "{}", answer.unwrap_or_else(words))?;
        answers.flush()?;
    }
    Ok(())
}

fn answered(
    policy: &OutsidePolicy,
    content: &[u8],
    decider: &mut Option<OnnxDecider>,
    request: &Value,
) -> Result<Value, String> {
    if let Some(hello) = request.get("hello") {
        let OutsidePolicy::Onnx(options) = policy else {
            return Err("a policy that this program does not evaluate".to_owned());
        };
        let tendons = hello.get("tendons").and_then(Value::as_u64).unwrap_or_default() as usize;
        let made = OnnxDecider::new(options, content, tendons);
        *decider =
            Some(made.map_err(|(found, expected)| format!("found {found}, expected {expected}"))?);
        return Ok(json!({ "ready": {} }));
    }
    let decider = decider.as_mut().ok_or("a request before `hello`")?;
    if request.get("reset").is_some() {
        return decider.reset().map(|()| json!({ "ready": {} })).map_err(|error| error.to_string());
    }
    let act = request.get("act").ok_or("a request that is not `act`")?;
    let numbers = |key: &str| -> Vec<f64> {
        let values = act.get(key).and_then(Value::as_array).into_iter().flatten();
        values.map(|value| value.as_f64().unwrap_or(f64::NAN)).collect()
    };
    let point = |key: &str| {
        <[f64; 3]>::try_from(numbers(key)).map_err(|_| format!("`{key}` of three numbers expected"))
    };
    let view = OutsideView {
        tip_m: point("tip_m")?,
        target_m: point("target_m")?,
        pulls_m: &numbers("pulls_m"),
        time_s: act.get("time_s").and_then(Value::as_f64).unwrap_or_default(),
    };
    let decision = decider.decide(&view).map_err(|error| error.to_string())?;
    Ok(json!({ "pulls_m": decision.pulls_m, "settled": decision.settled }))
}
