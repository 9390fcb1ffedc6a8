//! The rows of learning beside other packages.

use super::cell::Outcome;
use crate::data::table_rows;

table_rows! {
    "learning.csv", key [task, size, peer, round], failed [|row| !row.status.is_ok()]:
    /// One task of learning, carried out by one package in one round (`docs/evidence/peers.md`).
    pub struct LearningPeerRow {
        /// `fit`: three Gaussian processes from one start; `evaluation`: their likelihood with its
        /// gradient, once, for one output; `predict_one` and `predict_many`: mean and variance at
        /// one and at 10,000 points; `epoch` of an Elman network; `until_error`: its training up to
        /// 0.2 mm; `product_f64`, `product_f32`: of two square matrices.
        pub task: String,
        /// Samples, rows trained on, or rows of a matrix.
        pub size: u64,
        /// Package.
        pub peer: String,
        /// Round, from 1; each round runs this program and the packages in turn.
        pub round: u64,
        /// Processor time of one repetition, s.
        pub cpu_s: f64,
        /// Sum of the outputs' log marginal likelihoods that a fit reached, nats.
        pub likelihood: f64,
        /// Evaluations of the likelihood that a fit took, or epochs.
        pub evaluations: f64,
        /// Root mean square error of a fit on another exploration without noise, or mean absolute
        /// error of a network on rows that it was not trained on, metres.
        pub error_m: f64,
        /// `ok` or the failure; a failed run has no other numbers.
        pub status: Outcome,
    }
}
