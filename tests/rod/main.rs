//! The Cosserat rod against references, analytic solutions and itself.

#[path = "../support/mod.rs"]
mod support;

mod calibration;
mod campaign;
mod contact;
mod dynamics;
mod energy;
mod general;
mod hostile;
mod paths;
mod peers_till;
mod robust;
mod sensitivity;
mod stability;
mod statics;
mod tendon_friction;
mod tentacle;
mod trunk;
mod twin;
