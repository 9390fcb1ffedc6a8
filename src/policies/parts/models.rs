//! What policies are trained from, as data: whoever builds a policy trains the networks that its
//! entry names.

/// Columns of a sample of a motion.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "snake_case")]
pub enum SampleColumns {
    /// u_i: the displacement of each tendon, metres.
    Pulls,
    /// x_i: the tip before the step, metres.
    TipBefore,
    /// x_{i+1}: the tip after it, metres.
    TipAfter,
}

/// Where the samples come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrainingData {
    /// The exploration on the model.
    Simulated,
    /// The same commands on the robot: as many samples as a spec's `real_points`.
    Real,
    /// The exploration on the model, moved by the error model (eq. 24).
    Generated,
    /// The policy's own ways on robots that differ from the model at random
    /// ([`crate::policies::DaggerOptions`]).
    Randomised,
}

/// Validation mean absolute error at which training may end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum EarlyStopping {
    /// `forward_mae_m` of a kind of training.
    Forward,
    /// `inverse_mae_m` of a kind of training.
    Inverse,
    /// `inverse_b_mae_m` of a kind of training.
    InverseB,
    /// `pi_real_mae_m` of a kind of training.
    PiReal,
    /// This error, metres, in every kind of training.
    At(f64),
    /// Trained to convergence in every kind of training.
    Never,
}

/// A recurrent network that a policy is built from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NetworkDescription {
    /// Name in `networks.csv` and in claims. It is also the name of its seed.
    pub name: &'static str,
    /// Name of the stage that trains it, also its folder in the store.
    pub stage: &'static str,
    /// What it is, in words.
    pub label: &'static str,
    /// What it sees, in this order.
    pub inputs: &'static [SampleColumns],
    /// What it predicts.
    pub outputs: &'static [SampleColumns],
    /// What it is trained on.
    pub data: TrainingData,
    /// When its training may end.
    pub early_stopping: EarlyStopping,
    /// On generated data: the network whose weights it starts from, where a spec's
    /// `generated_start` says so. On robots that differ: the network that it starts from.
    pub start: Option<&'static NetworkDescription>,
    /// The paper's validation error, metres; not a number where it gives none.
    pub paper_mae_m: f64,
}

/// What a policy needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModelNeed {
    /// A network.
    Network(&'static NetworkDescription),
    /// The error model (eq. 20).
    ErrorModel,
}

/// The forward model of eq. (17): (u_i, x_i) → x_{i+1}.
pub static FORWARD: NetworkDescription = NetworkDescription {
    name: "forward",
    stage: "train_forward",
    label: "forward network",
    inputs: &[SampleColumns::Pulls, SampleColumns::TipBefore],
    outputs: &[SampleColumns::TipAfter],
    data: TrainingData::Simulated,
    early_stopping: EarlyStopping::Forward,
    start: None,
    paper_mae_m: 0.0024,
};

/// The inverse mapping of eq. (21) from simulated data: (x_i, x_{i+1}) → u_i.
pub static INVERSE: NetworkDescription = NetworkDescription {
    name: "inverse",
    stage: "train_inverse",
    label: "inverse network",
    inputs: &[SampleColumns::TipBefore, SampleColumns::TipAfter],
    outputs: &[SampleColumns::Pulls],
    data: TrainingData::Simulated,
    early_stopping: EarlyStopping::Inverse,
    start: None,
    paper_mae_m: 0.0024,
};

/// The inverse mapping from generated data (eq. 24).
pub static INVERSE_B: NetworkDescription = NetworkDescription {
    name: "inverse_b",
    stage: "train_inverse_b",
    label: "generated-data network",
    data: TrainingData::Generated,
    early_stopping: EarlyStopping::InverseB,
    start: Some(&INVERSE),
    paper_mae_m: 0.0019,
    ..INVERSE
};

/// The inverse mapping from its own ways on robots that differ. It starts from the one of the
/// model.
pub static DAGGER: NetworkDescription = NetworkDescription {
    name: "dagger",
    stage: "train_dagger",
    label: "network of robots that differ",
    data: TrainingData::Randomised,
    early_stopping: EarlyStopping::Never,
    start: Some(&INVERSE),
    paper_mae_m: f64::NAN,
    ..INVERSE
};

/// The inverse mapping from real data.
pub static PI_REAL: NetworkDescription = NetworkDescription {
    name: "pi_real",
    stage: "train_pi_real",
    label: "real network",
    data: TrainingData::Real,
    early_stopping: EarlyStopping::PiReal,
    paper_mae_m: f64::NAN,
    ..INVERSE
};
