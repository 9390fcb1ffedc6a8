//! Other engines and other learning libraries beside this one.

mod labels;
mod table;

figures! { rod_peers, learning, scaling }
