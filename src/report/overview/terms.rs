//! What the words of the page mean.

use maud::{Markup, html};

const TERMS: [(&str, &str); 11] = [
    (
        "Policy, controller",
        "computes the displacements of the tendons from the target and the measured tip.",
    ),
    (
        "A",
        "a network that inverts the simulation; a Gaussian process of the difference between simulation and robot, \
         fitted to few real points, moves its target.",
    ),
    (
        "B",
        "A’s network, trained further on simulated data that the Gaussian process has corrected.",
    ),
    ("C", "A; where A leaves a large error, B."),
    ("π_real", "a network trained on real data only, without a simulation."),
    (
        "Open loop, closed loop",
        "without and with the measured tip during a trial; “with a load”: 20 g at the tip that no training contained.",
    ),
    (
        "Stopped, converged",
        "networks trained to the validation errors of the paper, and until they stop improving.",
    ),
    ("Repetition", "the whole experiment once, with its own data, noise and initial weights."),
    ("True tip", "the position of the simulated tip without tracking noise."),
    (
        "Group",
        "several effects that explain a recording equally well; the program names all of them.",
    ),
    (
        "Span",
        "what effects of the catalogue can imitate; an effect outside the span has no imitation.",
    ),
];

/// The list.
pub(super) fn section() -> Markup {
    html! {
        section #terms {
            h2 { "Terms" }
            dl .terms { @for (term, meaning) in TERMS { div { dt { (term) } dd { (meaning) } } } }
        }
    }
}
